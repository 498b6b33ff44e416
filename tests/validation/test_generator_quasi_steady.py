"""The independent generator quasi_steady: dynamics, camera, detector, files."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

sys.path.insert(0, str(Path(__file__).parents[2]))

from validation.generators.quasi_steady import camera as cam
from validation.generators.quasi_steady import detector, studies, trials, writing
from validation.generators.quasi_steady import effects as fx
from validation.generators.quasi_steady import observation as obs


@pytest.fixture(scope="module")
def lab():
    return trials.draw_lab(np.random.default_rng(5), 9, two_heads=False, long=False, lens="pinhole")


def undisturbed_trial(trial, **changes):
    """The trial without gusts or errors."""
    return replace(
        trial,
        gusts=0 * trial.gusts,
        servo_error=0.0,
        flap_error=0.0,
        start=(0.0, 0.0, 0.0),
        **changes,
    )


def test_terminal_speed_is_that_of_thrust_against_drag(lab):
    trial = undisturbed_trial(lab.trials[0], head_angle=0.0, seconds=12.0)
    _, states, _ = trials.simulate_trial(lab, trial, [], 10)
    by_hand = trial.flap * np.sqrt(lab.robot.C_T / lab.robot.C_D0)
    assert states[-1, 3] == pytest.approx(by_hand, rel=1e-3)
    assert np.abs(states[:, 5]).max() < 1e-9


def test_speed_from_rest_follows_the_hyperbolic_tangent(lab):
    trial = undisturbed_trial(lab.trials[0], head_angle=0.0, seconds=2.0)
    times, states, _ = trials.simulate_trial(lab, trial, [], 10)
    robot = lab.robot
    top = trial.flap * np.sqrt(robot.C_T / robot.C_D0)
    rate = 0.5 * robot.rho * robot.area * robot.C_D0 * top / robot.mass
    np.testing.assert_allclose(states[:, 3], top * np.tanh(rate * times), atol=1e-6)


@pytest.mark.parametrize("form", [f for f in fx.FORMS if f.cause == "tail_fin_lift"])
def test_positive_head_angle_turns_clockwise(lab, form):
    fin = fx.draw_effect(form, np.random.default_rng(1))
    runs = [
        trials.simulate_trial(
            lab, undisturbed_trial(lab.trials[0], head_angle=a, seconds=5.0), [fin], 10
        )[1]
        for a in (0.5, -0.5)
    ]
    assert runs[0][-1, 5] < -0.1
    np.testing.assert_allclose(runs[0][:, [1, 2]], -runs[1][:, [1, 2]], atol=1e-6)


@pytest.mark.parametrize("model", ["pinhole", "fisheye", "plain"])
def test_projection_round_trip(model):
    rng = np.random.default_rng(3)
    camera = cam.draw_camera(rng, 2.6, 1.6, model)
    points = np.column_stack([rng.uniform(0, [2.6, 1.6], (50, 2)), np.full(50, -0.04)])
    back = cam.pixels_to_pool(camera, cam.project(camera, points), 0.04)
    np.testing.assert_allclose(back, points[:, :2], atol=1e-5)


def test_a_competent_lab_decodes_the_simulated_positions(lab):
    times, points, _ = writing.true_keypoints(
        lab, trials.with_start_pose(np.random.default_rng(0), lab, lab.trials[0], []), []
    )
    seen = obs.keypoint_pixels(lab, lab.trials[0], [], times, points)
    back = obs.pixels_to_stated_pool(lab, obs.stated_setup(lab, []), seen)
    assert np.abs(back - points).max() < 3e-3


def simulated_detectability(lab, trial, effect, draws):
    """Whitened norm of an effect's change of a trajectory, from the simulated covariance."""
    rng = np.random.default_rng(8)
    given = [trials.trial_inputs(lab, trial, some) for some in ([effect], [])]
    times = np.arange(int(trial.seconds / detector.BLOCK_S) + 1) * detector.BLOCK_S

    def observed(start, inputs):
        return trials.simulate(times, start, *inputs)[0][:, :3].T.ravel()

    clean = observed(np.zeros(7), given[0])
    signal = clean - observed(np.zeros(7), given[1])
    runs = []
    for _ in range(draws):
        start = np.r_[0, 0, 0, rng.normal(0, detector.START_STDS[3:]), 0]
        schedule = given[0][2].copy()
        schedule[:, 2:] = trials.draw_gusts(rng, lab.noise.gust_m_s, lab.noise.gust_s)
        runs.append(observed(start, (*given[0][:2], schedule)))
    cov = np.cov(np.array(runs).T)
    x, y, one, zero = *clean.reshape(3, -1)[:2], np.ones(len(times)), np.zeros(len(times))
    for shift in ([one, zero, zero], [zero, one, zero], [-y, x, one]):
        cov += np.outer(np.ravel(shift), np.ravel(shift))
    white, drift = detector.tracking_variances(lab)
    alike = np.exp(-np.abs(times[:, None] - times) / lab.noise.drift_s)
    cov += np.kron(np.diag(white), np.eye(len(times))) + np.kron(np.diag(drift), alike)
    return np.sqrt(signal @ np.linalg.solve(cov, signal))


