"""The engine on systems whose answers are known: evidence, search and probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal

from bluekoi.engine import (
    CauseSearchProblem,
    FitRequest,
    FittedCauseSet,
    NamedCause,
    Posterior,
    PriorInclusionProbabilities,
    candidates_from_effects,
    expand_likelihood,
    expansion,
    fit_cause_set,
    fit_noise_and_parameters,
    insignificance_sentence,
    insignificant_causes,
    named_causes,
    noise_estimation,
    posterior_over_sets,
    proposals,
    search,
    search_cause_sets,
    set_score,
    strength_estimates,
)
from bluekoi.engine.calibration import calibrated_probability, calibrated_shares_of_alternatives
from bluekoi.engine.candidates import CandidateCause
from bluekoi.engine.cause_set_columns import CauseSetColumns
from bluekoi.engine.cause_set_fit import refit_from_fitted_values
from bluekoi.engine.collinear_terms import collinear_terms
from bluekoi.engine.evidence import (
    laplace_log_evidence,
    log_evidence,
    most_probable_discrepancy_stds,
)
from bluekoi.engine.expansion import (
    LikelihoodExpansion,
    expand_likelihood_in_all_forms,
    one_step_strength_estimates,
)
from bluekoi.engine.fitted_sets import FittedCauseSets
from bluekoi.engine.noise_estimation import (
    MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND,
    SMALL_FORCE_CORRELATION_TIME_S,
    SMALL_FORCE_SHARE,
    fit_without_causes,
    noise_with_small_random_forces,
)
from bluekoi.engine.problem import MAX_SEARCH_TRIALS
from bluekoi.engine.proposals import (
    fit_causes_in_place_of_residual_terms,
    fit_requests_replacing_cause,
)
from bluekoi.engine.removed_cause import log_odds_without_cause
from bluekoi.engine.set_score import (
    MAX_LOG_STD_CHANGE,
    make_expansion_stationary_at_fit,
    refit_with_discrepancy,
    refit_with_reestimated_noise,
    score_cause_set,
)
from bluekoi.engine.trial_subset import d_optimal_trial_subset
from bluekoi.fitting import (
    Z_95,
    FreeParameter,
    Noise,
    TrialSeries,
    cluster_robust_covariance,
    filter_all,
)
from bluekoi.fitting.noise import FittedNoise
from bluekoi.fitting.normal import NormalEquationsByTrial
from bluekoi.fitting.predictions import finite_difference_step
from bluekoi.fitting.trial_effects import marginal_gram_matrices
from bluekoi.integrate import Effect, Parameter, Stage, System, compile_system
from validation.noise_starts import gain_table, gains_of_sets
from validation.proposal_ranks import proposed_causes_of, rank_summary
from validation.search_limits import round_gains


def one_strength(size: float, *, signed: bool = False) -> CauseSetColumns:
    """A set of one cause with one strength and nothing else."""
    return CauseSetColumns(
        columns=np.array([0]), count=0, blocks={"cause": np.array([0])},
        precision=np.array([size**-2.0]), gaussian=np.array([False]),
        included=np.array([False]), signed={"cause": signed},
        at=np.zeros(1), held=np.zeros(1, dtype=bool), sizes={"cause": np.array([size])},
    )  # fmt: skip


def exact_log_bayes_factor(H: float, g: float, size: float, lower: float = -np.inf) -> float:
    """Log of the integral of exp(g b - H b^2 / 2) over a Cauchy prior, from `lower` on."""
    peak = max(g / H, lower) if H > 0 else 0.0
    height = g * peak - 0.5 * H * peak**2

    def integrand(b: float) -> float:
        density = 1.0 / (np.pi * size * (1.0 + (b / size) ** 2))
        return float(np.exp(g * b - 0.5 * H * b * b - height) * density)

    width = 10.0 / np.sqrt(H)
    low = max(lower, peak - width)
    share = quad(integrand, low, peak + width, limit=200)[0]
    return float(np.log(share * (2.0 if lower == 0.0 else 1.0)) + height)


@pytest.mark.parametrize("z", [0.5, 3.0, 8.0])
def test_evidence_of_one_strength_is_the_integral_over_its_prior(z: float) -> None:
    H, size = 400.0, 1.0  # standard error 0.05, a twentieth of what is plausible
    found = laplace_log_evidence(np.array([[H]]), np.array([z * np.sqrt(H)]), one_strength(size))
    assert found == pytest.approx(exact_log_bayes_factor(H, z * np.sqrt(H), size), abs=0.05)


@pytest.mark.parametrize("z", [-1.0, 0.5, 4.0])
def test_a_strength_of_one_sign_has_half_the_prior(z: float) -> None:
    H, size = 400.0, 1.0
    lay = one_strength(size, signed=True)
    found = laplace_log_evidence(np.array([[H]]), np.array([z * np.sqrt(H)]), lay)
    exact = exact_log_bayes_factor(H, z * np.sqrt(H), size, lower=0.0)
    assert found == pytest.approx(exact, abs=0.1)


@pytest.mark.parametrize("slope", [0.0, 3.0, 40.0, 400.0])
def test_a_strength_held_at_its_bound_has_the_width_that_the_likelihood_has_inside(
    slope: float,
) -> None:
    """The harder the trials push beyond the bound, the smaller is the part of the prior near it."""
    H, size, bound = 400.0, 1.0, 0.2
    lay = replace(one_strength(size), at=np.array([bound]), held=np.array([True]))
    found = laplace_log_evidence(np.array([[H]]), np.array([slope]), lay)

    def likelihood_and_prior(b: float) -> float:
        inside = bound - b
        density = 1.0 / (np.pi * size * (1.0 + (b / size) ** 2))
        return float(np.exp(-slope * inside - 0.5 * H * inside**2) * density)

    exact = float(np.log(quad(likelihood_and_prior, -bound, bound, limit=200)[0]))
    assert found == pytest.approx(exact, abs=0.05)


def test_a_form_held_at_its_bound_counts_by_its_prior_and_the_width_inside() -> None:
    """Normal prior of deviation 0.5 that the likelihood contains; the form is free otherwise."""
    H, slope, bound = 30.0, 5.0, 1.0
    lay = replace(
        one_strength(1.0),
        columns=np.array([0, 1]), precision=np.array([1.0, 4.0]),
        gaussian=np.array([False, True]), included=np.array([False, True]),
        at=np.array([0.5, 0.0]), held=np.array([False, True]),
    )  # fmt: skip
    found = laplace_log_evidence(np.diag([100.0, H]), np.array([0.0, slope]), lay)
    without = laplace_log_evidence(
        np.array([[100.0]]), np.zeros(1), replace(one_strength(1.0), at=np.array([0.5]))
    )
    inside = quad(lambda t: np.exp(-slope * t - 0.5 * H * t**2), 0.0, 2.0 * bound)[0]
    exact = np.log(2.0 / np.sqrt(2.0 * np.pi) * inside)
    assert found - without == pytest.approx(float(exact), abs=0.01)


def test_a_cause_that_no_trial_informs_on_neither_gains_nor_loses() -> None:
    found = laplace_log_evidence(np.array([[1e-9]]), np.zeros(1), one_strength(1.0))
    assert abs(found) < 0.3


def test_an_effect_far_smaller_than_plausible_loses_to_no_effect() -> None:
    """Three standard errors from 0, but a thousandth of its plausible size (Lindley 1957)."""
    H = (3.0 / 1e-3) ** 2
    found = laplace_log_evidence(np.array([[H]]), np.array([1e-3 * H]), one_strength(1.0))
    assert found < -1.0


def test_random_trial_effects_are_integrated_out_exactly() -> None:
    rng = np.random.default_rng(3)
    e, J, Z = rng.normal(size=9), rng.normal(size=(9, 2)), rng.normal(size=(9, 2))
    stds = np.array([[0.7, 1.9]])
    columns = np.column_stack([e, J, Z])
    products, constant, effects = marginal_gram_matrices((columns.T @ columns)[None], stds)
    cov = np.eye(9) + Z @ np.diag(stds[0] ** 2) @ Z.T
    exact = multivariate_normal(np.zeros(9), cov).logpdf(e)
    white = -0.5 * 9 * np.log(2 * np.pi)
    assert white - 0.5 * products[0, 0, 0] + constant[0] == pytest.approx(exact)
    inverse = np.linalg.inv(cov)
    assert products[0, 1:, 1:] == pytest.approx(J.T @ inverse @ J)
    assert products[0, 1:, 0] == pytest.approx(J.T @ inverse @ e)
    own = np.linalg.solve(Z.T @ Z + np.diag(stds[0] ** -2.0), Z.T)
    assert effects.values[0] == pytest.approx(own @ e)
    assert effects.slopes[0] == pytest.approx(-own @ J)


def test_a_trial_in_which_the_model_runs_away_has_no_products_and_raises_nothing() -> None:
    """A search ended where a step made two differences grow alike beyond what floats resolve."""
    products = np.full((1, 4, 4), 2.0**100)
    found, constant, effects = marginal_gram_matrices(products, np.ones((1, 2)))
    assert np.isnan(found).all()
    assert np.isnan(effects.values).all()
    assert not np.isfinite(constant).any()


def test_a_trial_without_products_leaves_the_others_as_they_are() -> None:
    """The first has a singular matrix; of the second, rounding errors are all that is left."""
    rng = np.random.default_rng(1)
    columns, alike = rng.normal(size=(9, 4)), rng.normal(size=(9, 4))
    alike[:, 3] = alike[:, 2] + 1e-9 * alike[:, 3]
    alike[:, 0] = alike[:, 2]
    sound, close = columns.T @ columns, 1e20 * alike.T @ alike
    found, constant, effects = marginal_gram_matrices(
        np.array([np.full((4, 4), 2.0**100), close, sound]), np.ones((3, 2))
    )
    assert np.isnan(found[:2]).all()
    assert np.isnan(constant[:2]).all()
    assert np.isnan(effects.values[:2]).all()
    alone, own_constant, own_effects = marginal_gram_matrices(sound[None], np.ones((1, 2)))
    assert found[2] == pytest.approx(alone[0])
    assert constant[2] == pytest.approx(own_constant[0])
    assert effects.values[2] == pytest.approx(own_effects.values[0])


def no_force() -> tuple[float]:
    """No force of its own."""
    return (0.0,)


def rates(v: float, F: float, u: float, c: float) -> tuple[float, float]:
    """A unit mass driven by u, with linear drag c."""
    return v, u + F - c * v


def observe(x: float) -> tuple[float]:
    """The place is seen."""
    return (x,)


def quadratic_drag(v: float, k: float) -> tuple[float]:
    """F = -k v |v|."""
    return (-k * v * abs(v),)


def constant_force(F0: float) -> tuple[float]:
    """F = F0."""
    return (F0,)


def random_force(g: float) -> tuple[float]:
    """A random force."""
    return (g,)


def random_force_decay(g: float, tau: float) -> tuple[float]:
    """G' = -g / tau."""
    return (-g / tau,)


