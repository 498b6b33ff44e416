"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .between_trials import MAX_OVERDISPERSION, Z_95, cluster_robust_covariance
from .block_average import block_averaged
from .bootstrap import parametric_bootstrap
from .filtering import Filtered, FilterResults, disturbance_slots, filter_all, filter_series, smooth
from .free_run import FreeRun, free_runs
from .joint_fit import Fit, conditional_response, fit, pseudo_inverse
from .missing_force import MissingForce, added_force, missing_force, rms_forces
from .noise import fit_noise
from .normal import Normal, log_likelihoods, normal_equations, trial_values
from .paths import PathFit, fit_paths
from .predictions import slots_by_name
from .resampling import cov_hc2, cov_jackknife, inverse_fisher, off_bounds, student_t_draws
from .sandwich import (
    ClusterCovariance,
    ClusterInfluence,
    TrialRandomEffect,
    cluster_covariance,
    newton_step_off_bounds,
)
from .series import Free, Noise, Series, SharedMeasurement, TrialEffect

__all__ = [
    "MAX_OVERDISPERSION",
    "Z_95",
    "ClusterCovariance",
    "ClusterInfluence",
    "FilterResults",
    "Filtered",
    "Fit",
    "Free",
    "FreeRun",
    "MissingForce",
    "Noise",
    "Normal",
    "PathFit",
    "Series",
    "SharedMeasurement",
    "TrialEffect",
    "TrialRandomEffect",
    "added_force",
    "block_averaged",
    "cluster_covariance",
    "cluster_robust_covariance",
    "conditional_response",
    "cov_hc2",
    "cov_jackknife",
    "disturbance_slots",
    "filter_all",
    "filter_series",
    "fit",
    "fit_noise",
    "fit_paths",
    "free_runs",
    "inverse_fisher",
    "log_likelihoods",
    "missing_force",
    "newton_step_off_bounds",
    "normal_equations",
    "off_bounds",
    "parametric_bootstrap",
    "pseudo_inverse",
    "rms_forces",
    "slots_by_name",
    "smooth",
    "student_t_draws",
    "trial_values",
]
