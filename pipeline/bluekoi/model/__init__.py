"""The two-plate model: Eqs. 1 to 8, the effects that may be added, and simulations of both."""

from ..observation import OBSERVED_QUANTITIES
from .published import (
    PUBLISHED_FLAP_HZ,
    PUBLISHED_UNITS_NOTE,
    TABLE_1,
    TABLE_2_ERRORS_PCT,
)
from .residual import MOTION_VARIABLES
from .residual import channel_variable_pairs_by_term as residual_channels_and_variables
from .residual import channels_of_residual_term as residual_channels
from .similarity import RobotScaleRatios, robot_scale_ratios
from .simulation import (
    Simulation,
    constants_of_robot_trial,
    simulate,
    simulate_at_times,
    steady_speed_and_radius,
)
from .two_plate_model import (
    HYDRODYNAMIC_COEFFICIENTS,
    effect_names,
    is_residual,
    robot_scale_ratios_of_trial,
    robot_system,
    trial_system,
    two_plate_system,
)