def _effect(name: str, law: object, parameter: Parameter) -> Effect:
    return Effect(name, "physics", name, (parameter,), {"force": law}, "tests", ("surge",))


SYSTEM = System(
    "driven_mass", ("x", "v"), (), ("u",), (Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    (Stage("force", ("F",), no_force, open=True), Stage("rates", ("x", "v"), rates),
     Stage("observe", ("seen",), observe)),
    ("seen",),
    (Effect("gusts", "disturbance", "random force",
            (Parameter("present", "1", 1.0, 0.0, 1.0, ""),
             Parameter("tau", "s", 0.3, 0.01, 5.0, "")),
            {"force": random_force}, "tests", ("surge",), states=("g",), rates=random_force_decay),
     _effect("quadratic_drag", quadratic_drag, Parameter("k", "1/m", 0.5, 0.0, 20.0, "")),
     _effect("constant_force", constant_force, Parameter("F0", "N", 0.2, -5.0, 5.0, ""))),
)  # fmt: skip


def driven_mass_trials(k: float, F0: float, trials: int = 12) -> list[TrialSeries]:
    """Trials of a driven mass with quadratic drag k and a constant force F0, noise 1 mm."""
    rng, dt = np.random.default_rng(17), 1e-3
    out = []
    for i in range(trials):
        u, x, v, seen = 0.5 + 0.25 * (i % 6), 0.0, 0.0, []
        for step in range(4000):
            if step % 50 == 0:
                seen.append(x + 1e-3 * rng.standard_normal())
            v += dt * (u + F0 - 0.4 * v - k * v * abs(v))
            x += dt * v
        n = len(seen)
        out.append(TrialSeries(
            f"T{i}", "all", f"u {u:g}", np.arange(n) * 0.05, np.full((n, 1), u), np.zeros(0),
            np.array(seen)[:, None], np.full((n, 1, 1), 1e-6), np.zeros(3),
            np.diag([1e-4, 1e-4, 1e-6]),
        ))  # fmt: skip
    return out


def driven_mass_problem(series: list[TrialSeries]) -> CauseSearchProblem:
    """Both candidates beside the driven mass."""
    names = ["quadratic_drag", "constant_force"]
    return CauseSearchProblem(
        kernel=compile_system(SYSTEM),
        series=series,
        base=SYSTEM.parameter_vector({}),
        coefficients=(FreeParameter("c"),),
        candidates=candidates_from_effects(SYSTEM, names, PriorInclusionProbabilities(cause=0.1)),
        noise=Noise(np.array([0.01]), np.array([0.3]), np.ones(1)),
    )


@pytest.mark.parametrize(
    ("k", "F0", "true"),
    [(0.0, 0.0, set()), (0.3, 0.0, {"quadratic_drag"}), (0.0, 0.1, {"constant_force"}),
     (0.3, 0.1, {"quadratic_drag", "constant_force"})],
)  # fmt: skip
def test_the_causes_that_act_and_no_others_are_probable(k: float, F0: float, true: set) -> None:
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(k, F0)))
    found = posterior_over_sets(visited.problem, list(visited.sets.values()))
    assert {name for name, p in found.inclusion.items() if p > 0.5} == true
    assert all(found.inclusion[name] > 0.95 for name in true)
    assert found.probability.sum() == pytest.approx(1.0)


