"""One look for all figures: colours that the colour-blind can tell apart, letters, notices."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

LOOK: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e7ea",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "pdf.fonttype": 42,
    "figure.dpi": 100,
}

# Okabe and Ito (2008), the colours told apart by the colour-blind
COLOURS = ("#0072B2", "#009E73", "#D55E00", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
MEASURED, BEFORE, AFTER = "#20262e", "#D55E00", "#0072B2"
"""Measured path, model as published, model with what was left out."""
DIVERGING = "RdBu_r"
BAND = 1.96


@dataclass(frozen=True)
class Style:
    """Colour and marker of one power."""

    colour: str
    marker: str


def power_styles(powers: Iterable[float]) -> dict[float, Style]:
    """A colour and a marker for each power, in the order given."""
    listed = list(powers)
    if len(listed) <= len(COLOURS):
        colours = list(COLOURS[: len(listed)])
    else:
        colours = [to_hex(colormaps["cividis"](i / (len(listed) - 1))) for i in range(len(listed))]
    return {power: Style(colours[i], MARKERS[i % len(MARKERS)]) for i, power in enumerate(listed)}


def letter(axes: Axes, name: str) -> None:
    """Panel letter at the upper left, outside the axes."""
    axes.annotate(
        name,
        (0, 1),
        xytext=(-30, 8),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=12,
        fontweight="bold",
        annotation_clip=False,
    )


def absent(axes: Axes, sentence: str) -> None:
    """Say in the panel what is missing, and take the ticks away."""
    axes.text(
        0.5,
        0.5,
        textwrap.fill(sentence, 26),
        transform=axes.transAxes,
        ha="center",
        va="center",
        color="#5b6570",
        fontstyle="italic",
    )
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)


def notice(title: str, sentence: str) -> Figure:
    """A small figure that says why there is nothing to see."""
    figure = Figure(figsize=(7.5, 1.6))
    figure.text(0.03, 0.75, title, fontsize=11, fontweight="bold")
    figure.text(0.03, 0.3, textwrap.fill(sentence, 95), color="#5b6570", va="center")
    return figure


def spread_ticks(axes: Axes, *, x: int | None = None, y: int | None = None) -> None:
    """At most so many ticks on an axis."""
    if x is not None:
        axes.locator_params(axis="x", nbins=x)
    if y is not None:
        axes.locator_params(axis="y", nbins=y)
