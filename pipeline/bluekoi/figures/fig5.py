"""Figure 5 of the paper for this study: the three tuning steps at each power."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..campaign import Campaign
from ..study import Trial
from .drawing import groups
from .drawing.circles import LINE_STYLES, circle_points, equal_axes, measured_arc
from .drawing.model_sweeps import FitAtPower, fits_at_tested_powers, simulate_from_rest, turn_radius
from .drawing.style import BEFORE_COLOUR, MEASURED_COLOUR, panel_letter, placeholder

FIGURE_TITLE = "The paper's three tuning steps at each power"
FIGURE_CAPTION = (
    "One row per power, each tuned separately as published. Step 1: straight speed from rest "
    "(solid: data, dashed: simulation). Step 2: steady turns with the 1x head at each head angle "
    "(thick: measured arc, thin: circle fitted to it, dashed: simulation; percentages: simulated "
    "minus measured radius). Step 3: prediction for the longer head, which no step was tuned to."
)
REQUIRED_RESULTS = ("tracks", "steady", "coefficients")
TUNING_STEP_TITLES = (
    "step 1: straight speed",
    "step 2: turns, 1x head",
    "step 3: longer head, predicted",
)


def render_figure(campaign: Campaign) -> Figure:
    """Three panels per power."""
    known, powers = fits_at_tested_powers(campaign), groups.motor_powers_pct(campaign)
    figure = Figure(figsize=(10.5, 3.1 * len(powers) + 0.4), layout="constrained")
    panels = figure.subplots(len(powers), 3, squeeze=False)
    for row, (power, axes) in enumerate(zip(powers, panels, strict=True)):
        panel_letter(axes[0], "ABCDEFGHIJKLMNOPQRSTUVWXYZ"[row % 26])
        _draw_straight_tuning_step(axes[0], campaign, power, known.get(power))
        _draw_turn_tuning_step(
            axes[1], campaign, _standard_head_turns(campaign, power), known.get(power)
        )
        _draw_turn_tuning_step(
            axes[2], campaign, _longer_head_turns(campaign, power), known.get(power)
        )
        for axis, step in zip(axes, TUNING_STEP_TITLES, strict=True):
            axis.set_title(f"{power:g} %, {step}")
    lines = [
        Line2D([], [], color=MEASURED_COLOUR, label="data"),
        Line2D([], [], color=BEFORE_COLOUR, ls="--", label="simulation (sim.)"),
    ]
    figure.legend(handles=lines, loc="outside upper right", ncols=2)
    return figure


def _turning_trials_at_power(campaign: Campaign, power: float) -> list[Trial]:
    return [trial for trial in groups.turning_trials(campaign) if trial.power_pct == power]


def _standard_head_turns(campaign: Campaign, power: float) -> list[Trial]:
    return [
        t
        for t in _turning_trials_at_power(campaign, power)
        if groups.has_standard_head(campaign, t)
    ]


def _longer_head_turns(campaign: Campaign, power: float) -> list[Trial]:
    return [
        t
        for t in _turning_trials_at_power(campaign, power)
        if not groups.has_standard_head(campaign, t)
    ]


def _draw_straight_tuning_step(
    axes: Axes, campaign: Campaign, power: float, row: FitAtPower | None
) -> None:
    mine = [
        t
        for t in groups.straight_trials(campaign)
        if t.power_pct == power and groups.has_standard_head(campaign, t)
    ]
    if not mine:
        placeholder(axes, "no straight run of the 1x head at this power")
        return
    for trial in mine:
        track = campaign.tracks[trial.trial_id]
        axes.plot(track.time_s, track.speed_m_s, color=MEASURED_COLOUR, lw=1.1, gid=trial.trial_id)
    if row is None:
        axes.text(0.5, 0.3, "not tuned", transform=axes.transAxes, ha="center", color="0.4")
    else:
        last = max(campaign.tracks[t.trial_id].time_s[-1] for t in mine)
        run = simulate_from_rest(campaign, row, campaign.study.setup.robot.head_length_m, last)
        axes.plot(run.time_s, run.speed_m_s, color=BEFORE_COLOUR, ls="--")
    axes.set(xlabel="time (s)", ylabel="speed (m/s)", ylim=(0, None))


def _draw_turn_tuning_step(
    axes: Axes, campaign: Campaign, trials: list[Trial], row: FitAtPower | None
) -> None:
    if not trials:
        placeholder(axes, "no turn of this kind at this power")
        return
    conditions = sorted({(abs(t.head_angle_deg), t.head_length_m) for t in trials}, reverse=True)
    labels = []
    for i, (angle, length) in enumerate(conditions):
        mine = [t for t in trials if (abs(t.head_angle_deg), t.head_length_m) == (angle, length)]
        for trial in mine:
            arc = measured_arc(campaign, trial)
            axes.plot(*arc.T, color=MEASURED_COLOUR, lw=2, gid=trial.trial_id)
        seen = float(np.mean([campaign.steady[t.trial_id].radius_m for t in mine]))
        axes.plot(
            *circle_points(seen).T, color=MEASURED_COLOUR, lw=0.7, ls=LINE_STYLES[2 * (i % 2)]
        )
        longer = length > campaign.study.setup.robot.head_length_m + 1e-6
        name = f"{angle:g}°" + (f", {groups.head_length_label(campaign, length)}" if longer else "")
        labels.append(
            f"{name}: data {seen:.3f} m"
            + _draw_model_circle(axes, campaign, row, (angle, length, seen))
        )
    equal_axes(axes)
    _draw_radius_labels(axes, labels)


def _draw_model_circle(
    axes: Axes, campaign: Campaign, row: FitAtPower | None, condition: tuple[float, float, float]
) -> str:
    """Draw the simulated circle; return its radius and difference as text."""
    if row is None:
        return ""
    angle, length, seen = condition
    found = turn_radius(campaign, row, length, angle)
    if not np.isfinite(found):
        return "\nsimulation: no turn"
    axes.plot(*circle_points(found).T, color=BEFORE_COLOUR, ls="--")
    return f"\nsim. {found:.3f} m ({100 * (found / seen - 1):+.1f} %)"


def _draw_radius_labels(axes: Axes, labels: Iterable[str]) -> None:
    behind = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85}
    text = "\n".join(labels)
    axes.text(0, 0, text, ha="center", va="center", fontsize=6.5, bbox=behind, zorder=5)
