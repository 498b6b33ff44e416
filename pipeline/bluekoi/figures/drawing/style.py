"""Style of all figures: colours safe for colour-blind readers, panel letters, placeholders."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

RC_PARAMS: dict[str, Any] = {
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

# Okabe and Ito (2008): distinguishable with the common colour vision deficiencies
COLOURS = ("#0072B2", "#009E73", "#D55E00", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
PLOT_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
MEASURED_COLOUR, BEFORE_COLOUR, AFTER_COLOUR = "#20262e", "#D55E00", "#0072B2"
"""Colours of measured data, baseline model and extended model."""
DIVERGING_COLOURMAP = "RdBu_r"
Z_95 = 1.96
"""Half width of a 95 % interval in standard deviations."""
BASELINE_MODEL_LABEL = "baseline model (before)"
EXTENDED_MODEL_LABEL = "with identified causes (after)"
NOISE_FLOOR_LABEL = "noise floor: error on simulated data"


@dataclass(frozen=True)
class PowerStyle:
    """Colour and marker of one power."""

    colour: str
    marker: str


def power_styles(powers: Iterable[float]) -> dict[float, PowerStyle]:
    """Colour and marker of each power, in the order given."""
    listed = list(powers)
    if len(listed) <= len(COLOURS):
        colours = list(COLOURS[: len(listed)])
    else:
        colours = [to_hex(colormaps["cividis"](i / (len(listed) - 1))) for i in range(len(listed))]
    return {
        power: PowerStyle(colours[i], PLOT_MARKERS[i % len(PLOT_MARKERS)])
        for i, power in enumerate(listed)
    }


def panel_letter(axes: Axes, name: str) -> None:
    """Panel letter at the upper left, outside the axes."""
    axes.annotate(name, (0, 1), xytext=(-30, 8), xycoords="axes fraction", fontsize=12,
                  textcoords="offset points", fontweight="bold", annotation_clip=False)  # fmt: skip


def placeholder(axes: Axes, sentence: str) -> None:
    """Put a sentence into an empty panel and remove its ticks."""
    axes.text(0.5, 0.5, textwrap.fill(sentence, 26), transform=axes.transAxes, ha="center",
              va="center", color="#5b6570", fontstyle="italic")  # fmt: skip
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)


def placeholder_figure(title: str, sentence: str) -> Figure:
    """A small figure with the reason why nothing is drawn."""
    figure = Figure(figsize=(7.5, 1.6))
    figure.text(0.03, 0.75, title, fontsize=11, fontweight="bold")
    figure.text(0.03, 0.3, textwrap.fill(sentence, 95), color="#5b6570", va="center")
    return figure