def test_a_cause_is_fitted_in_place_of_all_residual_terms_of_its_kind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two terms stand for a fin and another cause; the fin alone describes less than both terms."""
    sources = {"residual.a": {("sway", "r")}, "residual.b": {("yaw", "v")},
               "fin": {("sway", "r"), ("yaw", "v")}, "sag": {("surge", "t")},
               "lag": {("yaw", "t")}}  # fmt: skip
    candidates = {
        n: CandidateCause(n, "residual" if "." in n else "physics", (), (), 0.1, frozenset(s))
        for n, s in sources.items()
    }
    problem = SimpleNamespace(candidate_by_name=candidates, candidates=tuple(candidates.values()),
                              collinear_terms=())  # fmt: skip
    visited = SimpleNamespace(
        problem=problem, sets={}, expansion_in_all_candidates=lambda scored: scored
    )
    fitted: list[tuple[tuple[str, ...], str]] = []

    def add(wanted: FitRequest) -> object:
        scored = SimpleNamespace(causes=wanted.causes, model=SimpleNamespace(key=wanted.key))
        fitted.append((tuple(sorted(wanted.causes)), "+".join(sorted(wanted.near.key))))
        visited.sets[wanted.key] = scored
        return scored

    visited.fit_and_keep, visited.fit_and_keep_in_threads = (
        add,
        lambda wanted: [add(one) for one in wanted],
    )
    monkeypatch.setattr(proposals, "rank_further_causes",
                        lambda _, __, among: [(1.0, c.name) for c in among])  # fmt: skip
    monkeypatch.setattr(proposals, "_start_values_of_added_cause", lambda *_: {})
    monkeypatch.setattr(proposals, "fit_requests_adding_cause",
                        lambda _, s, __: [FitRequest((*s.causes, "sag"), s.model)])  # fmt: skip
    best = SimpleNamespace(causes=("residual.a", "residual.b", "lag"),
                           model=SimpleNamespace(key=frozenset()))  # fmt: skip
    fit_causes_in_place_of_residual_terms(visited, best)
    assert fitted == [
        (("lag",), ""),
        (("fin", "lag"), "lag"),
        (("fin", "lag", "sag"), "fin+lag"),
        (("fin", "lag", "sag"), "lag"),
    ]
    fitted.clear()
    fit_causes_in_place_of_residual_terms(
        visited, SimpleNamespace(causes=("fin",), model=best.model)
    )
    assert fitted == []


@pytest.mark.parametrize("listed_by", ["quadratic_drag", "constant_force"])
def test_a_cause_is_replaced_by_one_that_it_can_be_confused_with(
    listed_by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever file lists the other one, and however little it promises; never by itself."""
    names = ["quadratic_drag", "constant_force"]
    (other,) = set(names) - {listed_by}
    effects = [replace(e, confused_with=(other,)) if e.name == listed_by else e
               for e in SYSTEM.effects]  # fmt: skip
    plain = driven_mass_problem(driven_mass_trials(0.3, 0.0))
    problem = replace(plain, kernel=compile_system(replace(SYSTEM, effects=tuple(effects))))
    for count, system in ((2, plain), (0, problem)):
        visited = FittedCauseSets(system)
        less = score_cause_set(system, fit_without_causes(system, {}))
        monkeypatch.setattr(proposals, "MAX_REPLACEMENT_REFITS_PER_CAUSE", count)
        wanted = fit_requests_replacing_cause(visited, "quadratic_drag", less)
        assert {fit.causes for fit in wanted} == {("constant_force",)}
    assert fit_requests_replacing_cause(FittedCauseSets(plain), "quadratic_drag", less) == []


