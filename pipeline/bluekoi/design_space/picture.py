"""Pictures: designs with their front, and a simulated path with what was commanded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..data import Float
from ..files import atomic_write
from ..model import Simulation
from ..study import StudySettings
from .front import RobotDesign, is_pareto_optimal
from .manoeuvres import Schedule

TESTED_COLOUR, FRONT_COLOUR = "#b0b8bf", "#0b5394"
MAX_PARETO_FRONT_MARKS = 14
"""Marks along the front, at most."""


def designs_figure(designs: Sequence[RobotDesign], *, min_speed_m_s: float = 0.0) -> Figure:
    """Speed over radius; the front with its 95 % bands; hollow where extrapolated."""
    figure = Figure(figsize=(7.5, 5.2), layout="constrained")
    axes = figure.add_subplot()
    front = is_pareto_optimal(designs)
    x = np.array([d.radius_m[0] for d in designs])
    y = np.array([d.speed_m_s[0] for d in designs])
    inside = np.array([not d.extrapolated for d in designs])
    for kind, name, face in (
        (inside, "tested range", TESTED_COLOUR),
        (~inside, "extrapolated", "none"),
    ):
        axes.plot(x[kind], y[kind], "o", ms=3.5, color=TESTED_COLOUR, mfc=face, mew=0.7, label=name)
    _draw_pareto_front(axes, [d for d, is_on in zip(designs, front, strict=True) if is_on])
    if min_speed_m_s > 0:
        axes.axhline(min_speed_m_s, color="#a61c00", lw=1, ls=":")
    known = x[np.isfinite(x)]
    if len(known):
        axes.set_xlim(0, 1.05 * np.percentile(known, 95))
    axes.set(xlabel="steady turn radius (m)", ylabel="steady speed (m/s)", ylim=(0, None))
    axes.legend(loc="lower right", frameon=False)
    axes.grid(color="#e4e7ea", lw=0.6)
    axes.set_axisbelow(True)
    return figure


def _draw_pareto_front(axes: Axes, front: Sequence[RobotDesign]) -> None:
    ordered = sorted(front, key=lambda d: d.radius_m[0])
    for d in ordered:
        (radius, *across), (speed, *along) = d.radius_m, d.speed_m_s
        axes.plot(across, [speed, speed], color=FRONT_COLOUR, lw=1, alpha=0.5)
        axes.plot([radius, radius], along, color=FRONT_COLOUR, lw=1, alpha=0.5)
        axes.plot(
            radius,
            speed,
            "o",
            ms=5,
            color=FRONT_COLOUR,
            mfc="white" if d.extrapolated else FRONT_COLOUR,
        )
    axes.plot([d.radius_m[0] for d in ordered], [d.speed_m_s[0] for d in ordered], lw=1,
              color=FRONT_COLOUR,
              label="front: none is faster and tighter, with 95 % bands")  # fmt: skip


def simulated_path_figure(
    run: Simulation, schedule: Schedule, setup: StudySettings, head_length_m: float
) -> Figure:
    """The path from above with the robot drawn along it; command and speed over time below."""
    figure = Figure(figsize=(7.5, 7.2), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=(2.4, 1))
    x, y = run.state[:, 0], run.state[:, 1]
    above.plot(x, y, color=FRONT_COLOUR, lw=1.2)
    marks = np.unique(np.linspace(0, len(x) - 1, MAX_PARETO_FRONT_MARKS).round().astype(int))
    outlines = _robot_outlines(run, marks, setup, head_length_m)
    above.add_collection(LineCollection(outlines, colors="0.25", linewidths=1.6))
    pool = setup.pool
    above.add_patch(Rectangle((0, 0), pool.length_m, pool.width_m, fill=False, ec="0.6", lw=1))
    above.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    above.autoscale_view()
    hz, angle = schedule.at(run.time_s)
    below.plot(run.time_s, run.speed_m_s, color=FRONT_COLOUR, label="speed (m/s)")
    below.plot(run.time_s, hz / 10, color="#6aa84f", label="flapping (10 Hz)")
    below.plot(run.time_s, np.degrees(angle) / 100, color="#e69138", label="head angle (100°)")
    below.set(xlabel="time (s)", xlim=(0, run.time_s[-1]))
    below.legend(loc="best", frameon=False, ncols=3, fontsize=8)
    return figure


def _robot_outlines(
    run: Simulation, marks: Float, setup: StudySettings, head_length_m: float
) -> list[Float]:
    """Lines (3, 2) from nose over hinge to tail base at some frames."""
    psi, theta = run.heading_rad[marks], run.state[marks, 2]
    points = setup.robot.body_points(head_length_m, run.state[marks, :2], psi, psi - theta)
    return list(points[:, [0, 1, 3]])


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure, whole or not at all, in the format of the file's ending."""
    FigureCanvasAgg(figure)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format=Path(path).suffix.lstrip(".") or "png", dpi=150)
