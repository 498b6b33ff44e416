"""Rigid distances over the pool: what is left wrong with lens, pose, refraction or scale."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..campaign import Campaign
from ..data import Float
from .drawing.look import DIVERGING, absent, letter
from .drawing.pool import pool

TITLE = "Is the geometry right? Rigid distances over the pool"
CAPTION = (
    "The robot's head and core keep their lengths wherever it swims; where keypoints were "
    "placed at stated lengths, by silhouette, it is the whole length from nose to tail that is "
    "seen. A: by how much the measured lengths miss the stated ones, place by place; grey "
    "figures are standard deviations. B: what the error that explains them would do, on the "
    "same scale; blank where no error shows. C: how much each possible error explains, fitted "
    "alone, in units of chi-squared (logarithmic), and by how much it would change lengths "
    "(rms). Hollow: by no more than a detector's lasting errors may (0.05 %; of the whole "
    "length some 0.4 %: half a pixel, and what a ruler misses): however many frames agree, it "
    "tells of nothing. Without lengths there is one sentence in place of the three parts."
)
NEEDS = ("geometry",)
SHOWN = 9
SEEN = "#56B4E9"
LEAST_TOLD = 0.01
BESIDE = 6.0
"""Room for the figure beside the longest bar, as a factor on the logarithmic axis."""


def draw(campaign: Campaign) -> Figure:
    """The map, what the likely error predicts, and all suspects."""
    found = campaign.geometry or {}
    if not found.get("map"):
        figure = Figure(figsize=(4.4, 3.0), layout="constrained")
        absent(figure.subplots(), str(found.get("sentence", "no distances")))
        return figure
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    for axes, name in zip((left, middle, right), "ABC", strict=True):
        letter(axes, name)
    grid = {key: _numbers(value) for key, value in found["map"].items()}
    span = _span(grid)
    _map(left, campaign, grid, span, "excess")
    picture = _map(middle, campaign, grid, span, "model")
    figure.colorbar(picture, ax=[left, middle], label="length error (%)", shrink=0.75)
    left.set_title("measured over stated length")
    middle.set_title(f"likeliest: {_plain(found['likely'])}")
    _suspects(right, found["estimates"])
    figure.suptitle(_words(found), fontsize=8.5, color="#5b6570")
    return figure


def _words(found: Mapping[str, Any]) -> str:
    """What the check says, and where the depth comes from."""
    source = "as given" if found.get("depth_given", True) else "estimated here"
    sentence = textwrap.fill(str(found["sentence"]), 150)
    return f"{sentence}; keypoints {1000 * found['depth_m']:.0f} mm deep, {source}"


def _span(grid: dict[str, Float]) -> float:
    """Largest error shown, %, by cells that are known no worse than twice the usual."""
    known = (grid["count"] > 0) & (grid["std"] <= 2 * np.nanmedian(grid["std"][grid["count"] > 0]))
    both = np.abs(np.concatenate([grid["excess"][known], grid["model"][known]]))
    return max(100 * float(np.nanmax(both)), 0.05)


def _numbers(values: Any) -> Float:
    return np.array(values, dtype=np.float64)


def _map(axes: Axes, campaign: Campaign, grid: dict[str, Float], span: float, name: str) -> Any:
    pool(axes, campaign.study)
    shown = np.where(grid["count"] > 0, 100 * grid[name], np.nan)
    picture = axes.pcolormesh(
        grid["x_edges_m"], grid["y_edges_m"], shown, cmap=DIVERGING, vmin=-span, vmax=span, zorder=1
    )
    if name == "excess":
        _deviations(axes, grid, span)
    return picture


def _deviations(axes: Axes, grid: dict[str, Float], span: float) -> None:
    x, y = (0.5 * (grid[key][1:] + grid[key][:-1]) for key in ("x_edges_m", "y_edges_m"))
    for row, column in zip(*np.nonzero(grid["count"] > 0), strict=True):
        std = 100 * grid["std"][row, column]
        text = f"±{std:.2f}" if std >= LEAST_TOLD else f"<{LEAST_TOLD}"
        dark = abs(100 * grid["excess"][row, column]) > 0.4 * span
        axes.text(x[column], y[row], text, ha="center", va="center", fontsize=5.5,
                  color="white" if dark else "#5b6570")  # fmt: skip


def _suspects(axes: Axes, estimates: list[dict[str, Any]]) -> None:
    best = estimates[:SHOWN][::-1]
    gains = [max(float(one["gain"] or 0.0), 1.0) for one in best]
    names = [f"{_plain(one['name'])}: {', '.join(map(_plain, one['parameters']))}" for one in best]
    fills = [SEEN if one["seen"] else "white" for one in best]
    axes.barh(range(len(best)), gains, left=1.0, color=fills, edgecolor=SEEN, height=0.6)
    for place, (one, gain) in enumerate(zip(best, gains, strict=True)):
        axes.annotate(f"{100 * one['share']:.2g} %", (1.0 + gain, place), xytext=(3, 0),
                      textcoords="offset points", va="center", fontsize=6.5)  # fmt: skip
    axes.set_yticks(range(len(best)), names, fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(1, BESIDE * max(10.0, *gains))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("chi-squared explained alone")


def _plain(name: str) -> str:
    return name.removesuffix("_m_s").removesuffix("_m").removesuffix("_rad").replace("_", " ")
