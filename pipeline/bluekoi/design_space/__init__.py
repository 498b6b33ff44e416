"""What a fitted robot could do: steady states of other designs, fronts, manoeuvres over time."""

from .fits import Fitted, load_fitted
from .front import Design, designs_csv_columns, is_on_front, smallest_radius
from .manoeuvres import MANOEUVRES, Schedule, read_schedule
from .robots import designs, tested_range
from .steady_states import Condition, steady_states
