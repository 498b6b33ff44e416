"""Fits of any state-space model to its trials: prediction errors, all trials jointly."""

from .filtering import Filtered, disturbance_slots, filter_all, filter_series, smooth
from .joint import Fit, Normal, fit, normal_equations, pseudo_inverse, slots_by_name, trial_values
from .noise import fit_noise
from .resampling import ensemble, jackknife_cov, open_combinations
from .series import Free, Noise, Series
from .shooting import Shot, shoot

__all__ = [
    "Filtered",
    "Fit",
    "Free",
    "Noise",
    "Normal",
    "Series",
    "Shot",
    "disturbance_slots",
    "ensemble",
    "filter_all",
    "filter_series",
    "fit",
    "fit_noise",
    "jackknife_cov",
    "normal_equations",
    "open_combinations",
    "pseudo_inverse",
    "shoot",
    "slots_by_name",
    "smooth",
    "trial_values",
]
