"""Recordings drawn from a model: the parametric bootstrap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import simulate_batch
from .filtering import (
    parameters_with_random_effects_on,
    random_state_indices,
    random_state_std_factors,
)
from .series import Noise, TrialSeries, padded_arrays


def parametric_bootstrap(  # noqa: PLR0917
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float],
    noises: Sequence[Noise], starts: Float, rng: np.random.Generator,
) -> list[TrialSeries]:  # fmt: skip
    """Trials from `starts` (trials, states), their observations drawn again at random.

    values: full parameter vectors; noises: one a trial, of the same correlation times tau. Between
    frames everything moves as modelled; at each frame the random states get an increment of
    variance sigma^2 (1 - exp(-2 dt / tau)).
    """
    state, tau = starts.copy(), noises[0].tau
    points = np.array(
        [
            parameters_with_random_effects_on(kernel, v, n)
            for v, n in zip(values, noises, strict=True)
        ]
    )
    times, inputs = (
        padded_arrays([s.times for s in series]),
        padded_arrays([s.inputs for s in series]),
    )
    constants = np.array([s.constants for s in series])
    sigma = np.array([n.disturbance for n in noises])
    slots = random_state_indices(kernel)[: sigma.shape[1]]
    sigma = sigma * random_state_std_factors(kernel, series)[:, : sigma.shape[1]]
    decay = np.zeros(sigma.shape)
    observed = np.zeros((*times.shape, len(kernel.system.observations)))
    for k in range(times.shape[1]):
        normal = rng.standard_normal(sigma.shape)
        state[:, slots] += sigma * np.sqrt(1 - decay**2) * normal
        following = min(k + 1, times.shape[1] - 1)
        seen, states = simulate_batch(
            kernel, *map(_repeat_rows_over_lanes, (state, points, constants)),
            times=times[:, [k, following]], inputs=inputs[:, [k, following]], keep_states=True,
        )  # fmt: skip
        observed[:, k], state = seen[:, 0, :, 0], states[:, 1, :, 0].copy()
        decay = np.exp(-(times[:, following] - times[:, k])[:, None] / tau)
    return [_with_white_noise(s, n, observed[i, : len(s.times)], rng)
            for i, (s, n) in enumerate(zip(series, noises, strict=True))]  # fmt: skip


def _with_white_noise(
    one: TrialSeries, noise: Noise, observed: Float, rng: np.random.Generator
) -> TrialSeries:
    root = np.linalg.cholesky(one.noise + 1e-18 * np.eye(one.noise.shape[1]))
    white = np.einsum("nij,nj->ni", root, rng.standard_normal(observed.shape)) * noise.scale
    return replace(one, seen=np.where(np.isfinite(one.seen), observed + white, np.nan))


def _repeat_rows_over_lanes(rows: Float) -> Float:
    return np.repeat(rows[:, :, None], LANES, axis=2)
