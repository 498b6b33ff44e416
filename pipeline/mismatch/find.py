"""The seven steps from a fitted model to a verdict (docs/mismatch.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ..data import Steady
from ..fitting import Series, fit_noise, jackknife_cov, moving
from ..integrate import Kernel, compiled
from ..model import plates
from ..study import Study
from ..tuning import Tuned, thin, tune
from .horizon import path_errors
from .locate import Dependence, MissingForce, dependences, missing_force
from .search import Trialled, trialled
from .select import Bench, Choice, Round, choose, one_round, pays
from .setting import held_out_trials, steady_errors, variables

NAMED_SHARE = 0.6
"""Named causes must bring at least this share of what they and nameless terms bring together."""
MOST_TERMS = 4
KINDS = ("physics", "measurement")


@dataclass(frozen=True)
class Found:
    """Everything the search found; `story.mismatch_json` tells it.

    verdict; choice: the search on the trials to fit; baseline and extended: tuned models on these;
    residual: nameless terms beside what was chosen; forces, dependences: what the baseline lacks,
    on all trials; errors: `baseline` and `extended` errors on the held-out trials; floor_m: path
    error that a true model would have on them; horizon_s: how long a free run means anything.
    """

    verdict: str
    choice: Choice
    baseline: Tuned
    extended: Tuned
    residual: Trialled
    forces: Sequence[MissingForce]
    dependences: Sequence[Dependence]
    held_out: Sequence[str]
    errors: Mapping[str, Mapping[str, float]]
    floor_m: float
    horizon_s: float


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
    few = thin(series)
    train = [s for s in few if s.name not in held_out]
    test = [s for s in series if s.name in held_out] or series
    progress("baseline")
    baseline = tune(train)
    names = tuple(e.name for e in plates().effects if e.kind in KINDS)
    bench = Bench(kernel, train, baseline.base, names, baseline.fit.free, progress)
    choice = choose(bench, trialled(kernel, (), baseline.fit, baseline.noise, train))
    progress("terms without a name")
    residual = nameless(bench, choice.chosen)
    verdict = _verdict(kernel, choice, residual)
    extended = retuned(bench, baseline, residual if verdict == "unexplained" else choice.chosen)
    progress("missing force")
    forces = missing_force(kernel, few, baseline.trial_values(kernel, few), baseline.noise)
    trials = {t.trial_id: t for t in study.trials}
    told = dependences(few, forces, variables(few, forces, trials))
    paths = path_errors(study, kernel, {"baseline": baseline, "extended": extended}, test)
    errors = {
        name: {"path_rmse_m": paths.rmse_m[name], **steady_errors(study, kernel, tuned, test,
                                                                  steady)}
        for name, tuned in (("baseline", baseline), ("extended", extended))
    }  # fmt: skip
    return Found(
        verdict=verdict, choice=choice, baseline=baseline, extended=extended, residual=residual,
        forces=forces, dependences=told, held_out=[s.name for s in test], errors=errors,
        floor_m=paths.floor_m, horizon_s=paths.horizon_s,
    )  # fmt: skip


def nameless(bench: Bench, model: Trialled) -> Trialled:
    """A model with the fewest nameless terms that pay beside its effects, one after the other."""
    effect = bench.kernel.system.effect("residual")
    terms = replace(bench, candidates=tuple(f"residual.{p.name}" for p in effect.parameters))
    for _ in range(MOST_TERMS):
        done: Round = one_round(terms, model, tried=4)
        if done.best.effects == model.effects:
            break
        model = done.best
    return model


def _verdict(kernel: Kernel, choice: Choice, residual: Trialled) -> str:
    """none, physics, measurement or unexplained, by held-out gains over the bare model."""
    beyond = residual.effects != choice.chosen.effects
    if not choice.chosen.effects:
        return "unexplained" if beyond else "none"
    share = (choice.chosen.total - choice.bare.total) / max(
        residual.total - choice.bare.total, 1e-9
    )
    if beyond and pays(choice.chosen, residual) and share < NAMED_SHARE:
        return "unexplained"
    return kernel.system.effect(choice.chosen.effects[0]).kind


def retuned(bench: Bench, baseline: Tuned, model: Trialled) -> Tuned:
    """A tried model with all of the noise fitted anew around it, and its covariance."""
    if not model.effects:
        return baseline
    noise = fit_noise(bench.kernel, bench.series, bench.points(model), model.noise)
    again = bench.refit(model.effects, replace(model, noise=noise))
    cov = jackknife_cov(again.fit.normal, moving(bench.kernel, again.fit))
    return Tuned(again.fit, noise, cov, baseline.base)
