"""The force that a model lacks, and the force that its additions exert, along its trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import simulate_batch
from .filtering import (
    FilterResults,
    filter_all,
    parameters_with_random_effects_on,
    random_state_indices,
    rts_smooth,
)
from .series import Noise, TrialSeries

IMPULSE_DURATION_S = 1e-3
"""Duration over which forces are compared by the change of the velocities."""
MAX_RMS_FORCE_FRAMES = 512
"""Frames, evenly spread over all trials, of which a root mean square force is taken: of independent
normal forces its standard error is (2 * 512)^-1/2 = 3 %. It scales prior standard deviations that
are known to a factor of three at best."""


@dataclass(frozen=True)
class MissingForce:
    """Smoothed missing force of one trial: force and std (n, channels), states (n, states)."""

    name: str
    times: Float
    force: Float
    std: Float
    states: Float


def missing_force(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise
) -> list[MissingForce]:
    """`MissingForce` of every trial around a fitted model."""
    slots = random_state_indices(kernel, acting=True)
    out = []
    for one, result in zip(series, filter_all(kernel, series, values, noise), strict=True):
        mean, cov = rts_smooth(result)
        std = np.sqrt(np.maximum(np.einsum("nii->ni", cov[:, slots][:, :, slots]), 0.0))
        out.append(MissingForce(one.name, one.times, mean[:, slots], std, mean))
    return out


def force_of_added_effects(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
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
        state, _ = rts_smooth(result)
        changed, base = (
            np.tile(parameters_with_random_effects_on(kernel, v, noise), (len(state), 1))
            for v in (with_, without)
        )
        force = _forces_of_parameter_changes(kernel, state, base, [changed], times=one.times,
                                   inputs=one.inputs,
                                   constants=np.tile(one.constants, (len(state), 1)))  # fmt: skip
        out.append(force[:, :, 0])
    return out


def rms_forces_of_parameter_changes(
    kernel: CompiledSystem, passes: FilterResults, points: Sequence[Float],
    changes: Sequence[Sequence[Float]], noise: Noise,
) -> Float:  # fmt: skip
    """Root mean square (changes, channels), over `MAX_RMS_FORCE_FRAMES` frames of all trials, of
    the force by which each change of the parameters differs from `points`, along the filtered
    paths.

    changes: full parameter vectors of every trial, for each change.
    """
    series = passes.series
    each = np.repeat(np.arange(len(passes)), [len(s.times) for s in series])
    chosen = np.linspace(0, len(each) - 1, min(len(each), MAX_RMS_FORCE_FRAMES)).round().astype(int)
    each = each[chosen]

    def of_frames(vectors: Sequence[Float]) -> Float:
        return parameters_with_random_effects_on(kernel, np.array(vectors).T, noise).T[each]

    state, base = np.concatenate([f.filtered for f in passes])[chosen], of_frames(points)
    times, inputs = (np.concatenate([getattr(s, k) for s in series])[chosen]
                     for k in ("times", "inputs"))  # fmt: skip
    constants = np.array([s.constants for s in series])[each]
    most, out = LANES - 1 - len(random_state_indices(kernel, acting=True)), []
    for begin in range(0, len(changes), most):
        some = [of_frames(change) for change in changes[begin : begin + most]]
        force = _forces_of_parameter_changes(kernel, state, base, some, times=times, inputs=inputs,
                                   constants=constants)  # fmt: skip
        out.append(np.sqrt(np.mean(force**2, axis=0)).T)
    return np.concatenate(out) if out else np.zeros((0, LANES - 1 - most))


def _forces_of_parameter_changes(
    kernel: CompiledSystem, state: Float, base: Float, changed: Sequence[Float], *, times: Float,
    inputs: Float, constants: Float,
) -> Float:  # fmt: skip
    """Force (n, channels, changes) at n states by which changed parameters (n, parameters) differ
    from the base: the impulse over `IMPULSE_DURATION_S`, in those of unit random forces.
    """
    slots = random_state_indices(kernel, acting=True)
    first = 1 + len(slots)
    lanes = np.repeat(state[:, :, None], LANES, axis=2)
    for k, slot in enumerate(slots):
        lanes[:, slot, 1 + k] += 1.0
    values = np.repeat(base[:, :, None], LANES, axis=2)
    values[:, :, first : first + len(changed)] = np.stack(changed, axis=2)
    _, after = simulate_batch(
        kernel, lanes, values, np.repeat(constants[:, :, None], LANES, axis=2),
        times=times[:, None] + np.array([0.0, IMPULSE_DURATION_S]), keep_states=True,
        inputs=np.repeat(inputs[:, None], 2, axis=1),
    )  # fmt: skip
    own = after[:, 1, : len(kernel.system.states)]
    with np.errstate(invalid="ignore"):
        moved = np.nan_to_num(own - own[:, :, :1], posinf=0.0, neginf=0.0)  # a model that ran away
    force: Float = np.linalg.pinv(moved[:, :, 1:first]) @ moved[:, :, first : first + len(changed)]
    return force
