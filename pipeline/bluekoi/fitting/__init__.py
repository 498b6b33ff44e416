"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .between_trials import MAX_OVERDISPERSION, Z_95, cluster_robust_covariance
from .block_average import block_averaged
from .bootstrap import parametric_bootstrap
from .filtering import (
    FilteredTrial,
    FilterResults,
    filter_all,
    filter_series,
    random_state_indices,
    rts_smooth,
)
from .free_run import FreeRun, free_runs
from .joint_fit import (
    ParameterFit,
    fit_parameters_jointly,
    regularised_fisher_inverse,
    sensitivity_to_other_parameters,
)
from .missing_force import (
    MissingForce,
    force_of_added_effects,
    missing_force,
    rms_forces_of_parameter_changes,
)
from .noise import estimate_noise_model
from .normal import (
    NormalEquationsByTrial,
    log_likelihood_by_trial,
    trial_normal_equations,
    trial_parameter_vector,
)
from .paths import TrajectoryFit, fit_trajectories
from .predictions import parameter_index_by_name
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
    "block_averaged",
    "cluster_covariance",
    "cluster_robust_covariance",
    "cov_hc2",
    "cov_jackknife",
    "estimate_noise_model",
    "filter_all",
    "filter_series",
    "fit_parameters_jointly",
    "fit_trajectories",
    "force_of_added_effects",
    "free_runs",
    "inverse_fisher",
    "log_likelihood_by_trial",
    "missing_force",
    "newton_step_ignoring_bounds",
    "off_bounds",
    "parameter_index_by_name",
    "parametric_bootstrap",
    "random_state_indices",
    "regularised_fisher_inverse",
    "rms_forces_of_parameter_changes",
    "rts_smooth",
    "sensitivity_to_other_parameters",
    "student_t_draws",
    "trial_normal_equations",
    "trial_parameter_vector",
]
