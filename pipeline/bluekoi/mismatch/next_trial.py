"""The trial that would separate the most probable explanations."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from ..data import Float
from ..engine import FittedCauseSet
from ..engine.candidates import RESIDUAL_EFFECT_KIND
from ..fitting import TrialSeries, trial_parameter_vector
from ..integrate import CompiledSystem
from ..model import simulate
from ..study import Study
from ..tuning import compiled_trial_system
from .find import MismatchResult
from .sentences import UNLISTED_FORCE_TEXT

CANDIDATE_HEAD_ANGLES_DEG = (0.0, 15.0, 30.0, 45.0)
"""Head angles of the trials that may be recommended, to either side: settings that a person chooses
among, without a part in probabilities or verdict."""
SAME_CONDITION_ANGLE_TOLERANCE_DEG = 5.0
"""A trial with the head angle nearer than this has the same condition: a third of the spacing of
`HEAD_ANGLES_DEG`, and many times the error of a commanded angle (0.3 degrees). Only for
the suggestion; no probability depends on it."""


def next_trial_json(
    found: MismatchResult, study: Study, series: Sequence[TrialSeries]
) -> dict[str, Any]:
    """The trial in which the two most probable sets of causes differ most."""
    kernel, sets = compiled_trial_system(series), found.posterior.sets
    order = np.argsort(-found.posterior.probability)
    first = found.model
    other = next((sets[i].model for i in order if sets[i].model.key != first.key), first)
    flap = {g: float(np.mean([s.inputs[0, 1] for s in series if s.group == g]))
            for g in sorted({s.group for s in series}, key=float)}  # fmt: skip
    values = [
        _parameter_vector_with_discrepancy(kernel, found.baseline.base, model)
        for model in (first, other)
    ]
    best = best_next_trial(study, kernel, values[0], values[1], flap)
    unlisted = {e.name for e in kernel.system.effects if e.kind == RESIDUAL_EFFECT_KIND}
    question = disagreement_text(first.causes, other.causes, unlisted)
    floor = 1000 * found.floor_m if np.isfinite(found.floor_m) else 0.0
    apart = float(str(best["apart_mm"]))
    if not apart > floor:
        why = (f"no trial of 4 s shows {question}: paths differ by at most {apart:.1f} mm, the "
               f"noise is {floor:.1f} mm; repeat trials instead")  # fmt: skip
    else:
        why = f"shows best {question}: paths differ by {apart:.0f} mm rms in 4 s"
    return best | {"why": why, "above_noise": bool(apart > floor)}


def _parameter_vector_with_discrepancy(
    kernel: CompiledSystem, base: Float, model: FittedCauseSet
) -> Float:
    """Full parameter vector of a set, with the discrepancy that was fitted with its numbers."""
    out = base.copy()
    for label, value in model.discrepancy.items():
        out[kernel.system.parameter_index[label]] = value
    return trial_parameter_vector(kernel, out, model.fit.free, model.fit.values, "")


def disagreement_text(
    first: Sequence[str], other: Sequence[str], unlisted: Collection[str] = ()
) -> str:
    """What two sets of causes disagree on. unlisted: names of the residual terms, which stand for a
    force on no list.
    """
    more, fewer = (
        list(dict.fromkeys(UNLISTED_FORCE_TEXT if c in unlisted else c for c in a if c not in b))
        for a, b in ((first, other), (other, first))
    )
    if more == fewer == [UNLISTED_FORCE_TEXT]:
        return f"which form {UNLISTED_FORCE_TEXT} has"
    if more and fewer:
        return f"whether it is {' and '.join(more)} or {' and '.join(fewer)}"
    names = more or fewer or ["anything else"]
    return f"whether {' and '.join(names)} {'acts' if len(names) == 1 else 'act'}"


def best_next_trial(
    study: Study, kernel: CompiledSystem, first: Float, second: Float, flap_hz: Mapping[str, float]
) -> dict[str, object]:
    """Condition in which two fitted models differ most in 4 s from rest, in units of path error:
    one that has not been filmed, unless all have.

    A condition in which a model swims farther than the pool is long counts as no difference: it
    runs away there.
    """
    pool = study.setup.pool
    diagonal = float(np.hypot(pool.length_m, pool.width_m))
    found: list[tuple[float, str, float, float]] = []
    lengths = sorted({t.head_length_m for t in study.trials})
    conditions = [*product(flap_hz, CANDIDATE_HEAD_ANGLES_DEG, lengths)]
    new = [c for c in conditions if not _has_trial_at_condition(study, *c)]
    for power, angle, length in new or conditions:
        paths = [
            _simulated_positions_m(
                study, kernel, v, angle=np.radians(angle), length=length, hz=flap_hz[power]
            )
            for v in (first, second)
        ]
        inside = all(np.all(np.ptp(path, axis=0) < diagonal) for path in paths)
        apart = _rms_distance(*paths) if inside else 0.0
        found.append((apart, power, angle, length))
    apart, power, angle, length = max(found)
    return {
        "power_pct": float(power),
        "head_angle_deg": angle,
        "head_length_m": length,
        "apart_mm": 1000 * apart,
    }


def _has_trial_at_condition(study: Study, power: str, angle_deg: float, length_m: float) -> bool:
    """Whether a trial of the study has this condition, to either side."""
    return any(
        percent == float(power)
        and length == length_m
        and abs(abs(deg) - angle_deg) < SAME_CONDITION_ANGLE_TOLERANCE_DEG
        for percent, deg, length in (t.condition for t in study.trials)
    )


def _rms_distance(first: Float, second: Float) -> float:
    return float(np.sqrt(np.mean(np.sum((first - second) ** 2, axis=1))))


def _simulated_positions_m(
    study: Study, kernel: CompiledSystem, values: Float, *, angle: float, length: float, hz: float
) -> Float:
    coefficients, effects = kernel.system.unpack_parameter_vector(values)
    run = simulate(coefficients, setup=study.setup, head_length_m=length, head_angle_rad=angle,
                   flap_hz=hz, duration_s=4.0, effects=effects)  # fmt: skip
    return run.state[::6, :2]
