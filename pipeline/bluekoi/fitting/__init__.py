"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .filtering import Filtered, Passes, disturbance_slots, filter_all, filter_series, smooth
from .joint import Fit, fit, pseudo_inverse, response
from .noise import fit_noise, with_forces_of
from .normal import (
    Normal,
    log_likelihoods,
    normal_equations,
    side_log_likelihoods,
    slots_by_name,
    trial_values,
)
from .paths import PathFit, fit_paths
from .resampling import ensemble, inverse_fisher, jackknife_cov, moving, scatter_cov
from .sandwich import (
    ClusterInfluence,
    Spread,
    TrialRandomEffect,
    spread_over_trials,
    without_bounds,
)
from .series import Free, Noise, Series, TrialEffect
from .shooting import Shot, shoot
from .thinning import thinned

__all__ = [
    "ClusterInfluence",
    "Filtered",
    "Fit",
    "Free",
    "Noise",
    "Normal",
    "Passes",
    "PathFit",
    "Series",
    "Shot",
    "Spread",
    "TrialEffect",
    "TrialRandomEffect",
    "disturbance_slots",
    "ensemble",
    "filter_all",
    "filter_series",
    "fit",
    "fit_noise",
    "fit_paths",
    "inverse_fisher",
    "jackknife_cov",
    "log_likelihoods",
    "moving",
    "normal_equations",
    "pseudo_inverse",
    "response",
    "scatter_cov",
    "shoot",
    "side_log_likelihoods",
    "slots_by_name",
    "smooth",
    "spread_over_trials",
    "thinned",
    "trial_values",
    "with_forces_of",
    "without_bounds",
]
