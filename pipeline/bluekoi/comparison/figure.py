"""Figure of two runs: coefficients, causes, errors and steady speeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.drawing.style import COLOURS, RC_PARAMS, placeholder
from .run_differences import MIN_LISTED_CAUSE_PROBABILITY, RunResults

FIRST_COLOUR, SECOND_COLOUR = COLOURS[0], COLOURS[2]
BAR_OFFSET = 0.15
"""Distance of the two runs' bars from their common line, in lines."""
MAX_CAUSES_SHOWN = 12


def comparison_figure(first: RunResults, second: RunResults, labels: tuple[str, str]) -> Figure:
    """Four panels; what only one run has is drawn alone."""
    with matplotlib.rc_context(RC_PARAMS):
        figure = Figure(figsize=(8.5, 6.5), layout="constrained")
        panels = figure.subplots(2, 2)
        runs = (first, second)
        _draw_coefficients(panels[0, 0], runs, labels)
        _draw_causes(panels[0, 1], runs, labels)
        _draw_errors(panels[1, 0], runs, labels)
        _draw_speeds(panels[1, 1], runs, labels)
        return figure


def _draw_coefficients(axes: Axes, runs: Sequence[RunResults], labels: Sequence[str]) -> None:
    """Values over the first run's, with 95 % intervals."""
    axes.set_title("Coefficients, first run = 1")
    names = [
        n
        for n, c in runs[0].joint_coefficients.items()
        if c.get("value") and n in runs[1].joint_coefficients
    ]
    if not names:
        return placeholder(axes, "No coefficients in both runs")
    for k, (run, label, colour) in enumerate(
        zip(runs, labels, (FIRST_COLOUR, SECOND_COLOUR), strict=True)
    ):
        unit = np.array([runs[0].joint_coefficients[n]["value"] for n in names], dtype=float)
        value = (
            np.array([_number_or_nan(run.joint_coefficients[n].get("value")) for n in names]) / unit
        )
        std = np.abs(
            np.array([_number_or_nan(run.joint_coefficients[n].get("std")) for n in names]) / unit
        )
        y = np.arange(len(names)) + BAR_OFFSET * (2 * k - 1)
        bars = 1.96 * np.nan_to_num(std)
        axes.errorbar(value, y, xerr=bars, fmt="o", ms=4, color=colour, label=label)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.axvline(1, color="#5b6570", lw=0.8)
    axes.set_xlabel("value / value of the first run, 95 % interval")
    axes.legend()
    return None


def _draw_causes(axes: Axes, runs: Sequence[RunResults], labels: Sequence[str]) -> None:
    axes.set_title("Probability of each cause")
    chances = [dict(run.mismatch.get("probabilities") or {}) for run in runs]
    most = {n: max(float(c.get(n) or 0) for c in chances) for n in {**chances[0], **chances[1]}}
    names = sorted(
        (n for n, p in most.items() if p >= MIN_LISTED_CAUSE_PROBABILITY), key=lambda n: -most[n]
    )
    names = names[:MAX_CAUSES_SHOWN]
    if not names:
        return placeholder(axes, "No cause is probable in either run")
    for k, (found, label, colour) in enumerate(
        zip(chances, labels, (FIRST_COLOUR, SECOND_COLOUR), strict=True)
    ):
        y = np.arange(len(names)) + BAR_OFFSET * (2 * k - 1)
        axes.barh(y, [float(found.get(n) or 0) for n in names], 0.28, color=colour, label=label)
    axes.set_yticks(range(len(names)), [n.replace("_", " ") for n in names])
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xlabel("probability")
    axes.legend()
    return None


def _draw_errors(axes: Axes, runs: Sequence[RunResults], labels: Sequence[str]) -> None:
    axes.set_title("Path error on held-out trials")
    rows = ("baseline model", "with identified causes", "noise floor")
    for k, (run, label, colour) in enumerate(
        zip(runs, labels, (FIRST_COLOUR, SECOND_COLOUR), strict=True)
    ):
        held = run.mismatch.get("held_out") or {}
        values = [(held.get(m) or {}).get("path_rmse_m") for m in ("baseline", "extended")]
        size = [1e3 * _number_or_nan(v) for v in (*values, held.get("noise_floor_path_rmse_m"))]
        axes.bar(np.arange(3) + BAR_OFFSET * (2 * k - 1), size, 0.28, color=colour, label=label)
    axes.set_xticks(range(3), rows)
    axes.set_ylabel("rms distance, mm")


def _draw_speeds(axes: Axes, runs: Sequence[RunResults], labels: Sequence[str]) -> None:
    axes.set_title("Steady speed of each trial")
    names = [n for n in runs[0].steady if n in runs[1].steady]
    a, b = (np.array([run.steady[n].speed_m_s for n in names]) for run in runs)
    if not names or not np.isfinite(a * b).any():
        return placeholder(axes, "No trial has a steady speed in both runs")
    top = 1.05 * float(np.nanmax([a, b]))
    axes.plot([0, top], [0, top], color="#5b6570", lw=0.8)
    axes.plot(a, b, "o", ms=4, color=SECOND_COLOUR)
    for name, x, y in zip(names, a, b, strict=True):
        if math.isfinite(x * y) and abs(y - x) > 0.05 * top:
            axes.annotate(name, (x, y), textcoords="offset points", xytext=(4, 2), fontsize=7)
    axes.set_xlabel(f"{labels[0]}, m/s")
    axes.set_ylabel(f"{labels[1]}, m/s")
    return None


def _number_or_nan(value: Any) -> float:
    return math.nan if value is None else float(value)
