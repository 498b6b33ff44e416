"""The steps from a fitted model to a verdict (docs/mismatch.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..data import Steady
from ..fitting import Series
from ..integrate import Kernel, compiled
from ..integrate.batch import each
from ..model import is_nameless, plates
from ..study import Study
from ..tuning import Tuned, thin, tune
from .bench import Bench
from .covariance import spread_of
from .direct import with_direct
from .horizon import path_errors
from .judge import Trialled, trialled
from .jumps import Jump, jumps, with_jumps
from .locate import Dependence, MissingForce, added_force, dependences, missing_force
from .nameless import (
    nameless,
    nameless_gain,
    not_a_crowd,
    not_outdone,
    only_form,
    tells,
    without_doubtful,
    without_proxies,
)
from .parts import LEAST, Part, part_of_trials, pays_in_part, with_part
from .paying import WRONG
from .select import Choice, choose, two_more
from .setting import has_roles, held_out_trials, steady_errors, variables
from .swinging import beside_a_swing, of_time, only_of_time, swings

LAST_NOISE_ROUNDS = 10
LEAST_UNIT = 0.1
ASTRAY = 8.0
"""A model with causes whose coefficients spread over trials this many times wider than they should
does not describe them; fewer than `TRIALS_FOR_ASTRAY` cannot tell. Without a cause `WRONG` is the
limit.
"""
TRIALS_FOR_ASTRAY = 12
KINDS = ("physics", "measurement")


@dataclass(frozen=True)
class Found:
    """Everything the search found; `story.mismatch_json` tells it.

    verdict; choice: the search on the trials to fit; baseline and extended: tuned models on these;
    residual: nameless terms beside what was chosen; nameless_gain: held-out log likelihood that
    all without a name gains, over the inflation; forces, dependences: what is lacking without
    the additions, on all trials; errors: those of `baseline` and `extended` on the held-out trials;
    floor_m: path error that a true model would have there; horizon_s: how long a free run bears;
    knocks: where the camera was, or seemed to be, moved during a trial; part: the trials in which a
    fault of measuring acts, where that is not all of them.
    """

    verdict: str
    choice: Choice
    baseline: Tuned
    extended: Tuned
    residual: Trialled
    nameless_gain: float
    forces: Sequence[MissingForce]
    dependences: Sequence[Dependence]
    held_out: Sequence[str]
    errors: Mapping[str, Mapping[str, float]]
    floor_m: float
    horizon_s: float
    knocks: Sequence[Jump] = ()
    part: Part | None = None


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
    bare = trialled(kernel, (), baseline.fit, baseline.noise, train)
    searched, part = _searched(bench, bare), None
    if (maybe := part_of_trials(bench, study, searched[1].chosen)) and maybe.ahead > LEAST:
        progress(f"{maybe.cause} in {len(maybe.trials)} trials")
        apart = replace(bench, series=with_part(kernel, train, maybe))
        again = _searched(apart, bare)
        if pays_in_part(searched[1], again[1]):
            searched, part = again, maybe
            series, few, test = (with_part(kernel, s, maybe) for s in (series, few, test))
            test = [s for s in test if s.name not in maybe.open] or test
    bench, choice, residual, swing = searched
    verdict = verdict_of(kernel, choice, residual)
    extended = retuned(bench, baseline, residual if verdict == "unexplained" else choice.chosen)
    progress("missing force")
    models = {"baseline": baseline, "extended": extended}
    (forces, told), paths = each(lambda task: task(), (
        partial(_located, study, kernel, few, baseline, extended),
        partial(path_errors, study, kernel, models, test),
    ))  # fmt: skip
    errors = {
        name: {"path_rmse_m": paths.rmse_m[name], **steady_errors(study, kernel, tuned, test,
                                                                  steady)}
        for name, tuned in models.items()
    }  # fmt: skip
    return Found(
        verdict=verdict, choice=choice, baseline=baseline, extended=extended, residual=residual,
        nameless_gain=swing + nameless_gain(choice, residual),
        forces=forces, dependences=told, held_out=[s.name for s in test], errors=errors,
        floor_m=paths.floor_m, horizon_s=paths.horizon_s, knocks=knocks, part=part,
    )  # fmt: skip


def _searched(bench: Bench, bare: Trialled) -> tuple[Bench, Choice, Trialled, float]:
    """The bench, with a swing of the water among the model's own numbers where there is one; what
    was chosen; that with the terms that have no name; what the swing gained.
    """
    choice = choose(bench, bare)
    bench.progress("terms without a name")
    choice = not_outdone(bench, not_a_crowd(bench, choice))
    choice = without_doubtful(bench, choice)
    residual = nameless(bench, choice.chosen, choice.bare)
    if residual.effects != choice.chosen.effects and not swings(residual.fit.free):
        bench.progress("two names at once")
        more = two_more(bench, choice, residual)
        kept = without_doubtful(bench, not_outdone(bench, more)) if more is not choice else choice
        if len(kept.chosen.effects) > len(choice.chosen.effects) + 1:
            choice, residual = kept, nameless(bench, kept.chosen, kept.bare)
    if tells(choice, residual) and only_form(bench, choice):
        residual = choice.chosen
    swing = 0.0
    if tells(choice, residual) and swings(residual.fit.free):
        swing = nameless_gain(choice, residual)
        bench, choice, residual = beside_a_swing(bench, choice, residual)
    if tells(choice, residual):
        choice, residual = without_proxies(bench, choice, residual)
    elif swings(bench.coefficients):
        residual = choice.chosen
    return bench, choice, residual, swing


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
    nameless = any(is_nameless(f.name) for f in free)
    full = extended.trial_values(kernel, series)
    values = [v.copy() for v in full]
    for f in free:
        if is_nameless(f.name) or ("." in f.name and not nameless):
            for v in values:
                v[kernel.system.slot[f.name]] = 0.0
    forces = missing_force(kernel, series, values, baseline.noise)
    trials = {t.trial_id: t for t in study.trials}
    count = forces[0].force.shape[1]
    units = np.maximum(extended.noise.disturbance, LEAST_UNIT * baseline.noise.disturbance)[:count]
    pushes = added_force(kernel, series, full, values, extended.noise)
    told = pushes if max(np.abs(p).max() for p in pushes) > 0 else [f.force for f in forces]
    found = dependences(series, told, variables(series, forces, trials), units)
    return forces, of_time(series, told, found, units, free) if only_of_time(free) else found


def verdict_of(kernel: Kernel, choice: Choice, residual: Trialled) -> str:
    """none, physics, measurement or unexplained."""
    chosen = choice.chosen
    astray = astray_by(chosen) > 1.0 if chosen.effects else chosen.inflation > WRONG
    if tells(choice, residual) or astray or swings(choice.bare.fit.free):
        return "unexplained"
    return kernel.system.effect(chosen.effects[0]).kind if chosen.effects else "none"


def astray_by(model: Trialled) -> float:
    """How many times more than may be a model's coefficients spread over trials, 1 at least."""
    many = len(model.worth) >= TRIALS_FOR_ASTRAY
    return max(1.0, model.astray / ASTRAY) if many else 1.0


def retuned(bench: Bench, baseline: Tuned, model: Trialled) -> Tuned:
    """A tried model with all of the noise fitted anew around it, and its covariance."""
    if len(model.fit.free) == len(baseline.fit.free):
        return baseline
    firm, aside = with_direct(bench, model)
    again = firm.renoised(model, rounds=LAST_NOISE_ROUNDS)
    again = again if np.isfinite(again.total) else model
    spread = spread_of(bench, again, aside)
    return Tuned(again.fit, again.noise, spread.cov, baseline.base, spread.freedom)