def test_the_ranks_of_the_causes_found_are_those_of_the_expansion_without_them() -> None:
    found = proposed_causes_of(search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1))))
    assert {one.name for one in found} == {"quadratic_drag", "constant_force"}
    assert all(one.rank == 1 and one.below_first == 0.0 for one in found)
    assert all(one.log_odds > 0.0 and one.fitted_log_odds > 0.0 for one in found)
    assert "2 causes of the most probable sets: ranks 2 within 1" in rank_summary(found)


def test_a_search_does_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("BLUEKOI_THREADS", threads)
        visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1)))
        found.append({key: one.log_posterior for key, one in visited.sets.items()})
    assert len(found[0]) > 2
    assert found[0] == found[1] == found[2]


def test_a_set_is_at_least_as_likely_as_its_parts() -> None:
    """Else its fit has not ended, and a cause loses to another whose fit has."""
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1)))
    likely = {k: visited.sets[k].model.log_joint for k in visited.converged}
    pairs = [(part, whole) for part in likely for whole in likely if part < whole]
    assert pairs
    assert all(likely[whole] > likely[part] - 1.0 for part, whole in pairs)


@pytest.mark.parametrize("tolerances", [{}, {"constant_force.F0": 0.02}])
def test_the_odds_without_a_cause_are_those_of_a_fit_without_it(
    tolerances: dict[str, float],
) -> None:
    problem = replace(driven_mass_problem(driven_mass_trials(0.3, 0.03)), tolerances=tolerances)
    whole, rest = (
        score_cause_set(problem, fit_cause_set(problem, causes, problem.noise, {}))
        for causes in (("quadratic_drag", "constant_force"), ("quadratic_drag",))
    )
    found = log_odds_without_cause(problem, whole.expansion, whole.layout, "constant_force")
    assert found == pytest.approx(rest.log_posterior - whole.log_posterior, abs=0.3)
    assert abs(rest.log_posterior - whole.log_posterior) > 1.0


def test_further_rounds_of_noise_and_parameters_do_not_make_a_set_less_probable() -> None:
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.1))
    gains = round_gains(search_cause_sets(problem), {"c": 1.0})
    assert len(gains) > 1
    assert min(gains) > -0.1


@pytest.mark.long
def test_the_noise_estimate_reaches_no_better_maximum_from_other_starts() -> None:
    """With the drag that acts and without it, where the random forces must explain it."""
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.0)))
    found = gains_of_sets(visited, {"c": 1.0})
    assert len(found) == 2
    for gains in found:
        assert max(gains.values()) < 0.5
    own = SMALL_FORCE_SHARE, SMALL_FORCE_CORRELATION_TIME_S
    assert f"{own[0]:g}  {own[1]:g} s" in gain_table(found)


@pytest.mark.parametrize("ridge", [1e-12, 1e-8])
def test_the_ridge_has_no_part_in_the_evidence(ridge: float, monkeypatch) -> None:
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.1))
    scored = search_cause_sets(problem).best
    before = log_evidence(problem, scored.expansion, scored.layout)
    monkeypatch.setattr("bluekoi.engine.evidence.DIAGONAL_RIDGE", ridge)
    assert log_evidence(problem, scored.expansion, scored.layout) == pytest.approx(before, abs=1e-3)


def test_a_cause_whose_strengths_may_all_be_zero_is_insignificant() -> None:
    by_name = driven_mass_problem(driven_mass_trials(0.3, 0.1)).candidate_by_name
    cause = NamedCause("quadratic_drag", 0.99, {})
    (label,) = (f.label for f in by_name["quadratic_drag"].strengths)
    for value, std, insignificant in (
        (0.1, 0.1, True), (0.1, 0.05, False), (0.0, np.nan, True), (0.1, np.nan, False),
        (0.1, np.inf, True),
    ):  # fmt: skip
        found = insignificant_causes([cause], by_name, {label: (value, std)})
        assert bool(found) == insignificant
    assert "quadratic_drag improves the fit (probability 0.84)" in insignificance_sentence(cause)


def drag_of_some_exponent(v: float, k: float, p: float) -> tuple[float]:
    """Drag k |v / v_1|^p, v_1 = 10 m/s: far from the speeds, so that p may stand for k."""
    return (-k * v / (abs(v) + 1e-9) * (abs(v) / 10.0 + 1e-9) ** p,)


def test_a_strength_is_judged_with_the_form_of_its_cause_held() -> None:
    """k and p trade places, so that the interval of k alone holds 0; no trial does without drag."""
    drag = Effect("drag", "physics", "A force.",
                  (Parameter("k", "N", 10.0, 0.0, 500.0, ""),
                   Parameter("p", "1", 2.0, 0.1, 4.0, "", spread=1.0)),
                  {"force": drag_of_some_exponent}, "tests", ("surge",))  # fmt: skip
    system = replace(SYSTEM, effects=(*SYSTEM.effects[:1], drag))
    problem = replace(
        driven_mass_problem(driven_mass_trials(0.3, 0.0)), kernel=compile_system(system),
        base=system.parameter_vector({}), candidates=candidates_from_effects(
            system, ["drag"], PriorInclusionProbabilities(cause=0.1)
        ),
    )  # fmt: skip
    fitted = fit_noise_and_parameters(problem, fit_cause_set(problem, ("drag",), problem.noise, {}))
    label = "drag.k"
    free = cluster_robust_covariance(fitted.fit.normal, np.ones(3, dtype=bool))
    wide = float(free.half_widths()[1]) / Z_95
    value, std = strength_estimates(fitted, problem.candidate_by_name)[label]
    assert value == fitted.fit.values_by_label()[label]
    assert wide > 3 * std
    assert insignificant_causes([NamedCause("drag", 1.0, {})], problem.candidate_by_name,
                                {label: (value, std)}) == []  # fmt: skip