def test_the_filter_agrees_with_brute_force(lab):
    effect = replace(fx.draw_effect(fx.CAUSES["viscous_drag"][0], np.random.default_rng(2)), k=0.01)
    trial = undisturbed_trial(lab.trials[0], head_angle=0.5, seconds=2.5)
    s = detector.trial_signals(lab, trial, [effect])
    e = detector.whitened_innovations(s, lab.noise, *detector.tracking_variances(lab))
    assert np.linalg.norm(e[:, :, 0]) == pytest.approx(
        simulated_detectability(lab, trial, effect, 500), rel=0.2
    )


def test_composition_of_forty_studies():
    slots = [studies.study_slot(i) for i in range(13, 53)]
    groups = [g for g, _, _ in slots]
    assert {g: groups.count(g) for g in set(groups)} == {
        "null": 8, "clear": 8, "faint": 6, "pair": 6, "measurement": 6, "unlisted": 6,
    }  # fmt: skip
    assert all(
        sum(f for g, f, _ in slots if g == name) * 2 == groups.count(name) for name in groups
    )
    assert sum(few for _, _, few in slots) == 10


def test_every_named_cause_can_be_drawn():
    names = set(fx.PHYSICS) | set(fx.MEASUREMENTS) | {"tail_fin_lift"}
    assert len(names) == 31
    assert all(len(fx.CAUSES[name]) >= 2 for name in names)
    drawn = {c for i in range(40) if studies.study_slot(i)[0] in ("clear", "faint")
             for c in studies.causes_from_deck(1, i)[:1]}  # fmt: skip
    drawn |= {
        c
        for i in range(40)
        if studies.study_slot(i)[0] == "pair"
        for c in studies.causes_from_deck(1, i)[:2]
    }
    assert drawn == set(fx.PHYSICS)


def test_a_study_is_determined_by_seed_and_index(tmp_path):
    index = next(
        i for i in range(40) if studies.study_slot(i)[0] == "null" and studies.study_slot(i)[2]
    )
    truths = [studies.generate(3, index, tmp_path / d) for d in "ab"]
    assert truths[0] == json.loads(
        (tmp_path / "a" / "truth" / f"{truths[0]['study']}.json").read_text()
    )
    assert json.dumps(truths[0]) == json.dumps(truths[1])
    folders = [tmp_path / d / "studies" / truths[0]["study"] for d in "ab"]
    files = sorted(p.relative_to(folders[0]) for p in folders[0].rglob("*") if p.is_file())
    assert all((folders[0] / f).read_bytes() == (folders[1] / f).read_bytes() for f in files)
    assert not list(folders[0].rglob("*truth*"))
    rows = pd.read_csv(folders[0] / "trials.csv")
    assert len(rows) == truths[0]["trials"] == 9
    stated = yaml.safe_load((folders[0] / "study.yaml").read_text())
    assert stated["robot"]["mass_kg"] == truths[0]["robot"]["mass"]
    assert truths[0]["verdict"] == ("physics" if truths[0]["fin"] else "none")
    assert truths[0]["unlisted"] is None
