"""Speed of the robot across the tank and along it, each command against its own mean."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..drawing import COLOURS, MEASURED
from .edge import MIDDLE_M, NEAR_M, Beats, beats
from .reading import Run


def draw(runs: Sequence[Run]) -> Figure:
    """Every beat in which the light was not lost, coloured by command."""
    figure = Figure(figsize=(9.5, 3.8), layout="constrained")
    across, along = figure.subplots(1, 2, sharey=True)
    for i, command in enumerate(dict.fromkeys(r.condition for r in runs)):
        own = [beats(r) for r in runs if r.condition == command]
        style = (COLOURS[i % len(COLOURS)], "os^"[i // len(COLOURS)])
        _command(across, along, own, command, style)
    across.axvspan(0, NEAR_M, color="#e4e7ea")
    across.set(xlabel="distance from the edge y = 0, m (grey: within 0.12 m)",
               ylabel="speed over the command's mean", title="Across, in the tank's middle",
               xlim=(-0.03, 2.05), ylim=(0, 1.7))  # fmt: skip
    along.set(xlabel="place along the tank, m", title="Along the tank")
    across.legend(title="frequency Hz, amplitude deg, lag", ncols=2, fontsize=6.5,
                  title_fontsize=6.5, loc="lower right")  # fmt: skip
    return figure


def _command(
    across: Axes, along: Axes, own: Sequence[Beats], command: str, style: tuple[str, str]
) -> None:
    colour, marker = style
    speed, x, y = (np.concatenate([getattr(b, k) for b in own]) for k in ("speed", "x", "y"))
    good = ~np.concatenate([b.gaps for b in own])
    middle = good & (x > MIDDLE_M[0]) & (x < MIDDLE_M[1])
    share = speed / speed[middle].mean()
    across.plot(y[middle], share[middle], marker, ms=3, color=colour,
                label=command.replace("_", ", "))  # fmt: skip
    along.plot(x[good], share[good], marker, ms=3, color=colour)
    for axes in (across, along):
        axes.axhline(1.0, color=MEASURED, lw=0.6)
