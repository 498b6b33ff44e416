"""Coefficients from trials: the paper's three steps at each power, and one set for all."""

from .joint_fit import JointFit, coefficient_cell, coefficient_table, fit_all_trials
from .paper_steps import fit_paper_steps
from .results import (
    coefficients_json_and_fit,
    simulation_columns_by_trial,
    table_1_coefficients,
    table_2_radius_errors,
)
from .series import (
    HEAD_ANGLE_STD_RAD,
    downsampled_with_head_angle_changes,
    session_order_fractions,
    study_series,
    trial_series,
)
from .similar_robots import compiled_trial_system, downsampled, robot_units_of_trials
from .stability import straight_swimming_growth_per_s
from .steady_errors import steady_errors
