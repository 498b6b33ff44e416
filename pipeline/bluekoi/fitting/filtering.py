"""Prediction errors of a model on its trials, through an extended Kalman filter around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import overload

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem, Effect, System
from ..integrate.batch import active_effects_by_parameter_vector, threaded_map
from .series import Noise, TrialSeries, padded_arrays

MAX_FILTER_STEP_S = 1 / 30
"""Longest integration step between observations, to 1 %: its error is far below a frame's noise.
1/20 s would do for accuracy, but a strong fin damps yaw at 80/s, for which Runge and Kutta's steps
are unstable from 1/30 s on.
"""
STATE_FINITE_DIFFERENCE_STEP = (
    1e-5  # size of state differences for the transition matrix, in each state's SI unit
)


@dataclass(frozen=True)
class FilteredTrial:
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


@dataclass(frozen=True)
class FilterResults(Sequence[FilteredTrial]):
    """Filter results of all trials t, with padded arrays for fixed-gain prediction.

    Shorter trials are padded with their last frame: gains (t, n, s, o), roots (t, n, o, o), times
    (t, n), inputs (t, n, inputs), seen (t, n, o); frames (t,) and log_lik_const (t,).
    """

    series: tuple[TrialSeries, ...]
    each: tuple[FilteredTrial, ...]

    def __len__(self) -> int:
        return len(self.each)

    @overload
    def __getitem__(self, index: int) -> FilteredTrial: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[FilteredTrial]: ...

    def __getitem__(self, index: int | slice) -> FilteredTrial | Sequence[FilteredTrial]:
        return self.each[index]

    @cached_property
    def gains(self) -> Float:
        """What a frame's innovation corrects the states by."""
        return padded_arrays([f.gains for f in self.each])

    @cached_property
    def inverse_innovation_cholesky(self) -> Float:
        """Inverse Cholesky factors of the innovation covariances."""
        return padded_arrays([f.roots for f in self.each])

    @cached_property
    def times(self) -> Float:
        """Times of the frames, s."""
        return padded_arrays([s.times for s in self.series])

    @cached_property
    def inputs(self) -> Float:
        """Inputs at the frames."""
        return padded_arrays([s.inputs for s in self.series])

    @cached_property
    def padded_observations(self) -> Float:
        """What was seen, 0 where missing."""
        return np.nan_to_num(padded_arrays([s.seen for s in self.series]))

    @cached_property
    def frame_counts(self) -> np.ndarray:
        """How many frames of each trial count."""
        return np.array([len(s.times) for s in self.series])

    @cached_property
    def log_lik_const(self) -> Float:
        """Log likelihood but for the squares of the whitened innovations."""
        return np.array([f.log_likelihood + 0.5 * float(np.sum(f.innovations**2))
                         for f in self.each])  # fmt: skip


def filter_series(
    kernel: CompiledSystem, series: TrialSeries, values: Float, noise: Noise
) -> FilteredTrial:
    """`FilteredTrial` of one trial for a full parameter vector `(parameters,)`."""
    return filter_all(kernel, [series], [values], noise)[0]


def filter_all(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise
) -> FilterResults:
    """`filter_series` for every trial with its own parameter vector, on all cores."""
    shared = _noise_arrays(kernel, noise)
    full = parameters_with_random_effects_on(kernel, np.array(values).T, noise).T.copy()
    on = active_effects_by_parameter_vector(kernel.system, full)
    jobs = list(zip(series, full, on, random_state_std_factors(kernel, series), strict=True))
    found = threaded_map(lambda job: _filter_trial(kernel, *job, shared=shared), jobs)
    return FilterResults(tuple(series), tuple(found))


@dataclass(frozen=True)
class _NoiseArrays:
    """What one noise means for all trials: variance and memory of states, places, scales."""

    noise: Noise
    variance: Float
    memory: Float
    random: np.ndarray
    difference: Float
    scales: Float


def _noise_arrays(kernel: CompiledSystem, noise: Noise) -> _NoiseArrays:
    count = len(kernel.system.all_states)
    variance, memory = np.zeros(count), np.ones(count)
    slots = np.array(random_state_indices(kernel)[: len(noise.disturbance)], dtype=int)
    variance[slots], memory[slots] = noise.disturbance**2, noise.tau
    scales = np.outer(noise.scale, noise.scale)
    return _NoiseArrays(
        noise, variance, memory, slots, np.full(count, STATE_FINITE_DIFFERENCE_STEP), scales
    )


