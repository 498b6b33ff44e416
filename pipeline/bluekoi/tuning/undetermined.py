"""What the data leave open, in words, with the trial that would determine it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..fitting import TrialSeries
from ..study import StudySettings
from .identify import (
    ParameterCombination,
    fisher_eigendirections,
    parameter_scales,
    parts_by_coefficient,
)
from .joint_fit import JointFit
from .new_trial import RecommendedTrial, c_optimal_trial
from .turning_trials import TURN_COEFFICIENTS, no_trial_turns_head

MAX_REMAINING_STD_SHARE = 0.8
"""A trial is recommended if it leaves less than this of a combination's deviation."""


def undetermined_combinations(
    series: Sequence[TrialSeries], tuned: JointFit, setup: StudySettings
) -> list[dict[str, Any]]:
    """Combinations that the data do not determine: in words, and which trial would.

    Each: combination, relative_std (None where nothing is known), sentence, trial.
    """
    still = no_trial_turns_head(series)
    names = [f.label for f in tuned.fit.free]
    return [
        {
            **combination_json(names, one),
            "sentence": _combination_sentence(names, one, straight=still),
            "trial": _advice_to_repeat_trial(series, tuned, one)
            or _next_trial_advice(c_optimal_trial(series, tuned, setup, one)),
        }
        for one in fisher_eigendirections(tuned)
        if is_undetermined(names, one, straight=still)
    ]


def is_undetermined(names: Sequence[str], one: ParameterCombination, *, straight: bool) -> bool:
    """Whether a combination is not determined: wide, at a bound, or of straight runs alone with a
    part in it that acts at an angle of attack.
    """
    return not one.determined or (
        straight and bool(_coefficients_needing_turns(parts_by_coefficient(names, one.direction)))
    )


def combination_json(names: Sequence[str], one: ParameterCombination) -> dict[str, Any]:
    """A combination as it stands in coefficients.json."""
    parts = parts_by_coefficient(names, one.direction)
    return {
        "combination": " ".join(f"{w:+.2f} d{n}/{n}" for n, w in parts.items()),
        "relative_std": one.std if np.isfinite(one.std) else None,
    }


def _coefficients_needing_turns(parts: Mapping[str, float]) -> list[str]:
    return [n for n in parts if n.split("@")[0] in TURN_COEFFICIENTS]


def _combination_sentence(
    names: Sequence[str], one: ParameterCombination, *, straight: bool
) -> str:
    parts = parts_by_coefficient(names, one.direction)
    out = (
        _single_number_sentence(next(iter(parts)), one)
        if len(parts) == 1
        else _combined_numbers_sentence(parts)
    )
    if np.isinf(one.std) and np.isfinite(one.naive):
        out += " Only one trial determines it, so that its error cannot be estimated from the"
        out += " variation between trials."
    blind = _coefficients_needing_turns(parts)
    if straight and blind:
        out += (
            " Straight runs hold alpha at 0: they fix C_T/C_D0, and the start from rest each of the"
            f" two, but they say nothing of {_join_names(blind)}."
        )
    return out


def _single_number_sentence(name: str, one: ParameterCombination) -> str:
    if one.side:
        return f"{name} stands at its {one.side} bound."
    if np.isfinite(one.std):
        return f"{name} may be off by {100 * one.std:.0f} %."
    return f"{name} is open." if np.isfinite(one.naive) else f"These trials say nothing of {name}."


def _combined_numbers_sentence(parts: Mapping[str, float]) -> str:
    up = [n for n, w in parts.items() if w > 0]
    down = [n for n, w in parts.items() if w < 0]
    if up and down:
        return (
            f"More {_join_names(up)} with less {_join_names(down)} leaves these trials almost "
            "unchanged."
        )
    both = up or down
    sentence = f"{_join_names(both)} may grow together"
    return sentence + (
        ": only their ratio is fixed." if len(both) == 2 else " with little effect on these trials."
    )


def _advice_to_repeat_trial(
    series: Sequence[TrialSeries], tuned: JointFit, one: ParameterCombination
) -> str:
    """Advice to repeat the trial that alone determines a combination."""
    if np.isfinite(one.std) or not np.isfinite(one.naive) or len(series) < 2:
        return ""
    weights = tuned.fit.naive_cov @ (one.direction / parameter_scales(tuned))
    information = np.einsum("p,tpq,q->t", weights, tuned.fit.normal.hessian, weights)
    name = series[int(np.argmax(information))].name
    return f"a repeat of {name}, the only trial that determines it: two show how far they disagree"


def _next_trial_advice(trial: RecommendedTrial | None) -> str:
    if trial is None:
        return "none: with these coefficients every simulation diverges"
    if trial.left > MAX_REMAINING_STD_SHARE:
        return (
            "no single trial of this robot helps much: "
            f"the best leaves {100 * trial.left:.0f} % of the deviation"
        )
    kind = "a straight run" if trial.head_angle_deg == 0 else f"a turn at {trial.head_angle_deg:g}°"
    return (
        f"{kind} at {trial.power_pct:g} % power with a head of {trial.head_length_m:.3g} m, from "
        f"rest, would leave {100 * trial.left:.0f} % of the deviation"
    )


def _join_names(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
