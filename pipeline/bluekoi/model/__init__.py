"""The two-plate model: Eqs. 1 to 8, the effects that may be added, and simulations of both."""

from ..observation import OBSERVATIONS
from .plates import COEFFICIENTS, effect_names, is_residual, plates
from .published import FLAP_HZ, TABLE_1, TABLE_2_PCT, UNIT_READING
from .residual import STATE_VARIABLES
from .residual import channels as residual_channels
from .residual import channels_and_variables as residual_channels_and_variables
from .simulation import Simulation, constants, simulate, simulate_at, steady_turn
