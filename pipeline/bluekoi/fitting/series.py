"""What a fit is made to: one time series a trial, and the noise that is in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..data import Float


@dataclass(frozen=True, eq=False)
class SharedMeasurement:
    """A vector that was measured once for all trials, such as lengths all over a pool.

    parameters: names of those that its prediction depends on. errors: their values (k,) -> its
    errors (m,), independent and of unit variance. trials: how many trials share it.
    """

    parameters: tuple[str, ...]
    errors: Callable[[Float], Float]
    trials: int


@dataclass(frozen=True)
class TrialSeries:
    """One trial as the filter sees it.

    times (n,), inputs (n, inputs), constants (constants,), seen (n, observations) with NaN where
    missing, noise (n, observations, observations), mean (states,) and cov (states, states) before
    the first frame. group: what trials share that have coefficients of their own (a power).
    condition: what repeats share. evidence: name -> (value, std) of side measurements. shared: one
    that all trials share. force_size: of the random forces in this trial, over `Noise.disturbance`.
    """

    name: str
    group: str
    condition: str
    times: Float
    inputs: Float
    constants: Float
    seen: Float
    noise: Float
    mean: Float
    cov: Float
    evidence: dict[str, tuple[float, float]] = field(default_factory=dict)
    shared: SharedMeasurement | None = None
    force_size: float = 1.0

    def slice_frames(self, first: int, last: int) -> TrialSeries:
        """Frames `first` to `last` (excluded) of the trial, with the same start."""
        part = slice(first, last)
        return replace(self, times=self.times[part], inputs=self.inputs[part],
                       seen=self.seen[part], noise=self.noise[part])  # fmt: skip


@dataclass(frozen=True)
class TrialEffect:
    """A parameter that differs from trial to trial, normally distributed about its common value.

    std: standard deviation in the parameter's unit, whatever its common value is.
    """

    parameter: str
    std: float


@dataclass(frozen=True)
class Noise:
    """Strength of what is random.

    disturbance (random states,): stationary standard deviation of each random state, in the order
    of the system's states, of forces in a trial of `force_size` 1; states beyond its end are
    absent. tau (random states,), or one for all:
    correlation times [s]. scale (observations,): factor on the stated standard deviation of each
    observation. trial_effects: errors that are constant within a trial and differ between trials.
    least_scale: lower bound of estimates of `scale`, 1 if the stated deviations are those of the
    instrument. fixed_scales: indices of the observations whose `scale` is not estimated.
    """

    disturbance: Float
    tau: Float
    scale: Float
    trial_effects: tuple[TrialEffect, ...] = ()
    least_scale: float = 0.0
    fixed_scales: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if np.any(self.disturbance < 0) or np.any(self.scale <= 0) or np.any(self.tau <= 0):
            raise ValueError("noise strengths must be positive")
        object.__setattr__(self, "tau", np.broadcast_to(self.tau, self.disturbance.shape).copy())


@dataclass(frozen=True)
class FreeParameter:
    """One number that a fit may change: a parameter, for all groups or for one alone."""

    name: str
    group: str | None = None

    @property
    def label(self) -> str:
        """Name in tables: `C_Md` or `C_Md@50`."""
        return self.name if self.group is None else f"{self.name}@{self.group}"


def padded_arrays(parts: Sequence[Float]) -> Float:
    """Trials of unequal length as one array (trials, frames, ...), the last frame repeated."""
    longest = max(len(p) for p in parts)
    return np.array([np.concatenate([p, np.repeat(p[-1:], longest - len(p), axis=0)])
                     for p in parts])  # fmt: skip


def observations_and_weights(series: Sequence[TrialSeries]) -> tuple[np.ndarray, Float, Float]:
    """Frames (t,) of trials side by side; what was seen (t, n, o) and its weight, one over the
    stated deviation; both 0 where missing or after a trial's end.
    """
    seen = padded_arrays([s.seen for s in series])
    variance = padded_arrays([np.diagonal(s.noise, axis1=1, axis2=2) for s in series])
    frames = np.array([len(s.times) for s in series])
    known = np.isfinite(seen) & (np.arange(seen.shape[1]) < frames[:, None])[:, :, None]
    return frames, np.where(known, seen, 0.0), known / np.sqrt(variance)
