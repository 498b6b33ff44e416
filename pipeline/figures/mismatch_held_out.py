"""Before and after on trials that the fit did not see, where a study could spare any."""

from __future__ import annotations

import math
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..campaign import Campaign
from .drawing.held_out import judged_on, none_held_out
from .drawing.look import AFTER, BEFORE, MEASURED, absent, letter
from .drawing.pool import pool

TITLE = "Held-out trials, before and after"
CAPTION = (
    "Trials that no fit saw. (A) Errors of the model before (orange) and with what was left out "
    "(blue); dotted: the noise floor, the error that the model with what was left out makes on "
    "trials of its own making, with their water and noise. (B) Their paths: measured solid black, "
    "before dashed, after blue; numbers: rms distance to the measured path, mm."
)
HELD_OUT = "Trials that no fit saw."
ONE_TITLE = "Held-out trials and the model"
ONE = (
    "Nothing was put into the model, so there is one model to show. (A) Its errors; dotted: the "
    "noise floor, the error that it makes on trials of its own making, with their water and noise. "
    "(B) Paths: measured solid black, model dashed; numbers: rms distance to the measured path, mm."
)
FITTED_TITLE = "The fitted trials, before and after"
FITTED_ONE_TITLE = "The fitted trials and the model"
FITTED = (
    "The study is too small to hold trials out: these are the trials that were fitted, so that "
    "smaller errors are no proof that what was put in is there."
)
NEEDS = ("tracks", "mismatch")
MOST_PATHS = 6
BESIDE_A_LINE = {"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.85}
ERRORS = (
    ("path_rmse_m", "path (mm)", 1000.0),
    ("radius_error_pct", "radius (%)", 1.0),
    ("speed_error_pct", "speed (%)", 1.0),
)


class Model(NamedTuple):
    """A model as drawn: its name in mismatch.json, its columns' prefix, its look and label."""

    result: str
    prefix: str
    colour: str
    dash: str
    name: str


def told(campaign: Campaign) -> tuple[str, str]:
    """Title and caption, by whether any trial was held out."""
    fitted = none_held_out(campaign)
    trials = FITTED if fitted else HELD_OUT
    if not campaign.has_additions:
        return (FITTED_ONE_TITLE if fitted else ONE_TITLE), f"{trials} {ONE}"
    return (FITTED_TITLE if fitted else TITLE), CAPTION.replace(HELD_OUT, trials)


def draw(campaign: Campaign) -> Figure:
    """Error bars at the left, paths of the trials that they are of at the right."""
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    sides = figure.add_gridspec(1, 2, width_ratios=(1, 1.7))
    bars = sides[0].subgridspec(1, 3)
    for i, (key, label, factor) in enumerate(ERRORS):
        axes = figure.add_subplot(bars[i])
        _error(axes, campaign, key, factor)
        axes.set_title(label)
        if i == 0:
            letter(axes, "A")
    names = [name for name in judged_on(campaign) if name in campaign.tracks][:MOST_PATHS]
    places = sides[1].subgridspec(2, 3)
    for i in range(MOST_PATHS):
        axes = figure.add_subplot(places[i // 3, i % 3])
        if i < len(names):
            _paths(axes, campaign, names[i])
        else:
            axes.axis("off")
        if i == 0:
            letter(axes, "B")
    figure.legend(handles=_legend(campaign), loc="outside upper center", ncols=3)
    return figure


def _error(axes: Axes, campaign: Campaign, key: str, factor: float) -> None:
    models = _models(campaign)
    numbers = [factor * campaign.held_out_error(model.result, key) for model in models]
    if all(math.isnan(number) for number in numbers):
        absent(axes, "none to compare")
        return
    colours = [model.colour for model in models]
    for place, (number, colour) in enumerate(zip(numbers, colours, strict=True)):
        axes.bar(place, number if math.isfinite(number) else 0.0, color=colour, width=0.65)
        if math.isinf(number):
            axes.annotate("runs away", (place, 0), xytext=(0, 6), ha="center", rotation=90,
                          textcoords="offset points", fontsize=8, color=colour)  # fmt: skip
        elif math.isfinite(number):
            axes.annotate(f"{number:.3g}", (place, number), xytext=(0, 2), ha="center",
                          textcoords="offset points", fontsize=8, bbox=BESIDE_A_LINE)  # fmt: skip
    floor = ((campaign.mismatch or {}).get("held_out") or {}).get("noise_floor_path_rmse_m")
    if key == "path_rmse_m" and floor is not None and floor < campaign.study.setup.pool.width_m:
        axes.axhline(factor * float(floor), color=MEASURED, ls=":", lw=1.4)
    axes.set_xticks(range(len(models)), [model.name for model in models])
    axes.set_xlim(-0.6, 1.6)
    axes.grid(visible=False, axis="x")
    axes.margins(y=0.12)


def _paths(axes: Axes, campaign: Campaign, name: str) -> None:
    pool(axes, campaign.study, labels=False)
    trial, track = campaign.study.trial(name), campaign.tracks[name]
    axes.plot(track.x_m, track.y_m, color=MEASURED, lw=1.6)
    axes.plot(track.x_m[:1], track.y_m[:1], "o", color=MEASURED, ms=3)
    columns = campaign.simulations.get(name, {})
    for i, model in enumerate(_models(campaign)):
        if f"{model.prefix}_x_m" not in columns:
            continue
        x, y = columns[f"{model.prefix}_x_m"], columns[f"{model.prefix}_y_m"]
        axes.plot(x, y, color=model.colour, ls=model.dash, lw=1.2)
        error = 1000 * campaign.path_rmse_m(trial.trial_id, model.prefix)
        text = f"{error:.1f}" if math.isfinite(error) else "runs away"
        place = (0.96, 0.05 + 0.13 * i)
        axes.text(*place, text, transform=axes.transAxes, ha="right", color=model.colour)
    axes.set_title(f"{name}: {trial.power_pct:g} %, {trial.head_angle_deg:g}°", fontsize=8)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


def _models(campaign: Campaign) -> list[Model]:
    """Before and after; one model where nothing was put in."""
    before = Model("baseline", "joint", BEFORE, "--", "before")
    after = Model("extended", "extended", AFTER, "-", "after")
    return [before, after] if campaign.has_additions else [before._replace(name="model")]


def _legend(campaign: Campaign) -> list[Line2D]:
    return [
        Line2D([], [], color=MEASURED, label="measured"),
        *(Line2D([], [], color=m.colour, ls=m.dash, label=m.name) for m in _models(campaign)),
    ]
