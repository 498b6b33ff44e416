"""Recordings made elsewhere, predicted by a fitted model without the causes of its own site."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Series, shoot
from .comparison import Fitted
from .explanation import Explanation, test_series
from .model import Model
from .trials import Trial, checked

KNOWN_S = 1.0


@dataclass(frozen=True)
class Run:
    """A trial simulated freely: times (n,), simulated and seen (n, observations)."""

    trial: str
    times: Float
    simulated: Float
    seen: Float
    errors: dict[str, float]
    measures: dict[str, float]


@dataclass(frozen=True)
class Predicted:
    """Runs of every trial by the baseline and by the extended model, each with the start that suits
    the whole trial and with the start told by its first `known_s` seconds; measures of the
    recordings; causes that were not applied.
    """

    runs: dict[tuple[str, str], list[Run]]
    measured: list[dict[str, float]]
    known_s: float
    not_applied: tuple[str, ...]
    messages: tuple[str, ...]


WHOLE, FIRST = "start fitted", "start from the first seconds"


def predict(found: Explanation, trials: Sequence[Trial], *, known_s: float = KNOWN_S) -> Predicted:
    """`Predicted` for trials that the model was not fitted to."""
    model = found.model
    series = test_series(found.prepared, checked(model, trials))
    site = tuple(c for c in found.extended.model.causes
                 if c in model.by_name and model.by_name[c].site)  # fmt: skip
    models = {"baseline": found.baseline, "extended": elsewhere(found, site)}
    runs = {(name, start): _runs(found, one, series, known)
            for name, one in models.items()
            for start, known in ((WHOLE, np.inf), (FIRST, known_s))}  # fmt: skip
    messages = [f"{c} belongs to the site of the fitted recordings and is not applied here."
                for c in site]  # fmt: skip
    messages += _groups(found, series)
    return Predicted(runs, [_measures(model, s.times, s.seen) for s in series], known_s, site,
                     tuple(messages))  # fmt: skip


def elsewhere(found: Explanation, site: Sequence[str]) -> Fitted:
    """The extended model with the strengths of site-specific causes at 0."""
    one = found.extended
    off = {f.label for c in site for f in found.prepared.problem.by_name[c].strengths}
    values = np.array([0.0 if f.label in off else v
                       for f, v in zip(one.fit.free, one.fit.values, strict=True)])  # fmt: skip
    return replace(one, fit=replace(one.fit, values=values))


def _groups(found: Explanation, series: Sequence[Series]) -> list[str]:
    known = {f.group for f in found.extended.fit.free if f.group is not None}
    new = sorted({s.group for s in series} - known) if known else []
    return [f"Group '{g}' was not fitted: its coefficients are at their start values." for g in new]


def _runs(found: Explanation, one: Fitted, series: Sequence[Series], known_s: float) -> list[Run]:
    problem, model = found.prepared.problem, found.model
    told = [replace(s, seen=np.where(s.times[:, None] <= s.times[0] + known_s, s.seen, np.nan))
            for s in series]  # fmt: skip
    shots = shoot(problem.kernel, told, one.values(problem, series), open_states=len(model.states))
    return [Run(s.name, s.times, shot.observed, s.seen, errors_of(model, shot.observed - s.seen),
                _measures(model, s.times, shot.observed))
            for s, shot in zip(series, shots, strict=True)]  # fmt: skip


def errors_of(model: Model, error: Float) -> dict[str, float]:
    """Root mean squares of errors (frames, observations) by name, and of a place in the plane."""
    known = ~np.isnan(error)
    mean = [float(np.mean(c[k] ** 2)) if k.any() else np.nan
            for c, k in zip(error.T, known.T, strict=True)]  # fmt: skip
    names = [o.name for o in model.observations]
    out = {f"{n}_rmse": float(np.sqrt(m)) for n, m in zip(names, mean, strict=True)}
    if model.path:
        out["path_rmse"] = float(np.sqrt(sum(mean[names.index(n)] for n in model.path)))
    return out


def _measures(model: Model, times: Float, observed: Float) -> dict[str, float]:
    if model.measures is None:
        return {}
    known = np.isfinite(observed).all(axis=1)
    if known.sum() < 3:
        return {}
    return {str(k): float(v) for k, v in model.measures(times[known], observed[known]).items()}
