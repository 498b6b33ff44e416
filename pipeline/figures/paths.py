"""Measured path and model paths of every trial."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..campaign import Campaign
from ..study import Trial
from .drawing.look import AFTER, BEFORE, MEASURED, absent
from .drawing.pool import pool

TITLE = "Measured and simulated path of every trial"
CAPTION = (
    "Each panel is the pool from above. Solid: measured path of the centre of mass, dot at its "
    "start. Dashed: the model with one coefficient set for all trials, from the fitted start. "
    "Blue, where something was found: the model with what was left out. Numbers: rms distance to "
    "the measured path over the trial, mm. Of large studies the 60 trials that fit worst are shown."
)
NEEDS = ("tracks",)
COLUMNS = 6
MOST = 60
MODELS = {
    "joint": (BEFORE, "--", "model, one coefficient set"),
    "extended": (AFTER, "-", "model with what was left out"),
}
"""Prefix of a model's columns -> colour, dash, name."""


def draw(campaign: Campaign) -> Figure:
    """Small multiples, one panel a trial in the order of trials.csv."""
    trials = _shown(campaign)
    columns = min(COLUMNS, len(trials))
    rows = math.ceil(len(trials) / columns)
    figure = Figure(figsize=(max(6, 2.15 * columns), 1.75 * rows + 0.7), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False)
    for i, axes in enumerate(panels.flat):
        if i < len(trials):
            _panel(axes, campaign, trials[i])
            axes.tick_params(labelleft=i % columns == 0, labelbottom=i + columns >= len(trials))
        else:
            axes.axis("off")
    figure.supxlabel("x (m)")
    figure.supylabel("y (m)")
    figure.legend(handles=_legend(campaign), loc="outside upper center", ncols=3)
    return figure


def _shown(campaign: Campaign) -> tuple[Trial, ...]:
    """All trials, or of a large study those that the model fits worst, in the study's order."""
    trials = campaign.study.trials
    if len(trials) <= MOST:
        return trials
    known = [trial.trial_id for trial in trials if trial.trial_id in campaign.tracks]
    errors = {name: campaign.path_rmse_m(name, "joint") for name in known}
    ranked = sorted(known, key=lambda n: -errors[n] if math.isfinite(errors[n]) else -math.inf)
    worst = set(ranked[:MOST])
    return tuple(trial for trial in trials if trial.trial_id in worst)


def _panel(axes: Axes, campaign: Campaign, trial: Trial) -> None:
    axes.set_title(
        f"{trial.trial_id}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°, "
        f"{trial.head_length_m:g} m",
        fontsize=7,
    )
    track = campaign.tracks.get(trial.trial_id)
    if track is None:
        absent(axes, "left out")
        return
    pool(axes, campaign.study, labels=False)
    axes.plot(track.x_m, track.y_m, color=MEASURED, lw=1.3)
    axes.plot(track.x_m[:1], track.y_m[:1], "o", ms=3, color=MEASURED)
    columns = campaign.model_columns(trial.trial_id)
    words = []
    for prefix, (colour, dash, _) in MODELS.items():
        if f"{prefix}_x_m" in columns:
            axes.plot(
                columns[f"{prefix}_x_m"], columns[f"{prefix}_y_m"], color=colour, ls=dash, lw=1.1
            )
            words.append((1000 * campaign.path_rmse_m(trial.trial_id, prefix), colour))
    for i, (number, colour) in enumerate(words):
        text = f"{number:.1f}" if math.isfinite(number) else "runs away"
        place = (0.95, 0.06 + 0.12 * i)
        axes.text(*place, text, color=colour, ha="right", fontsize=7, transform=axes.transAxes)


def _legend(campaign: Campaign) -> list[Line2D]:
    have = {name for trial in campaign.simulations for name in campaign.model_columns(trial)}
    return [
        Line2D([], [], color=MEASURED, label="measured"),
        *(
            Line2D([], [], color=colour, ls=dash, label=name)
            for prefix, (colour, dash, name) in MODELS.items()
            if f"{prefix}_x_m" in have
        ),
    ]
