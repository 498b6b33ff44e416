"""Measured and simulated paths of a trial, with the styles and names of the models."""

from __future__ import annotations

import math
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ...campaign import Campaign
from .pool import draw_pool
from .style import (
    AFTER_COLOUR,
    BASELINE_MODEL_LABEL,
    BEFORE_COLOUR,
    EXTENDED_MODEL_LABEL,
    MEASURED_COLOUR,
)

MEASURED_LINE_WIDTH = 2.8
"""So wide that the measured path shows beneath a model that follows it."""


class ModelPlotStyle(NamedTuple):
    """A model as drawn: name in mismatch.json, prefix of its columns, style and labels."""

    result: str
    prefix: str
    colour: str
    dash: str
    name: str
    tick: str


def model_plot_styles(campaign: Campaign) -> tuple[ModelPlotStyle, ...]:
    """Baseline and extended model; one model if no cause was identified."""
    before = ModelPlotStyle(
        "baseline", "joint", BEFORE_COLOUR, "--", BASELINE_MODEL_LABEL, "before"
    )
    after = ModelPlotStyle("extended", "extended", AFTER_COLOUR, "-", EXTENDED_MODEL_LABEL, "after")
    if campaign.has_additions:
        return before, after
    return (before._replace(name="model", tick="model"),)


def path_legend_entries(campaign: Campaign) -> list[Line2D]:
    """Legend entries of the measured path and of each model."""
    entries = [
        Line2D([], [], color=m.colour, ls=m.dash, label=m.name) for m in model_plot_styles(campaign)
    ]
    return [
        Line2D([], [], color=MEASURED_COLOUR, lw=MEASURED_LINE_WIDTH, label="measured"),
        *entries,
    ]


def draw_paths(axes: Axes, campaign: Campaign, trial_id: str, *, labels: bool) -> None:
    """Paths of a trial in the pool; numbers: rms path error of each model."""
    draw_pool(axes, campaign.study, labels=labels)
    track, columns = campaign.tracks[trial_id], campaign.model_columns(trial_id)
    axes.plot(track.x_m, track.y_m, color=MEASURED_COLOUR, lw=MEASURED_LINE_WIDTH, gid=trial_id)
    axes.plot(track.x_m[:1], track.y_m[:1], "o", ms=3, color=MEASURED_COLOUR)
    known = [model for model in model_plot_styles(campaign) if f"{model.prefix}_x_m" in columns]
    for i, model in enumerate(known):
        x, y = columns[f"{model.prefix}_x_m"], columns[f"{model.prefix}_y_m"]
        axes.plot(x, y, color=model.colour, ls=model.dash, lw=1.1, gid=trial_id)
        error = 1000 * campaign.path_rmse_m(trial_id, model.prefix)
        text = f"{error:.1f} mm" if math.isfinite(error) else "diverges"
        axes.text(0.95, 0.06 + 0.12 * i, text, color=model.colour, ha="right", fontsize=7,
                  transform=axes.transAxes)  # fmt: skip
