"""Trials side by side, padded to the longest, with all that stays while a fit goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import MAX_INTEGRATION_STEP_S
from .predictions import parameter_index_by_name
from .series import FreeParameter, TrialSeries, observations_and_weights, padded_arrays

COARSE_INTEGRATION_STEP_S = 2 * MAX_INTEGRATION_STEP_S
"""Step of the integrator while a fit is led to where it may begin."""


@dataclass(frozen=True)
class PaddedTrials:
    """Everything that stays, padded to the longest trial: t trials, n frames, o observations.

    own: for each free number, its place among the parameters and the trials (t,) it stands for.
    """

    kernel: CompiledSystem
    base: Float
    own: tuple[tuple[int, np.ndarray], ...]
    least_step: Float
    open_states: int
    times: Float
    inputs: Float
    frames: np.ndarray
    constants: Float
    seen: Float
    weight: Float
    prior: Float
    prior_std: Float
    step_s: float = MAX_INTEGRATION_STEP_S

    def first_share_of_trials(self, share: float) -> PaddedTrials:
        """The first share of each trial's frames, two at least; in longer steps unless all."""
        frames = np.maximum(2, np.ceil(share * self.frames).astype(int))
        longest = slice(0, int(frames.max()))
        late = np.arange(longest.stop) >= frames[:, None]
        return replace(
            self, frames=frames, times=self.times[:, longest], inputs=self.inputs[:, longest],
            seen=self.seen[:, longest],
            weight=np.where(late[:, :, None], 0.0, self.weight[:, longest]),
            step_s=MAX_INTEGRATION_STEP_S if share == 1.0 else COARSE_INTEGRATION_STEP_S,
        )  # fmt: skip


def padded_trials(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    free: Sequence[FreeParameter],
    open_states: int,
) -> PaddedTrials:
    """Trials of a fit side by side.

    Raises: ValueError where a trial has more free numbers than lanes.
    """
    if open_states + len(free) > LANES - 1:
        raise ValueError(f"{open_states + len(free)} numbers a trial, at most {LANES - 1}")
    frames, seen, weight = observations_and_weights(series)
    slots, parameters = parameter_index_by_name(kernel), kernel.system.parameters
    groups = np.array([s.group for s in series])
    own = [np.full(len(series), True) if f.group is None else groups == f.group for f in free]
    starts = [abs(parameters[slots[f.name]].start) for f in free]
    return PaddedTrials(
        kernel, base, tuple(zip([slots[f.name] for f in free], own, strict=True)),
        least_step=np.maximum(0.05 * np.array(starts), 1e-6),
        open_states=open_states,
        times=padded_arrays([s.times for s in series]),
        inputs=padded_arrays([s.inputs for s in series]),
        frames=frames,
        constants=np.repeat(np.array([s.constants for s in series])[:, :, None], LANES, axis=2),
        seen=seen,
        weight=weight,
        prior=np.array([s.mean for s in series]),
        prior_std=np.sqrt([s.cov.diagonal() for s in series]),
    )  # fmt: skip
