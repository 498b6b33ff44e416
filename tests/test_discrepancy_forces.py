"""What the formula of a cause may leave: forces in its own channels, a share of its own there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.engine import CauseSearchProblem, FittedCauseSet, expand_likelihood, fit_cause_set
from bluekoi.engine.cause_set_columns import (
    MAX_RELATIVE_DISCREPANCY_STD,
    PRIOR_RELATIVE_DISCREPANCY_STDS,
    CauseSetColumns,
    columns_of_cause_set,
    prior_precisions_given_stds,
)
from bluekoi.engine.evidence import (
    log_evidence,
    log_evidence_given_discrepancy_stds,
    most_probable_discrepancy_stds,
)
from bluekoi.engine.expansion import LikelihoodExpansion
from bluekoi.engine.forces import rms_force_by_cause
from bluekoi.fitting import ParameterFit, fit_parameters_jointly
from bluekoi.integrate import compile_system
from bluekoi.mismatch.robot_problem import robot_cause_search_problem
from bluekoi.model import two_plate_system
from bluekoi.tuning import downsampled, downsampled_with_head_angle_changes, fit_all_trials
from simulated_campaigns import ErrorModel, simulate_campaigns, trial_plans

SURGE, SWAY, YAW = range(3)


@pytest.fixture(scope="module")
def friction_fit() -> tuple[CauseSearchProblem, FittedCauseSet]:
    """Six trials, fitted with a friction force, which is far stronger in surge than in sway."""
    series = simulate_campaigns(
        trial_plans(powers=(75,)), ErrorModel(), np.random.default_rng(5), count=1
    )[0]
    baseline = fit_all_trials(downsampled(series))
    problem = robot_cause_search_problem(
        compile_system(two_plate_system()),
        downsampled_with_head_angle_changes(series, 5.0),
        baseline,
        displaced=(),
        progress=lambda _: None,
    )
    known = {**baseline.fit.values_by_label(), "coulomb_friction.F_c": 0.01}
    return problem, fit_cause_set(problem, ("coulomb_friction",), problem.noise, known)


@pytest.fixture(scope="module")
def friction_columns(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
) -> tuple[LikelihoodExpansion, CauseSetColumns]:
    """The expansion about that fit, and the columns of its set."""
    problem, model = friction_fit
    expansion = expand_likelihood(problem, model)
    return expansion, columns_of_cause_set(problem, expansion, model.causes)


def test_a_residual_term_pushes_in_its_channel_alone(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
) -> None:
    forces = rms_force_by_cause(*friction_fit)
    unit = forces["residual.sway_v"]
    assert max(unit[SURGE], unit[YAW]) < 1e-3 * unit[SWAY]


def test_the_force_of_a_unit_strength_is_the_root_mean_square_of_its_variable(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
) -> None:
    problem, model = friction_fit
    place = problem.kernel.system.all_states.index("v")
    v = np.concatenate([f.filtered[:, place] for f in model.passes])
    unit = rms_force_by_cause(problem, model)["residual.sway_v"]
    assert unit[SWAY] == pytest.approx(np.sqrt(np.mean(v**2)), rel=0.01)


def test_a_discrepancy_is_a_share_of_the_cause_in_the_same_channel(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
    friction_columns: tuple[LikelihoodExpansion, CauseSetColumns],
) -> None:
    forces = rms_force_by_cause(*friction_fit)
    expansion, lay = friction_columns
    precisions = dict(zip(lay.columns.tolist(), lay.precision, strict=True))
    (column,) = expansion.strengths["residual.sway_v"]
    force = precisions[column] ** -0.5 * forces["residual.sway_v"][SWAY]
    assert force == pytest.approx(MAX_RELATIVE_DISCREPANCY_STD * forces["coulomb_friction"][SWAY])
    assert force < 0.7 * MAX_RELATIVE_DISCREPANCY_STD * forces["coulomb_friction"][SURGE]


def test_the_evidence_is_the_mean_over_the_shares_that_a_formula_may_be_wrong_by(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
    friction_columns: tuple[LikelihoodExpansion, CauseSetColumns],
) -> None:
    expansion, lay = friction_columns
    single = [log_evidence_given_discrepancy_stds(expansion, lay, {"coulomb_friction": share})
              for share in PRIOR_RELATIVE_DISCREPANCY_STDS]  # fmt: skip
    assert single[0] == max(single)
    mean = np.log(np.mean(np.exp(np.array(single) - max(single)))) + max(single)
    assert log_evidence(friction_fit[0], expansion, lay) == pytest.approx(mean)


def test_discrepancy_of_an_exact_formula_costs_at_most_log_4(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
    friction_columns: tuple[LikelihoodExpansion, CauseSetColumns],
) -> None:
    """The trials have no friction: what is fitted needs no discrepancy, and at most log 4 is lost
    against the evidence without one.
    """
    expansion, lay = friction_columns
    none = log_evidence_given_discrepancy_stds(expansion, lay, {"coulomb_friction": 1e-6})
    assert (
        log_evidence(friction_fit[0], expansion, lay)
        > none - np.log(len(PRIOR_RELATIVE_DISCREPANCY_STDS)) - 0.5
    )


def test_evidence_of_a_large_remainder_is_capped_at_the_fitted_share(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
    friction_columns: tuple[LikelihoodExpansion, CauseSetColumns],
) -> None:
    """A residual force of a fifth of the cause's own, far above its standard error. The evidence
    counts it only if the set was fitted under a prior that allows it.
    """
    expansion, lay = friction_columns
    position = int(np.argmax(lay.discrepancy["coulomb_friction"]))
    column = lay.columns[position]
    size = MAX_RELATIVE_DISCREPANCY_STD * lay.discrepancy["coulomb_friction"][position]
    hessian, gradient = expansion.hessian.copy(), expansion.gradient.copy()
    hessian[0, column, column] += (30 / size) ** 2
    gradient[0, column] += 30**2 / size
    pushed = replace(expansion, hessian=hessian, gradient=gradient)
    assert most_probable_discrepancy_stds(pushed, lay) == {
        "coulomb_friction": max(PRIOR_RELATIVE_DISCREPANCY_STDS)
    }
    smallest, largest = (
        log_evidence_given_discrepancy_stds(pushed, lay, {"coulomb_friction": share})
        for share in (min(PRIOR_RELATIVE_DISCREPANCY_STDS), max(PRIOR_RELATIVE_DISCREPANCY_STDS))
    )
    assert largest > smallest + 10.0
    problem = friction_fit[0]
    assert log_evidence(problem, pushed, lay) == pytest.approx(smallest)
    (label,) = (f.label for name, columns in expansion.strengths.items()
                for f, i in zip(problem.candidate_by_name[name].strengths, columns, strict=True)
                if i == column)  # fmt: skip
    fitted = replace(pushed, model=replace(friction_fit[1], deviations={label: size}))
    assert log_evidence(problem, fitted, lay) > smallest + 5.0


def test_a_term_of_two_causes_may_be_as_strong_as_the_larger_share_of_them() -> None:
    lay = CauseSetColumns(
        columns=np.arange(2), count=0, blocks={}, precision=np.ones(2),
        gaussian=np.ones(2, dtype=bool), included=np.zeros(2, dtype=bool), signed={},
        at=np.zeros(2), held=np.zeros(2, dtype=bool), sizes={},
        discrepancy={"fin": np.array([1.0, 0.0]), "stall": np.array([4.0, 0.0])},
    )  # fmt: skip
    both = [{"fin": 0.2, "stall": 0.02}, {"fin": 0.02, "stall": 0.2}]
    assert prior_precisions_given_stds(lay, both) == pytest.approx(
        np.array([[25.0, 1.0], [1.5625, 1.0]])
    )


def test_the_discrepancy_is_fitted_with_the_numbers_of_a_set(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet],
) -> None:
    """The most probable point of both: its terms stand where likelihood and prior balance."""
    problem, model = friction_fit
    stds = {"residual.surge_u": 0.02, "residual.sway_v": 0.02}
    both = fit_cause_set(
        problem, model.causes, model.noise, model.fit.values_by_label(), deviations=stds
    )
    assert both.discrepancy.keys() == stds.keys()
    assert both.log_joint > model.log_joint
    expansion = expand_likelihood(problem, both)
    for label, std in stds.items():
        (column,) = expansion.strengths[label]
        slope = float(expansion.gradient[:, column].sum()) - both.discrepancy[label] / std**2
        bend = float(expansion.hessian[:, column, column].sum()) + std**-2
        assert abs(slope) < 0.2 * np.sqrt(bend)


def test_a_fit_that_held_gains_lead_astray_lets_them_follow(
    friction_fit: tuple[CauseSearchProblem, FittedCauseSet], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, model = friction_fit
    given = []

    def astray(*args: object, **options: object) -> ParameterFit:
        given.append(options["predictor"])
        found = fit_parameters_jointly(*args, **options)  # type: ignore[arg-type]
        if options["predictor"] is None:
            return found
        return replace(found, normal=replace(found.normal, gradient=found.normal.gradient * np.nan))

    monkeypatch.setattr("bluekoi.engine.cause_set_fit.fit_parameters_jointly", astray)
    again = fit_cause_set(problem, model.causes, model.noise, model.fit.values_by_label())
    assert None in given
    assert again.is_finite
    assert again.log_likelihood == pytest.approx(model.log_likelihood, abs=0.5)
