"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .block_average import block_averaged
from .bootstrap import parametric_bootstrap
from .filtering import Filtered, FilterResults, disturbance_slots, filter_all, filter_series, smooth
from .free_run import FreeRun, free_runs
from .joint import Fit, fit, pseudo_inverse, response
from .noise import fit_noise
from .normal import (
    Normal,
    log_likelihoods,
    normal_equations,
    slots_by_name,
    trial_values,
)
from .paths import PathFit, fit_paths
from .resampling import cov_hc2, cov_jackknife, ensemble, inverse_fisher, off_bounds
from .sandwich import (
    ClusterCovariance,
    ClusterInfluence,
    TrialRandomEffect,
    cluster_covariance,
    newton_step_off_bounds,
)
from .series import Free, Noise, Series, TrialEffect

__all__ = [
    "ClusterCovariance",
    "ClusterInfluence",
    "FilterResults",
    "Filtered",
    "Fit",
    "Free",
    "FreeRun",
    "Noise",
    "Normal",
    "PathFit",
    "Series",
    "TrialEffect",
    "TrialRandomEffect",
    "block_averaged",
    "cluster_covariance",
    "cov_hc2",
    "cov_jackknife",
    "disturbance_slots",
    "ensemble",
    "filter_all",
    "filter_series",
    "fit",
    "fit_noise",
    "fit_paths",
    "free_runs",
    "inverse_fisher",
    "log_likelihoods",
    "newton_step_off_bounds",
    "normal_equations",
    "off_bounds",
    "parametric_bootstrap",
    "pseudo_inverse",
    "response",
    "slots_by_name",
    "smooth",
    "trial_values",
]
