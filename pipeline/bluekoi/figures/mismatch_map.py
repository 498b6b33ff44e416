"""The missing force along the paths."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ..campaign import Campaign
from .drawing.missing_force import (
    FORCE_CHANNELS,
    FORCE_NAMES,
    FORCE_UNITS,
    MissingForceSeries,
    missing_forces,
)
from .drawing.pool import draw_pool
from .drawing.style import DIVERGING_COLOURMAP, panel_letter, placeholder

FIGURE_TITLE = "Missing force along the paths"
FIGURE_CAPTION = (
    "Force that the baseline model would need to follow the measured motion, estimated by a "
    "smoother. (A-C) All paths in the pool, coloured by missing surge force (forward positive), "
    "sway force (positive to the left) and yaw moment (counter-clockwise positive). (D-F) The "
    "three trials with the largest missing force relative to its uncertainty; arrows: surge and "
    "sway force."
)
REQUIRED_RESULTS = ("tracks", "steady", "mismatch_detail")
WORST_TRIALS_SHOWN = 3


def render_figure(campaign: Campaign) -> Figure:
    """A map per channel, and the three trials with the largest missing force."""
    found = missing_forces(campaign)
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    panels = figure.subplots(2, 3)
    for i, (axes, channel) in enumerate(zip(panels[0], FORCE_CHANNELS, strict=True)):
        panel_letter(axes, "ABC"[i])
        _draw_force_map(figure, axes, campaign, found, i)
        axes.set_title(f"missing {FORCE_NAMES[channel]} ({FORCE_UNITS[channel]})")
    worst = sorted(found.values(), key=_mean_square_standardised_force, reverse=True)[
        :WORST_TRIALS_SHOWN
    ]
    longest = max((float(np.hypot(*one.force[:, :2].T).max()) for one in worst), default=1.0)
    longest = max(longest, 1e-3)
    for i, axes in enumerate(panels[1]):
        panel_letter(axes, "DEF"[i])
        if i < len(worst):
            _draw_force_arrows(axes, campaign, worst[i], longest)
        else:
            placeholder(axes, "no further trial")
    return figure


def _mean_square_standardised_force(one: MissingForceSeries) -> float:
    """Mean square of the missing force in standard errors."""
    return float(np.mean((one.force / np.maximum(one.std, 1e-9)) ** 2))


def _draw_force_map(
    figure: Figure,
    axes: Axes,
    campaign: Campaign,
    found: dict[str, MissingForceSeries],
    channel: int,
) -> None:
    if not found:
        placeholder(axes, "no missing force in mismatch_detail.json")
        return
    draw_pool(axes, campaign.study)
    every = np.concatenate([one.force[:, channel] for one in found.values()])
    limit = max(float(np.quantile(np.abs(every), 0.98)), 1e-6)
    norm = Normalize(-limit, limit)
    for one in found.values():
        xy = one.motion[:, :2]
        pieces = np.stack([xy[:-1], xy[1:]], axis=1)
        lines = LineCollection(list(pieces), cmap=DIVERGING_COLOURMAP, norm=norm, linewidths=2.6,
                               zorder=3, gid=one.trial_id)  # fmt: skip
        lines.set_array(0.5 * (one.force[:-1, channel] + one.force[1:, channel]))
        axes.plot(*xy.T, color="#5b6570", lw=3.4, zorder=2, solid_capstyle="butt")
        axes.add_collection(lines)
    figure.colorbar(lines, ax=axes, shrink=0.7, extend="both")


def _draw_force_arrows(
    axes: Axes, campaign: Campaign, one: MissingForceSeries, longest: float
) -> None:
    draw_pool(axes, campaign.study)
    xy, psi = one.motion[:, :2], one.motion[:, 2]
    surge, sway = one.force[:, 0], one.force[:, 1]
    c, s = np.cos(psi), np.sin(psi)
    world = np.column_stack([surge * c - sway * s, surge * s + sway * c])
    some = slice(None, None, max(1, len(xy) // 24))
    axes.plot(*xy.T, color="#20262e", lw=1.2)
    axes.plot(*xy[:1].T, "o", color="#20262e", ms=4)
    arrows = axes.quiver(
        *xy[some].T, *world[some].T, angles="xy", scale_units="xy", scale=longest / 0.35,
        color="#D55E00", width=0.006, zorder=4,
    )  # fmt: skip
    tick = float(f"{longest / 2:.1g}")
    axes.quiverkey(arrows, 0.84, 0.9, tick, f"{tick:g} mN", labelpos="S", coordinates="axes")
    trial = campaign.study.trial(one.trial_id)
    axes.set_title(f"{one.trial_id}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°")
