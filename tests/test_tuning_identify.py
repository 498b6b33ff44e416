"""What trials determine and what not: spectrum, profiles, and the trial that would help."""

from __future__ import annotations

import numpy as np
import pytest

from campaigns import COEFFICIENTS, Errors, plans, sixteen
from pipeline.fitting import Series
from pipeline.tuning import thin, tune
from pipeline.tuning.identify import best_new_trial, profile, spectrum
from pipeline.tuning.words import undetermined
from robots import SETUP

NAMES = tuple(COEFFICIENTS)


@pytest.fixture(scope="module")
def campaign() -> list[Series]:
    return thin(sixteen(plans((50, 100)), Errors(), np.random.default_rng(7), count=1)[0])


@pytest.fixture(scope="module")
def straight() -> list[Series]:
    made = sixteen(plans((50, 100), ((0.0, 0.12), (0.0, 0.12))), Errors(push=(1e-4, 1e-4, 1e-6)),
                   np.random.default_rng(8), count=1)  # fmt: skip
    return thin(made[0])


def test_spectrum_covers_all_directions_the_least_determined_first(campaign) -> None:
    found = spectrum(tune(campaign))
    assert len(found) == 6
    stds = [c.std for c in found]
    assert stds == sorted(stds, reverse=True)
    for one in found:
        assert np.linalg.norm(one.direction) == pytest.approx(1.0)
    assert found[-1].std < 0.02


def test_straight_runs_leave_the_turning_coefficients_open_and_say_so(straight) -> None:
    joint = tune(straight)
    told = undetermined(straight, joint, SETUP)
    assert told
    named = " ".join(t["combination"] for t in told)
    assert "C_Da" in named or "C_Md" in named
    assert any("Straight runs hold alpha at 0" in t["sentence"] for t in told)
    assert any(t["trial"].startswith("a turn at") for t in told), told


def test_the_trial_that_is_named_does_help(straight) -> None:
    joint = tune(straight)
    worst = spectrum(joint)[0]
    trial = best_new_trial(straight, joint, SETUP, worst)
    assert trial.head_angle_deg > 0
    assert trial.left < 0.7


def test_profile_has_its_top_at_the_fit_and_agrees_with_the_fisher_matrix(campaign) -> None:
    joint = tune(campaign)
    for name in ("C_T", "C_La"):
        index = NAMES.index(name)
        found = profile(campaign, joint, index)
        assert np.all(found.lost > -0.1)
        naive = np.sqrt(joint.fit.naive_cov[index, index])
        expected = 0.5 * ((found.values - joint.fit.values[index]) / naive) ** 2
        assert found.lost == pytest.approx(expected, rel=0.5, abs=0.3)
        assert found.lower is None or found.lower < joint.fit.values[index]
        assert found.upper is None or found.upper > joint.fit.values[index]


def test_a_well_planned_campaign_determines_what_it_should(campaign) -> None:
    joint = tune(campaign)
    truth = np.array([COEFFICIENTS[n] for n in NAMES])
    inside = (joint.interval_95[:, 0] <= truth) & (truth <= joint.interval_95[:, 1])
    assert inside.sum() >= 5
    assert joint.freedom is not None
    assert np.all((joint.freedom > 1) & (joint.freedom < 12))
