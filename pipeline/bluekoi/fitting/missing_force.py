"""The force that a model lacks, and the force that its additions exert, along its trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate
from .filtering import FilterResults, disturbance_slots, filter_all, smooth, with_noise
from .series import Noise, Series

IMPULSE_S = 1e-3
"""Duration over which forces are compared by the change of the velocities."""


@dataclass(frozen=True)
class MissingForce:
    """Smoothed missing force of one trial: force and std (n, channels), states (n, states)."""

    name: str
    times: Float
    force: Float
    std: Float
    states: Float


def missing_force(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise
) -> list[MissingForce]:
    """`MissingForce` of every trial around a fitted model."""
    slots = disturbance_slots(kernel, acting=True)
    out = []
    for one, result in zip(series, filter_all(kernel, series, values, noise), strict=True):
        mean, cov = smooth(result)
        std = np.sqrt(np.maximum(np.einsum("nii->ni", cov[:, slots][:, :, slots]), 0.0))
        out.append(MissingForce(one.name, one.times, mean[:, slots], std, mean))
    return out


def added_force(
    kernel: Kernel,
    series: Sequence[Series],
    on: Sequence[Float],
    off: Sequence[Float],
    noise: Noise,
) -> list[Float]:
    """Force (n, channels) that a model's additions exert along the smoothed path of each trial.

    on, off: full parameter vectors of every trial with and without the additions. The force is what
    changes the velocities over a moment as the additions do, by the change that a unit of each
    random force makes.
    """
    out = []
    for one, result, with_, without in zip(
        series, filter_all(kernel, series, on, noise), on, off, strict=True
    ):
        state, _ = smooth(result)
        out.append(_force_difference(kernel, one, state, with_noise(kernel, with_, noise),
                               without=with_noise(kernel, without, noise)))  # fmt: skip
    return out


def _force_difference(
    kernel: Kernel, one: Series, state: Float, with_: Float, *, without: Float
) -> Float:
    slots, n = disturbance_slots(kernel, acting=True), len(one.times)
    lanes = np.repeat(state[:, :, None], LANES, axis=2)
    for k, slot in enumerate(slots):
        lanes[:, slot, 2 + k] += 1.0
    values = np.repeat(without[:, None], LANES, axis=1)
    values[:, 0] = with_
    constants = np.repeat(one.constants[:, None], LANES, axis=1)
    _, after = propagate(
        kernel, lanes, np.repeat(values[None], n, axis=0), np.repeat(constants[None], n, axis=0),
        times=one.times[:, None] + np.array([0.0, IMPULSE_S]), keep_states=True,
        inputs=np.repeat(one.inputs[:, None], 2, axis=1),
    )  # fmt: skip
    own = after[:, 1, : len(kernel.system.states)]
    with np.errstate(invalid="ignore"):
        moved = np.nan_to_num(own - own[:, :, 1:2], posinf=0.0, neginf=0.0)  # a model that ran away
    return (np.linalg.pinv(moved[:, :, 2 : 2 + len(slots)]) @ moved[:, :, :1])[:, :, 0]


def rms_forces(
    kernel: Kernel, passes: FilterResults, points: Sequence[Float],
    changes: Sequence[Sequence[Float]], noise: Noise,
) -> Float:  # fmt: skip
    """Root mean square (changes, channels), over all frames of all trials, of the force by which
    each change of the parameters differs from `points`, along the filtered paths.

    changes: full parameter vectors of every trial, for each change.
    """
    slots = disturbance_slots(kernel, acting=True)
    each = np.repeat(np.arange(len(passes)), [len(s.times) for s in passes.series])
    times = np.concatenate([s.times for s in passes.series])[:, None] + np.array([0.0, IMPULSE_S])
    inputs = np.repeat(np.concatenate([s.inputs for s in passes.series])[:, None], 2, axis=1)
    constants = np.array([s.constants for s in passes.series])[each]
    state = np.repeat(np.concatenate([f.filtered for f in passes])[:, :, None], LANES, axis=2)
    for k, slot in enumerate(slots):
        state[:, slot, 1 + k] += 1.0
    first, out = 1 + len(slots), []
    for begin in range(0, len(changes), LANES - first):
        some = changes[begin : begin + LANES - first]
        lanes = [points] * first + list(some) + [points] * (LANES - first - len(some))
        values = np.array([[with_noise(kernel, v, noise) for v in of] for of in lanes])
        _, after = propagate(
            kernel, state, np.moveaxis(values, 0, 2)[each],
            np.repeat(constants[:, :, None], LANES, axis=2), times=times, inputs=inputs,
            keep_states=True,
        )  # fmt: skip
        own = after[:, 1, : len(kernel.system.states)]
        with np.errstate(invalid="ignore"):
            moved = np.nan_to_num(own - own[:, :, :1], posinf=0.0, neginf=0.0)
        force = np.linalg.pinv(moved[:, :, 1:first]) @ moved[:, :, first : first + len(some)]
        out.append(np.sqrt(np.mean(force**2, axis=0)).T)
    return np.concatenate(out) if out else np.zeros((0, len(slots)))
