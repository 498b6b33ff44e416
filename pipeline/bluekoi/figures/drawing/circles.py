"""Steady turns as circles about one centre."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ...campaign import Campaign
from ...data import Float
from ...study import Trial
from .groups import distinct_abs_head_angles_deg, head_length_label, head_lengths, turning_trials
from .style import PowerStyle, placeholder

LINE_STYLES = ("-", "--", ":", "-.")


def head_angle_with_most_lengths_deg(campaign: Campaign) -> float:
    """Head angle tested with most head lengths, the larger one at a tie; NaN without turns."""
    found = turning_trials(campaign)
    if not found:
        return float("nan")

    def heads(angle: float) -> int:
        return len({t.head_length_m for t in found if abs(t.head_angle_deg) == angle})

    return max(distinct_abs_head_angles_deg(found), key=lambda angle: (heads(angle), angle))


def circle_points(radius_m: float) -> Float:
    """Points of a circle about the origin, (181, 2), m."""
    around = np.linspace(0, 2 * np.pi, 181)
    return radius_m * np.column_stack([np.cos(around), np.sin(around)])


def measured_arc(campaign: Campaign, trial: Trial) -> Float:
    """Steady part of a track about its centre, (n, 2), m, from the x axis counter-clockwise."""
    track, steady = campaign.tracks[trial.trial_id], campaign.steady[trial.trial_id]
    kept = (track.time_s >= steady.steady_from_s) & (track.time_s <= steady.steady_to_s)
    xy = np.column_stack([track.x_m, track.y_m])[kept] - np.array(steady.center_m)
    if len(xy) == 0 or not np.isfinite(xy).all():
        return np.zeros((0, 2))
    if steady.turn < 0:
        xy = xy * np.array([1.0, -1.0])
    start = np.arctan2(xy[0, 1], xy[0, 0])
    c, s = np.cos(start), np.sin(start)
    return np.asarray(xy @ np.array([[c, -s], [s, c]]))


def draw_turns(
    axes: Axes,
    campaign: Campaign,
    trials: Sequence[Trial],
    styles: dict[float, PowerStyle],
    *,
    vary: str,
) -> None:
    """Fitted circle and measured arc of every turn; colour: power, dashes: head angle or length."""
    if not trials:
        placeholder(axes, "no turn of this kind in the study")
        return
    lines = _dash_patterns(campaign, trials, vary)
    for trial in trials:
        colour = styles[trial.power_pct].colour
        dash = lines[_varied_head_angle_or_length(trial, vary)][0]
        ring = circle_points(campaign.steady[trial.trial_id].radius_m)
        axes.plot(*ring.T, color=colour, ls=dash, lw=0.7, alpha=0.75)
        axes.plot(*measured_arc(campaign, trial).T, color=colour, lw=2, gid=trial.trial_id)
    equal_axes(axes)
    keys = [Line2D([], [], color="0.3", ls=dash, lw=1, label=name) for dash, name in lines.values()]
    keys += [Line2D([], [], color=s.colour, lw=2, label=f"{p:g} %") for p, s in styles.items()]
    axes.legend(handles=keys, loc="center", fontsize=6.5, handlelength=1.6)


def equal_axes(axes: Axes) -> None:
    """Equal scales in metres about the centre of the turn."""
    axes.set_aspect("equal")
    axes.set_xlabel("x - centre (m)")
    axes.set_ylabel("y - centre (m)")


def _varied_head_angle_or_length(trial: Trial, vary: str) -> float:
    return abs(trial.head_angle_deg) if vary == "angle" else trial.head_length_m


def _dash_patterns(
    campaign: Campaign, trials: Iterable[Trial], vary: str
) -> dict[float, tuple[str, str]]:
    """Dash pattern and label of each head angle or head length."""
    trials = list(trials)
    values = distinct_abs_head_angles_deg(trials) if vary == "angle" else head_lengths(campaign)
    labels = [f"{v:g}°" if vary == "angle" else head_length_label(campaign, v) for v in values]
    return {v: (LINE_STYLES[i % 4], w) for i, (v, w) in enumerate(zip(values, labels, strict=True))}
