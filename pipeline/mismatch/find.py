"""The steps from a fitted model to a verdict (docs/mismatch.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Steady
from ..fitting import Series
from ..integrate import Kernel, compiled
from ..model import plates
from ..study import Study
from ..tuning import Tuned, thin, tune
from .bench import Bench
from .covariance import spread_of
from .horizon import path_errors
from .judge import Trialled, trialled
from .jumps import jumps, with_jumps
from .locate import Dependence, MissingForce, added_force, dependences, missing_force
from .paying import pays
from .select import Choice, Round, choose, one_round
from .setting import has_roles, held_out_trials, steady_errors, variables

TELLING_SHARE = 0.3
LEAST_PART = 0.1
LEAST_NAMELESS = 5.0
"""Nameless terms tell of something unexplained where they turn this share of the variance that
looked random in a channel into law, and gain this part of what the strongest of the named causes
gains (and over the inflation not less than the last number): a named law in another form than
nature's leaves less.
"""
MOST_TERMS = 4
CONTESTED = 4
WEAK = 60.0
CLEARLY = 5.0
CLEARLY_PART = 0.15
"""A named cause that gains less than `WEAK` over the inflation must not be outdone by one nameless
term: by `CLEARLY` over the inflation and by this part of its own gain.
"""
LAST_NOISE_ROUNDS = 10
LEAST_UNIT = 0.1
ASTRAY = 8.0
"""A model whose numbers spread over trials this many times wider than they should does not describe
them, whether or not a cause was found.
"""
KINDS = ("physics", "measurement")


@dataclass(frozen=True)
class Found:
    """Everything the search found; `story.mismatch_json` tells it.

    verdict; choice: the search on the trials to fit; baseline and extended: tuned models on these;
    residual: nameless terms beside what was chosen; forces, dependences: what is lacking without
    the additions, on all trials; errors: those of `baseline` and `extended` on the held-out trials;
    floor_m: path error that a true model would have there; horizon_s: how long a free run bears.
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
    progress("baseline")
    few = thin(series)
    baseline = tune([s for s in few if s.name not in held_out])
    knocks = jumps(kernel, few, baseline.trial_values(kernel, few), baseline.noise)
    series, few = with_jumps(kernel, series, knocks), with_jumps(kernel, few, knocks)
    if not has_roles(study):
        # the moment of a jump is known, its size is not: from that trial alone it can be fitted
        held_out = [name for name in held_out if name not in {k.trial for k in knocks}]
    train = [s for s in few if s.name not in held_out]
    test = [s for s in series if s.name in held_out] or list(series)
    if knocks:
        baseline = tune(train)
    names = tuple(e.name for e in plates().effects if e.kind in KINDS)
    bench = Bench(kernel, train, baseline.base, names, baseline.fit.free, progress)
    choice = choose(bench, trialled(kernel, (), baseline.fit, baseline.noise, train))
    progress("terms without a name")
    choice = not_outdone(bench, choice)
    residual = nameless(bench, choice.chosen, choice.bare)
    if _tells(choice, residual):
        choice, residual = without_proxies(bench, choice, residual)
    verdict = verdict_of(kernel, choice, residual)
    extended = retuned(bench, baseline, residual if verdict == "unexplained" else choice.chosen)
    progress("missing force")
    forces, told = _located(study, kernel, few, baseline, extended)
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


def _located(
    study: Study, kernel: Kernel, series: Sequence[Series], baseline: Tuned, extended: Tuned
) -> tuple[list[MissingForce], list[Dependence]]:
    """What the model lacks without its additions, and what that depends on.

    The coefficients are those found with the additions, since the baseline's own have absorbed
    part of what is missing; where something has no name, the named additions stay. Where the
    additions push, it is their push that is told of; else (a fault of measuring) the forces that
    the filter needs in their stead.
    """
    free = extended.fit.free
    nameless = any(f.name.startswith("residual.") for f in free)
    full = extended.trial_values(kernel, series)
    values = [v.copy() for v in full]
    for f in free:
        if f.name.startswith("residual.") or ("." in f.name and not nameless):
            for v in values:
                v[kernel.system.slot[f.name]] = 0.0
    forces = missing_force(kernel, series, values, baseline.noise)
    trials = {t.trial_id: t for t in study.trials}
    count = forces[0].force.shape[1]
    units = np.maximum(extended.noise.disturbance, LEAST_UNIT * baseline.noise.disturbance)[:count]
    pushes = added_force(kernel, series, full, values, extended.noise)
    told = pushes if max(np.abs(p).max() for p in pushes) > 0 else [f.force for f in forces]
    return forces, dependences(series, told, variables(series, forces, trials), units)


