"""The swing over time beside that of three frictions, and the probability of each stretch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bluekoi.fitting import Series

from ..drawing import COLOURS, MEASURED
from .laws import Law, turning_points


def draw(whole: Series, laws: Mapping[str, Law]) -> Figure:
    """laws: what a law is called -> the law."""
    figure = Figure(figsize=(9.5, 3.6), layout="constrained")
    a, b = figure.subplots(1, 2)
    for (name, one), colour in zip(laws.items(), COLOURS, strict=False):
        _apart(a, whole, one, name, colour)
        b.plot(np.arange(1, len(one.worth) + 1), one.worth, "o-", ms=4, color=colour, label=name)
    a.axhline(0.0, color=MEASURED, lw=0.6)
    a.set(xlabel="time, s", ylabel="swing seen less swing of the law, rad",
          title="Turning points: what each friction gets wrong")  # fmt: skip
    b.set(xlabel="stretch of the run left out of the fit",
          ylabel="log likelihood of the stretch", title="Foretold from the others")  # fmt: skip
    b.legend()
    return figure


def _apart(axes: Axes, whole: Series, one: Law, name: str, colour: str) -> None:
    times, seen = turning_points(whole.times, whole.seen[:, 0])
    run_times, run = turning_points(whole.times, one.run[:, 0])
    near = np.array([int(np.argmin(np.abs(run_times - t))) for t in times])
    axes.plot(times, np.abs(seen) - np.abs(run[near]), "o-", ms=3, lw=0.8, color=colour, label=name)
