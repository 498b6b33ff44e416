"""The generator of concealed studies: its tank, its laws, and the studies that it writes."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from bluekoi.files import write_json
from bluekoi.model import simulate
from bluekoi.study import load_study
from bluekoi.synthetic.eddies import random_eddies, water_velocity
from bluekoi.synthetic.ground_truth_physics import (
    Fin,
    GroundTruthPhysics,
    TrialSettings,
    published_model_physics,
)
from bluekoi.synthetic.motion_simulation import simulate_true_motion as demo_tank
from small_studies import small_study
from validation.generators.concealed import generate
from validation.generators.concealed.effects import PHYSICS, UNLISTED
from validation.generators.concealed.faults import FAULTS
from validation.generators.concealed.plan import (
    BLOCK_SIZE,
    KIND_SHARES,
    draw_recipe_of,
    plan_block,
    planned_study,
)
from validation.generators.concealed.recipe import (
    ChosenEffect,
    draw_recipe,
    effect_by_name,
    with_effect,
)
from validation.generators.concealed.strength import (
    refit_basis,
    rms_after_refit,
    simulated_paths,
    strength_for_path_error,
)
from validation.generators.concealed.swimmer.inputs import (
    NO_EDDIES,
    BodyParameters,
    HiddenLaws,
    TrialCommand,
)
from validation.generators.concealed.swimmer.motion import states, swim
from validation.generators.concealed.swimmer.water import eddies_as_rows, eddy_flow
from validation.scoring import score_all

BODY = BodyParameters(
    0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 4.5e-3, 0.5, 2.5, 3.14, 0.1, 0.13, 0.0
)
COEFFICIENTS = {n: getattr(BODY, n) for n in ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")}
SHORT_S = 2.5
EFFECT_FORMS = [(n, i) for n in (*PHYSICS, *UNLISTED) for i in range(len(effect_by_name(n).forms))]
FORMS_OF_CANDIDATES = [(n, i) for n, i in EFFECT_FORMS if effect_by_name(n).forms[i].reported_as]


def effect_in_form(name: str, number: int) -> ChosenEffect:
    """An effect in one of its forms, shapes at the middle of their range."""
    effect = effect_by_name(name)
    form = effect.forms[number]
    if effect.direction:
        form = type(form)(form.law, dict(zip(effect.direction, (0.8, -0.6), strict=True)),
                          form.fixed, form.shape, form.reported_as)  # fmt: skip
    return ChosenEffect(name, form, {k: 0.5 * (a + b) for k, (a, b) in form.shape.items()}, 10.0)


def core_path(laws: HiddenLaws, command: TrialCommand, body: BodyParameters = BODY) -> np.ndarray:
    """Where the keypoint of the core goes, (times, 3): x, y, heading."""
    motion = swim(body, laws, command, SHORT_S, eddies=NO_EDDIES, recoil=None)
    return motion.mean(np.linspace(0, SHORT_S, 26))[:, :3]


@pytest.mark.parametrize("fin", [None, Fin(0.0125, 0.11, 2.0)])
@pytest.mark.parametrize(("power", "angle_deg"), [(2.37, 30.0), (5.82, -45.0), (5.82, 0.0)])
def test_the_compiled_tank_agrees_with_the_tank_of_the_demo(fin, power, angle_deg):
    run = TrialSettings(power, math.radians(angle_deg), 0.12, start=(1.0, 0.7, 0.4))
    tank = (
        GroundTruthPhysics(fin=fin, recoil=None)
        if fin
        else published_model_physics(GroundTruthPhysics())
    )
    expected = demo_tank(tank, run, SHORT_S).state_without_recoil(np.linspace(0, SHORT_S, 26))[
        :, :3
    ]
    laws = HiddenLaws(fin_m2=0.025, fin_arm_m=0.11) if fin else HiddenLaws()
    found = core_path(laws, TrialCommand(power, math.radians(angle_deg), 0.12, 1.0, 0.7, 0.4))
    assert np.allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize(("power", "speed"), [(2.37, 0.225), (4.02, 0.381), (5.82, 0.552)])
def test_paper_terminal_speeds_model_md_audit_1(power, speed):
    found = states(
        BODY, HiddenLaws(), TrialCommand(power, 0.0, 0.12), NO_EDDIES, 4800, 1 / 480, 480
    )
    assert found[-1, 3] == pytest.approx(speed, abs=6e-4)


def test_pulsed_thrust_oscillates_the_speed_twice_a_beat_about_its_mean():
    command, hz = TrialCommand(4.0, 0.0, 0.12), 4.0
    plain, pulsed = (
        states(BODY._replace(pulse=p), HiddenLaws(), command, NO_EDDIES, 4800, 1 / 480, 1)
        for p in (0.0, 0.5)
    )
    swing = (pulsed - plain)[-480:, 3]
    power = np.abs(np.fft.rfft(swing - swing.mean()))
    assert np.argmax(power) == round(2 * hz)
    assert abs(swing.mean()) < 1e-3
    assert np.ptp(swing) > 2e-3


@pytest.mark.parametrize(("name", "number"), EFFECT_FORMS)
def test_every_form_changes_a_path_and_vanishes_with_its_strength(name, number):
    one = effect_in_form(name, number)
    command = TrialCommand(5.0, 0.6, 0.15, 0.5, 0.4, 0.3)
    plain, fin = core_path(HiddenLaws(), command), HiddenLaws(fin_m2=0.025)
    none = with_effect(HiddenLaws(), one, 0.0)
    assert np.allclose(core_path(none, command), plain, atol=1e-12)
    long = TrialCommand(5.0, 0.7, 0.15, 1.3, 0.8, 0.3, u=0.4, r=-1.0, turned=-6.0)
    bent = core_path(with_effect(fin, one, effect_by_name(name).most), long)
    assert np.all(np.isfinite(bent))
    assert np.hypot(*(bent - core_path(fin, long))[:, :2].T).max() > 1e-3


@pytest.fixture(scope="module")
def setup(tmp_path_factory):
    """Pool, water and robot of the published dimensions."""
    return load_study(small_study(tmp_path_factory.mktemp("same") / "s")).setup


FORM_IN_TRUTH = {
    "servo_lag": {"missing_share": 1.0, "rate_limit_exponent": 1.0, "angle_dependence": 0.0},
    "motor_spin_up": {"missing_share": 1.0, "ramp_share": 0.0},
    "tail_fin_lift": {"half_length": 0.0, "sideways_flow_share": 0.0},
    "crossflow_drag": {"taper": 0.0, "tail_depth": 0.0},
    "port_starboard_asymmetry": {"transition_sine": 0.0},
}
"""Functional form of the concealed law, in the candidate's parameters."""


