"""What trials say nothing of unless the head is turned in some of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..fitting import TrialSeries
from ..fitting.joint_fit import AT_BOUND_REASON
from .bounds import bound_sides, intervals_at_bounds
from .joint_fit import JointFit

TURN_COEFFICIENTS = ("C_Da", "C_La", "C_Ma", "C_Md")
"""Coefficients that only turns determine."""
MAX_STRAIGHT_ANGLE_RAD = np.radians(3.0)
"""Head angle below which a trial is a straight run."""


def undetermined_without_turns(
    table: Mapping[str, dict[str, Any]], series: Sequence[TrialSeries]
) -> dict[str, dict[str, Any]]:
    """A table in which straight runs alone determine nothing that acts at an angle of attack: what
    the random water reveals depends on the model of that water.
    """
    if not no_trial_turns_head(series):
        return dict(table)
    why = "no turns: straight runs hold alpha at 0 and say nothing of it"
    return {
        name: cell | {"determined": False, "why": why} if name in TURN_COEFFICIENTS else cell
        for name, cell in table.items()
    }


def count_turning_trials(series: Sequence[TrialSeries]) -> int:
    """How many trials have the head turned."""
    return sum(not no_trial_turns_head([s]) for s in series)


def depends_on_one_trial(tuned: JointFit) -> bool:
    """Whether some number that acts at an angle of attack is determined by one trial alone."""
    held = bound_sides(tuned.fit)
    return any(
        f.name in TURN_COEFFICIENTS and not held[i] and not np.isfinite(tuned.interval_95[i]).all()
        for i, f in enumerate(tuned.fit.free)
    )


def joint_fit_outcome_text(tuned: JointFit, series: Sequence[TrialSeries]) -> str:
    """The joint fit's outcome; of numbers at a bound whether the data ask for more than is
    plausible, or whether they only say too little of them.
    """
    if tuned.fit.outcome != AT_BOUND_REASON:
        return tuned.fit.outcome
    held = [tuned.fit.free[i].label for i, side in enumerate(bound_sides(tuned.fit)) if side]
    blind = [name for name in held if name.split("@")[0] in TURN_COEFFICIENTS]
    if no_trial_turns_head(series) and blind == held:
        return (
            "at a bound: straight runs hold alpha at 0 and say nothing of "
            f"{', '.join(held)}: turns are lacking"
        )
    unsaid = [tuned.fit.free[i].label for i in _at_bound_consistent_with_start(tuned)]
    if unsaid == held:
        lacking = "more turns are" if blind == held else "more trials are"
        return f"at a bound: these trials say too little of {', '.join(held)}: {lacking} lacking"
    return tuned.fit.outcome


def _at_bound_consistent_with_start(tuned: JointFit) -> list[int]:
    """Numbers at a bound that may as well have their usual value: the start of fits, which lies
    in their one-sided interval.
    """
    return [
        i
        for i, ends in intervals_at_bounds(tuned.fit).items()
        if ends[0] <= tuned.fit.definitions[i].start <= ends[1]
    ]


def no_trial_turns_head(series: Sequence[TrialSeries]) -> bool:
    """Whether no trial turns its head."""
    return all(abs(s.inputs[:, 0]).max() < MAX_STRAIGHT_ANGLE_RAD for s in series)