def test_without_its_limit_the_posterior_keeps_every_set() -> None:
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1)))
    sets = list(visited.sets.values())
    kept = posterior_over_sets(visited.problem, sets, max_log_odds=5.0)
    whole = posterior_over_sets(visited.problem, sets, max_log_odds=np.inf)
    assert len(kept.sets) < len(whole.sets) == len(sets)
    assert whole.inclusion == pytest.approx(kept.inclusion, abs=0.01)


def test_strengths_of_probable_causes_are_those_that_acted() -> None:
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1)))
    values = visited.best.model.fit.values_by_label()
    assert values["quadratic_drag.k"] == pytest.approx(0.3, rel=0.1)
    assert values["constant_force.F0"] == pytest.approx(0.1, rel=0.1)


def test_a_better_noise_of_the_most_probable_set_alone_does_not_search_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its neighbours have been fitted, and have nearly the same ranks."""
    explored = []

    def found_likelier_noise(visited: FittedCauseSets) -> None:
        best = visited.best
        explored.append(best.model.key)
        visited.replace_fit(replace(best, log_posterior=best.log_posterior + 5.0))

    monkeypatch.setattr("bluekoi.engine.search._refit_with_shared_noise", found_likelier_noise)
    visited = search_cause_sets(driven_mass_problem(driven_mass_trials(0.3, 0.1)))
    assert explored == [visited.best.model.key]


def test_a_fit_begins_at_the_strength_that_the_expansion_gives() -> None:
    """Also where the sign is other than that of the usual start."""
    for true in (0.3, -0.2):
        whole = driven_mass_problem(driven_mass_trials(0.0, true))
        first = fit_noise_and_parameters(whole, fit_cause_set(whole, (), whole.noise, {}))
        start = one_step_strength_estimates(
            whole, expand_likelihood(whole, first), "constant_force"
        )
        (value,) = start.values()
        assert value == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize("share", [0.01, 0.1, 10.0])
def test_other_starts_of_the_noise_reach_the_same_fit(share: float) -> None:
    """Random forces of other strengths, as those of another set of causes are."""
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.1))
    other = noise_with_small_random_forces(problem, problem.noise, share=share)
    first, again = (
        fit_noise_and_parameters(problem, fit_cause_set(problem, ("quadratic_drag",), noise, {}))
        for noise in (problem.noise, other)
    )
    assert again.log_joint == pytest.approx(first.log_joint, abs=MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND)


def test_the_model_without_causes_is_fitted_from_two_noises_and_the_likelier_fit_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Random forces so large that the filter runs away do not end a search."""
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.1))
    small = noise_with_small_random_forces(problem, problem.noise)
    singly = [fit_noise_and_parameters(problem, fit_cause_set(problem, (), noise, {}))
              for noise in (problem.noise, small)]  # fmt: skip
    both = fit_without_causes(problem, {})
    assert both.log_joint == max(model.log_joint for model in singly)

    def upset_by_large_forces(
        problem: CauseSearchProblem, causes: Sequence[str], noise: Noise, known: dict[str, float]
    ) -> FittedCauseSet:
        model = fit_cause_set(problem, causes, noise, known)
        if noise is not problem.noise:
            return model
        normal = replace(model.fit.normal, log_likelihood=np.full(len(problem.series), np.nan))
        return replace(model, fit=replace(model.fit, normal=normal))

    monkeypatch.setattr(noise_estimation, "fit_cause_set", upset_by_large_forces)
    found = fit_without_causes(problem, {})
    assert found.is_finite
    assert found.log_joint == singly[1].log_joint


def test_a_difference_with_which_a_trial_runs_away_is_repeated_smaller(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.1))
    model = fit_cause_set(problem, (), problem.noise, {})
    plain = expand_likelihood(problem, model)
    column = plain.strengths["constant_force"][0]
    computed = expansion._trial_information_and_gradients
    steps: list[float] = []

    def upset_by_a_large_step(*args: object) -> NormalEquationsByTrial:
        normal, changes = computed(*args), args[3]
        steps.append(changes[column].step)
        hessian = normal.hessian.copy()
        if changes[column].step == steps[0]:
            hessian[0, column] = np.nan
        return replace(normal, hessian=hessian)

    monkeypatch.setattr(expansion, "_trial_information_and_gradients", upset_by_a_large_step)
    found = expand_likelihood(problem, model)
    strength = problem.candidate_by_name["constant_force"].strengths[0]
    assert steps[1] == finite_difference_step(problem.kernel, strength, 0.0) < 0.1 * steps[0]
    assert found.is_finite
    assert found.hessian.sum(axis=0) == pytest.approx(plain.hessian.sum(axis=0), rel=1e-3, abs=1.0)


def test_a_search_on_a_subset_of_many_trials_names_the_same_causes_as_one_on_all() -> None:
    whole = driven_mass_problem(driven_mass_trials(0.3, 0.1, trials=MAX_SEARCH_TRIALS + 12))
    visited = search_cause_sets(whole)
    assert visited.best.model.key == {"quadratic_drag", "constant_force"}
    assert frozenset() in visited.sets  # the model without causes, with which others are compared
    assert len(visited.best.expansion.log_likelihood) == len(whole.series)


def test_the_subset_holds_the_trials_that_alone_inform_on_a_number() -> None:
    """Two of thirty trials inform on the second number, the others on the first alone."""
    information = np.zeros((30, 2, 2))
    information[:, 0, 0] = 1.0
    information[[4, 17], 1, 1] = 1.0
    assert {4, 17} <= set(d_optimal_trial_subset(information, 5))