@pytest.mark.parametrize(("name", "number"), FORMS_OF_CANDIDATES)
def test_forms_stated_to_be_the_candidates_law_give_its_path(name, number, setup):
    """The parameters in the truth mean what the candidate means by them: same path."""
    one = effect_in_form(name, number)
    laws = with_effect(HiddenLaws(), one, effect_by_name(name).usual)
    values = laws._asdict()
    in_truth = {k: values[field] * factor for k, (field, factor) in one.form.reported_as.items()}
    in_truth |= FORM_IN_TRUTH.get(name, {})
    if name == "lift_lag":
        in_truth |= {"build_up_lengths": laws.lag_lengths}
    if name == "thrust_loss_with_speed":
        in_truth = {"loss_per_advance": 0.5 * BODY.C_T * laws.slip_per_m}
    start = (1.3, 0.8, 0.2, 0.0, 0.0, 0.0)
    run = simulate(COEFFICIENTS, setup=setup, head_length_m=0.15, head_angle_rad=0.5, flap_hz=4.0,
                   duration_s=SHORT_S, dt_s=1 / 120, start=start,
                   effects={name: in_truth})  # fmt: skip
    expected = run.state[::12, :2]
    found = core_path(laws, TrialCommand(4.0, 0.5, 0.15, *start[:3]))[: len(expected), :2]
    bent = np.abs(
        found - core_path(HiddenLaws(), TrialCommand(4.0, 0.5, 0.15, *start[:3]))[:, :2]
    ).max()
    if name == "centre_of_mass_shift":
        psi = run.heading_rad[::12]
        ahead = np.column_stack([np.cos(psi), np.sin(psi)])
        expected = expected - in_truth["forward_shift"] * ahead
    along_the_body = 0.3 if name == "pool_gyre" else 0.02  # here the water differs along the body
    assert np.abs(found - expected).max() < along_the_body * bent + 2e-5


@pytest.mark.parametrize("name", [n for n, e in PHYSICS.items() if not (e.signed or e.direction)])
def test_laws_without_a_side_are_mirror_symmetric(name):
    laws = with_effect(HiddenLaws(fin_m2=0.02), effect_in_form(name, 0), effect_by_name(name).usual)
    middle = BODY.pool_width_m / 2
    left = core_path(laws, TrialCommand(4.0, 0.5, 0.12, 1.3, middle, 0.3))
    right = core_path(laws, TrialCommand(4.0, -0.5, 0.12, 1.3, middle, -0.3))
    mirrored = np.column_stack([right[:, 0], 2 * middle - right[:, 1], -right[:, 2]])
    assert np.allclose(left, mirrored, atol=1e-9)


