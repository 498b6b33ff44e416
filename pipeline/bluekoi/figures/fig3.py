"""Figure 3 of the paper for this study: straight speeds and steady turns, as measured."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from ..campaign import Campaign
from ..study import Trial
from .drawing import groups
from .drawing.circles import draw_turns, head_angle_with_most_lengths_deg
from .drawing.groups import ConditionMean
from .drawing.pool import draw_pool, draw_robot_along_track
from .drawing.style import Z_95, PowerStyle, panel_letter, placeholder, power_styles

FIGURE_TITLE = "Straight speeds and turn radii"
FIGURE_CAPTION = (
    "(A) A straight run: path of the centre of mass, and the robot (head orange). (B) Speed over "
    "time of all straight runs, one row per head length; band: 95 % of the smoothed speed; "
    "dashed line: mean steady speed. (C) Means of B with standard deviations over repeats. (D) A "
    "turn. (E) Steady turns with the 1x head at each head angle: circles about a common centre "
    "(thick: the measured arc), and means with standard deviations. (F) The same over head length. "
    "Left and right turns are pooled. Small dots: single trials; hollow markers: means over trials "
    "none of which reached a good steady state."
)
REQUIRED_RESULTS = ("tracks", "steady")


def render_figure(campaign: Campaign) -> Figure:
    """Panels A to F of the paper's Figure 3."""
    styles = power_styles(groups.motor_powers_pct(campaign))
    figure = Figure(figsize=(max(12.0, 5.5 + 2.2 * len(styles)), 7.4), layout="constrained")
    rows = figure.add_gridspec(2, 1, height_ratios=(1.5, 1))
    upper = rows[0].subgridspec(1, 3, width_ratios=(1.25, 0.85 * max(2, len(styles)), 0.95))
    lower = rows[1].subgridspec(1, 5, width_ratios=(1.3, 1, 1, 1, 1))
    left, others = lower[0], [lower[i] for i in range(1, 5)]
    _draw_example_path(
        figure.add_subplot(upper[0]),
        campaign,
        groups.straight_trials(campaign),
        "A",
        "straight run",
    )
    _draw_speed_over_time_panels(figure, upper[1], campaign, styles)
    _draw_mean_speed_over_power(figure.add_subplot(upper[2]), campaign, styles)
    _draw_example_path(
        figure.add_subplot(left), campaign, groups.turning_trials(campaign), "D", "turn"
    )
    axes = [figure.add_subplot(place) for place in others]
    _draw_radius_over_angle(axes[0], axes[1], campaign, styles)
    _draw_radius_over_length(axes[2], axes[3], campaign, styles)
    return figure


def _draw_example_path(
    axes: Axes, campaign: Campaign, trials: tuple[Trial, ...], name: str, kind: str
) -> None:
    """The longest path of a kind, seen from above in the pool."""
    panel_letter(axes, name)
    if not trials:
        placeholder(axes, f"no {kind} in this study")
        return
    trial = max(trials, key=lambda t: _path_length_m(campaign, t))
    track = campaign.tracks[trial.trial_id]
    draw_pool(axes, campaign.study)
    axes.plot(track.x_m, track.y_m, color="#20262e", lw=1, zorder=6, gid=trial.trial_id)
    draw_robot_along_track(axes, campaign.study.setup.robot, trial.head_length_m, track)
    axes.set_title(f"{kind} {trial.trial_id}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°")
    axes.text(0.06, 0.91, "robot: head orange, core grey", transform=axes.transAxes, va="top",
              fontsize=6.5, color="0.35")  # fmt: skip


def _path_length_m(campaign: Campaign, trial: Trial) -> float:
    track = campaign.tracks[trial.trial_id]
    return float(np.hypot(np.diff(track.x_m), np.diff(track.y_m)).sum())


def _draw_speed_over_time_panels(
    figure: Figure, place: SubplotSpec, campaign: Campaign, styles: dict[float, PowerStyle]
) -> None:
    heads = groups.head_lengths(campaign)
    grid = place.subgridspec(len(heads), len(styles))
    first: Axes | None = None
    for row, head in enumerate(heads):
        for column, (power, style) in enumerate(styles.items()):
            axes = figure.add_subplot(grid[row, column], sharex=first, sharey=first)
            first = first or axes
            _draw_speed_panel(axes, campaign, (power, head), style)
            if row == 0:
                axes.set_title(f"{power:g} % power")
            axes.tick_params(labelleft=column == 0, labelbottom=row == len(heads) - 1)
            if column == 0:
                axes.set_ylabel(f"{groups.head_length_label(campaign, head)}\nspeed (m/s)")
            if row == len(heads) - 1:
                axes.set_xlabel("time (s)")
    if first is not None:
        panel_letter(first, "B")
        first.set_ylim(bottom=0)