def _filter_trial(
    kernel: CompiledSystem, series: TrialSeries, values: Float, on: np.ndarray, sizes: Float, *,
    shared: _NoiseArrays,
) -> FilteredTrial:  # fmt: skip
    """One trial; values (parameters,) with the random parts switched on, on (effects,): those that
    act, sizes: a row of `random_state_std_factors`.
    """
    n, s, o = len(series.times), len(kernel.system.all_states), len(kernel.system.observations)
    shapes = ((n, s, o), (n, o, o), (n, s, s), (n, s), (n, s), (n, s, s), (n, s, s), (n, o))
    gains, roots, transitions, predicted, filtered, cov_p, cov_f, innovations = map(
        np.zeros, shapes
    )
    cov, variance = series.cov.copy(), shared.variance.copy()
    variance[shared.random] *= sizes[: len(shared.random)] ** 2
    cov[shared.random, shared.random] = variance[shared.random]
    step_s = kernel.system.longest_step_s(MAX_FILTER_STEP_S)
    log_likelihood = kernel.kalman(
        series.mean, cov, values, series.constants, series.times, series.inputs, series.seen,
        series.noise * shared.scales, variance, shared.memory, shared.difference,
        state_indices_of_active_effects(kernel.system, on), on, step_s, gains, roots, transitions,
        predicted, filtered, cov_p, cov_f, innovations,
    )  # fmt: skip
    return FilteredTrial(
        log_likelihood, innovations, gains, roots, transitions, predicted, filtered, cov_p, cov_f
    )


def rts_smooth(result: FilteredTrial) -> tuple[Float, Float]:
    """Rauch-Tung-Striebel means `(n, states)` and covariances `(n, states, states)`."""
    mean, cov = result.filtered.copy(), result.cov_filtered.copy()
    # C_k = P_k F' (P_k+1|k)^-1, of all frames at once
    predicted = result.cov_predicted[1:]
    moved = result.transitions[1:] @ result.cov_filtered[:-1]
    C = np.swapaxes(np.linalg.solve(_regularised(predicted), moved), 1, 2)
    for k in range(len(mean) - 2, -1, -1):
        mean[k] += C[k] @ (mean[k + 1] - result.predicted[k + 1])
        cov[k] += C[k] @ (cov[k + 1] - predicted[k]) @ C[k].T
    return mean, cov


def random_state_indices(kernel: CompiledSystem, *, acting: bool = False) -> list[int]:
    """Places of the random states in the state vector; of those alone that push, where `acting`."""
    return [
        kernel.system.all_states.index(s)
        for effect in disturbance_effects(kernel)
        if effect.channels or not acting
        for s in effect.states
    ]


def random_state_std_factors(kernel: CompiledSystem, series: Sequence[TrialSeries]) -> Float:
    """Standard deviations (trials, random states) over those of `Noise.disturbance`: those of
    forces have the `force_size` of their trial.
    """
    pushing = set(random_state_indices(kernel, acting=True))
    acts = np.array([slot in pushing for slot in random_state_indices(kernel)])
    return np.where(acts, np.array([s.force_size for s in series])[:, None], 1.0)


def disturbance_effects(kernel: CompiledSystem) -> list[Effect]:
    """The system's random parts, in the order of their states."""
    return [e for e in kernel.system.effects if e.kind == "disturbance"]


def parameters_with_random_effects_on(kernel: CompiledSystem, values: Float, noise: Noise) -> Float:
    """`values` (parameters, ...) with the random parts of `noise` switched on, as a copy.

    A random effect's parameters are `present` and then a memory for all its states, or one each.
    """
    out = values.copy()
    for present, memories, first, last in _stochastic_effect_slots(kernel.system):
        acts = bool(np.any(noise.disturbance[first:last] > 0))
        out[present] = float(acts)
        for i, slot in enumerate(memories if acts else ()):
            out[slot] = noise.tau[first + i]
    return out


@lru_cache(maxsize=64)
def _stochastic_effect_slots(system: System) -> tuple[tuple[int, tuple[int, ...], int, int], ...]:
    """Of each random effect: places of `present` and of its memories, its states from and to."""
    out, at = [], 0
    for effect in (e for e in system.effects if e.kind == "disturbance"):
        present, *memories = system.effect_parameter_indices(effect.name)
        out.append((present, tuple(memories), at, at + len(effect.states)))
        at += len(effect.states)
    return tuple(out)


def state_indices_of_active_effects(system: System, on: np.ndarray) -> np.ndarray:
    """Places of the model's states and of those of the effects that are on, uint8 (effects,)."""
    return _active_state_indices(system, on.tobytes())


@lru_cache(maxsize=512)
def _active_state_indices(system: System, on: bytes) -> np.ndarray:
    used = [s for e, acts in zip(system.effects, on, strict=True) if acts for s in e.states]
    return np.array([system.all_states.index(n) for n in (*system.states, *used)])


def _regularised(matrices: Float) -> Float:
    """Matrices (n, s, s) with small numbers added to their diagonals, so that they are regular."""
    traces = np.trace(matrices, axis1=1, axis2=2)[:, None, None]
    return matrices + (1e-14 * traces + 1e-18) * np.eye(matrices.shape[1])
