"""Trials grouped by condition, with means and standard deviations over repeats."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from ...campaign import Campaign
from ...data import SteadyState
from ...study import Trial
from ...tuning.paper_steps import has_straight_head
from .style import PowerStyle

TRUSTED_STEADY_STATE_QUALITIES = ("good", "straight")


@dataclass(frozen=True)
class ConditionMean:
    """Mean over the repeats of a condition.

    std: sample standard deviation over repeats; of a single trial, its standard error.
    trusted: all values come from steady motion (quality good or straight).
    """

    power_pct: float
    angle_deg: float
    head_length_m: float
    value: float
    std: float
    count: int
    trusted: bool


def motor_powers_pct(campaign: Campaign) -> tuple[float, ...]:
    """Motor powers of the study, ascending, %."""
    return tuple(sorted({trial.power_pct for trial in campaign.study.trials}))


def head_lengths(campaign: Campaign) -> tuple[float, ...]:
    """Head lengths of the study, ascending, m."""
    return tuple(sorted({trial.head_length_m for trial in campaign.study.trials}))


def head_length_label(campaign: Campaign, head_length_m: float) -> str:
    """Head length in the paper's notation: `1.5x head`."""
    ratio = head_length_m / campaign.study.setup.robot.head_length_m
    return f"{round(ratio, 1):g}x head"


def has_standard_head(campaign: Campaign, trial: Trial) -> bool:
    """Whether a trial used the 1x head."""
    return abs(trial.head_length_m - campaign.study.setup.robot.head_length_m) < 1e-6


def straight_trials(campaign: Campaign) -> tuple[Trial, ...]:
    """Analysed trials with a straight head."""
    return tuple(trial for trial in campaign.analysed if has_straight_head(trial))


def turning_trials(campaign: Campaign) -> tuple[Trial, ...]:
    """Analysed trials with a turned head and a finite radius."""
    return tuple(
        trial
        for trial in campaign.analysed
        if not has_straight_head(trial) and np.isfinite(campaign.steady[trial.trial_id].radius_m)
    )


def distinct_abs_head_angles_deg(trials: Iterable[Trial]) -> tuple[float, ...]:
    """Absolute head angles, ascending, degrees."""
    return tuple(sorted({abs(trial.head_angle_deg) for trial in trials}))


def speed_means(campaign: Campaign) -> tuple[ConditionMean, ...]:
    """Mean steady speed of straight runs, m/s, per power and head length."""
    return _condition_means(
        campaign, straight_trials(campaign), lambda s: (s.speed_m_s, s.speed_std_m_s)
    )


def radius_means(campaign: Campaign) -> tuple[ConditionMean, ...]:
    """Mean turn radius, m, per power, absolute head angle and head length.

    Good steady turns only; all turns of a condition that has no good one.
    """
    return _condition_means(
        campaign, turning_trials(campaign), lambda s: (s.radius_m, s.radius_std_m)
    )


def _condition_means(
    campaign: Campaign, trials: Iterable[Trial], read: Callable[[SteadyState], tuple[float, float]]
) -> tuple[ConditionMean, ...]:
    groups: dict[tuple[float, float, float], list[SteadyState]] = {}
    for trial in trials:
        key = (trial.power_pct, abs(trial.head_angle_deg), trial.head_length_m)
        groups.setdefault(key, []).append(campaign.steady[trial.trial_id])
    return tuple(
        found
        for key, rows in sorted(groups.items())
        if (found := _condition_mean(key, rows, read)) is not None
    )


def _condition_mean(
    key: tuple[float, float, float],
    rows: list[SteadyState],
    read: Callable[[SteadyState], tuple[float, float]],
) -> ConditionMean | None:
    finite = [row for row in rows if np.isfinite(read(row)[0])]
    trusted = [row for row in finite if row.quality in TRUSTED_STEADY_STATE_QUALITIES]
    kept = trusted or finite
    if not kept:
        return None
    values = np.array([read(row)[0] for row in kept])
    std = float(values.std(ddof=1)) if len(values) > 1 else read(kept[0])[1]
    return ConditionMean(*key, float(values.mean()), std, len(values), bool(trusted))


def draw_mean(
    axes: Axes, x: float, mean: ConditionMean, style: PowerStyle, *, size: float = 5.5
) -> None:
    """A mean with its standard deviation; hollow if it is not trusted."""
    edge = {"mec": "white", "mew": 0.8} if mean.trusted else {"mfc": "white"}
    axes.errorbar(x, mean.value, yerr=mean.std, fmt=style.marker, color=style.colour, ms=size,
                  capsize=3, lw=1.2, zorder=5, **edge)  # fmt: skip
