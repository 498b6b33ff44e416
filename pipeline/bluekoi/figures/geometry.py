"""Rigid distances over the pool: remaining errors of lens, pose, refraction or scale."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..campaign import Campaign
from ..data import Float
from ..study.keypoint_depth import DEPTH_DECIMALS
from .drawing.pool import draw_pool
from .drawing.style import DIVERGING_COLOURMAP, panel_letter, placeholder

FIGURE_TITLE = "Geometry check: rigid distances over the pool"
FIGURE_CAPTION = (
    "Head and core of the robot are rigid, so their measured lengths must not depend on the "
    "position in the pool. (With keypoints from silhouettes, the length from nose to tail is "
    "compared.) (A) Relative error of the measured length by position; small numbers: standard "
    "errors. (B) The same for the error source that explains A best; blank where none is "
    "detected. (C) Reduction in chi-squared by each error source fitted alone (logarithmic), and "
    "the rms length change that it implies. Hollow bars are below the accuracy of the detector "
    "(0.05 %, for the whole length about 0.4 %) and are ignored, however many frames agree."
)
REQUIRED_RESULTS = ("geometry",)
MAX_ERROR_SOURCES_SHOWN = 9
"""Possible errors of the geometry that are drawn, at most."""
DETECTABLE_ERROR_SOURCE_COLOUR = "#56B4E9"
SMALLEST_PRINTED_STD_ERROR_PCT = 0.01
"""Smallest standard error that is printed as a number, %."""
MIN_COLOUR_LIMIT_PCT = 0.05
"""Smallest colour limit of the maps, %: the accuracy of the detector."""
LOG_AXIS_HEADROOM_FACTOR = 6.0
"""Space right of the longest bar, a factor on the logarithmic axis."""


def render_figure(campaign: Campaign) -> Figure:
    """Measured map, map predicted by the likeliest error source, and all error sources."""
    found = campaign.geometry or {}
    if not found.get("map"):
        figure = Figure(figsize=(4.4, 3.0), layout="constrained")
        placeholder(figure.subplots(), str(found.get("sentence", "no distances")))
        return figure
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    for axes, name in zip((left, middle, right), "ABC", strict=True):
        panel_letter(axes, name)
    grid = {key: _as_float_array(value) for key, value in found["map"].items()}
    span = _colour_limit_pct(grid)
    _draw_error_map(left, campaign, grid, span, "excess")
    picture = _draw_error_map(middle, campaign, grid, span, "model")
    figure.colorbar(picture, ax=[left, middle], label="length error (%)", shrink=0.75)
    left.set_title("error of length (±: standard error, %)")
    likely = str(found["likely"])
    middle.set_title(
        "no error detected"
        if likely == "nothing"
        else f"likeliest source: {_error_source_label(likely)}"
    )
    _draw_error_sources(right, found["estimates"])
    figure.suptitle(_check_summary(found), fontsize=8.5, color="#5b6570")
    return figure


def _check_summary(found: Mapping[str, Any]) -> str:
    """Result of the check, and the source of the keypoint depth."""
    source = "from study.yaml" if found.get("depth_given", True) else _keypoint_depth_source(found)
    sentence = textwrap.fill(str(found["sentence"]), 150)
    return f"{sentence}; keypoint depth {1000 * found['depth_m']:.0f} mm, {source}"


def _keypoint_depth_source(found: Mapping[str, Any]) -> str:
    """How a keypoint depth that study.yaml does not give was found; see study/keypoint_depth.py."""
    estimate, std = found.get("depth_estimate_m"), found.get("depth_estimate_std_m")
    if estimate is None or std is None:
        return "assumed"
    if round(estimate, DEPTH_DECIMALS) == found["depth_m"]:
        return f"estimated from the rigid lengths (± {1000 * std:.0f} mm)"
    return f"assumed: the rigid lengths give it to ± {1000 * std:.0f} mm only"


def _colour_limit_pct(grid: dict[str, Float]) -> float:
    """Colour limit, %: twice the median standard error, or the largest error of the cells with no
    more than that; at least `MIN_COLOUR_LIMIT_PCT`.
    """
    noise_limit = 2 * float(np.nanmedian(grid["std"][grid["count"] > 0]))
    known = (grid["count"] > 0) & (grid["std"] <= noise_limit)
    both = np.abs(np.concatenate([grid["excess"][known], grid["model"][known]]))
    return max(100 * float(np.nanmax(both)), 100 * noise_limit, MIN_COLOUR_LIMIT_PCT)


def _as_float_array(values: Any) -> Float:
    return np.array(values, dtype=np.float64)


def _draw_error_map(
    axes: Axes, campaign: Campaign, grid: dict[str, Float], span: float, name: str
) -> Any:
    draw_pool(axes, campaign.study)
    shown = np.where(grid["count"] > 0, 100 * grid[name], np.nan)
    picture = axes.pcolormesh(
        grid["x_edges_m"],
        grid["y_edges_m"],
        shown,
        cmap=DIVERGING_COLOURMAP,
        vmin=-span,
        vmax=span,
        zorder=1,
    )
    if name == "excess":
        _mark_standard_errors(axes, grid, span)
    return picture


def _mark_standard_errors(axes: Axes, grid: dict[str, Float], span: float) -> None:
    x, y = (0.5 * (grid[key][1:] + grid[key][:-1]) for key in ("x_edges_m", "y_edges_m"))
    for row, column in zip(*np.nonzero(grid["count"] > 0), strict=True):
        std = 100 * grid["std"][row, column]
        text = (
            f"±{std:.2f}"
            if std >= SMALLEST_PRINTED_STD_ERROR_PCT
            else f"<{SMALLEST_PRINTED_STD_ERROR_PCT}"
        )
        dark = abs(100 * grid["excess"][row, column]) > 0.4 * span
        axes.text(x[column], y[row], text, ha="center", va="center", fontsize=5.5,
                  color="white" if dark else "#5b6570")  # fmt: skip


def _draw_error_sources(axes: Axes, estimates: list[dict[str, Any]]) -> None:
    best = estimates[:MAX_ERROR_SOURCES_SHOWN][::-1]
    gains = [max(float(one["gain"] or 0.0), 1.0) for one in best]
    names = [
        _error_source_label(one["name"]) + _parameter_list_text(one["parameters"]) for one in best
    ]
    fills = [DETECTABLE_ERROR_SOURCE_COLOUR if one["detectable"] else "white" for one in best]
    axes.barh(
        range(len(best)),
        gains,
        left=1.0,
        color=fills,
        edgecolor=DETECTABLE_ERROR_SOURCE_COLOUR,
        height=0.6,
    )
    for place, (one, gain) in enumerate(zip(best, gains, strict=True)):
        axes.annotate(f"{100 * one['share']:.2g} %", (1.0 + gain, place), xytext=(3, 0),
                      textcoords="offset points", va="center", fontsize=6.5)  # fmt: skip
    axes.set_yticks(range(len(best)), names, fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(1, LOG_AXIS_HEADROOM_FACTOR * max(10.0, *gains))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("reduction in chi-squared\n(at the bars: rms length change)")


def _parameter_list_text(parameters: Sequence[str]) -> str:
    return f": {', '.join(map(_error_source_label, parameters))}" if len(parameters) > 1 else ""


def _error_source_label(name: str) -> str:
    return name.removesuffix("_m_s").removesuffix("_m").removesuffix("_rad").replace("_", " ")
