"""The seven steps from a fitted model to a verdict (docs/mismatch.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Steady
from ..fitting import (
    Fit,
    Series,
    filter_all,
    fit_noise,
    jackknife_cov,
    shoot,
    smooth,
    trial_values,
)
from ..integrate import Kernel, compiled
from ..model import plates
from ..study import Study
from ..tuning import Tuned, tune
from ..tuning.joint import moving
from .locate import Dependence, MissingForce, dependences, missing_force
from .search import Trialled, folds, held_out_worth, try_effects
from .select import Choice, Round, choose, pays, settled, without
from .setting import held_out_trials, steady_errors, variables

NAMED_SHARE = 0.6
"""Named causes must bring at least this share of what a nameless residual would bring."""


@dataclass(frozen=True)
class Found:
    """Everything the search found; `report.mismatch_json` tells it.

    verdict; choice: the search on the trials to fit; baseline and extended: tuned models on these;
    dropped: chosen effect -> the model without it; residual: the nameless term, tried beside;
    forces, dependences: what the baseline lacks, on all trials; errors: `baseline` and `extended`
    errors on the held-out trials; floor_m: distance of the seen positions from the smoothed path.
    """

    verdict: str
    choice: Choice
    baseline: Tuned
    extended: Tuned
    dropped: Mapping[str, Trialled]
    residual: Trialled
    forces: Sequence[MissingForce]
    dependences: Sequence[Dependence]
    held_out: Sequence[str]
    errors: Mapping[str, Mapping[str, float]]
    floor_m: float


def find_mismatch(
    study: Study,
    series: Sequence[Series],
    steady: Mapping[str, Steady],
    *,
    progress: Callable[[str], None],
) -> Found:
    """`Found` for the measured trials of a study."""
    kernel = compiled(plates())
    held_out = held_out_trials(study, [s.name for s in series])
    train = [s for s in series if s.name not in held_out]
    test = [s for s in series if s.name in held_out] or train
    progress("baseline")
    baseline = tune(train)
    bare = Trialled(
        (), baseline.fit, held_out_worth(baseline.fit.normal, folds(train)), baseline.noise
    )
    names = [e.name for e in plates().effects if e.kind in ("physics", "measurement")]
    choice = choose(kernel, train, baseline.base, bare, names, progress=progress)
    progress("residual without a name")
    first = choice.rounds[0]
    residual = _with_residual(kernel, train, baseline, first)
    dropped = {
        name: without(kernel, train, baseline.base, choice, name) for name in choice.chosen.effects
    }
    verdict = _verdict(kernel, choice, residual)
    final = residual if verdict == "unexplained" else choice.chosen
    extended = retuned(kernel, train, baseline, final)
    progress("missing force")
    values = baseline.trial_values(kernel, series)
    forces = missing_force(kernel, series, values, baseline.noise)
    trials = {t.trial_id: t for t in study.trials}
    told = dependences(series, forces, variables(series, forces, trials))
    errors = {
        name: _errors(study, kernel, tuned, test, steady)
        for name, tuned in (("baseline", baseline), ("extended", extended))
    }
    return Found(
        verdict=verdict, choice=choice, baseline=baseline, extended=extended, dropped=dropped,
        residual=residual, forces=forces, dependences=told, held_out=[s.name for s in test],
        errors=errors, floor_m=_floor(kernel, extended, test),
    )  # fmt: skip


def _with_residual(
    kernel: Kernel, train: Sequence[Series], baseline: Tuned, first: Round
) -> Trialled:
    """The nameless residual in the first round's place, under its own noise."""
    coefficients = list(baseline.fit.free)
    tried = try_effects(
        kernel, train, baseline.base, coefficients, ["residual"], noise=first.before.noise,
        predictor=first.predictor, start=baseline.fit.by_label(), iterations=8,
    )  # fmt: skip
    return settled(kernel, train, baseline.base, tried, count=len(coefficients))


def _verdict(kernel: Kernel, choice: Choice, residual: Trialled) -> str:
    """none, physics, measurement or unexplained, by held-out gains over the bare model."""
    before = choice.rounds[0].before
    if not choice.chosen.effects:
        return "unexplained" if pays(before, residual) else "none"
    named = choice.rounds[-1].before
    share = (named.total - before.total) / max(residual.total - before.total, 1e-9)
    if pays(named, residual) and share < NAMED_SHARE:
        return "unexplained"
    return kernel.system.effect(choice.chosen.effects[0]).kind


def retuned(kernel: Kernel, train: Sequence[Series], baseline: Tuned, model: Trialled) -> Tuned:
    """A tried model with the noise fitted anew around it, and its covariance."""
    if not model.effects:
        return baseline
    frees = model.fit.free
    points = [trial_values(kernel, baseline.base, frees, model.fit.values, s.group) for s in train]
    noise = fit_noise(kernel, train, points, baseline.noise, rounds=4)
    own = list(frees[: len(baseline.fit.free)])
    again = try_effects(kernel, train, baseline.base, own, model.effects, noise=noise,
                        start=model.fit.by_label())  # fmt: skip
    found: Fit = again.fit
    return Tuned(found, noise, jackknife_cov(found.normal, moving(kernel, found)), baseline.base)


def _errors(
    study: Study,
    kernel: Kernel,
    tuned: Tuned,
    test: Sequence[Series],
    steady: Mapping[str, Steady],
) -> dict[str, float]:
    shots = shoot(kernel, test, tuned.trial_values(kernel, test))
    known = [s.rmse**2 for s in shots if np.isfinite(s.rmse)]
    rmse = float(np.sqrt(np.mean(known))) if known else float("nan")
    return {"path_rmse_m": rmse, **steady_errors(study, kernel, tuned, test, steady)}


def _floor(kernel: Kernel, tuned: Tuned, test: Sequence[Series]) -> float:
    """Root mean square distance of the seen positions from the smoothed path, m: no model can
    come closer without following the measuring noise.
    """
    points = tuned.trial_values(kernel, test)
    squares = []
    for one, result in zip(test, filter_all(kernel, test, points, tuned.noise), strict=True):
        mean, _ = smooth(result)
        square = np.sum((one.seen[:, :2] - mean[:, :2]) ** 2, axis=1)
        squares.append(float(np.mean(square[np.isfinite(square)])))
    return float(np.sqrt(np.mean(squares)))
