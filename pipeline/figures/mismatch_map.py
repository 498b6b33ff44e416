"""Where along the paths a force is missing."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ..campaign import Campaign
from .drawing.lacking import CHANNELS, UNITS, Lacking, lacking
from .drawing.look import DIVERGING, absent, letter
from .drawing.pool import pool

TITLE = "The missing force along the paths"
CAPTION = (
    "What the model with one coefficient set lacks, estimated by a smoother around it. Above: all "
    "paths in the pool, coloured by missing surge force (forward positive), sway force (to the "
    "left positive) and yaw moment (counter-clockwise positive). Below: the three trials that lack "
    "most, with the missing force as arrows."
)
NEEDS = ("tracks", "steady", "mismatch_detail")
SHOWN = 3


def draw(campaign: Campaign) -> Figure:
    """Three maps, and the three trials that lack most."""
    found = lacking(campaign)
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    panels = figure.subplots(2, 3)
    for i, (axes, channel) in enumerate(zip(panels[0], CHANNELS, strict=True)):
        letter(axes, "ABC"[i])
        _map(figure, axes, campaign, found, i)
        axes.set_title(f"missing {channel} {'moment' if channel == 'yaw' else 'force'}")
    worst = sorted(found.values(), key=_strength, reverse=True)[:SHOWN]
    longest = max((float(np.hypot(*one.force[:, :2].T).max()) for one in worst), default=1.0)
    longest = max(longest, 1e-3)
    for i, axes in enumerate(panels[1]):
        letter(axes, "DEF"[i])
        if i < len(worst):
            _arrows(axes, campaign, worst[i], longest)
        else:
            absent(axes, "no further trial")
    return figure


def _strength(one: Lacking) -> float:
    """Mean square of the missing force over its own uncertainty."""
    return float(np.mean((one.force / np.maximum(one.std, 1e-9)) ** 2))


def _map(
    figure: Figure, axes: Axes, campaign: Campaign, found: dict[str, Lacking], channel: int
) -> None:
    pool(axes, campaign.study)
    if not found:
        return
    every = np.concatenate([one.force[:, channel] for one in found.values()])
    span = max(float(np.quantile(np.abs(every), 0.98)), 1e-6)
    norm = Normalize(-span, span)
    for one in found.values():
        xy = one.motion[:, :2]
        pieces = np.stack([xy[:-1], xy[1:]], axis=1)
        lines = LineCollection(list(pieces), cmap=DIVERGING, norm=norm, linewidths=2.6, zorder=3)
        lines.set_array(0.5 * (one.force[:-1, channel] + one.force[1:, channel]))
        axes.plot(*xy.T, color="#5b6570", lw=3.4, zorder=2, solid_capstyle="butt")
        axes.add_collection(lines)
    figure.colorbar(lines, ax=axes, label=UNITS[CHANNELS[channel]], shrink=0.7, extend="both")


def _arrows(axes: Axes, campaign: Campaign, one: Lacking, longest: float) -> None:
    pool(axes, campaign.study)
    xy, psi = one.motion[:, :2], one.motion[:, 2]
    surge, sway = one.force[:, 0], one.force[:, 1]
    c, s = np.cos(psi), np.sin(psi)
    world = np.column_stack([surge * c - sway * s, surge * s + sway * c])
    some = slice(None, None, max(1, len(xy) // 24))
    axes.plot(*xy.T, color="#20262e", lw=1.2)
    axes.plot(*xy[:1].T, "o", color="#20262e", ms=4)
    arrows = axes.quiver(
        *xy[some].T,
        *world[some].T,
        angles="xy",
        scale_units="xy",
        scale=longest / 0.35,
        color="#D55E00",
        width=0.006,
        zorder=4,
    )
    tick = float(f"{longest / 2:.1g}")
    axes.quiverkey(arrows, 0.84, 0.9, tick, f"{tick:g} mN", labelpos="S", coordinates="axes")
    trial = campaign.study.trial(one.trial_id)
    axes.set_title(f"{one.trial_id}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°")
