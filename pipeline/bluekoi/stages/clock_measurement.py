"""The tail beat seen, compared with the motor's, as a measurement of the video's clock.

A clock is wrong by one share in all trials. The ratios of the trials differ for other reasons as
well, which a one-way model of random effects separates (Searle, Casella and McCulloch, Variance
Components (1992), sec. 3.6): errors of each trial, which average out, and errors common to the
trials of a power, such as a supply that sags under load. The latter need not be zero on average:
their variance, estimated between the powers, counts in full.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import FlappingFrequency, Float
from ..fitting import TrialSeries
from ..mismatch.robot_problem import PRIOR_INCLUSION_PROBABILITIES
from ..mismatch.wrong_clock import with_clock_error_in_trials
from .clock_factor import MIN_CLOCK_RATIO_STD_SHARE

STATED_FREQUENCY_STD_SHARE = (
    0.01  # ASSUME a `flap_hz` that several trials share, so not measured in each, is right to 1 %
)
UNCHECKED_FRAME_RATE_STD_SHARE = (
    0.05  # ASSUME a frame rate that no tail beat checks is right to 5 %
)
MIN_TRIALS_TO_SPLIT = 4
"""Trials without which no part of them is compared with the others: two variances about a mean need
two trials each."""
MAX_DISTINCT_FREQUENCY_SHARE = 0.5
"""Stated frequencies were not measured trial by trial where at most so many of them differ."""


def with_clock_measurement(
    series: Sequence[TrialSeries], flapping: Mapping[str, FlappingFrequency]
) -> list[TrialSeries]:
    """Series with the ratio of the tail beat seen to the motor's as evidence on the clock; that to
    a frequency stated for several trials is evidence on a sag of the supply as well.

    The standard deviations are such that those of all trials together give that of the mean ratio.
    Where no trial shows its tail beat, nothing but the statement speaks for the frame rate.
    """
    beats = {s.name: flapping[s.name] for s in series}
    seen = [s for s in series if beats[s.name].flap_hz > 0 and np.isfinite(beats[s.name].video_hz)]
    if not seen:
        unchecked = UNCHECKED_FRAME_RATE_STD_SHARE * float(np.sqrt(len(series)))
        return [
            replace(s, evidence={**s.evidence, "clock_ratio": (0.0, unchecked)}) for s in series
        ]
    found = [beats[s.name] for s in seen]
    ratio = np.array([b.video_hz / b.flap_hz - 1 for b in found])
    own: Float = np.nan_to_num(np.array([b.video_hz_std / b.flap_hz for b in found]))
    stated = _are_frequencies_shared_by_trials(found)
    groups = [s.group for s in seen]
    floor = np.hypot(own, MIN_CLOCK_RATIO_STD_SHARE)
    wrong = None if stated else split_by_clock_ratio(ratio, floor, groups)
    if wrong is not None:
        return _with_clock_error_of_some_trials(series, [s.name for s in seen], ratio, own, wrong)
    within, between = within_between_group_variances(ratio, own**2, groups)
    shared = between + _drift_variance(seen, found) + stated * STATED_FREQUENCY_STD_SHARE**2
    std = np.sqrt(MIN_CLOCK_RATIO_STD_SHARE**2 + own**2 + within + len(ratio) * shared)
    evidence = {s.name: (float(r), float(d)) for s, r, d in zip(seen, ratio, std, strict=True)}
    name = "stated_ratio" if stated else "clock_ratio"
    return [
        replace(s, evidence={**s.evidence, name: evidence[s.name]}) if s.name in evidence else s
        for s in series
    ]


def split_by_clock_ratio(ratio: Float, std: Float, groups: Sequence[str]) -> np.ndarray | None:
    """Which trials have a wrong clock (n,), by their ratios less 1 and the standard deviations of
    these; None unless a part of them stands apart. A part that holds all trials of its powers
    (groups) does not: a supply that sags under load has the same ratios.

    The trials are split between two of their sorted ratios, where the variance about the two means
    is smallest. With S_1 and S_2, the sums of squares without and with the split, the odds are

        PRIOR_INCLUSION_PROBABILITIES.cause / n (S_1 / S_2 (1 - 2 / pi))^(n / 2)

    since the best split of normally distributed ratios leaves 1 - 2 / pi of their variance, and
    there are n places to split. The part whose mean is farther from 1 is the wrong one.
    """
    n, order = len(ratio), np.argsort(ratio)
    if n < MIN_TRIALS_TO_SPLIT:
        return None

    def squares(parts: list[np.ndarray]) -> float:
        own = sum(float(np.sum((ratio[p] - ratio[p].mean()) ** 2)) for p in parts)
        return own + float(np.sum(std**2))

    splits = [[order[:k], order[k:]] for k in range(1, n)]
    best = min(splits, key=squares)
    shrinkage = squares([order]) / squares(best) * (1.0 - 2.0 / np.pi)
    if PRIOR_INCLUSION_PROBABILITIES.cause / n * shrinkage ** (n / 2) < 1.0:
        return None
    wrong = np.zeros(n, dtype=bool)
    wrong[max(best, key=lambda part: abs(ratio[part].mean()))] = True
    apart = {g for g, bad in zip(groups, wrong, strict=True) if bad}
    together = {g for g, bad in zip(groups, wrong, strict=True) if not bad}
    return wrong if apart & together else None


def _with_clock_error_of_some_trials(
    series: Sequence[TrialSeries], seen: Sequence[str], ratio: Float, own: Float, wrong: np.ndarray
) -> list[TrialSeries]:
    """Series of which those that stand apart have the error of the clock, and their ratios as
    evidence on it.
    """
    scatter = float(np.var(ratio[wrong], ddof=1)) if wrong.sum() > 1 else 0.0
    std = np.sqrt(MIN_CLOCK_RATIO_STD_SHARE**2 + np.maximum(own**2, scatter))
    known = {name: (float(r), float(d))
             for name, r, d, bad in zip(seen, ratio, std, wrong, strict=True) if bad}  # fmt: skip
    measured = [
        replace(
            s, evidence=s.evidence | ({"clock_ratio": known[s.name]} if s.name in known else {})
        )
        for s in series
    ]
    return with_clock_error_in_trials(measured, known.keys())


def within_between_group_variances(
    values: Float, variances: Float, groups: Sequence[str]
) -> tuple[float, float]:
    """Variance within and between groups, beyond the values' own variances (n,); at least 0.

    By the analysis of variance of groups of unequal size; a single group has none between.
    """
    members = [np.flatnonzero(np.array(groups) == name) for name in dict.fromkeys(groups)]
    n, k, own = len(values), len(members), float(np.mean(variances))
    squares = sum(float(np.sum((values[m] - values[m].mean()) ** 2)) for m in members)
    total = squares / (n - k) if n > k else own
    means = np.array([values[m].mean() for m in members])
    if k < 2:
        return max(total - own, 0.0), 0.0
    of_means = total * float(np.mean([1 / len(m) for m in members]))
    return max(total - own, 0.0), max(float(np.var(means, ddof=1)) - of_means, 0.0)


def _drift_variance(seen: Sequence[TrialSeries], found: Sequence[FlappingFrequency]) -> float:
    """Variance of the ratio because a frequency that no log shows is not that of the whole trial.

    A frequency that drifts through the range D in a trial passes the stated one at an unknown time,
    so that the mean differs from it by D / 12^1/2 rms. Whoever states it takes the same part of all
    trials: the variance is common to them.
    """
    drift = np.nan_to_num([b.drift_per_s for b in found])
    drift[[b.source == "motor_log" for b in found]] = 0.0
    ranges = drift * np.array([np.ptp(s.times) for s in seen])
    return float(np.mean(ranges**2)) / 12.0


def _are_frequencies_shared_by_trials(found: Sequence[FlappingFrequency]) -> bool:
    stated = [b.flap_hz for b in found if b.source != "motor_log"]
    return len(stated) > 1 and len(set(stated)) <= MAX_DISTINCT_FREQUENCY_SHARE * len(stated)
