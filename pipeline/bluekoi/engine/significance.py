"""Whether the trials agree that a named cause acts: its strengths against the variation between
trials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..fitting import Z_95, cluster_robust_covariance
from .candidates import CandidateCause
from .cause_set_fit import FittedCauseSet, off_bounds_mask
from .named_cause import NamedCause

EstimateByLabel = Mapping[str, tuple[float, float]]
"""Label of a parameter -> value, standard deviation (NaN if unknown)."""


def strength_estimates(
    model: FittedCauseSet, candidates: Mapping[str, CandidateCause]
) -> EstimateByLabel:
    """Strengths of a set's causes, each with the standard deviation of a normal distribution with
    its 95 % interval, from the variation between trials while the form of its cause is held.

    At strength 0 a form means nothing. While it is free, it may compensate any strength: a fin has
    much vortex lift and little area, or the reverse, yet no trial can do without its force.
    """
    place = {f.label: i for i, f in enumerate(model.fit.free)}
    out: dict[str, tuple[float, float]] = {}
    for candidate in (candidates[name] for name in model.causes):
        free = off_bounds_mask(model)
        free[[place[f.label] for f in candidate.forms if f.label in place]] = False
        std = cluster_robust_covariance(model.fit.normal, free).half_widths() / Z_95
        out |= {f.label: (float(model.fit.values[i]), float(std[i]) if free[i] else np.nan)
                for f in candidate.strengths if (i := place.get(f.label)) is not None}  # fmt: skip
    return out


def insignificant_causes(
    named: Sequence[NamedCause],
    candidates: Mapping[str, CandidateCause],
    estimates: EstimateByLabel,
) -> list[NamedCause]:
    """Causes none of whose strengths differs from 0 at the 5 % level, by the variation between
    trials.

    The evidence counts what a cause adds to the fit. If the trials do not agree that it acts, it
    describes a difference between them.
    """

    def may_be_zero(label: str) -> bool:
        value, std = estimates.get(label, (np.nan, np.nan))
        return value == 0 or bool(abs(value) < Z_95 * std)

    return [c for c in named if all(may_be_zero(f.label) for f in candidates[c.name].strengths)]


def insignificance_sentence(cause: NamedCause) -> str:
    """Why a probable cause is not named."""
    return (
        f"{cause.name} improves the fit (probability {cause.probability:.2f}), but none of its "
        "strengths differs significantly from 0 by the variation between trials. It is not named."
    )