def test_the_subset_has_nearly_the_determinant_of_the_best_one() -> None:
    rng = np.random.default_rng(3)
    columns = rng.standard_normal((9, 4, 3)) * rng.uniform(0.2, 2.0, (9, 1, 1))
    information = np.swapaxes(columns, 1, 2) @ columns

    def size(chosen: Sequence[int]) -> float:
        return float(np.linalg.slogdet(information[list(chosen)].sum(axis=0))[1])

    best = max(size(chosen) for chosen in combinations(range(9), 4))
    assert size(d_optimal_trial_subset(information, 4)) > best - 0.5


def test_a_small_study_is_searched_whole() -> None:
    assert d_optimal_trial_subset(np.ones((5, 1, 1)), 24) == [0, 1, 2, 3, 4]


def test_order_of_the_trials_changes_no_probability() -> None:
    series = driven_mass_trials(0.3, 0.0)
    both = []
    for trials in (series, series[::-1]):
        visited = search_cause_sets(driven_mass_problem(trials))
        both.append(visited.best.log_posterior)
    assert both[0] == pytest.approx(both[1], abs=0.5)


def test_a_set_that_one_trial_alone_supports_is_less_sure_than_its_evidence() -> None:
    series = driven_mass_trials(0.0, 0.0)
    odd = replace(series[0], seen=series[0].seen + 0.004 * series[0].times[:, None] ** 2)
    visited = search_cause_sets(driven_mass_problem([odd, *series[1:]]))
    found = posterior_over_sets(visited.problem, list(visited.sets.values()))
    logs = np.array([s.log_posterior for s in found.sets])
    plain = np.exp(logs - logs.max()) / np.exp(logs - logs.max()).sum()
    assert found.probability.max() <= plain.max() + 0.05


def posterior_of_sets(*sets: tuple[tuple[str, ...], float]) -> Posterior:
    """A posterior with these sets of causes and their probabilities."""
    models = [SimpleNamespace(causes=c, model=SimpleNamespace(key=frozenset(c))) for c, _ in sets]
    names = {n for c, _ in sets for n in c}
    inclusion = {n: sum(p for c, p in sets if n in c) for n in names}
    return Posterior(tuple(models), np.array([p for _, p in sets]), inclusion)


CANDIDATES_BY_NAME = {n: SimpleNamespace(is_residual=n == "residual.u")
       for n in ("fin", "lag", "mass", "residual.u")}  # fmt: skip


def test_a_cause_less_probable_than_not_is_not_named() -> None:
    found = posterior_of_sets((("fin", "lag"), 0.4), (("fin", "mass"), 0.3), (("fin",), 0.3))
    named, unexplained = named_causes(found, CANDIDATES_BY_NAME)
    assert [c.name for c in named] == ["fin"]
    assert unexplained == 0.0


def test_one_of_two_causes_that_surely_act_in_one_place_is_named_with_the_other() -> None:
    found = posterior_of_sets((("fin", "lag"), 0.49), (("fin", "mass"), 0.46), (("fin",), 0.05))
    lag = next(c for c in named_causes(found, CANDIDATES_BY_NAME)[0] if c.name == "lag")
    assert (lag.probability, dict(lag.alternatives)) == (0.49, {"mass": 0.46})
    assert lag.credible_set == ["lag", "mass"]


def test_alternatives_in_one_place_are_not_both_named() -> None:
    """mass is more probable on the whole, lag in the most probable set."""
    found = posterior_of_sets((("fin", "lag"), 0.44), (("fin", "mass"), 0.42), (("mass",), 0.14))
    named, _ = named_causes(found, CANDIDATES_BY_NAME)
    assert [c.name for c in named] == ["fin", "mass"]
    assert named[1].credible_set == ["mass", "lag"]


def test_of_two_alternatives_the_calibrated_shares_are_the_calibrated_probabilities() -> None:
    for p in (0.5, 0.8, 0.99):
        shares = calibrated_shares_of_alternatives({"lag": p, "mass": 1.0 - p})
        assert shares["lag"] == pytest.approx(calibrated_probability(p))
        assert sum(shares.values()) == pytest.approx(1.0)


def test_an_alternative_that_is_not_excluded_is_in_the_credible_set() -> None:
    assert NamedCause("stall", 0.94, {"lag": 0.06}).credible_set == ["stall", "lag"]
    assert NamedCause("stall", 0.9999, {"lag": 0.0001}).credible_set == ["stall"]


def test_a_named_cause_and_its_alternatives_share_the_probability_of_one() -> None:
    one = NamedCause("stall", 0.94, {"lag": 0.06})
    assert one.alternative_probabilities == {"lag": pytest.approx(1.0 - one.probability)}
    two = NamedCause("stall", 0.84, {"lag": 0.08, "mass": 0.05})
    assert two.probability + sum(two.alternative_probabilities.values()) == pytest.approx(1.0)
    assert two.alternative_probabilities["lag"] > two.alternative_probabilities["mass"]
    assert NamedCause("stall", 0.9, {}).alternative_probabilities == {}


def test_a_calibrated_probability_rises_with_the_posterior_and_names_the_same_causes() -> None:
    posteriors = np.linspace(0.0, 1.0, 201)
    stated = np.array([calibrated_probability(p) for p in posteriors])
    assert (np.diff(stated) >= 0).all()
    assert ((stated > 0.5) == (posteriors > 0.5)).all()
    assert (stated[posteriors > 0.5] <= posteriors[posteriors > 0.5]).all()


def test_a_force_that_no_candidate_describes_leaves_its_place_unnamed() -> None:
    found = posterior_of_sets((("fin", "residual.u"), 0.8), (("fin", "lag"), 0.2))
    named, unexplained = named_causes(found, CANDIDATES_BY_NAME)
    assert [c.name for c in named] == ["fin"]
    assert unexplained == pytest.approx(0.8)


