"""Measured path and model paths of every trial."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..campaign import Campaign
from ..study import Trial
from .drawing.model_paths import draw_paths, path_legend_entries
from .drawing.style import placeholder

FIGURE_TITLE = "Measured and simulated path of every trial"
FIGURE_CAPTION = (
    "Each panel shows the pool from above. Black: measured path of the centre of mass, dot at its "
    "start. Orange, dashed: baseline model with one coefficient set for all trials, started from "
    "the fitted initial state. Blue: model with the identified causes, if there are any. Numbers: "
    "rms distance to the measured path. Large studies show the 60 trials with the largest "
    "error of the baseline."
)
REQUIRED_RESULTS = ("tracks",)
PANELS_PER_ROW = 6
MAX_PANELS = 60


def render_figure(campaign: Campaign) -> Figure:
    """Small multiples, one panel a trial in the order of trials.csv."""
    trials = _all_or_worst_trials(campaign)
    columns = min(PANELS_PER_ROW, len(trials))
    rows = math.ceil(len(trials) / columns)
    figure = Figure(figsize=(max(6, 2.15 * columns), 1.75 * rows + 0.7), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False)
    for i, axes in enumerate(panels.flat):
        if i < len(trials):
            _draw_trial_panel(axes, campaign, trials[i])
            axes.tick_params(labelleft=i % columns == 0, labelbottom=i + columns >= len(trials))
        else:
            axes.axis("off")
    figure.supxlabel("x (m)")
    figure.supylabel("y (m)")
    figure.legend(handles=path_legend_entries(campaign), loc="outside upper center", ncols=3)
    return figure


def _all_or_worst_trials(campaign: Campaign) -> tuple[Trial, ...]:
    """All trials, or the worst ones of a large study, in the study's order."""
    trials = campaign.study.trials
    if len(trials) <= MAX_PANELS:
        return trials
    known = [trial.trial_id for trial in trials if trial.trial_id in campaign.tracks]
    errors = {name: campaign.path_rmse_m(name, "joint") for name in known}
    ranked = sorted(known, key=lambda n: -errors[n] if math.isfinite(errors[n]) else -math.inf)
    worst = set(ranked[:MAX_PANELS])
    return tuple(trial for trial in trials if trial.trial_id in worst)


def _draw_trial_panel(axes: Axes, campaign: Campaign, trial: Trial) -> None:
    axes.set_title(
        f"{trial.trial_id}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°, "
        f"{trial.head_length_m:g} m",
        fontsize=7,
    )
    if trial.trial_id in campaign.tracks:
        draw_paths(axes, campaign, trial.trial_id, labels=False)
    else:
        placeholder(axes, "excluded")
