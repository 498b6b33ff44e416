"""A trial from a picture turned by 180 degrees is named by the lengths that it shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from exact_campaign import make_trial
from test_pose import circle_poses, keypoint_positions

from bluekoi.camera import pool_camera, pool_to_pixels
from bluekoi.camera.turned_picture import half_turn_regression_sums, turned_picture_warnings
from bluekoi.cli import main
from bluekoi.data import BODY_PART_NAMES, Keypoints
from bluekoi.study import load_study
from small_studies import published_model_design, small_study
from validation.tracking_noise import keypoint_study

DEPTH_M = 0.04
TRIALS = {t.trial_id: t for t in (make_trial(k, 100, 30) for k in range(1, 10))}


@pytest.fixture(scope="module")
def camera(tmp_path_factory):
    return pool_camera(load_study(small_study(tmp_path_factory.mktemp("turned") / "study")).setup)


def seen_robot(camera, number: int, length_error: float = 0.0) -> Keypoints:
    """Three seconds on a part of a circle, elsewhere in the pool for each number, 0.4 px noise."""
    rng = np.random.default_rng(number)
    pose = circle_poses(n=90, turns=0.3)
    pose[:, :2] += rng.uniform([-0.5, -0.3], [0.5, 0.1])
    xy = keypoint_positions(pose).xy_m
    middle = xy[:, 2:3]
    places = (middle + (1 + length_error) * (xy - middle)).reshape(-1, 2)
    flat = pool_to_pixels(camera, np.column_stack([places, np.full(len(places), -DEPTH_M)]))
    px = flat.reshape(90, 5, 2) + rng.normal(0, 0.4, (90, 5, 2))
    cov = np.broadcast_to(0.16 * np.eye(2), (90, 5, 2, 2))
    return Keypoints(np.arange(90) / 30, BODY_PART_NAMES, px, np.ones((90, 5)), cov)


def turned(camera, found: Keypoints) -> Keypoints:
    return replace(found, xy_px=np.array(camera.size_px) - 1.0 - found.xy_px)


def warnings(camera, keypoints) -> list[str]:
    statuses = {
        name: {"ok": True, "turned_picture": half_turn_regression_sums(camera, found, DEPTH_M)}
        for name, found in keypoints.items()
    }
    return list(turned_picture_warnings(TRIALS, statuses))


@pytest.mark.parametrize("seed", range(5))
def test_a_turned_trial_is_named_and_no_other(camera, seed):
    good = {name: seen_robot(camera, 100 * seed + k) for k, name in enumerate(TRIALS)}
    assert warnings(camera, good) == []
    far = max(good, key=lambda name: half_turn_regression_sums(
        camera, good[name], DEPTH_M)["core"]["rms"])  # fmt: skip
    (text,) = warnings(camera, good | {far: turned(camera, good[far])})
    assert f"Trial {far}: keypoints/{far}.csv: found rigid lengths" in text
    assert "turned by 180 degrees; expected the same lengths" in text


@pytest.mark.parametrize("error", [0.05, -0.05])
def test_larger_errors_of_a_length_are_no_turned_picture(camera, error):
    """5 % everywhere in one trial, where turning the picture changes lengths by less than 3 %."""
    good = {name: seen_robot(camera, k) for k, name in enumerate(TRIALS)}
    record = half_turn_regression_sums(camera, good["T01"], DEPTH_M)
    assert record["core"]["rms"] < 0.03
    assert warnings(camera, good | {"T01": seen_robot(camera, 0, length_error=error)}) == []


def test_few_trials_and_missing_parts_are_not_judged(camera):
    good = {name: seen_robot(camera, k) for k, name in enumerate(TRIALS)}
    two = dict(list(good.items())[:2])
    assert warnings(camera, two | {"T01": turned(camera, two["T01"])}) == []
    lost = replace(good["T01"], likelihood=np.zeros((90, 5)))
    assert half_turn_regression_sums(camera, lost, DEPTH_M) == {}
    assert warnings(camera, good | {"T01": lost}) == []


def test_check_names_the_file(tmp_path):
    keypoint_study(published_model_design(), tmp_path / "study", tmp_path / "truth")
    file = tmp_path / "study/keypoints/T10.csv"
    assert "180 degrees" not in CliRunner().invoke(main, ["check", str(tmp_path / "study")]).output
    lines = file.read_text().splitlines()
    size = load_study(tmp_path / "study").setup.camera.image_size_px
    for k in range(3, len(lines)):
        cells = lines[k].split(",")
        for axis in (0, 1):
            at = slice(1 + axis, None, 3)
            cells[at] = [f"{size[axis] - 1 - float(v):.4f}" if v else "" for v in cells[at]]
        lines[k] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")
    shown = CliRunner().invoke(main, ["check", str(tmp_path / "study")]).output
    assert "Trial T10: keypoints/T10.csv: found rigid lengths" in shown
    assert shown.count("turned by 180 degrees") == 1
