"""What a fitted robot could do: steady states of other designs, fronts, manoeuvres over time."""

from .fits import Fitted, load_fitted
from .front import COLUMNS, Design, columns, on_front, smallest_radius
from .manoeuvres import MANOEUVRES, Schedule, read_schedule
from .robots import Range, designs, tested_range
from .steady_states import Condition, SteadyStates, steady_states

__all__ = [
    "COLUMNS",
    "MANOEUVRES",
    "Condition",
    "Design",
    "Fitted",
    "Range",
    "Schedule",
    "SteadyStates",
    "columns",
    "designs",
    "load_fitted",
    "on_front",
    "read_schedule",
    "smallest_radius",
    "steady_states",
    "tested_range",
]
