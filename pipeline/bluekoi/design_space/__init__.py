"""What a fitted robot could do: steady states of other designs, fronts, manoeuvres over time."""

from .fits import FittedRobot, load_fitted_robot
from .front import RobotDesign, designs_csv_columns, is_pareto_optimal, tightest_turn_design
from .manoeuvres import MANOEUVRES, Schedule, read_schedule
from .robots import evaluate_designs, tested_range
from .steady_states import OperatingCondition, steady_states