def nameless(bench: Bench, model: Trialled, bare: Trialled, *, most: int = MOST_TERMS) -> Trialled:
    """A model with the fewest nameless terms that pay beside its effects, one after the other."""
    terms = _terms(bench)
    for _ in range(most):
        done: Round = one_round(terms, model, bare, tried=CONTESTED)
        if done.best.effects == model.effects:
            break
        model = done.best
    return model


def _terms(bench: Bench) -> Bench:
    effect = bench.kernel.system.effect("residual")
    return replace(bench, candidates=tuple(f"residual.{p.name}" for p in effect.parameters))


def not_outdone(bench: Bench, choice: Choice) -> Choice:
    """Choice without the weaker causes in whose place one nameless term does clearly better."""
    for name in choice.chosen.effects:
        chosen, before = choice.chosen, choice.without[name]
        gain = chosen.total - before.total
        if gain > WEAK * chosen.inflation:
            continue
        bench.progress(f"terms without a name in place of {name}")
        best = one_round(_terms(bench), before, choice.bare, tried=CONTESTED).best
        if best.total - chosen.total > max(CLEARLY * chosen.inflation, CLEARLY_PART * gain):
            choice = _dropped(bench, choice, [name])
    return choice


def without_proxies(bench: Bench, choice: Choice, residual: Trialled) -> tuple[Choice, Trialled]:
    """Choice and nameless model without the named causes that one more nameless term replaces.

    Where something has no name, a candidate may have been picked up in its place: it stays only if
    it pays beside the nameless terms as well. The weakest is tried first.
    """
    dropped: list[str] = []
    for name in sorted(
        choice.chosen.effects, key=lambda e: choice.chosen.total - choice.without[e].total
    ):
        bench.progress(f"{name} beside terms without a name")
        bare = nameless(bench, bench.less(residual, [name]), choice.bare, most=1)
        if not pays(bare, residual, choice.bare):
            residual = bare
            dropped.append(name)
    return _dropped(bench, choice, dropped), residual


def _dropped(bench: Bench, choice: Choice, names: Sequence[str]) -> Choice:
    """Choice without some of its effects, the rest refitted."""
    if not names:
        return choice
    kept = [e for e in choice.chosen.effects if e not in names]
    chosen = bench.less(choice.chosen, names) if kept else choice.bare
    return replace(choice, chosen=chosen, without={e: choice.without[e] for e in kept},
                   places={e: choice.places[e] for e in kept})  # fmt: skip


def verdict_of(kernel: Kernel, choice: Choice, residual: Trialled) -> str:
    """none, physics, measurement or unexplained."""
    chosen = choice.chosen
    if _tells(choice, residual) or (not chosen.effects and chosen.inflation > ASTRAY):
        return "unexplained"
    return kernel.system.effect(chosen.effects[0]).kind if chosen.effects else "none"


def _tells(choice: Choice, residual: Trialled) -> bool:
    """Whether nameless terms beside the chosen effects tell of something more than their form."""
    chosen = choice.chosen
    if residual.effects == chosen.effects:
        return False
    gain = residual.total - chosen.total
    named = max((chosen.total - m.total for m in choice.without.values()), default=0.0)
    enough = gain > max(LEAST_NAMELESS * residual.inflation, LEAST_PART * named)
    return enough and foretold_randomness(chosen, residual) > TELLING_SHARE


def foretold_randomness(before: Trialled, after: Trialled) -> float:
    """Largest share of a random state's variance that a larger model has turned into law."""
    old, new = (m.noise.disturbance for m in (before, after))
    return float(np.max(1.0 - (new / np.maximum(old, 1e-12))[old > 0] ** 2, initial=0.0))


def retuned(bench: Bench, baseline: Tuned, model: Trialled) -> Tuned:
    """A tried model with all of the noise fitted anew around it, and its covariance."""
    if not model.effects:
        return baseline
    again = bench.renoised(model, rounds=LAST_NOISE_ROUNDS)
    again = again if np.isfinite(again.total) else model
    spread = spread_of(bench, again)
    return Tuned(again.fit, again.noise, spread.cov, baseline.base, spread.freedom)
