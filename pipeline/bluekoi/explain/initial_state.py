"""Initial state of a trial from its first samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from ..data import Float
from ..errors import input_error
from .model import Model
from .system_assembly import AssembledSystem

MAX_START_SAMPLES, MIN_PARABOLA_SAMPLES = 8, 4
"""Samples from which an initial state is estimated at most, and those of a parabola at least: four
leave one degree of freedom for its misfit."""
CURVATURE_TEST_LEVEL = 0.99
"""Quantile of chi squared that the misfit of the first samples may reach."""
MAX_MISFIT_OVER_STATED = 100.0
"""Misfit over the stated standard deviation, as large as errors may be for a fit to go on
(`fit_quality.MAX_ERROR_OVER_STATED_TO_FIT`)."""


def initial_state_mean_and_cov(
    model: Model, assembly: AssembledSystem, times: Float, seen: Float, known: Mapping[str, float]
) -> tuple[Float, Float]:
    """Mean (states,) and covariance (states, states) before the first frame.

    times (n,), seen (n, observations); known: state -> value, where it is known.
    """
    count = len(assembly.system.all_states)
    mean, std = np.zeros(count), np.full(count, 1e-6)
    given = model.start(times, seen) if model.start else None
    if given is not None and len(given) != len(model.states):
        raise input_error(f"model '{model.name}'", "start", f"{len(given)} values",
                          f"one for each of {len(model.states)} states")  # fmt: skip
    places = {o.name: k for k, o in enumerate(model.observations)}
    for k, s in enumerate(model.states):
        std[k] = s.start_std
        if s.name in known:
            mean[k] = known[s.name]
        elif given is not None:
            mean[k] = given[k]
        elif source := s.observed or s.rate_of:
            o = places[source]
            found = initial_level_and_slope(times, seen[:, o], model.observations[o].std)
            mean[k], own = found.level if s.observed else found.slope
            std[k] = np.hypot(s.start_std, own)
        else:
            mean[k] = s.start
    for cause in model.causes:
        for state in cause.states:
            std[assembly.system.all_states.index(state)] = cause.start_std
    return mean, np.diag(std**2)


@dataclass(frozen=True)
class InitialLevelAndSlope:
    """Value and slope of an observation at the first time, each with its standard deviation."""

    level: tuple[float, float]
    slope: tuple[float, float]


def initial_level_and_slope(times: Float, values: Float, std: float) -> InitialLevelAndSlope:
    """Value and slope at the first time, by a line through the first known samples.

    Where these bend by more than their noise of standard deviation std, by a parabola through as
    many of them as lie on one. If not even the first four do, what a cubic through them changes
    counts as error. A misfit of more than `MAX_MISFIT_OVER_STATED` is an error of the recording:
    the line is kept, and the check of the fitted errors names the recording. Without a known sample
    both are 0.
    """
    known = np.flatnonzero(np.isfinite(values))[:MAX_START_SAMPLES]
    if not len(known):
        return InitialLevelAndSlope((0.0, 0.0), (0.0, 0.0))
    t, y = times[known] - times[0], values[known]
    fit = _fitted_polynomial(t, y, 1, std)
    for count in range(len(known), MIN_PARABOLA_SAMPLES - 1, -1):
        if fit.agrees:
            break
        fit = _fitted_polynomial(t[:count], y[:count], 2, std)
    if not fit.agrees and len(known) >= MIN_PARABOLA_SAMPLES:
        cubic = _fitted_polynomial(t[:MIN_PARABOLA_SAMPLES], y[:MIN_PARABOLA_SAMPLES], 3, std)
        change = np.abs(cubic.level_and_slope - fit.level_and_slope)
        fit = replace(fit, stds=np.hypot(fit.stds, change))
    if fit.stds[0] > MAX_MISFIT_OVER_STATED * std:
        fit = replace(_fitted_polynomial(t, y, 1, std), stds=np.zeros(2))
    (level, slope), (level_std, slope_std) = fit.level_and_slope, fit.stds
    return InitialLevelAndSlope((float(level), float(level_std)), (float(slope), float(slope_std)))


@dataclass(frozen=True)
class _FittedPolynomial:
    """Value and slope (2,) of a polynomial at 0, their standard deviations (2,), and whether its
    samples agree with it.
    """

    level_and_slope: Float
    stds: Float
    agrees: bool


def _fitted_polynomial(t: Float, y: Float, degree: int, std: float) -> _FittedPolynomial:
    """Polynomial by least squares; samples have the standard deviation std, or a larger one where
    their misfit shows it.
    """
    unit = np.array([1.0, float(t[-1]) or 1.0])
    design = np.vander(t / unit[1], degree + 1, increasing=True)
    found = np.linalg.lstsq(design, y, rcond=None)[0]
    freedom = max(len(t) - degree - 1, 1)
    misfit = float(np.sum((y - design @ found) ** 2)) / std**2
    variances = np.diag(np.linalg.pinv(design.T @ design))[:2] * max(1.0, misfit / freedom)
    return _FittedPolynomial(found[:2] / unit, std * np.sqrt(variances) / unit,
                             misfit <= chi2.ppf(CURVATURE_TEST_LEVEL, freedom))  # fmt: skip