def test_evidence_is_taken_at_the_better_fit_of_a_set() -> None:
    """A fit that is not converged has a lower joint density, whatever it extrapolates."""
    whole = driven_mass_problem(driven_mass_trials(0.3, 0.0))
    good = search_cause_sets(whole).sets[frozenset({"quadratic_drag"})]
    start = good.model.fit.values_by_label() | {"quadratic_drag.k": 0.15}
    poor = score_cause_set(
        whole, fit_cause_set(whole, ("quadratic_drag",), good.model.noise, start, iterations=0)
    )
    assert good.log_joint > poor.log_joint + 5.0
    assert good.log_posterior > poor.log_posterior + 4.0


def test_evidence_is_not_extrapolated_along_a_slope_at_the_fit() -> None:
    """With held gains a fit rests where the likelihood still has a slope that no refit follows."""
    whole = driven_mass_problem(driven_mass_trials(0.3, 0.0))
    fitted = search_cause_sets(whole).sets[frozenset({"quadratic_drag"})]
    gradient = fitted.expansion.gradient.sum(axis=0)[list(fitted.expansion.own)]
    assert np.abs(gradient[~fitted.model.at_bound]).max() < 1e-6


def test_a_number_at_its_bound_promises_no_gain_from_leaving_it() -> None:
    """The fit has ended there; a slope away from the bound is one of held gains."""
    whole = driven_mass_problem(driven_mass_trials(0.0, -0.1))
    model = fit_cause_set(whole, ("quadratic_drag",), whole.noise, {"quadratic_drag.k": 0.0})
    values, place = model.fit.values.copy(), 1
    values[place] = 0.0
    at_zero = replace(
        model, fit=replace(model.fit, values=values), at_bound=np.array([False, True])
    )
    expansion = expand_likelihood(whole, at_zero, [])
    for slope, kept in ((5.0, 0.0), (-5.0, -5.0)):
        gradient = np.full_like(expansion.gradient, slope / len(expansion.gradient))
        found = make_expansion_stationary_at_fit(
            whole, replace(expansion, gradient=gradient)
        ).gradient.sum(axis=0)
        assert found == pytest.approx([0.0, kept], abs=1e-12)


def problem_with_a_discrepancy(left: float = 0.05) -> CauseSearchProblem:
    """Drag and what its formula leaves, a constant force."""
    problem = driven_mass_problem(driven_mass_trials(0.3, left))
    source = frozenset({("surge", "speed")})
    drag, force = (replace(c, sources=source) for c in problem.candidates)
    return replace(problem, candidates=(drag, replace(force, kind="residual")),
                   state_variables=frozenset({"speed"}))  # fmt: skip


