"""What a fit says of the recordings: errors far above the stated ones, one trial unlike the others,
a force that is only an input in another unit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float
from ..engine import FittedCauseSet, ScoredCauseSet
from ..errors import input_error
from ..fitting import MAX_OVERDISPERSION, FilterResults, Noise
from .preparation import PreparedCauseSearch, stated_std

MAX_ERROR_OVER_STATED = 10.0
"""Estimated over stated errors of an observation above which the report warns."""
MAX_ERROR_OVER_STATED_TO_FIT = 100.0
"""Estimated over stated errors of an observation above which nothing is fitted: the model and the
stated accuracy describe other recordings.
"""
MIN_MEAN_SQUARE_INNOVATION = 0.1
"""Mean square of the whitened prediction errors, 1 if the stated errors are right, below which the
report warns.
"""
MIN_DEVIATING_TRIAL_SCORE_SHARE = 0.5
"""Share of one trial in the variation between trials, above which it is named."""


def trial_disagreement_sentences(best: ScoredCauseSet) -> list[str]:
    """A sentence where the trials disagree, with the trial that deviates if it is one."""
    if (c := best.overdispersion) <= MAX_OVERDISPERSION:
        return []
    one = deviating_trial(best.model)
    most = (
        f"Most of it comes from {one}: is its input, its sign or its clock another than in the "
        "other trials?"
        if one
        else "Something is missing that no candidate describes."
    )
    return [
        f"Parameters vary between trials {c:.1f} times more (in variance) than their standard "
        f"errors allow. {most}"
    ]


def deviating_trial(model: FittedCauseSet) -> str:
    """Name of the trial whose score g' H^-1 g is more than half of the sum over trials, or none."""
    normal, move = model.fit.normal, ~model.at_bound
    if not move.any():
        return ""
    g = normal.gradient[:, move]
    H = normal.hessian.sum(axis=0)[np.ix_(move, move)]
    scores = np.einsum("ti,ij,tj->t", g, np.linalg.pinv(H), g)
    if not (scores.sum() > 0 and np.isfinite(scores).all()):
        return ""
    k = int(np.argmax(scores))
    names = [s.name for s in model.passes.series]
    return names[k] if scores[k] > MIN_DEVIATING_TRIAL_SCORE_SHARE * scores.sum() else ""


def misstated_error_warnings(ready: PreparedCauseSearch, model: FittedCauseSet) -> list[str]:
    """A sentence for each observation whose estimated errors are far larger than the stated ones:
    white noise and errors that last together.
    """
    observations = ready.model.observations
    ratios = estimated_over_stated_errors(ready, model.noise)
    squares = np.concatenate([f.innovations**2 for f in model.passes if len(f.innovations)])
    small = np.nanmean(np.where(squares > 0, squares, np.nan), axis=0) < MIN_MEAN_SQUARE_INNOVATION
    return [
        f"The stated std of {o.name}, {o.std:.3g} {o.unit}, is several times larger than its "
        "errors in the recordings; effects smaller than it stay hidden."
        for o, flag in zip(observations, small, strict=True)
        if flag
    ] + [
        f"The errors of {o.name} are estimated as {ratio:.0f} times the stated ones (std "
        f"{o.std:.3g} {o.unit}). Is std the accuracy of the instrument, and are there outliers, "
        "codes for missing values, or a trial in another unit or of another sign?"
        for o, ratio in zip(observations, ratios, strict=True)
        if ratio > MAX_ERROR_OVER_STATED
    ]


def estimated_over_stated_errors(ready: PreparedCauseSearch, noise: Noise) -> Float:
    """Estimated errors (observations,), white and lasting ones together, over the stated ones."""
    lasting = noise.disturbance[-len(ready.model.observations) :]
    return np.hypot(noise.scale, lasting / stated_std(ready.problem.series))


def refuse_far_larger_errors(
    ready: PreparedCauseSearch, noise: Noise, passes: FilterResults
) -> None:
    """InputError where the errors of the model without causes are over a hundred times the stated
    ones, as in a wrong unit.
    """
    for o, ratio in zip(
        ready.model.observations, estimated_over_stated_errors(ready, noise), strict=True
    ):
        if ratio > MAX_ERROR_OVER_STATED_TO_FIT:
            one = _trial_with_most_errors(passes)
            raise input_error(
                f"trial {one}" if one else "all trials", o.name,
                f"errors of about {ratio * o.std:.2g} {o.unit} around the model without causes",
                f"errors of the order of its std, {o.std:.3g} {o.unit}",
                "Check the unit and the sign of its column, outliers and codes for missing "
                "values, or state the real accuracy as std.",
            )  # fmt: skip


def _trial_with_most_errors(passes: FilterResults) -> str:
    """Name of the trial with more than half of the squared prediction errors of all, or none."""
    squares = np.array([float(np.nansum(f.innovations**2)) for f in passes])
    k = int(np.argmax(squares))
    most = len(squares) > 2 and squares[k] > MIN_DEVIATING_TRIAL_SCORE_SHARE * squares.sum()
    return passes.series[k].name if most else ""


def input_unit_warnings(ready: PreparedCauseSearch, causes: Sequence[str]) -> list[str]:
    """A sentence for each residual term that is linear in an input, as one of a wrong unit is."""
    inputs = {i.name for i in ready.model.inputs}
    out = []
    for name in causes:
        term = ready.problem.candidate_by_name[name]
        for _, variable in sorted(term.sources) if term.is_residual else ():
            if variable in inputs and name.endswith("_linear"):
                out.append(
                    f"{name} is in proportion to the input {variable}: check the unit and the sign "
                    "of its column, or the force that the model makes of it."
                )
    return out
