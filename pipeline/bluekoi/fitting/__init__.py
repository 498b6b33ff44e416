"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .between_trials import MAX_OVERDISPERSION, Z_95, cluster_robust_covariance
from .block_average import block_averaged
from .bootstrap import parametric_bootstrap
from .filtering import (
    FilteredTrial,
    FilterResults,
    disturbance_slots,
    filter_all,
    filter_series,
    rts_smooth,
)
from .free_run import FreeRun, free_runs
from .joint_fit import (
    ParameterFit,
    conditional_response,
    fit_parameters_jointly,
    regularised_fisher_inverse,
)
from .missing_force import MissingForce, added_force, missing_force, rms_forces_of_parameter_changes
from .noise import estimate_noise_model
from .normal import (
    NormalEquationsByTrial,
    log_likelihood_by_trial,
    trial_normal_equations,
    trial_parameter_vector,
)
from .paths import TrajectoryFit, fit_trajectories
from .predictions import slots_by_name
from .resampling import cov_hc2, cov_jackknife, inverse_fisher, off_bounds, student_t_draws
from .sandwich import (
    ClusterCovariance,
    ClusterInfluence,
    TrialRandomEffect,
    cluster_covariance,
    newton_step_ignoring_bounds,
)
from .series import FreeParameter, Noise, SharedMeasurement, TrialEffect, TrialSeries

__all__ = [
    "MAX_OVERDISPERSION",
    "Z_95",
    "ClusterCovariance",
    "ClusterInfluence",
    "FilterResults",
    "FilteredTrial",
    "FreeParameter",
    "FreeRun",
    "MissingForce",
    "Noise",
    "NormalEquationsByTrial",
    "ParameterFit",
    "SharedMeasurement",
    "TrajectoryFit",
    "TrialEffect",
    "TrialRandomEffect",
    "TrialSeries",
    "added_force",
    "block_averaged",
    "cluster_covariance",
    "cluster_robust_covariance",
    "conditional_response",
    "cov_hc2",
    "cov_jackknife",
    "disturbance_slots",
    "estimate_noise_model",
    "filter_all",
    "filter_series",
    "fit_parameters_jointly",
    "fit_trajectories",
    "free_runs",
    "inverse_fisher",
    "log_likelihood_by_trial",
    "missing_force",
    "newton_step_ignoring_bounds",
    "off_bounds",
    "parametric_bootstrap",
    "regularised_fisher_inverse",
    "rms_forces_of_parameter_changes",
    "rts_smooth",
    "slots_by_name",
    "student_t_draws",
    "trial_normal_equations",
    "trial_parameter_vector",
]
