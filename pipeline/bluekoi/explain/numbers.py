"""Fitted numbers with intervals from how the trials disagree; which stand at a bound."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from ..engine import FittedCauseSet
from ..fitting import cluster_robust_covariance
from ..integrate import CompiledSystem


@dataclass(frozen=True)
class FittedNumber:
    """A fitted number; std such that value +- 1.96 std is its 95 % interval, NaN where the trials
    do not determine it; at_bound: `lower`, `upper` or nothing.
    """

    label: str
    value: float
    std: float
    unit: str
    at_bound: str = ""


def fitted_numbers(kernel: CompiledSystem, model: FittedCauseSet) -> list[FittedNumber]:
    """The numbers of a fitted set; a covariance that diverges leaves them without deviations."""
    move = ~model.at_bound
    std = np.full(len(move), np.nan)
    with contextlib.suppress(np.linalg.LinAlgError, ValueError, FloatingPointError):
        std = _standard_deviations(model, move)  # else NaN, and `undetermined_sentences`
    out = []
    for free, value, s in zip(model.fit.free, model.fit.values, std, strict=True):
        p = kernel.system.parameters[kernel.system.parameter_index[free.name]]
        bound = "lower" if value <= p.lower else "upper" if value >= p.upper else ""
        out.append(FittedNumber(free.label, float(value), float(s), p.unit, bound))
    return out


@np.errstate(all="ignore")
def _standard_deviations(model: FittedCauseSet, move: np.ndarray) -> np.ndarray:
    std = np.sqrt(np.diag(cluster_robust_covariance(model.fit.normal, move).cov))
    std[~move | ~np.isfinite(std) | (std <= 0)] = np.nan
    return np.asarray(std)


def at_bound_sentences(found: list[FittedNumber]) -> list[str]:
    """A sentence for each number at a bound."""
    return [f"{n.label} stands at its {n.at_bound} bound, {n.value:g} {n.unit}: its value is not "
            "determined; check the units of the columns, widen the bound or leave out what it "
            "belongs to."
            for n in found if n.at_bound]  # fmt: skip


def undetermined_sentences(found: list[FittedNumber]) -> list[str]:
    """A sentence on numbers without a finite deviation."""
    names = [n.label for n in found if not n.at_bound and not np.isfinite(n.std)]
    if not names:
        return []
    return [f"The trials do not determine {', '.join(names)}: the covariance has no finite value."]
