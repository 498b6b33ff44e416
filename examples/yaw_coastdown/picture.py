"""Spin-downs foretold from the others, by linear damping alone and with all that pays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from bluekoi.data import Float
from bluekoi.fitting import Series

from ..drawing import AFTER, BEFORE, MEASURED


def draw(trials: Sequence[Series], runs: Mapping[str, Sequence[Float]]) -> Figure:
    """runs: name of a model -> yaw rates (n,) of every trial by a fit to the others; two models."""
    figure = Figure(figsize=(9.5, 4.6), layout="constrained")
    rows = figure.subplots(2, len(trials), sharey="row", squeeze=False)
    for top, bottom, one, *told in zip(*rows, trials, *runs.values(), strict=True):
        top.plot(one.times, one.seen[:, 0], color=MEASURED, lw=2.5, alpha=0.4, label="measured")
        for run, name, colour in zip(told, runs, (BEFORE, AFTER), strict=True):
            top.plot(one.times, run, color=colour, lw=1, label=name)
            bottom.plot(one.times, one.seen[:, 0] - run, color=colour, lw=0.8)
        bottom.axhline(0.0, color=MEASURED, lw=0.6)
        bottom.set(xlabel="time, s", ylim=(-0.08, 0.08))
        top.set_title(one.name, fontsize=8)
    rows[0, 0].set_ylabel("yaw rate, rad/s")
    rows[1, 0].set_ylabel("measured less foretold, rad/s")
    rows[0, 0].legend(fontsize=6.5)
    return figure