def test_compiled_eddies_equal_those_of_the_demo():
    eddies = random_eddies(np.random.default_rng(3), 0.002)
    for x, y, t in ((0.3, 0.4, 0.0), (2.0, 1.1, 5.0)):
        assert complex(*eddy_flow(eddies_as_rows(eddies), t, x, y)) == pytest.approx(
            water_velocity(eddies, t, complex(x, y)), abs=1e-15
        )


TRIAL_COMMANDS = [
    (TrialCommand(f, a, 0.12, 1.0, 0.8, 0.2), 4.0) for f in (2.4, 5.8) for a in (0.0, 0.5, -0.8)
]


def test_changes_that_a_refit_absorbs_leave_no_path_error():
    basis = refit_basis(BODY, HiddenLaws(fin_m2=0.02), TRIAL_COMMANDS)
    base = simulated_paths(BODY, HiddenLaws(fin_m2=0.02), TRIAL_COMMANDS)
    other = simulated_paths(
        BODY._replace(C_La=BODY.C_La * 1.01), HiddenLaws(fin_m2=0.0201), TRIAL_COMMANDS
    )
    assert rms_after_refit(basis, other - base) < 0.02 * np.sqrt(np.mean((other - base) ** 2))
    assert basis.T @ basis == pytest.approx(np.eye(basis.shape[1]), abs=1e-9)


@pytest.mark.parametrize("name", ["linear_yaw_damping", "uniform_current", "head_angle_offset"])
def test_strengths_leave_the_wanted_path_error(name):
    recipe = draw_recipe((1, 2), "S", kind="single", trials=9, effects=(name,), level="clear")
    strength, error = strength_for_path_error(
        recipe, recipe.laws, recipe.chosen[0], TRIAL_COMMANDS, noise_m=0.001
    )
    assert error == pytest.approx(0.010, rel=0.1)
    assert 0 < strength < effect_by_name(name).most


def test_kinds_have_their_shares_and_effects_are_dealt_evenly():
    dealt = [entry for block in range(4) for entry in plan_block(5, block)]
    for kind, share in KIND_SHARES.items():
        assert sum(e.kind == kind for e in dealt) == pytest.approx(4 * BLOCK_SIZE * share, abs=4)
    singles = [e.effects[0] for e in dealt if e.kind == "single"]
    counts = [singles.count(name) for name in PHYSICS]
    assert max(counts) - min(counts) <= 4
    assert {e.level for e in dealt if e.kind == "single"} == {"clear", "faint"}
    assert {e.effects[0] for e in dealt if e.kind == "outside"} == set(UNLISTED)
    assert {e.effects[0] for e in dealt if e.kind == "measurement"} == set(FAULTS)
    assert sum(e.trials == 9 for e in dealt) == 40


def test_a_study_is_determined_by_seed_and_index():
    assert planned_study(5, 63) == planned_study(5, 63)
    assert [planned_study(5, i) for i in range(50)] != [planned_study(6, i) for i in range(50)]
    filmed = [planned_study(5, i, footage=True) for i in range(50)]
    assert all(e.footage and "keypoint_bias" not in e.effects for e in filmed)


def test_half_of_the_robots_have_a_fin_and_half_are_of_another_size():
    recipes = [draw_recipe_of(e, 3) for block in range(3) for e in plan_block(3, block)]
    free = [r for r in recipes if not any(c.name == "tail_fin_lift" for c in r.chosen)]
    assert 0.38 < np.mean([r.has_fin for r in free]) < 0.62
    assert 0.38 < np.mean([r.robot.mass_kg == 0.68 for r in recipes]) < 0.62
    assert all(r.water_rms_m_s > 0 for r in recipes)


@pytest.fixture(scope="module")
def generated_study(tmp_path_factory) -> tuple[Path, dict]:
    """A study of nine trials with one concealed effect, and its truth."""
    folder = tmp_path_factory.mktemp("made")
    index = next(
        i for i in range(50) if (e := planned_study(9, i)).trials == 9 and e.kind == "single"
    )
    return folder, generate(9, index, folder)


def test_a_study_does_not_contain_its_truth(generated_study):
    folder, truth = generated_study
    study = folder / "studies" / truth["study"]
    assert len(load_study(study).trials) == truth["trials"] == 9
    text = " ".join(p.read_text() for p in study.rglob("*") if p.suffix in (".yaml", ".csv"))
    assert not re.search("seed|hidden|" + "|".join([*PHYSICS, *UNLISTED, *FAULTS]), text)


def test_the_scores_read_the_truth(generated_study):
    folder, truth = generated_study
    causes = [{"name": c["name"], "weight": 0.9} for c in truth["causes"]]
    verdict = {"verdict": "physics", "causes": causes}
    verdict = {"cpu_s": 1.0, "failure": "", "mismatch": verdict}
    write_json(folder / "verdicts" / "test" / f"{truth['study']}.json", verdict)
    assert [one.strict for one in score_all(folder, "test")] == [True]
