"""The motor's clock compared with the camera's."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from ..data import FlappingFrequency

CLOCK_AGREEMENT_SIGMAS = 3.0
"""Standard errors within which the tail's frequency agrees with the motor's."""
MAX_RELATIVE_CLOCK_ERROR = 0.25
"""Ratios that differ by less than this share are errors of one clock, not another frame rate."""
CLOCK_RATIO_TOLERANCE = 0.02
"""Trials agree on a ratio where theirs differ by less than this share."""
MAX_CLOCK_DEVIATION_MADS = 8.0
"""Median absolute deviations beyond which a trial's ratio is another clock's: 5.4 standard
deviations of a normal distribution."""
STATED_FREQUENCY_STD_SHARE = 0.01  # ASSUME flap_hz in trials.csv is exact to 1 %


def flapping_from_stated_frequency(flap_hz: float) -> FlappingFrequency:
    """Flapping of a trial whose frequency is stated in trials.csv."""
    std = STATED_FREQUENCY_STD_SHARE * float(flap_hz)
    return FlappingFrequency(flap_hz=float(flap_hz), flap_hz_std=std, source="flap_hz")


def flapping_compared_with_video(
    flapping: FlappingFrequency, ratio: float, std: float
) -> FlappingFrequency:
    """`flapping` with the ratio of tail-beat frequency in the video to the motor's.

    The clocks agree where the ratio is within three standard deviations of 1, or unknown (NaN).
    `video_hz` is set where the ratio is near 1: a beat elsewhere is another frame rate.
    """
    if not (math.isfinite(ratio) and math.isfinite(std)):
        return flapping
    near = abs(ratio - 1) < MAX_RELATIVE_CLOCK_ERROR
    agrees = abs(ratio - 1) <= CLOCK_AGREEMENT_SIGMAS * std
    own = math.sqrt(max(std**2 - (ratio * flapping.flap_hz_std / flapping.flap_hz) ** 2, 0.0))
    return replace(
        flapping,
        ratio=ratio,
        ratio_std=std,
        video_hz=ratio * flapping.flap_hz if near else math.nan,
        video_hz_std=own * flapping.flap_hz if near else math.nan,
        agrees=agrees,
        remarks=flapping.remarks
        if agrees
        else (*flapping.remarks, _clock_disagreement_remark(ratio, std)),
    )


def _clock_disagreement_remark(ratio: float, std: float) -> str:
    return (
        f"clocks disagree: tail beat in the video / motor = {ratio:.4f} +- {std:.4f}; check fps in "
        "trials.csv, the motor log's time column, and that the log is this trial's"
    )


def common_clock_ratio(flapping: Iterable[FlappingFrequency]) -> tuple[float, float] | None:
    """Ratio of video to motor frequency that most trials agree on, and its standard deviation.

    The median where more than half of the ratios known, two or more, lie within 2 % of it; else
    None. Standard deviation: that of the mean of those that agree.
    """
    ratios = np.array([f.ratio for f in flapping if math.isfinite(f.ratio)])
    middle = float(np.median(ratios)) if len(ratios) else math.nan
    alike = ratios[np.abs(ratios / middle - 1) < CLOCK_RATIO_TOLERANCE]
    if len(alike) < 2 or 2 * len(alike) <= len(ratios):
        return None
    return float(alike.mean()), float(alike.std(ddof=1) / math.sqrt(len(alike)))


def trials_with_deviating_clock(flapping: Mapping[str, FlappingFrequency]) -> list[str]:
    """Trials whose clock is not that of most others: the log or the frame rate is another trial's.

    A ratio of video to motor frequency deviates where it is 2 %, three standard deviations and
    `MAX_CLOCK_DEVIATION_MADS` away from the one that most trials share; where they share none, 25 %
    from 1. Stated frequencies are inexact, so that the ratios of all trials scatter; 60 instead of
    50 frames/s lie outside such a scatter.
    """
    common = common_clock_ratio(flapping.values())
    ratios = {i: f.ratio for i, f in flapping.items() if math.isfinite(f.ratio)}
    found = [i for i, f in flapping.items() if i not in ratios and not f.agrees]
    if common is None:
        return [*found, *(i for i, r in ratios.items() if abs(r - 1) > MAX_RELATIVE_CLOCK_ERROR)]
    away = {i: abs(r / common[0] - 1) for i, r in ratios.items()}
    scatter = float(np.median([*away.values()]))
    usual = max(CLOCK_RATIO_TOLERANCE, MAX_CLOCK_DEVIATION_MADS * scatter)
    sigmas = {i: share * common[0] / max(flapping[i].ratio_std, 1e-9) for i, share in away.items()}
    apart = [i for i, share in away.items()
             if share > usual and not sigmas[i] <= CLOCK_AGREEMENT_SIGMAS]  # fmt: skip
    return [*found, *apart]
