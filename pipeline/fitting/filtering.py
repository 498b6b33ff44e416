"""Prediction errors of a model on its trials, through an extended Kalman filter around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import Kernel
from ..integrate.batch import STEP_S, each, switches
from .series import Noise, Series

DIFFERENCE = 1e-5  # size of state differences for the transition matrix, in each state's SI unit


@dataclass(frozen=True)
class Filtered:
    """One trial through the filter: n frames, s states, o observations.

    log_likelihood; innovations (n, o), whitened; gains (n, s, o); roots (n, o, o): inverse
    Cholesky factors of the innovation covariance; transitions (n, s, s); predicted and filtered
    means (n, s) and covariances (n, s, s).
    """

    log_likelihood: float
    innovations: Float
    gains: Float
    roots: Float
    transitions: Float
    predicted: Float
    filtered: Float
    cov_predicted: Float
    cov_filtered: Float


def filter_series(kernel: Kernel, series: Series, values: Float, noise: Noise) -> Filtered:
    """`Filtered` of one trial for a full parameter vector `(parameters,)`."""
    n, s, o = len(series.times), len(kernel.system.all_states), len(kernel.system.observations)
    shapes = ((n, s, o), (n, o, o), (n, s, s), (n, s), (n, s), (n, s, s), (n, s, s), (n, o))
    gains, roots, transitions, predicted, filtered, cov_p, cov_f, innovations = map(
        np.zeros, shapes
    )
    values, intensity, cov = _with_disturbance(kernel, series, values, noise)
    log_likelihood = kernel.kalman(
        series.mean,
        cov,
        values,
        series.constants,
        series.times,
        series.inputs,
        series.seen,
        series.noise * np.outer(noise.scale, noise.scale),
        intensity,
        np.full(s, DIFFERENCE),
        switches(kernel.system, values),
        _substeps(series),
        gains,
        roots,
        transitions,
        predicted,
        filtered,
        cov_p,
        cov_f,
        innovations,
    )
    return Filtered(
        log_likelihood, innovations, gains, roots, transitions, predicted, filtered, cov_p, cov_f
    )


def filter_all(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise
) -> list[Filtered]:
    """`filter_series` for every trial with its own parameter vector, on all cores."""
    jobs = list(zip(series, values, strict=True))
    return each(lambda job: filter_series(kernel, job[0], job[1], noise), jobs)


def smooth(result: Filtered) -> tuple[Float, Float]:
    """Rauch-Tung-Striebel means `(n, states)` and covariances `(n, states, states)`."""
    mean, cov = result.filtered.copy(), result.cov_filtered.copy()
    for k in range(len(mean) - 2, -1, -1):
        # C = P_k F' (P_k+1|k)^-1
        predicted = result.cov_predicted[k + 1]
        F = result.transitions[k + 1]
        C = np.linalg.solve(_regular(predicted), F @ result.cov_filtered[k]).T
        mean[k] = result.filtered[k] + C @ (mean[k + 1] - result.predicted[k + 1])
        cov[k] = result.cov_filtered[k] + C @ (cov[k + 1] - predicted) @ C.T
    return mean, cov


def disturbance_slots(kernel: Kernel) -> list[int]:
    """Places of the disturbing states in the state vector."""
    effect = next((e for e in kernel.system.effects if e.kind == "disturbance"), None)
    return [kernel.system.all_states.index(s) for s in effect.states] if effect else []


def _with_disturbance(
    kernel: Kernel, series: Series, values: Float, noise: Noise
) -> tuple[Float, Float, Float]:
    """Parameters with the disturbance on, its intensity (2 sigma^2 / tau), and the start's cov."""
    intensity = np.zeros(len(kernel.system.all_states))
    values, cov = values.copy(), series.cov.copy()
    slots = disturbance_slots(kernel)
    if slots:
        name = next(e.name for e in kernel.system.effects if e.kind == "disturbance")
        present, tau = kernel.system.slots(name)
        values[present], values[tau] = 1.0, noise.tau
        intensity[slots] = 2.0 * noise.disturbance**2 / noise.tau
        cov[slots, slots] = noise.disturbance**2
    return values, intensity, cov


def _substeps(series: Series) -> int:
    return max(1, int(np.ceil(np.max(np.diff(series.times)) / STEP_S - 1e-6)))


def _regular(matrix: Float) -> Float:
    return matrix + 1e-14 * np.trace(matrix) * np.eye(len(matrix)) + 1e-18 * np.eye(len(matrix))
