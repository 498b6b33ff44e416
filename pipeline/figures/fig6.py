"""Figure 6 of the paper for this study: the tuned model over power, head angle and head length."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..campaign import Campaign
from ..data import Float
from .drawing import groups
from .drawing.circles import compared_angle_deg
from .drawing.groups import Mean
from .drawing.look import Style, absent, letter, power_styles
from .drawing.sweeps import (
    Swept,
    Tuned,
    extended,
    over_angle,
    over_length,
    radius,
    speed_from_rest,
)

TITLE = "The model beyond what was tested"
CAPTION = (
    "(A) Simulated straight speeds from rest. (B) Simulated turn radius over head angle with the "
    "1x head; points: measured averages with deviations, set apart a little by power. (C) The same "
    "over head length; inset: measured minus simulated radius with the longer head. Full lines: "
    "tested powers; dashed: powers not tested, with f, C_Md and C_Da drawn along straight lines "
    "over power and the other coefficients held. Bands: 95 % of what the fits leave open; they "
    "follow the lines where these are extended. Shaded: head angles and lengths outside those "
    "tested."
)
NEEDS = ("tracks", "steady", "coefficients")
ANGLES_DEG = np.arange(10.0, 61.0, 2.5)
LENGTHS_M = np.arange(0.04, 0.2401, 0.01)
TIMES_S = np.arange(151) / 30.0


def draw(campaign: Campaign) -> Figure:
    """Panels A to C of the paper's Figure 6."""
    rows = extended(campaign)
    styles = _styles(campaign, rows)
    figure = Figure(figsize=(12, 4.3), layout="constrained")
    axes = figure.subplots(1, 3)
    for axis, name in zip(axes, "ABC", strict=True):
        letter(axis, name)
    if not rows:
        for axis in axes:
            absent(axis, "no power has a full set of coefficients")
        return figure
    _speeds(axes[0], campaign, rows, styles)
    _angles(axes[1], campaign, rows, styles)
    _lengths(axes[2], campaign, rows, styles)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _styles(campaign: Campaign, rows: dict[float, Tuned]) -> dict[float, Style]:
    """Tested powers keep the colours of the other figures."""
    tested = groups.powers(campaign)
    return power_styles([*tested, *(power for power in rows if power not in tested)])


def _line(
    axes: Axes,
    at: Float,
    values: Swept,
    row: Tuned,
    *,
    styles: dict[float, Style],
    label: str | None = None,
) -> None:
    """One power's line, dashed where the power was not tested, with its 95 % band."""
    colour = styles[row.power_pct].colour
    axes.plot(at, values.best, color=colour, ls="-" if row.tested else "--", label=label)
    axes.fill_between(at, values.low, values.high, color=colour, alpha=0.15, lw=0)


def _speeds(
    axes: Axes, campaign: Campaign, rows: dict[float, Tuned], styles: dict[float, Style]
) -> None:
    for power, row in rows.items():
        name = f"{power:g} % ({row.flap_hz:.2f} Hz)" + ("" if row.tested else ", extrapolated")
        _line(axes, TIMES_S, speed_from_rest(campaign, row, TIMES_S), row,
              styles=styles, label=name)  # fmt: skip
    axes.set(xlabel="time (s)", ylabel="straight speed (m/s)", xlim=(0, 5), ylim=(0, None))
    axes.set_title("straight, 1x head")


def _angles(
    axes: Axes, campaign: Campaign, rows: dict[float, Tuned], styles: dict[float, Style]
) -> None:
    head = campaign.study.setup.robot.head_length_m
    for row in rows.values():
        _line(axes, ANGLES_DEG, over_angle(campaign, row, head, ANGLES_DEG), row, styles=styles)
    seen = [m for m in groups.radius_means(campaign) if abs(m.head_length_m - head) < 1e-6]
    _points(axes, seen, [m.angle_deg for m in seen], styles)
    _untested(axes, [m.angle_deg for m in seen], (ANGLES_DEG[0], ANGLES_DEG[-1]))
    axes.set(xlabel="head angle, size (°)", ylabel="turn radius (m)")
    axes.set_title("turns, 1x head")


def _lengths(
    axes: Axes, campaign: Campaign, rows: dict[float, Tuned], styles: dict[float, Style]
) -> None:
    angle = compared_angle_deg(campaign)
    if not np.isfinite(angle):
        absent(axes, "no turn in this study")
        return
    for row in rows.values():
        _line(axes, LENGTHS_M, over_length(campaign, row, LENGTHS_M, angle), row, styles=styles)
    seen = [m for m in groups.radius_means(campaign) if m.angle_deg == angle]
    _points(axes, seen, [m.head_length_m for m in seen], styles)
    _untested(axes, [m.head_length_m for m in seen], (LENGTHS_M[0], LENGTHS_M[-1]))
    axes.set(xlabel="head length (m)", ylabel="turn radius (m)")
    axes.set_xticks(np.arange(0.04, 0.25, 0.04))
    axes.set_title(f"turns at {angle:g}° head angle")
    longest = max(m.head_length_m for m in seen)
    if longest > campaign.study.setup.robot.head_length_m + 1e-6:
        mine = [m for m in seen if m.head_length_m == longest]
        _inset(axes, campaign, mine, rows, styles)


def _points(axes: Axes, means: list[Mean], at: list[float], styles: dict[float, Style]) -> None:
    step = 0.012 * (axes.get_xlim()[1] - axes.get_xlim()[0])
    for x, mean in zip(at, means, strict=True):
        style = styles[mean.power_pct]
        axes.errorbar(
            x + step * (list(styles).index(mean.power_pct) - 1),
            mean.value,
            yerr=mean.std,
            fmt=style.marker,
            color=style.colour,
            mfc=style.colour if mean.trusted else "white",
            mec="white" if mean.trusted else style.colour,
            mew=0.8,
            ms=7,
            capsize=3,
            zorder=5,
        )


def _untested(axes: Axes, tested: list[float], span: tuple[float, float]) -> None:
    """Shade what lies outside the tested values."""
    axes.set_xlim(*span)
    low, high = (min(tested), max(tested)) if tested else (span[1], span[1])
    for left, right in ((span[0], low), (high, span[1])):
        if right > left:
            axes.axvspan(left, right, color="#eceff1", zorder=0)
    axes.set_ylim(bottom=0)


def _inset(
    axes: Axes,
    campaign: Campaign,
    means: list[Mean],
    rows: dict[float, Tuned],
    styles: dict[float, Style],
) -> None:
    inner = axes.inset_axes((0.58, 0.58, 0.4, 0.34))
    shown = [m for m in means if m.power_pct in rows]
    for mean in shown:
        model = radius(campaign, rows[mean.power_pct], mean.head_length_m, mean.angle_deg)
        style = styles[mean.power_pct]
        apart, error = 1000 * (mean.value - model), 1000 * mean.std
        inner.errorbar(
            mean.power_pct, apart, yerr=error, fmt=style.marker, color=style.colour, capsize=2, ms=5
        )
    inner.axhline(0, color="0.3", lw=0.8)
    inner.set_title(
        f"data - model, {groups.head_name(campaign, means[0].head_length_m)} (mm)", fontsize=7
    )
    inner.set_xticks([m.power_pct for m in shown])
    inner.set_xlabel("power (%)", fontsize=6.5, labelpad=1)
    inner.tick_params(labelsize=6.5)
    inner.margins(x=0.25, y=0.3)
