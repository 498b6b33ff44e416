"""Balls: the force that gravity leaves out over speed; drag coefficients; the fall after 2 s."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..drawing import AFTER, BEFORE, MEASURED
from ..forecasting import Forecast
from .errors import PUBLISHED_M2, Drop

SPHERE = ((0.4, 0.5, "sphere"), (0.1, 0.3, "beyond drag crisis"))


@dataclass(frozen=True)
class Ball:
    """What the figure shows of a ball: its drops, their Reynolds number at the mean speed,
    and the forecast of the first drop.
    """

    name: str
    drops: Sequence[Drop]
    reynolds: float
    rest: Forecast


def draw(balls: Mapping[str, Ball]) -> Figure:
    """Drag coefficients, scales of the drops, errors after two seconds."""
    figure = Figure(figsize=(9.5, 6.4), layout="constrained")
    (a, b), (c, d) = figure.subplots(2, 2, height_ratios=(1.2, 1))
    _drag(a, balls)
    _errors(b, balls)
    _drops(c, balls, "scale", "lengths seen too long, %", 100.0)
    _drops(d, balls, "release_s", "release after first frame, s", 1.0)
    return figure


def _drag(axes: Axes, balls: Mapping[str, Ball]) -> None:
    for low, high, words in SPHERE:
        axes.axvspan(low, high, color="#e4e7ea")
        axes.annotate(words, (0.5 * (low + high), len(balls) - 0.45), fontsize=6.5, ha="center",
                      color="#5a6570")  # fmt: skip
    for i, ball in enumerate(reversed(list(balls.values()))):
        C = np.array([d.drag for d in ball.drops])
        axes.errorbar(C[:, 0], i + np.array([0.12, -0.12]), xerr=C[:, 1], fmt="o", ms=4,
                      color=AFTER, lw=1)  # fmt: skip
    labels = [f"{ball.name}, {ball.reynolds / 1e5:.1f}" for ball in balls.values()]
    axes.set_yticks(np.arange(len(balls))[::-1], labels)
    axes.set(xlabel="drag coefficient", xlim=(0, 0.9), ylim=(-0.6, len(balls) - 0.1),
             title="Drag in each of two drops; Reynolds number in 1e5")  # fmt: skip


def _errors(axes: Axes, balls: Mapping[str, Ball]) -> None:
    y = np.arange(len(balls))[::-1]
    rests = [ball.rest for ball in balls.values()]
    axes.plot([r.mean_square for r in rests], y, "o", color=AFTER, label="foretold here")
    axes.plot([r.expected for r in rests], y, "|", color=AFTER, ms=12, label="as expected of it")
    axes.plot([PUBLISHED_M2[name] for name in balls], y, "D", color=BEFORE, ms=4,
              label="published")  # fmt: skip
    axes.set_xscale("log")
    axes.set_yticks(y, list(balls))
    axes.set(xlabel="mean square error after 2 s, m$^2$", title="First drop, told by its first 2 s")
    axes.legend(loc="upper left")


def _drops(axes: Axes, balls: Mapping[str, Ball], what: str, label: str, factor: float) -> None:
    drops = [drop for ball in balls.values() for drop in ball.drops]
    values = factor * np.array([getattr(drop, what) for drop in drops])
    sure = np.abs(values[:, 0]) > 3.0 * values[:, 1]
    for chosen, colour in ((~sure, MEASURED), (sure, BEFORE)):
        axes.errorbar(
            np.flatnonzero(chosen),
            values[chosen, 0],
            values[chosen, 1],
            fmt="o",
            ms=3,
            lw=1,
            color=colour,
        )
    axes.axhline(0.0, color=MEASURED, lw=0.6)
    axes.set_xticks(range(0, len(drops), 2), [d.name[:-2] for d in drops[::2]], rotation=60,
                    ha="right", fontsize=6.5)  # fmt: skip
    axes.set(ylabel=label)
