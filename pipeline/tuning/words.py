"""What the data leave open, in words, with the trial that would determine it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..fitting import Series
from ..study import Setup
from .bounds import sides
from .identify import Combination, NewTrial, best_new_trial, by_name, spectrum
from .joint import Tuned

TURNING = ("C_Da", "C_La", "C_Ma", "C_Md")
STRAIGHT_BELOW_RAD = np.radians(3.0)
HELPS = 0.8
"""A trial is recommended if it leaves less than this of a combination's deviation."""


def undetermined(series: Sequence[Series], tuned: Tuned, setup: Setup) -> list[dict[str, Any]]:
    """Combinations that the data do not determine: in words, and which trial would.

    Each: combination, relative_std (None where nothing is known), sentence, trial.
    """
    straight = _straight(series)
    names = [f.label for f in tuned.fit.free]
    return [
        {
            **told(names, one),
            "sentence": _sentence(by_name(names, one.direction), one.std, straight=straight),
            "trial": _trial(best_new_trial(series, tuned, setup, one)),
        }
        for one in spectrum(tuned)
        if not one.determined
    ]


def open_without_turns(
    table: Mapping[str, dict[str, Any]], series: Sequence[Series]
) -> dict[str, dict[str, Any]]:
    """A table in which straight runs alone determine nothing that acts at an angle of attack: what
    the random water tells of it rests on the model of that water.
    """
    if not _straight(series):
        return dict(table)
    why = "no turns: straight runs hold alpha at 0 and say nothing of it"
    return {
        name: cell | {"determined": False, "why": cell["why"] or why} if name in TURNING else cell
        for name, cell in table.items()
    }


def turns(series: Sequence[Series]) -> int:
    """How many trials have the head turned."""
    return sum(not _straight([s]) for s in series)


def hangs_on_one_trial(tuned: Tuned) -> bool:
    """Whether one trial alone tells of some number that acts at an angle of attack."""
    held = sides(tuned.fit)
    return any(
        f.name in TURNING and not held[i] and not np.isfinite(tuned.interval_95[i]).all()
        for i, f in enumerate(tuned.fit.free)
    )


def _straight(series: Sequence[Series]) -> bool:
    """Whether no trial turns its head."""
    return all(abs(s.inputs[:, 0]).max() < STRAIGHT_BELOW_RAD for s in series)


def told(names: Sequence[str], one: Combination) -> dict[str, Any]:
    """A combination as it stands in coefficients.json."""
    parts = by_name(names, one.direction)
    return {
        "combination": " ".join(f"{w:+.2f} d{n}/{n}" for n, w in parts.items()),
        "relative_std": one.std if np.isfinite(one.std) else None,
    }


def _sentence(parts: Mapping[str, float], std: float, *, straight: bool) -> str:
    up = [n for n, w in parts.items() if w > 0]
    down = [n for n, w in parts.items() if w < 0]
    if len(parts) == 1:
        name = (up or down)[0]
        told = (
            f"{name} may be off by {100 * std:.0f} %." if np.isfinite(std)
            else f"These trials say nothing of {name}."
        )  # fmt: skip
    elif up and down:
        told = f"More {_listed(up)} with less {_listed(down)} leaves these trials almost unchanged."
    else:
        together = up or down
        told = f"{_listed(together)} may grow together"
        told += ": only their ratio is fixed." if len(together) == 2 else " and hardly be noticed."
    blind = [n for n in parts if n.split("@")[0] in TURNING]
    if straight and blind:
        told += (
            " Straight runs hold alpha at 0: they fix C_T/C_D0, and the start from rest each of the"
            f" two, but they say nothing of {_listed(blind)}."
        )
    return told


def _trial(trial: NewTrial) -> str:
    if trial.left > HELPS:
        return (
            "no single trial of this robot helps much: "
            f"the best leaves {100 * trial.left:.0f} % of the deviation"
        )
    kind = "a straight run" if trial.head_angle_deg == 0 else f"a turn at {trial.head_angle_deg:g}°"
    return (
        f"{kind} at {trial.power_pct:g} % power with a head of {trial.head_length_m:.3g} m, from "
        f"rest, would leave {100 * trial.left:.0f} % of the deviation"
    )


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
