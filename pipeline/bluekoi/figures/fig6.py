"""Figure 6 of the paper for this study: the tuned model over power, head angle and head length."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..campaign import Campaign
from ..data import Float
from .drawing import groups
from .drawing.circles import head_angle_with_most_lengths_deg
from .drawing.groups import ConditionMean
from .drawing.model_sweeps import (
    FitAtPower,
    PredictionWithBand,
    fits_at_tested_and_extrapolated_powers,
    speed_from_rest,
    turn_radii_over_head_angle,
    turn_radii_over_head_length,
    turn_radius,
)
from .drawing.style import PowerStyle, panel_letter, placeholder, power_styles

FIGURE_TITLE = "Model predictions beyond the tested conditions"
FIGURE_CAPTION = (
    "(A) Simulated straight speed from rest. (B) Simulated turn radius over head angle with the 1x "
    "head; points: measured means with standard deviations, shifted slightly by power. (C) The "
    "same over head length; inset: measured minus simulated radius with the longer head. Solid: "
    "tested powers; dashed: untested powers, with f, C_Md and C_Da extrapolated linearly over "
    "power and the other coefficients constant. Bands: 95 % intervals from the fits' uncertainty. "
    "Grey areas: untested head angles and lengths."
)
REQUIRED_RESULTS = ("tracks", "steady", "coefficients")
SIMULATED_HEAD_ANGLES_DEG = np.arange(10.0, 61.0, 2.5)
SIMULATED_HEAD_LENGTHS_M = np.arange(0.04, 0.2401, 0.01)
SIMULATED_TIMES_S = np.arange(151) / 30.0
UNTESTED_COLOUR = "#e6eaed"
MAX_SHOWN_TO_MEASURED_RADIUS_RATIO = 1.8
"""Radius at which panel C ends, over the largest one measured."""


def render_figure(campaign: Campaign) -> Figure:
    """Panels A to C of the paper's Figure 6."""
    rows = fits_at_tested_and_extrapolated_powers(campaign)
    styles = _styles_by_power(campaign, rows)
    figure = Figure(figsize=(12, 4.3), layout="constrained")
    axes = figure.subplots(1, 3)
    for axis, name in zip(axes, "ABC", strict=True):
        panel_letter(axis, name)
    if not rows:
        for axis in axes:
            placeholder(axis, "no power has a full set of coefficients")
        return figure
    _draw_simulated_speeds(axes[0], campaign, rows, styles)
    _draw_radius_over_angle(axes[1], campaign, rows, styles)
    _draw_radius_over_length(axes[2], campaign, rows, styles)
    handles = [*axes[0].get_legend_handles_labels()[0], *_legend_entries()]
    figure.legend(handles=handles, loc="outside upper center", ncols=(len(handles) + 1) // 2)
    return figure


def _legend_entries() -> list[Artist]:
    """Legend entries of what is not a power."""
    return [
        Line2D([], [], color="0.35", marker="o", ls="", label="measured mean"),
        Patch(color="0.35", alpha=0.15, label="95 % interval of the model"),
        Patch(color=UNTESTED_COLOUR, label="untested range"),
    ]


def _styles_by_power(campaign: Campaign, rows: dict[float, FitAtPower]) -> dict[float, PowerStyle]:
    """Colours by power; tested powers as in the other figures."""
    tested = groups.motor_powers_pct(campaign)
    return power_styles([*tested, *(power for power in rows if power not in tested)])


def _draw_prediction(
    axes: Axes,
    at: Float,
    values: PredictionWithBand,
    row: FitAtPower,
    *,
    styles: dict[float, PowerStyle],
    label: str | None = None,
) -> None:
    """Prediction for one power with its 95 % band; dashed for untested powers."""
    colour = styles[row.power_pct].colour
    axes.plot(at, values.best, color=colour, ls="-" if row.tested else "--", label=label)
    axes.fill_between(at, values.low, values.high, color=colour, alpha=0.15, lw=0)


def _draw_simulated_speeds(
    axes: Axes, campaign: Campaign, rows: dict[float, FitAtPower], styles: dict[float, PowerStyle]
) -> None:
    for power, row in rows.items():
        name = f"{power:g} % ({row.flap_hz:.2f} Hz)" + ("" if row.tested else ", extrapolated")
        _draw_prediction(
            axes,
            SIMULATED_TIMES_S,
            speed_from_rest(campaign, row, SIMULATED_TIMES_S),
            row,
            styles=styles,
            label=name,
        )
    axes.set(xlabel="time (s)", ylabel="straight speed (m/s)", xlim=(0, 5), ylim=(0, None))
    axes.set_title("straight, 1x head")


def _draw_radius_over_angle(
    axes: Axes, campaign: Campaign, rows: dict[float, FitAtPower], styles: dict[float, PowerStyle]
) -> None:
    head = campaign.study.setup.robot.head_length_m
    for row in rows.values():
        _draw_prediction(
            axes,
            SIMULATED_HEAD_ANGLES_DEG,
            turn_radii_over_head_angle(campaign, row, head, SIMULATED_HEAD_ANGLES_DEG),
            row,
            styles=styles,
        )
    seen = [m for m in groups.radius_means(campaign) if abs(m.head_length_m - head) < 1e-6]
    _draw_measured_means(axes, seen, [m.angle_deg for m in seen], styles)
    _shade_untested(
        axes,
        [m.angle_deg for m in seen],
        (SIMULATED_HEAD_ANGLES_DEG[0], SIMULATED_HEAD_ANGLES_DEG[-1]),
    )
    axes.set(xlabel="absolute head angle (°)", ylabel="turn radius (m)")
    axes.set_title("turns, 1x head")


def _draw_radius_over_length(
    axes: Axes, campaign: Campaign, rows: dict[float, FitAtPower], styles: dict[float, PowerStyle]
) -> None:
    angle = head_angle_with_most_lengths_deg(campaign)
    if not np.isfinite(angle):
        placeholder(axes, "no turn in this study")
        return
    for row in rows.values():
        _draw_prediction(
            axes,
            SIMULATED_HEAD_LENGTHS_M,
            turn_radii_over_head_length(campaign, row, SIMULATED_HEAD_LENGTHS_M, angle),
            row,
            styles=styles,
        )
    seen = [m for m in groups.radius_means(campaign) if m.angle_deg == angle]
    _draw_measured_means(axes, seen, [m.head_length_m for m in seen], styles)
    _limit_to_measured_radii(axes, seen)
    _shade_untested(
        axes,
        [m.head_length_m for m in seen],
        (SIMULATED_HEAD_LENGTHS_M[0], SIMULATED_HEAD_LENGTHS_M[-1]),
    )
    axes.set(xlabel="head length (m)", ylabel="turn radius (m)")
    axes.set_xticks(np.arange(0.04, 0.25, 0.04))
    axes.set_title(f"turns at {angle:g}° head angle")
    longest = max(m.head_length_m for m in seen)
    if longest > campaign.study.setup.robot.head_length_m + 1e-6:
        mine = [m for m in seen if m.head_length_m == longest]
        _draw_radius_difference_inset(axes, campaign, mine, rows, styles)


def _draw_measured_means(
    axes: Axes, means: list[ConditionMean], at: list[float], styles: dict[float, PowerStyle]
) -> None:
    step = 0.012 * (axes.get_xlim()[1] - axes.get_xlim()[0])
    for x, mean in zip(at, means, strict=True):
        place = x + step * (list(styles).index(mean.power_pct) - 1)
        groups.draw_mean(axes, place, mean, styles[mean.power_pct], size=7)


def _limit_to_measured_radii(axes: Axes, seen: list[ConditionMean]) -> None:
    """End the axis at a multiple of the measured radii: the model's grows without bound as the
    head becomes short.
    """
    if seen:
        highest = MAX_SHOWN_TO_MEASURED_RADIUS_RATIO * max(m.value + m.std for m in seen)
        axes.set_ylim(top=min(axes.get_ylim()[1], highest))


def _shade_untested(axes: Axes, tested: list[float], span: tuple[float, float]) -> None:
    """Shade the untested range."""
    axes.set_xlim(*span)
    low, high = (min(tested), max(tested)) if tested else (span[1], span[1])
    for left, right in ((span[0], low), (high, span[1])):
        if right > left:
            axes.axvspan(left, right, color=UNTESTED_COLOUR, zorder=0)
    axes.set_ylim(bottom=0)


def _draw_radius_difference_inset(
    axes: Axes,
    campaign: Campaign,
    means: list[ConditionMean],
    rows: dict[float, FitAtPower],
    styles: dict[float, PowerStyle],
) -> None:
    inner = axes.inset_axes((0.58, 0.58, 0.4, 0.34))
    shown = [m for m in means if m.power_pct in rows]
    for mean in shown:
        model = turn_radius(campaign, rows[mean.power_pct], mean.head_length_m, mean.angle_deg)
        style = styles[mean.power_pct]
        apart, error = 1000 * (mean.value - model), 1000 * mean.std
        inner.errorbar(
            mean.power_pct, apart, yerr=error, fmt=style.marker, color=style.colour, capsize=2, ms=5
        )
    inner.axhline(0, color="0.3", lw=0.8)
    inner.set_title(
        f"data - model, {groups.head_length_label(campaign, means[0].head_length_m)} (mm)",
        fontsize=7,
    )
    inner.set_xticks([m.power_pct for m in shown])
    inner.set_xlabel("power (%)", fontsize=6.5, labelpad=1)
    inner.tick_params(labelsize=6.5)
    inner.margins(x=0.25, y=0.3)
