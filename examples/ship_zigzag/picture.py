"""The ship: one zigzag foretold from the others, and the error of every one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bluekoi.data import Float
from bluekoi.fitting import Series

from ..drawing import AFTER, BEFORE, MEASURED
from ..forecasting import Forecast

SHOWN = "Z_20_05"
"""A manoeuvre of middling size, drawn where the folder has it."""


def draw(
    trials: Sequence[Series],
    runs: Mapping[str, Sequence[Forecast]],
    minutes: Mapping[str, Sequence[Sequence[Forecast]]],
) -> Figure:
    """runs: name of a model -> every manoeuvre foretold to its end; minutes: by minutes; two
    models.
    """
    figure = Figure(figsize=(10.5, 6.2), layout="constrained")
    (a, b), (c, d) = figure.subplots(2, 2)
    shown = next((i for i, t in enumerate(trials) if t.name == SHOWN), 0)
    own = {name: shots[shown] for name, shots in runs.items()}
    _manoeuvre(a, b, c, trials[shown], own)
    y = np.arange(len(trials))[::-1]
    for (name, each), colour, shift in zip(minutes.items(), (BEFORE, AFTER), (0.2, -0.2),
                                           strict=True):  # fmt: skip
        error = [np.sqrt(np.mean([f.path_rms**2 for f in one])) if one else np.nan for one in each]
        d.barh(y + shift, error, 0.38, color=colour, label=name)
    d.set_yticks(y, [t.name for t in trials])
    d.set(xlabel="path error, m (root mean square)", title="Every manoeuvre, a minute ahead")
    d.legend()
    return figure


def _manoeuvre(a: Axes, b: Axes, c: Axes, one: Series, runs: Mapping[str, Forecast]) -> None:
    seen = one.seen
    a.plot(seen[:, 0], seen[:, 1], color=MEASURED, lw=3, alpha=0.4, label="measured")
    b.plot(one.times, np.degrees(seen[:, 2]), color=MEASURED, lw=3, alpha=0.4)
    c.plot(one.times, _speed(one.times, seen), color=MEASURED, lw=3, alpha=0.4)
    b.plot(one.times, np.degrees(one.inputs[:, 0]), color=MEASURED, lw=0.8, ls=":", label="rudder")
    for (name, run), colour in zip(runs.items(), (BEFORE, AFTER), strict=True):
        a.plot(run.foretold[:, 0], run.foretold[:, 1], color=colour, label=name)
        b.plot(run.times, np.degrees(run.foretold[:, 2]), color=colour)
        c.plot(run.times, _speed(run.times, run.foretold), color=colour)
    a.set(xlabel="x, m", ylabel="y, m", title=f"{one.name}: path")
    b.set(xlabel="time, s", ylabel="heading and rudder, deg", title=f"{one.name}: heading")
    c.set(xlabel="time, s", ylabel="speed, m/s", title=f"{one.name}: speed")
    a.legend()
    b.legend()


def _speed(times: Float, places: Float) -> Float:
    return np.hypot(*np.gradient(places[:, :2], times, axis=0).T)
