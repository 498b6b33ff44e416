"""Calibration plot: how often stated probabilities were right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#e69f00", "#7f7f7f")


def calibration_plot(
    sets: Mapping[str, Sequence[Mapping[str, Any]]], path: Path, *, description: str
) -> None:
    """Share of true causes over mean stated probability for each set of bins, with 95 % bars.

    description: kept in the metadata of the svg.
    """
    with mpl.rc_context({"svg.hashsalt": "bluekoi", "svg.fonttype": "none"}):
        figure = Figure(figsize=(5.0, 4.2), layout="constrained")
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1], color="0.7", lw=1, zorder=0)
        for i, (name, bins) in enumerate(sets.items()):
            _draw_errorbars(axes, name, bins, COLOURS[i], shift=0.006 * (i - 1))
        axes.set(xlabel="stated probability of a named cause", ylabel="share that was true",
                 xlim=(0, 1.03), ylim=(-0.03, 1.03), title="Calibration")  # fmt: skip
        axes.legend(loc="lower right", frameon=False)
        figure.savefig(path, metadata={"Date": None, "Description": description})


def _draw_errorbars(
    axes: Any, name: str, bins: Sequence[Mapping[str, Any]], colour: str, *, shift: float
) -> None:
    share = [one["true"] / one["count"] for one in bins]
    ends = [one["interval_95"] for one in bins]
    below = [s - low for s, (low, _) in zip(share, ends, strict=True)]
    above = [high - s for s, (_, high) in zip(share, ends, strict=True)]
    axes.errorbar([one["mean"] + shift for one in bins], share, yerr=[below, above], fmt="o",
                  color=colour, capsize=3, label=name)  # fmt: skip
    for one, s in zip(bins, share, strict=True):
        axes.annotate(str(one["count"]), (one["mean"] + shift, s), xytext=(5, -10),
                      textcoords="offset points", fontsize=8, color=colour)  # fmt: skip
