"""Recordings as a model would have given them, with its random forces and errors drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import Noise, Series, filter_all, smooth
from ..fitting.filtering import disturbance_slots, with_noise
from ..fitting.series import filled
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate


def simulated(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise,
    rng: np.random.Generator,
) -> list[Series]:  # fmt: skip
    """Trials begun where the smoother has them, their observations drawn again at random.

    Between frames everything moves as modelled; at each frame the random states of correlation
    time tau get a kick of variance sigma^2 (1 - exp(-2 dt / tau)).
    """
    state = np.array([smooth(f)[0][0] for f in filter_all(kernel, series, values, noise)])
    points = np.array([with_noise(kernel, v, noise) for v in values])
    times, inputs = filled([s.times for s in series]), filled([s.inputs for s in series])
    constants = np.array([s.constants for s in series])
    slots = disturbance_slots(kernel)[: len(noise.disturbance)]
    keep = np.zeros((len(series), len(slots)))
    observed = np.zeros((len(series), times.shape[1], len(kernel.system.observations)))
    for k in range(times.shape[1]):
        kick = rng.standard_normal((len(series), len(slots)))
        state[:, slots] += noise.disturbance * np.sqrt(1 - keep**2) * kick
        ahead = min(k + 1, times.shape[1] - 1)
        seen, states = propagate(
            kernel, _lanes(state), _lanes(points), _lanes(constants),
            times=times[:, [k, ahead]], inputs=inputs[:, [k, ahead]], keep_states=True,
        )  # fmt: skip
        observed[:, k], state = seen[:, 0, :, 0], states[:, 1, :, 0].copy()
        keep = np.exp(-(times[:, ahead] - times[:, k])[:, None] / noise.tau)
    return [_with_white(s, noise, observed[i, : len(s.times)], rng) for i, s in enumerate(series)]


def _with_white(one: Series, noise: Noise, clean: Float, rng: np.random.Generator) -> Series:
    root = np.linalg.cholesky(one.noise + 1e-18 * np.eye(one.noise.shape[1]))
    white = np.einsum("nij,nj->ni", root, rng.standard_normal(clean.shape)) * noise.scale
    return replace(one, seen=np.where(np.isfinite(one.seen), clean + white, np.nan))


def _lanes(rows: Float) -> Float:
    return np.repeat(rows[:, :, None], LANES, axis=2)