def test_a_set_with_which_the_model_diverges_is_impossible(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces that are no number do not end a search."""
    problem = problem_with_a_discrepancy()
    model = fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})

    def without_numbers(*given: Any) -> LikelihoodExpansion:
        found = expand_likelihood(*given)
        forces = {name: np.full_like(f, np.nan) for name, f in found.forces.items()}
        return replace(found, forces=forces, hessian=np.full_like(found.hessian, np.nan))

    monkeypatch.setattr("bluekoi.engine.set_score.expand_likelihood", without_numbers)
    assert score_cause_set(problem, model).log_posterior == -np.inf


def end_fits_early(monkeypatch) -> None:
    """Fits with a discrepancy end where they begin, and keep the noise."""

    def ends_early(
        problem: CauseSearchProblem, model: FittedCauseSet, noise: Noise, **given
    ) -> FittedCauseSet:
        return fit_cause_set(
            problem, model.causes, noise, {"c": 3.0}, iterations=0, passes=1, **given
        )

    monkeypatch.setattr(set_score, "refit_from_fitted_values", ends_early)
    monkeypatch.setattr(set_score, "fit_noise_and_parameters", lambda problem, model, **_: model)


def test_a_predicted_gain_that_no_fit_reaches_is_not_evidence(monkeypatch) -> None:
    """Where fits with the discrepancy end lower, the evidence is that of none, at an optimum."""
    problem, label = problem_with_a_discrepancy(), "constant_force.F0"
    fitted = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    scored = score_cause_set(problem, fitted)
    reached = refit_with_discrepancy(problem, scored)
    assert reached.model.deviations.keys() == {label}
    assert reached.log_joint > scored.log_joint
    end_fits_early(monkeypatch)
    found = refit_with_discrepancy(problem, scored)
    assert found.log_joint == pytest.approx(scored.log_joint)
    assert found.model.discrepancy == {label: 0.0}
    column = found.expansion.strengths["constant_force"][0]
    assert scored.expansion.gradient[:, column].sum() > 1.0
    assert found.expansion.gradient[:, column].sum() == pytest.approx(0.0, abs=1e-9)
    assert found.log_posterior < scored.log_posterior


@pytest.mark.parametrize(("left", "share"), [(0.0, 0.006), (0.1, 0.2)])
def test_a_set_is_fitted_at_the_share_with_the_largest_evidence(left: float, share: float) -> None:
    """An exact formula, and one that leaves a force of a third of its own."""
    problem, label = problem_with_a_discrepancy(left), "constant_force.F0"
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    found = refit_with_discrepancy(problem, score_cause_set(problem, model), rounds=4)
    assert most_probable_discrepancy_stds(found.expansion, found.layout) == {
        "quadratic_drag": share
    }
    scale = found.layout.discrepancy["quadratic_drag"].max()
    assert found.model.deviations[label] == pytest.approx(share * scale, rel=MAX_LOG_STD_CHANGE)


def test_an_offset_within_its_tolerance_is_fitted_and_integrated_out() -> None:
    """A force of half its tolerance: it is no cause, and the evidence is that of an optimum."""
    problem, label = driven_mass_problem(driven_mass_trials(0.3, 0.02)), "constant_force.F0"
    problem = replace(problem, tolerances={label: 0.04})
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    found = refit_with_discrepancy(problem, score_cause_set(problem, model))
    assert found.model.deviations == {label: pytest.approx(0.04)}
    assert found.model.discrepancy[label] == pytest.approx(0.02, abs=0.01)
    (column,) = found.expansion.strengths["constant_force"]
    slope = found.expansion.gradient[:, column].sum()
    assert slope == pytest.approx(found.model.discrepancy[label] / 0.04**2, rel=1e-6)
    assert found.log_posterior <= found.model.log_likelihood


def test_a_predicted_gain_of_an_offset_that_no_fit_reaches_is_not_evidence(monkeypatch) -> None:
    """As for a discrepancy: a fit that ends early leaves the offset, and its gain, at 0."""
    problem, label = driven_mass_problem(driven_mass_trials(0.3, 0.1)), "constant_force.F0"
    problem = replace(problem, tolerances={label: 0.04})
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    scored = score_cause_set(problem, model)
    end_fits_early(monkeypatch)
    found = refit_with_discrepancy(problem, scored)
    assert found.model.discrepancy == {label: 0.0}
    assert found.log_posterior < scored.log_posterior - 1.0


def test_noise_is_kept_where_another_estimate_has_less_evidence(monkeypatch) -> None:
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.0))
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    scored = score_cause_set(problem, model)
    worse = refit_from_fitted_values(
        problem, model, replace(model.noise, scale=3.0 * model.noise.scale)
    )
    monkeypatch.setattr(set_score, "fit_noise_and_parameters", lambda *_, **__: worse)
    assert refit_with_reestimated_noise(problem, scored) is scored
    less = score_cause_set(problem, worse)
    monkeypatch.setattr(set_score, "fit_noise_and_parameters", lambda *_, **__: model)
    assert refit_with_reestimated_noise(problem, less).model is model


def test_a_noise_that_was_estimated_without_a_gain_is_not_estimated_again(monkeypatch) -> None:
    problem, estimates = driven_mass_problem(driven_mass_trials(0.3, 0.0)), []
    model = fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})

    def worse(kernel, series, points, noise, **_):
        estimates.append(noise)
        return FittedNoise(
            replace(noise, scale=3.0 * noise.scale), filter_all(kernel, series, points, noise)
        )

    monkeypatch.setattr(noise_estimation, "estimate_noise_model", worse)
    found = fit_noise_and_parameters(problem, model)
    assert found.noise is model.noise
    assert fit_noise_and_parameters(problem, found) is found
    assert len(estimates) == 1


def test_a_fit_is_repeated_from_another_noise_once(monkeypatch) -> None:
    """A second time, the fit would start from the same values and end at the same ones."""
    problem = driven_mass_problem(driven_mass_trials(0.3, 0.0))
    visited, repeated = FittedCauseSets(problem), []
    for causes in ((), ("quadratic_drag",)):
        visited.fit_and_keep(FitRequest(causes, fit_cause_set(problem, (), problem.noise, {})))
    monkeypatch.setattr(search, "_refit_from_noise", lambda *given: repeated.append(given[1:]))
    for _ in range(2):
        search._refit_with_shared_noise(visited)
    assert len(repeated) == 1
    visited.replace_fit(replace(visited.best, model=replace(visited.best.model)))
    search._refit_with_shared_noise(visited)
    assert len(repeated) == 2


def test_a_discrepancy_is_fitted_first_at_the_smallest_share(monkeypatch) -> None:
    """Then at the largest, which a force of a third of the cause's own needs."""
    problem, label = problem_with_a_discrepancy(0.1), "constant_force.F0"
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    scored, stds = score_cause_set(problem, model), []

    def recorded(
        problem: CauseSearchProblem, model: FittedCauseSet, noise: Noise, **given
    ) -> FittedCauseSet:
        stds.append(given["deviations"][label])
        return refit_from_fitted_values(problem, model, noise, **given)

    monkeypatch.setattr(set_score, "refit_from_fitted_values", recorded)
    refit_with_discrepancy(problem, scored, rounds=4)
    scale = scored.layout.discrepancy["quadratic_drag"].max()
    assert stds[0] == pytest.approx(0.006 * scale)
    assert max(stds) == pytest.approx(0.2 * scale, rel=MAX_LOG_STD_CHANGE)


def test_the_prior_of_a_discrepancy_is_that_of_the_forces_at_the_fit(monkeypatch) -> None:
    """The fit changes the forces that the prior is relative to: it is repeated until both agree."""
    problem, label = problem_with_a_discrepancy(), "constant_force.F0"
    model = fit_noise_and_parameters(
        problem, fit_cause_set(problem, ("quadratic_drag",), problem.noise, {})
    )
    scored = score_cause_set(problem, model)
    stds = iter([1.0, 0.5, 0.2, 0.2, 0.2])
    monkeypatch.setattr(
        set_score, "most_probable_discrepancy", lambda *_: {label: (0.05, next(stds))}
    )
    found = refit_with_discrepancy(problem, scored, rounds=4)
    assert found.model.deviations == {label: 0.2}


def test_a_residual_term_collinear_with_a_cause_is_no_candidate_of_its_own() -> None:
    """v |v| in the channel and variable of the drag is the drag; a constant force is not."""
    source = frozenset({("surge", "speed")})
    copy = _effect("copy", quadratic_drag, Parameter("k", "1/m", 0.5, -20.0, 20.0, ""))
    system = replace(SYSTEM, effects=(*SYSTEM.effects, copy))
    names = ["quadratic_drag", "constant_force", "copy"]
    drag, force, twin = candidates_from_effects(
        system, names, PriorInclusionProbabilities(cause=0.1)
    )
    residual = {"kind": "residual", "sources": source}
    problem = replace(
        driven_mass_problem(driven_mass_trials(0.3, 0.0)), kernel=compile_system(system),
        base=system.parameter_vector({}), candidates=(replace(drag, sources=source),
        replace(force, **residual), replace(twin, **residual)),
    )  # fmt: skip
    bare = fit_cause_set(problem, (), problem.noise, {})
    assert collinear_terms(problem, *expand_likelihood_in_all_forms(problem, bare)) == {"copy"}
    visited = search_cause_sets(problem)
    assert visited.best.causes == ("quadratic_drag",)
    assert not any("copy" in key for key in visited.sets)
