"""Errors before and after on held-out trials, or on the fitted ones of a small study."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..campaign import Campaign
from .drawing.held_out import evaluated_on_fitted_trials, evaluated_trials, noise_floor_m
from .drawing.model_paths import draw_paths, model_plot_styles, path_legend_entries
from .drawing.style import MEASURED_COLOUR, NOISE_FLOOR_LABEL, panel_letter, placeholder

FIGURE_TITLE = "Held-out trials: errors of the model before and after"
FIGURE_CAPTION = (
    "Trials that no fit used. (A) Errors of the baseline model (before, orange) and of the model "
    "with the identified causes (after, blue). Dotted: noise floor, the error of the extended "
    "model on trials simulated by itself with the estimated process and measurement noise; an "
    "error near or below it leaves nothing to explain. (B) Their paths in the pool; numbers: rms "
    "distance to the measured path."
)
HELD_OUT_SENTENCE = "Trials that no fit used."
TITLE_WITHOUT_CAUSES = "Held-out trials: errors of the model"
CAPTION_WITHOUT_CAUSES = (
    "No cause was identified, so there is one model. (A) Its errors; dotted: noise floor, the "
    "error of the model on trials simulated by itself with the estimated noise. (B) Their paths "
    "in the pool; numbers: rms distance to the measured path."
)
FITTED_TRIALS_CAPTION = (
    "The study is too small to hold trials out: these trials were fitted, so smaller errors do "
    "not confirm the identified causes."
)
REQUIRED_RESULTS = ("tracks", "mismatch")
MAX_PATHS_SHOWN = 6
VALUE_LABEL_BOX_STYLE = {"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.85}
ERROR_LABELS = (
    ("path_rmse_m", "rms path error (mm)", 1000.0),
    ("radius_error_pct", "radius error (%)", 1.0),
    ("speed_error_pct", "speed error (%)", 1.0),
)
"""Key of mismatch.json, label of its axis, factor to the unit of the label."""


def title_and_caption(campaign: Campaign) -> tuple[str, str]:
    """Title and caption, by whether trials were held out and causes identified."""
    fitted = evaluated_on_fitted_trials(campaign)
    title = FIGURE_TITLE if campaign.has_additions else TITLE_WITHOUT_CAUSES
    text = (
        FIGURE_CAPTION
        if campaign.has_additions
        else f"{HELD_OUT_SENTENCE} {CAPTION_WITHOUT_CAUSES}"
    )
    if fitted:
        return title.replace("Held-out", "Fitted"), text.replace(
            HELD_OUT_SENTENCE, FITTED_TRIALS_CAPTION
        )
    return title, text


def render_figure(campaign: Campaign) -> Figure:
    """Error bars on the left, paths of the evaluated trials on the right."""
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    sides = figure.add_gridspec(1, 2, width_ratios=(1, 1.7))
    bars = sides[0].subgridspec(1, 3)
    for i, (key, label, factor) in enumerate(ERROR_LABELS):
        axes = figure.add_subplot(bars[i])
        _draw_model_error_bar_chart(axes, campaign, key, factor)
        axes.set_title(label)
        if i == 0:
            panel_letter(axes, "A")
    names = [name for name in evaluated_trials(campaign) if name in campaign.tracks][
        :MAX_PATHS_SHOWN
    ]
    places = sides[1].subgridspec(2, 3)
    for i in range(MAX_PATHS_SHOWN):
        axes = figure.add_subplot(places[i // 3, i % 3])
        if i < len(names):
            trial = campaign.study.trial(names[i])
            draw_paths(axes, campaign, names[i], labels=True)
            axes.set_title(
                f"{names[i]}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°", fontsize=8
            )
        else:
            axes.axis("off")
        if i == 0:
            panel_letter(axes, "B")
    handles = path_legend_entries(campaign)
    if noise_floor_m(campaign) is not None:
        handles.append(Line2D([], [], color=MEASURED_COLOUR, ls=":", label=NOISE_FLOOR_LABEL))
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


def _draw_model_error_bar_chart(axes: Axes, campaign: Campaign, key: str, factor: float) -> None:
    drawn = model_plot_styles(campaign)
    values = [factor * campaign.held_out_error(model.result, key) for model in drawn]
    if all(math.isnan(value) for value in values):
        placeholder(axes, "no value")
        return
    for place, (value, model) in enumerate(zip(values, drawn, strict=True)):
        axes.bar(place, value if math.isfinite(value) else 0.0, color=model.colour, width=0.65)
        if math.isinf(value):
            axes.annotate("diverges", (place, 0), xytext=(0, 6), ha="center", rotation=90,
                          textcoords="offset points", fontsize=8, color=model.colour)  # fmt: skip
        elif math.isfinite(value):
            axes.annotate(
                f"{value:.3g}",
                (place, value),
                xytext=(0, 3),
                ha="center",
                textcoords="offset points",
                fontsize=8,
                bbox=VALUE_LABEL_BOX_STYLE,
            )
    floor = noise_floor_m(campaign)
    if key == "path_rmse_m" and floor is not None:
        axes.axhline(factor * floor, color=MEASURED_COLOUR, ls=":", lw=1.4)
    axes.set_xticks(range(len(drawn)), [model.tick for model in drawn])
    axes.set_xlim(-0.6, 1.6)
    axes.grid(visible=False, axis="x")
    axes.margins(y=0.12)