def _draw_speed_panel(
    axes: Axes, campaign: Campaign, condition: tuple[float, float], style: PowerStyle
) -> None:
    shown = [
        t for t in groups.straight_trials(campaign) if (t.power_pct, t.head_length_m) == condition
    ]
    for trial in shown:
        track = campaign.tracks[trial.trial_id]
        t, v, half = track.time_s, track.speed_m_s, Z_95 * track.speed_m_s_std
        axes.fill_between(t, v - half, v + half, color=style.colour, alpha=0.15, lw=0)
        axes.plot(t, v, color=style.colour, lw=1.1, gid=trial.trial_id)
    if not shown:
        axes.text(0.5, 0.5, "no straight run", transform=axes.transAxes, ha="center", color="0.4")
    for mean in groups.speed_means(campaign):
        if (mean.power_pct, mean.head_length_m) == condition:
            axes.axhline(mean.value, color="0.25", lw=0.9, ls="--")
            axes.annotate(f"{mean.value:.3f} m/s", (0.98, mean.value), xytext=(0, 3), ha="right",
                          xycoords=("axes fraction", "data"), textcoords="offset points",
                          fontsize=7.5)  # fmt: skip


def _draw_mean_speed_over_power(
    axes: Axes, campaign: Campaign, styles: dict[float, PowerStyle]
) -> None:
    panel_letter(axes, "C")
    means = groups.speed_means(campaign)
    if not means:
        placeholder(axes, "no straight run in this study")
        return
    for i, head in enumerate(groups.head_lengths(campaign)):
        mine = [mean for mean in means if mean.head_length_m == head]
        shift = 1.2 * (i - 0.5 * (len(groups.head_lengths(campaign)) - 1))
        at = [mean.power_pct + shift for mean in mine]
        line, name = ("-", "--", ":", "-.")[i % 4], groups.head_length_label(campaign, head)
        axes.plot(at, [m.value for m in mine], color="0.45", ls=line, lw=1, label=name)
        for x, mean in zip(at, mine, strict=True):
            groups.draw_mean(axes, x, mean, styles[mean.power_pct])
    body = campaign.study.setup.robot.body_length_m
    lengths = axes.secondary_yaxis(
        "right", functions=(lambda v: np.divide(v, body), lambda v: np.multiply(v, body))
    )
    lengths.set_ylabel("body lengths per second")
    axes.set(xlabel="motor power (%)", ylabel="mean straight speed (m/s)", ylim=(0, None))
    axes.set_xticks(list(styles))
    axes.legend(loc="upper left")


def _draw_radius_over_angle(
    circles: Axes, averages: Axes, campaign: Campaign, styles: dict[float, PowerStyle]
) -> None:
    head = campaign.study.setup.robot.head_length_m
    mine = [t for t in groups.turning_trials(campaign) if abs(t.head_length_m - head) < 1e-6]
    panel_letter(circles, "E")
    draw_turns(circles, campaign, mine, styles, vary="angle")
    circles.set_title("1x head, by head angle")
    means = [m for m in groups.radius_means(campaign) if abs(m.head_length_m - head) < 1e-6]
    _draw_mean_radii(averages, means, styles, [mean.angle_deg for mean in means])
    _draw_single_trial_radii(
        averages, campaign, mine, styles, [abs(t.head_angle_deg) for t in mine]
    )
    averages.set_box_aspect(1)
    averages.set_xlabel("absolute head angle (°)")


def _draw_radius_over_length(
    circles: Axes, averages: Axes, campaign: Campaign, styles: dict[float, PowerStyle]
) -> None:
    angle = head_angle_with_most_lengths_deg(campaign)
    mine = [t for t in groups.turning_trials(campaign) if abs(t.head_angle_deg) == angle]
    panel_letter(circles, "F")
    draw_turns(circles, campaign, mine, styles, vary="length")
    circles.set_title(f"{angle:g}° head angle, by head length" if mine else "by head length")
    means = [m for m in groups.radius_means(campaign) if m.angle_deg == angle]
    _draw_mean_radii(averages, means, styles, [mean.head_length_m for mean in means])
    _draw_single_trial_radii(averages, campaign, mine, styles, [t.head_length_m for t in mine])
    averages.set_box_aspect(1)
    averages.set_xlabel("head length (m)")


def _draw_mean_radii(
    axes: Axes, means: list[ConditionMean], styles: dict[float, PowerStyle], at: list[float]
) -> None:
    if not means:
        placeholder(axes, "no steady turn")
        return
    ticks = sorted(set(at))
    step = 0.045 * ((ticks[-1] - ticks[0]) or ticks[0])
    for i, (power, style) in enumerate(styles.items()):
        shift = step * (i - 0.5 * (len(styles) - 1))
        mine = [(x + shift, m) for x, m in zip(at, means, strict=True) if m.power_pct == power]
        axes.plot([x for x, _ in mine], [m.value for _, m in mine], color=style.colour, lw=0.9)
        for x, mean in mine:
            groups.draw_mean(axes, x, mean, style)
    axes.set_xticks(ticks)
    axes.margins(x=0.2)
    axes.set(ylabel="turn radius (m)", ylim=(0, 1.12 * axes.get_ylim()[1]))


def _draw_single_trial_radii(
    axes: Axes,
    campaign: Campaign,
    trials: list[Trial],
    styles: dict[float, PowerStyle],
    at: list[float],
) -> None:
    for x, trial in zip(at, trials, strict=True):
        radius_m = campaign.steady[trial.trial_id].radius_m
        axes.plot(x, radius_m, ".", ms=3, color=styles[trial.power_pct].colour, alpha=0.6,
                  gid=trial.trial_id)  # fmt: skip
