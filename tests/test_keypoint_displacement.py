"""Keypoints displaced in a direction of the pool are found by the robot's rigid lengths."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from bluekoi.camera.displacement_change_point import displacements_by_session_part
from bluekoi.camera.keypoint_displacement import (
    displacements_identifiable,
    estimate_keypoint_displacements,
)
from bluekoi.camera.keypoint_displacement_field import (
    KeypointDisplacementField,
    remove_keypoint_displacements,
)
from bluekoi.camera.rigid_distances import rigid_distances
from bluekoi.camera.rigid_length_warnings import rigid_length_warnings
from bluekoi.data import KeypointPositions, read_pose
from bluekoi.files import write_json
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial, write_keypoints_csv
from bluekoi.mismatch.displaced_keypoints import with_keypoint_bias_cause
from bluekoi.stages.geometry import geometry
from bluekoi.stages.keypoint_errors import keypoint_errors
from bluekoi.stages.keypoint_errors_file import NO_ERRORS, displacements_of_trial
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.result_paths import ResultPaths
from bluekoi.stages.tracks import tracks
from bluekoi.study import Robot, load_study
from small_studies import SMALL_STUDY_TRIALS, small_study

ROBOT = Robot(
    mass_kg=0.68, yaw_inertia_kg_m2=0.0095, body_length_m=0.331, head_length_m=0.12,
    head_span_m=0.069, hinge_to_com_m=0.04, tail_length_m=0.066,
)  # fmt: skip
PARTS = ("head_tip", "hinge", "core_center", "tail_base")
CAMERA_M = np.array([1.5, 0.6])
HEAD_ANGLES_RAD = np.radians([-30.0, -15.0, 0.0, 15.0, 30.0, 0.0])
EMPTY_VERDICT = {"verdict": "none", "sentence": "Nothing.", "causes": [], "rivals": [],
                 "probabilities": {"keypoint_bias": 0.01}}  # fmt: skip


def circle_with_noise(head_angle_rad: float, seed: int, std_m: float = 0.001) -> KeypointPositions:
    """Five seconds of a robot on a circle; straight, in a direction of its own, without a head
    angle.
    """
    rng, t = np.random.default_rng(seed), np.arange(150) / 30.0
    heading = rng.uniform(-np.pi, np.pi) + 1.5 * np.sin(head_angle_rad) * t
    core = np.exp(1j * heading)
    center = 0.8j + 1.3 + np.cumsum(0.2 / 30.0 * core) * (1.0 if head_angle_rad else 0.3)
    hinge = center + ROBOT.hinge_to_com_m * core
    tip = hinge + 0.12 * core * np.exp(1j * head_angle_rad)
    tail = center - ROBOT.com_to_tail_base_m * core
    points = np.stack([tip, hinge, center, tail], axis=1)
    xy = np.stack([points.real, points.imag], axis=2) + rng.normal(0.0, std_m, (len(t), 4, 2))
    cov = np.broadcast_to(std_m**2 * np.eye(2), (len(t), 4, 2, 2))
    return KeypointPositions(t, PARTS, xy, cov, np.ones((len(t), 4)))


def circles(seed: int, std_m: float = 0.001) -> list[KeypointPositions]:
    return [circle_with_noise(a, 100 * seed + k, std_m) for k, a in enumerate(HEAD_ANGLES_RAD)]


def displaced_by(
    one: KeypointPositions, vector: tuple[float, float], *parts: str, parallax: float = 0.0
) -> KeypointPositions:
    """With `parts` displaced by a vector and away from `CAMERA_M`, the point below the camera."""
    moved = np.array([name in parts for name in one.names])[:, None]
    return replace(one, xy_m=one.xy_m + moved * (vector + parallax * (one.xy_m - CAMERA_M)))


def circles_all_over_the_pool(
    trials: int, seed: int, std_m: float = 0.001
) -> list[KeypointPositions]:
    places = np.random.default_rng(seed).uniform(-0.8, 0.8, (trials, 2))
    heads = np.resize(HEAD_ANGLES_RAD, trials)
    return [replace(one, xy_m=one.xy_m + place)
            for k, (angle, place) in enumerate(zip(heads, places, strict=True))
            for one in [circle_with_noise(angle, 1000 * seed + k, std_m)]]  # fmt: skip


def vectors_m(found: dict) -> dict[str, tuple[float, float]]:
    assert all(one.parallax == 0.0 for one in found.values())
    return {name: (one.x_m, one.y_m) for name, one in found.items()}


def found_in(trials: list[KeypointPositions]) -> dict:
    return estimate_keypoint_displacements(trials, [0.12] * len(trials), ROBOT)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("vector", [(0.02, 0.0), (-0.004, 0.004), (0.0, -0.01)])
def test_one_displaced_keypoint_is_found(part, vector):
    found = found_in([displaced_by(one, vector, part) for one in circles(1)])
    assert list(found) == [part]
    assert vectors_m(found)[part] == pytest.approx(vector, abs=0.001)


@pytest.mark.parametrize("names", [("head_tip", "hinge"), ("hinge", "tail_base")])
def test_of_two_keypoints_displaced_alike_the_difference_to_the_others_is_found(names):
    """Whether these two or the other two are displaced, no length shows."""
    found = vectors_m(found_in([displaced_by(one, (0.012, 0.0), *names) for one in circles(1)]))
    assert len(found) == 2
    sign = 1.0 if set(found) == set(names) else -1.0
    assert set(found) == set(names) or not set(found) & set(names)
    for one in found.values():
        assert one == pytest.approx((sign * 0.012, 0.0), abs=0.001)


def test_estimates_have_the_stated_standard_errors():
    """Of 30 seeds; the rounding to 0.1 mm is part of them."""
    normalised = []
    for seed in range(30):
        moved = [displaced_by(one, (0.03, 0.0), "hinge") for one in circles(seed, std_m=0.01)]
        one = found_in(moved)["hinge"]
        errors = np.array([one.x_m, one.y_m]) - (0.03, 0.0)
        normalised += list(errors / [one.x_std_m, one.y_std_m])
    assert 0.5 < np.std(normalised) < 1.3


def test_a_displacement_that_begins_within_the_session_is_found_with_its_trials():
    trials = [*circles(1), *circles(2), *circles(3)]
    late = [displaced_by(one, (0.015, 0.0), "hinge") for one in trials[8:]]
    ((part, found),) = displacements_by_session_part([*trials[:8], *late], [0.12] * 18, ROBOT)
    assert part == range(8, 18)
    assert vectors_m(found)["hinge"] == pytest.approx((0.015, 0.0), abs=0.001)


def test_a_displacement_that_turns_round_has_two_parts():
    trials = [*circles(4), *circles(5), *circles(6)]
    moved = [displaced_by(one, (-0.01 if k < 9 else 0.01, 0.0), "tail_base")
             for k, one in enumerate(trials)]  # fmt: skip
    found = displacements_by_session_part(moved, [0.12] * 18, ROBOT)
    assert [part for part, _ in found] == [range(9), range(9, 18)]
    assert [vectors_m(one)["tail_base"][0] for _, one in found] == pytest.approx(
        [-0.01, 0.01], abs=0.001
    )


def test_a_lasting_displacement_has_one_part():
    trials = [*circles(7), *circles(8)]
    moved = [displaced_by(one, (0.02, 0.0), "hinge") for one in trials]
    ((part, _),) = displacements_by_session_part(moved, [0.12] * 12, ROBOT)
    assert part == range(12)
    assert displacements_by_session_part(trials, [0.12] * 12, ROBOT) == []


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("parallax", [0.03, -0.02])
def test_a_keypoint_above_or_below_the_others_is_found_by_its_parallax(part, parallax):
    trials = circles_all_over_the_pool(12, 1)
    found = found_in([displaced_by(one, (0.0, 0.0), part, parallax=parallax) for one in trials])
    assert list(found) == [part]
    assert found[part].parallax == pytest.approx(parallax, abs=0.002)
    center = -np.array([found[part].x_m, found[part].y_m]) / found[part].parallax
    assert center == pytest.approx(CAMERA_M, abs=0.05)


@pytest.mark.parametrize("std_m", [0.0001, 0.001])
def test_a_head_above_the_body_has_one_parallax_for_both_keypoints(std_m):
    """Two keypoints against two: which pair is displaced is not known, and must not alternate."""
    trials = circles_all_over_the_pool(12, 1, std_m)
    moved = [displaced_by(one, (0.0, 0.0), "head_tip", "hinge", parallax=0.03) for one in trials]
    found = found_in(moved)
    assert list(found) == ["head_tip", "hinge"]
    assert [one.parallax for one in found.values()] == pytest.approx([0.03] * 2, abs=0.002)


def test_vector_and_parallax_of_one_keypoint_are_found_together():
    trials = circles_all_over_the_pool(12, 2)
    moved = [displaced_by(one, (0.01, -0.02), "hinge", parallax=0.02) for one in trials]
    field = found_in(moved)["hinge"].field
    truth = KeypointDisplacementField(0.01 - 0.02 * 1.5, -0.02 - 0.02 * 0.6, 0.02)
    for one, exact in zip(moved, trials, strict=True):
        assert field.at(exact.xy_m) == pytest.approx(truth.at(exact.xy_m), abs=0.001)
        corrected = remove_keypoint_displacements(one, {"hinge": field})
        assert corrected.xy_m == pytest.approx(exact.xy_m, abs=0.001)


def test_parallaxes_have_the_stated_standard_errors():
    """Of 30 seeds; stated errors include the scatter between few trials, and are rather large."""
    normalised = []
    for seed in range(30):
        moved = [displaced_by(one, (0.0, 0.0), "hinge", parallax=0.03)
                 for one in circles_all_over_the_pool(12, seed)]  # fmt: skip
        one = found_in(moved)["hinge"]
        normalised.append((one.parallax - 0.03) / one.parallax_std)
    assert 0.5 < np.std(normalised) < 1.3


def test_a_parallax_that_changes_within_the_session_has_two_parts():
    """The positions of both parts are the same, so that their means are."""
    trials = [*circles_all_over_the_pool(12, 3)] * 2
    moved = [displaced_by(one, (0.02, 0.0), "hinge", parallax=0.03 if k < 12 else 0.01)
             for k, one in enumerate(trials)]  # fmt: skip
    found = displacements_by_session_part(moved, [0.12] * 24, ROBOT)
    assert [part for part, _ in found] == [range(12), range(12, 24)]
    assert [one["hinge"].parallax for _, one in found] == pytest.approx([0.03, 0.01], abs=0.002)


def test_an_estimate_that_does_not_converge_is_not_used():
    """Displaced by more than half of the distance: lengths have the directions of other points."""
    trials = circles_all_over_the_pool(12, 4)
    moved = [displaced_by(one, (0.0, 0.0), "hinge", parallax=-0.6) for one in trials]
    assert found_in(moved) == {}


@pytest.mark.parametrize("seed", range(4))
def test_camera_errors_all_over_the_pool_displace_no_keypoint(seed):
    middle = np.array([1.3, 0.8])
    trials = circles_all_over_the_pool(12, seed)
    assert found_in(trials) == {}
    for distort in (
        lambda out: out * (1.0 + 0.03 * np.sum(out**2, axis=2, keepdims=True)),
        lambda out: out / (1.0 + out @ np.array([[0.03], [0.02]])),
        lambda out: 1.05 * out,
    ):
        seen = [replace(one, xy_m=middle + distort(one.xy_m - middle)) for one in trials]
        assert found_in(seen) == {}


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_found_in_exact_lengths(seed):
    assert found_in(circles(seed)) == {}


def test_a_keypoint_displaced_on_the_body_is_not_displaced_in_the_pool():
    for along, across in ((0.01, 0.0), (0.0, 0.01)):
        trials = []
        for one in circles(2):
            axis = one.part("hinge") - one.part("tail_base")
            axis /= np.linalg.norm(axis, axis=1)[:, None]
            xy = one.xy_m.copy()
            xy[:, 2] += along * axis + across * np.column_stack([-axis[:, 1], axis[:, 0]])
            trials.append(KeypointPositions(one.time_s, PARTS, xy, one.cov_m2, one.likelihood))
        assert found_in(trials) == {}


def test_a_stretched_picture_displaces_no_keypoint():
    middle = np.array([1.3, 0.8])
    trials = []
    for one in circles(3):
        out = one.xy_m - middle
        radial = 1.0 + 0.03 * np.sum(out**2, axis=2, keepdims=True)
        trials.append(
            KeypointPositions(one.time_s, PARTS, middle + out * radial, one.cov_m2, one.likelihood)
        )
    assert found_in(trials) == {}


def test_straight_trials_in_one_direction_show_no_displacement():
    """They cannot tell a displacement in the pool from one on the body."""
    one = circle_with_noise(0.0, 5)
    moved = displaced_by(one, (0.01, 0.0), "hinge")
    assert found_in([moved] * 3) == {}


def test_two_keypoints_are_no_evidence():
    one = circle_with_noise(0.3, 1)
    pair = KeypointPositions(one.time_s, PARTS[1:3], one.xy_m[:, 1:3], one.cov_m2[:, 1:3],
                     one.likelihood[:, 1:3])  # fmt: skip
    assert found_in([pair]) == {}
    assert not displacements_identifiable(rigid_distances([pair], [0.12], ROBOT))
    assert displacements_identifiable(rigid_distances([one], [0.12], ROBOT))
    (warning,) = rigid_length_warnings({"keypoint_displacements_visible": False}, None)
    assert "Label head tip, hinge" in warning


def test_tracks_of_a_study_are_corrected(tmp_path):
    """A study whose hinge lies ten pixels to the right in all files: poses as without that."""
    heads = []
    for name, shift in (("right", 0.0), ("moved", 10.0)):
        study, results = small_study(tmp_path / name / "study"), tmp_path / name / "results"
        loaded = load_study(study)
        for trial in loaded.trials:
            path = loaded.paths(trial)[0]
            seen = read_keypoints_of_trial(path, trial)
            xy = seen.xy_px.copy()
            xy[:, seen.names.index("hinge"), 0] += shift
            write_keypoints_csv(path, replace(seen, xy_px=xy))
        for trial_id in SMALL_STUDY_TRIALS:
            keypoints(study, results, trial_id)
        keypoint_errors(study, results)
        geometry(study, results)
        displaced = json.loads((results / "geometry.json").read_text())["keypoint_displacements"]
        assert [list(part["keypoints"]) for part in displaced] == ([["hinge"]] if shift else [])
        for trial_id in SMALL_STUDY_TRIALS:
            tracks(study, results, trial_id)
        heads.append(read_pose(results / f"poses/{SMALL_STUDY_TRIALS[-1]}.csv").values[:, 3])
    assert np.nanmedian(np.abs(heads[1] - heads[0])) < 0.01


def test_the_verdict_names_keypoint_bias_first():
    hinge = {"x_m": 0.0, "y_m": -0.012, "x_std_m": 2e-4, "y_std_m": 3e-4, "sigmas": 40.0,
             "parallax": 0.0, "parallax_std": 1e-4}  # fmt: skip
    displaced = [{"trials": ["T1", "T2"], "keypoints": {"hinge": hinge}}]
    on_body = {"name": "keypoint_bias", "weight": 0.9, "parameters": {"left_offset": {"value": 1}}}
    other = {"name": "stall", "weight": 0.9, "parameters": {}}
    content = EMPTY_VERDICT | {"causes": [other, on_body]}
    result = with_keypoint_bias_cause(content, displaced, ["T1", "T2"])
    assert [c["name"] for c in result["causes"]] == ["keypoint_bias", "stall"]
    assert "in all 2 trials, hinge by 12.0 mm, -90 degrees from the x axis" in result["sentence"]
    assert result["causes"][0]["parameters"].keys() == {"hinge_x", "hinge_y", "left_offset"}
    assert result["probabilities"]["keypoint_bias"] == 1.0
    assert with_keypoint_bias_cause(content, [], ["T1", "T2"]) == content
    later = with_keypoint_bias_cause(content, displaced, ["T1", "T2", "T3"])
    assert "in 2 trials from T1 to T2, hinge by 12.0 mm" in later["sentence"]


def test_the_verdict_states_a_parallax():
    tail = {"x_m": 0.026, "y_m": 0.016, "x_std_m": 2e-4, "y_std_m": 3e-4, "sigmas": 40.0,
            "parallax": -0.02, "parallax_std": 1e-4}  # fmt: skip
    displaced = [{"trials": ["T1", "T2"], "keypoints": {"tail_base": tail}}]
    result = with_keypoint_bias_cause(EMPTY_VERDICT, displaced, ["T1", "T2"])
    text = "tail_base by 2.0 % of its distance from (1.30, 0.80) m, towards it"
    assert text in result["sentence"]
    (cause,) = result["causes"]
    assert cause["parameters"].keys() == {"tail_base_parallax"}
    assert "(1.30, 0.80) m" in cause["parameters"]["tail_base_parallax"]["meaning"]
    assert "higher or lower than the others" in cause["sentence"]
    assert "Highlights" not in cause["sentence"]
    parts = [{"trials": [name], "keypoints": {"tail_base": tail}} for name in ("T1", "T2")]
    both = with_keypoint_bias_cause(EMPTY_VERDICT, parts, ["T1", "T2"])["causes"][0]["parameters"]
    assert {"tail_base_parallax_part_1", "tail_base_parallax_part_2"} <= both.keys()


def test_a_file_of_an_earlier_version_has_no_parallax(tmp_path):
    study = load_study(small_study(tmp_path / "study"))
    layout = ResultPaths(tmp_path / "results")
    part = {"trials": ["T10"], "keypoints": {"hinge": {"x_m": 0.01, "y_m": 0.0}}}
    write_json(layout.keypoint_errors, {**NO_ERRORS, "displacements": [part]})
    found = displacements_of_trial(study.trial("T10"), layout)
    assert found == {"hinge": KeypointDisplacementField(0.01, 0.0, 0.0)}
    assert displacements_of_trial(study.trial("T09"), layout) == {}
