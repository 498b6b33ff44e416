"""The fish: its tail's beat and recoil over the bias, its turning, and paths foretold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bluekoi.data import Float

from ..drawing import AFTER, BEFORE, COLOURS, MEASURED
from .asymmetry import side_by_side
from .reading import Recording


def draw(recordings: Sequence[Recording], paths: Mapping[str, Sequence[Float]]) -> Figure:
    """paths: `measured`, `bare`, `named` -> places (n, 2) of every trial, conditions left out."""
    figure = Figure(figsize=(10.5, 6.6), layout="constrained")
    (a, b, c), (d, e, f) = figure.subplots(2, 3)
    rows = np.array(side_by_side(recordings))
    for amplitude, colour in zip(np.unique(rows[:, 0]), COLOURS, strict=False):
        own = rows[rows[:, 0] == amplitude]
        label = f"amplitude {amplitude:g} deg"
        a.plot(own[:, 1], own[:, 2], "o-", ms=4, color=colour, label=label)
        b.plot(own[:, 1], np.degrees(own[:, 3]), "o-", ms=4, color=colour, label=label)
    _curvature(c, recordings)
    a.set(xlabel="tail bias, deg", ylabel="tail beat seen, Hz", title="Beat: faster to one side")
    b.set(xlabel="tail bias, deg", ylabel="yaw recoil, deg", title="Recoil of the heading")
    a.legend()
    for axes, k in zip((d, e, f), _shown(recordings), strict=True):
        _path(axes, recordings[k], {name: p[k] for name, p in paths.items()})
    d.legend()
    return figure


def _curvature(axes: Axes, recordings: Sequence[Recording]) -> None:
    for r in recordings:
        k = r.track
        half = slice(len(k.time_s) // 2, None)
        rate = float(np.mean(k.yaw_rate_rad_s[half]))
        speed = float(np.mean(k.speed_m_s[half]))
        axes.plot(r.bias_deg, rate, "o", ms=4, color=BEFORE)
        axes.plot(r.bias_deg, rate / speed / 10.0, "s", ms=3, color=AFTER)
    axes.plot([], [], "o", color=BEFORE, label="yaw rate, rad/s")
    axes.plot([], [], "s", color=AFTER, label="curvature, 1/m, over 10")
    axes.axhline(0.0, color=MEASURED, lw=0.6)
    axes.set(xlabel="tail bias, deg", title="Turning, second half of each trial")
    axes.legend()


def _shown(recordings: Sequence[Recording]) -> list[int]:
    """A turn to one side, the straightest, a turn to the other, at the largest amplitude."""
    largest = max(r.amplitude_deg for r in recordings)
    own = [i for i, r in enumerate(recordings) if r.amplitude_deg == largest]
    ordered = sorted(own, key=lambda i: recordings[i].bias_deg)
    straight = min(own, key=lambda i: abs(recordings[i].bias_deg))
    return [ordered[0], straight, ordered[-1]]


def _path(axes: Axes, one: Recording, paths: Mapping[str, Float]) -> None:
    styles = {"measured": (MEASURED, 3.0), "bare": (BEFORE, 1.2), "named": (AFTER, 1.2)}
    for name, (colour, width) in styles.items():
        x, y = paths[name].T
        axes.plot(x, y, color=colour, lw=width, alpha=0.5 if name == "measured" else 1, label=name)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x, m", ylabel="y, m", title=f"{one.name}")
