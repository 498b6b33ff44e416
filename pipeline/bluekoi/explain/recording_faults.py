"""Duplicate recordings, and single samples that cannot be measurements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..data import Float
from ..errors import InputIssue

if TYPE_CHECKING:
    from .trials import Trial

MAX_UNREPORTED_GAP_INTERVALS = 20.0
"""A longer pause than this many usual sampling intervals is reported."""
MIN_MEDIAN_OVER_MEAN_INTERVAL = 0.1
"""Median over mean sampling interval below which the times of a recording come in groups."""
MIN_SPIKE_DISTANCE_RANGES, MIN_SPIKE_SAMPLES = 10.0, 20
"""A single sample that lies further from both its neighbours than so many times the range of all
others is no measurement; asked of columns with so many samples."""


def median_interval_s(trials: Sequence[Trial]) -> float:
    """Usual sampling interval of trials."""
    return float(np.median([np.median(np.diff(t.times)) for t in trials]))


def has_grouped_sampling(times: Float) -> bool:
    """Whether most samples (n,) of a recording are far closer than they are on average."""
    steps = np.diff(times)
    return bool(np.median(steps) < MIN_MEDIAN_OVER_MEAN_INTERVAL * steps.mean())


def samples_after_gaps(times: Float) -> np.ndarray:
    """Samples before which a recording pauses; none where its times come in groups."""
    steps = np.diff(times)
    if has_grouped_sampling(times):
        return np.zeros(0, dtype=int)
    return np.flatnonzero(steps > MAX_UNREPORTED_GAP_INTERVALS * np.median(steps)) + 1


def duplicate_recordings(trials: Sequence[Trial]) -> list[InputIssue]:
    """Trials that hold the samples of a trial before: evidence must not count twice."""
    out = []
    for k, t in enumerate(trials):
        first = next((o for o in trials[:k] if _has_same_samples(o, t)), None)
        if first is not None:
            out.append(InputIssue(t.source or t.name, "", f"the samples of {first.name}",
                                  "a recording of its own", "Remove one of the two."))  # fmt: skip
    return out


def _has_same_samples(a: Trial, b: Trial) -> bool:
    if len(a.times) != len(b.times) or a.times[0] - b.times[0] != a.times[-1] - b.times[-1]:
        return False
    pairs = [(np.asarray(x[n], dtype=float), np.asarray(y[n], dtype=float))
             for x, y in ((a.observed, b.observed), (a.inputs, b.inputs)) for n in x]  # fmt: skip
    moved = any(np.nanmax(x) > np.nanmin(x) for x, _ in pairs[: len(a.observed)])
    return moved and all(np.array_equal(x, y, equal_nan=True) for x, y in pairs)


def motionless_findings(trials: Sequence[Trial]) -> list[InputIssue]:
    """A finding where no observation changes within any of the trials to fit: nothing determines
    how the state changes.
    """
    columns = [np.asarray(x, dtype=float) for t in trials for x in t.observed.values()]
    if any(np.nanmax(x) > np.nanmin(x) for x in columns):
        return []
    return [InputIssue("trials", "", "observations that are constant in each trial", "a motion",
                       "Do the columns hold what their names say?")]  # fmt: skip


def spike_findings(file: str, name: str, column: Float) -> list[InputIssue]:
    """The sample of an observation that lies far beyond all others, such as a code for nothing
    seen.
    """
    rows = np.flatnonzero(np.isfinite(column))
    x = column[rows]
    if len(x) < MIN_SPIKE_SAMPLES:
        return []
    if (code := _missing_value_sentinel(x)) is not None:
        k = int(np.flatnonzero(x == code)[0])
        return [_spike_finding(file, name, int(rows[k]), code, x[x != code])]
    step = np.diff(x)
    out_and_back = step[:-1] * step[1:] < 0.0
    size = np.where(out_and_back, np.minimum(np.abs(step[:-1]), np.abs(step[1:])), 0.0)
    far = np.concatenate([[False], size > 0.1 * size.max(), [False]])
    rest = float(np.ptp(x[~far]))
    spikes = np.flatnonzero(size > MIN_SPIKE_DISTANCE_RANGES * rest) + 1
    if not (rest > 0.0 and len(spikes)):
        return []
    k = int(spikes[0])
    return [_spike_finding(file, name, int(rows[k]), float(x[k]), x[~far])]


def _spike_finding(file: str, name: str, sample: int, value: float, others: Float) -> InputIssue:
    return InputIssue(file, f"{name}, sample {sample}", f"{value:g}",
                      f"a value near the others, {others.min():g} to {others.max():g}",
                      "Leave the cell empty where nothing was seen.")  # fmt: skip


def _missing_value_sentinel(x: Float) -> float | None:
    """A value that stands several times, to the last digit, far beyond the range of all others."""
    for value in (float(x.min()), float(x.max())):
        others = x[x != value]
        if len(x) - len(others) < 2 or len(others) < MIN_SPIKE_SAMPLES:
            continue
        beyond = max(others.min() - value, value - others.max())
        if beyond > MIN_SPIKE_DISTANCE_RANGES * np.ptp(others) > 0:
            return value
    return None
