"""Numbers that a side measurement tells: a scale by rigid lengths, a clock by the tail beat.

The paths tell of them too, but only by way of the model's levers and inertia: where nature's are a
little different they are wrong by more than their deviations say. So feedback from the paths is cut
in the last fit (Plummer, Stat. Comput. 25 (2015), 37: cuts in Bayesian graphical models).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..fitting import Series
from .bench import Bench
from .judge import Trialled
from .paying import TOLD_ASIDE

FIRM = 0.02
"""Share of its deviation that a side measurement is given in the last fit, in which the paths then
have no weight worth naming beside it.
"""


def with_direct(bench: Bench, model: Trialled) -> tuple[Bench, dict[str, float]]:
    """Bench on which side measurements alone tell the numbers of the model's effects that they
    speak for, and label -> standard deviation of these measurements.
    """
    system = bench.kernel.system
    speaking: dict[str, float] = {}
    names: set[str] = set()
    for effect in (system.effect(e) for e in model.effects if "." not in e):
        for name, parameters in effect.evidence.items():
            std, clearly = _pooled(bench.series, name)[1], _gain(bench.series, name) > TOLD_ASIDE
            names |= {name} if clearly else set()
            alone = parameters if clearly else parameters.keys() & effect.aside.keys()
            for label in (f"{effect.name}.{parameter}" for parameter in alone):
                speaking[label] = min(speaking.get(label, np.inf), std)
    told = {label: std for label, std in speaking.items() if np.isfinite(std)}
    return replace(bench, series=[_firm(s, names) for s in bench.series]), told


def _pooled(series: Sequence[Series], name: str) -> tuple[float, float]:
    """Value and standard deviation of one side measurement over all trials."""
    both = np.array([s.evidence[name] for s in series if name in s.evidence]).reshape(-1, 2)
    weights = both[:, 1] ** -2.0
    if not weights.sum() > 0:
        return 0.0, np.inf
    return float(both[:, 0] @ weights / weights.sum()), float(weights.sum() ** -0.5)


def _gain(series: Sequence[Series], name: str) -> float:
    """Log likelihood that a number of its own would gain on one side measurement."""
    value, std = _pooled(series, name)
    return 0.5 * (value / std) ** 2


def _firm(series: Series, names: set[str]) -> Series:
    evidence = {
        name: (value, std * FIRM if name in names else std)
        for name, (value, std) in series.evidence.items()
    }
    return replace(series, evidence=evidence)
