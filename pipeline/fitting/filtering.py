"""Prediction errors of a model on its trials, through an extended Kalman filter around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import Effect, Kernel
from ..integrate.batch import each, switches
from .series import Noise, Series

STEP_S = 1 / 30
"""Longest integration step between observations: a frame's error is far below its noise."""
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
    values, variance, memory, cov = _with_disturbance(kernel, series, values, noise)
    on = switches(kernel.system, values)
    log_likelihood = kernel.kalman(
        series.mean,
        cov,
        values,
        series.constants,
        series.times,
        series.inputs,
        series.seen,
        series.noise * np.outer(noise.scale, noise.scale),
        variance,
        memory,
        np.full(s, DIFFERENCE),
        _active(kernel, on),
        on,
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


def disturbance_slots(kernel: Kernel, *, acting: bool = False) -> list[int]:
    """Places of the random states in the state vector; of those alone that push, where `acting`."""
    return [
        kernel.system.all_states.index(s)
        for effect in random_effects(kernel)
        if effect.channels or not acting
        for s in effect.states
    ]


def random_effects(kernel: Kernel) -> list[Effect]:
    """The system's random parts, in the order of their states."""
    return [e for e in kernel.system.effects if e.kind == "disturbance"]


def with_noise(kernel: Kernel, values: Float, noise: Noise) -> Float:
    """`values` (parameters, ...) with the random parts of `noise` switched on, as a copy.

    A random effect's parameters are `present` and then a memory for all its states, or one each.
    """
    out, at = values.copy(), 0
    for effect in random_effects(kernel):
        present, *memories = kernel.system.slots(effect.name)
        own = noise.disturbance[at : at + len(effect.states)]
        out[present] = float(np.any(own > 0))
        if np.any(own > 0):
            for i, slot in enumerate(memories):
                out[slot] = noise.tau[at + i]
        at += len(effect.states)
    return out


def _with_disturbance(
    kernel: Kernel, series: Series, values: Float, noise: Noise
) -> tuple[Float, Float, Float, Float]:
    """Parameters with the random parts on, variance and memory of states, the start's cov."""
    count = len(kernel.system.all_states)
    variance, memory, cov = np.zeros(count), np.ones(count), series.cov.copy()
    slots = disturbance_slots(kernel)[: len(noise.disturbance)]
    variance[slots], memory[slots] = noise.disturbance**2, noise.tau
    cov[slots, slots] = noise.disturbance**2
    return with_noise(kernel, values, noise), variance, memory, cov


def _active(kernel: Kernel, on: np.ndarray) -> np.ndarray:
    """Places of the model's states and of those of the effects that are on."""
    system = kernel.system
    names = [*system.states, *(s for e, o in zip(system.effects, on, strict=True) if o
                               for s in e.states)]  # fmt: skip
    return np.array([system.all_states.index(n) for n in names])


def _substeps(series: Series) -> int:
    return max(1, int(np.ceil(np.max(np.diff(series.times)) / STEP_S - 1e-6)))


def _regular(matrix: Float) -> Float:
    return matrix + 1e-14 * np.trace(matrix) * np.eye(len(matrix)) + 1e-18 * np.eye(len(matrix))
