"""Coefficients from trials: the paper's three steps at each power, and one set for all."""

from .joint_fit import JointFit, coefficient_cell, coefficient_table, downsampled, fit_all_trials
from .paper_steps import three_steps
from .results import coefficients, simulations, table_1, table_2
from .series import study_series, trial_series
from .stability import growth_per_s
from .steady_errors import steady_errors
