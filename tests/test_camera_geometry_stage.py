"""geometry.json and its figure: what a study's keypoints say about scale, depth and lens."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_campaign import GEOMETRY_JSON, exact_campaign

from bluekoi.camera import pool_camera
from bluekoi.camera.calibration_uncertainty import calibration_covariance_at_points
from bluekoi.camera.camera_error_displacement import camera_error_field_coefficients
from bluekoi.camera.rigid_length_warnings import rigid_length_warnings
from bluekoi.campaign import Campaign, load_campaign
from bluekoi.data import read_track
from bluekoi.figures import draw
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial, write_keypoints_csv
from bluekoi.stages.depth import keypoint_depth
from bluekoi.stages.geometry import geometry
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.result_paths import ResultPaths
from bluekoi.stages.tracks import tracks
from bluekoi.study import load_study
from small_studies import SMALL_STUDY_TRIALS, small_study


def with_study_change(study: Path, change) -> None:
    path = study / "study.yaml"
    content = yaml.safe_load(path.read_text())
    change(content)
    path.write_text(yaml.safe_dump(content))


@pytest.fixture(scope="module")
def detected_study(tmp_path_factory):
    """A study of three trials, its keypoints read."""
    root = tmp_path_factory.mktemp("geometry")
    study = small_study(root / "study")
    for trial in SMALL_STUDY_TRIALS:
        keypoints(study, root / "results", trial)
    return study, root / "results"


def geometry_json(study: Path, results: Path) -> dict:
    geometry(study, results)
    return json.loads((results / "geometry.json").read_text())


def test_a_right_study_has_scale_one_and_its_depth_as_given(detected_study):
    found = geometry_json(*detected_study)
    assert found["scale"] == pytest.approx(1.0, abs=max(4 * found["scale_std"], 0.001))
    assert 0 < found["scale_std"] < 0.01
    assert found["depth_given"]
    assert found["depth_m"] == 0.04
    assert found["likely"] == "nothing"
    assert found["trials"] == 3
    assert np.shape(found["map"]["excess"]) == np.shape(found["map"]["model"])


def test_keypoints_placed_at_stated_lengths_measure_none(detected_study, tmp_path):
    """The silhouette's lie where study.yaml has them: that they agree with it says nothing."""
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    notes = [
        ResultPaths(tmp_path / "results").detection_status(name) for name in SMALL_STUDY_TRIALS
    ]
    for count, note in enumerate(notes, start=1):
        note.write_text(json.dumps(json.loads(note.read_text()) | {"source": "silhouette"}))
        found = geometry_json(study, tmp_path / "results")
        assert found.get("trials", 0) == len(notes) - count
    assert (found["scale"], found["likely"]) == (None, "unknown")
    assert "lengths of study.yaml" in found["sentence"]
    assert found["windows"] is None


def silhouette_keypoints(found: Path, lengths: list[list[float]]) -> None:
    """Keypoints of all trials as a silhouette gives them, and the whole lengths that it saw."""
    for name in SMALL_STUDY_TRIALS:
        note = ResultPaths(found).detection_status(name)
        reported = {"source": "silhouette", "length_seen": lengths}
        note.write_text(json.dumps(json.loads(note.read_text()) | reported))


def measured_share_of_frames(share: float, spread: float) -> list[list[float]]:
    draw = np.random.default_rng(5).normal(share, spread, 40)
    return [[i, float(v)] for i, v in zip(range(0, 80, 2), draw, strict=True)]


@pytest.mark.parametrize("share", [0.97, 1.02])
def test_the_whole_length_of_a_silhouette_gives_the_scale(detected_study, tmp_path, share):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", measured_share_of_frames(share, 0.001))
    found = geometry_json(study, tmp_path / "results")
    assert found["scale"] == pytest.approx(share, abs=0.002)
    assert found["measured"] == "whole length"
    windows = found["windows"]
    shares = np.array(windows["excess_m"]) / np.array(windows["known_m"])
    assert shares == pytest.approx(share - 1, abs=0.003)


@pytest.mark.parametrize("sidecar", [True, False])
def test_keypoint_files_of_the_silhouette_detector_are_not_measured_lengths(
    detected_study, tmp_path, sidecar
):
    """Given as source of a study, they say no more of scale and lens than the video does."""
    study, results = detected_study
    again = tmp_path / "study"
    shutil.copytree(study, again)
    for trial in load_study(study).trials:
        given = read_keypoints_of_trial(ResultPaths(results).keypoints(trial.trial_id), trial, {})
        lengths = np.random.default_rng(5).normal(0.97, 0.001, len(given.time_s))
        path = again / trial.source
        length_m = load_study(study).setup.robot.whole_length_m(trial.head_length_m)
        write_keypoints_csv(path, replace(given, length_seen=lengths), "silhouette",
                            stated_length_m=length_m)  # fmt: skip
        if not sidecar:
            path.with_suffix(".cov.csv").unlink()
        keypoints(again, tmp_path / "results", trial.trial_id)
    found = geometry_json(again, tmp_path / "results")
    if sidecar:
        assert found["measured"] == "whole length"
        assert found["scale"] == pytest.approx(0.97, abs=0.002)
    else:
        assert (found["scale"], found["likely"]) == (None, "unknown")
        assert "lengths of study.yaml" in found["sentence"]
        assert not rigid_length_warnings(found, None)


def test_whole_lengths_a_little_off_show_no_error(detected_study, tmp_path):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", measured_share_of_frames(0.9975, 0.001))
    assert geometry_json(study, tmp_path / "results")["likely"] == "nothing"


@pytest.mark.parametrize(
    "lengths", [measured_share_of_frames(0.97, 0.02), measured_share_of_frames(0.97, 0.001)[:9], []]
)
def test_a_smeared_tail_or_few_frames_give_no_length(detected_study, tmp_path, lengths):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", lengths)
    found = geometry_json(study, tmp_path / "results")
    assert (found["scale"], found["likely"], found["windows"]) == (None, "unknown", None)


def test_a_body_whose_tail_ends_far_from_where_it_is_stated_gives_a_warning(
    detected_study, tmp_path
):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", [])
    (warning,) = rigid_length_warnings(geometry_json(study, tmp_path / "results"), None)
    assert "measure body_length_m" in warning
    silhouette_keypoints(tmp_path / "results", measured_share_of_frames(1.0, 0.001))
    assert not rigid_length_warnings(geometry_json(study, tmp_path / "results"), None)


def test_a_length_is_no_surer_than_pixels_and_exposure_let_it_be(detected_study, tmp_path):
    """Half a pixel of the body's length where nothing is wrong, and more where frames differ."""
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    least = []
    for spread in (0.0005, 0.004):
        silhouette_keypoints(tmp_path / "results", measured_share_of_frames(0.995, spread))
        found = geometry_json(study, tmp_path / "results")
        least.append(found["min_share"])
        assert found["likely"] == "nothing"
    assert 0.003 < least[0] < 0.0045 < least[1]


def test_lengths_of_two_trials_are_too_few(detected_study, tmp_path):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", measured_share_of_frames(0.97, 0.001))
    note = ResultPaths(tmp_path / "results").detection_status(next(iter(SMALL_STUDY_TRIALS)))
    note.write_text(json.dumps(json.loads(note.read_text()) | {"length_seen": []}))
    found = geometry_json(study, tmp_path / "results")
    assert (found["scale"], found["likely"]) == (None, "unknown")
    assert "2 trials" in found["sentence"]


def test_frames_that_are_not_believed_give_no_length(detected_study, tmp_path):
    study, results = detected_study
    shutil.copytree(results, tmp_path / "results")
    silhouette_keypoints(tmp_path / "results", measured_share_of_frames(0.97, 0.001))
    for name in SMALL_STUDY_TRIALS:
        path = ResultPaths(tmp_path / "results").keypoints(name)
        given = read_keypoints_of_trial(path, load_study(study).trial(name), {})
        write_keypoints_csv(path, replace(given, likelihood=np.full_like(given.likelihood, 0.2)))
    assert geometry_json(study, tmp_path / "results")["likely"] == "unknown"


def test_a_pool_stated_too_short_shows_in_the_scale(detected_study, tmp_path):
    study, results = detected_study
    copy = tmp_path / "study"
    copy.mkdir()
    for name in ("study.yaml", "trials.csv"):
        (copy / name).write_bytes((study / name).read_bytes())

    def shorten(content):
        content["pool"]["length_m"] *= 0.97
        content["pool"]["width_m"] *= 0.97

    with_study_change(copy, shorten)
    found = geometry_json(copy, results)
    assert found["scale"] == pytest.approx(0.97, abs=0.006)
    assert found["likely"] != "nothing"
    assert "scale_error" in {found["likely"], *found["rivals"]}
    geometry_json(study, results)


def test_depth_that_is_not_given_is_estimated_and_used(detected_study, tmp_path):
    study, results = detected_study
    copy = tmp_path / "study"
    copy.mkdir()
    for name in ("study.yaml", "trials.csv"):
        (copy / name).write_bytes((study / name).read_bytes())
    with_study_change(copy, lambda content: content["robot"].pop("keypoint_depth_m"))
    found = geometry_json(copy, results)
    assert not found["depth_given"]
    std = found["depth_estimate_std_m"]
    assert found["depth_estimate_m"] == pytest.approx(0.04, abs=4 * std)
    taken = round(found["depth_estimate_m"], 3) if std < 0.01 else 0.04
    assert found["depth_m"] == pytest.approx(taken)
    assert keypoint_depth(load_study(copy).setup, ResultPaths(results)) == pytest.approx(taken)
    geometry_json(study, results)


def test_an_estimated_depth_reaches_the_patterns_of_lens_and_refraction(detected_study, tmp_path):
    study, _ = detected_study
    copy = tmp_path / "study"
    copy.mkdir()
    for name in ("study.yaml", "trials.csv"):
        (copy / name).write_bytes((study / name).read_bytes())
    with_study_change(copy, lambda content: content["robot"].pop("keypoint_depth_m"))
    (tmp_path / "geometry.json").write_text(json.dumps({"depth_m": 0.09}))
    setup = load_campaign(tmp_path, load_study(copy)).study.setup
    assert (setup.robot.keypoint_depth_m, setup.robot.keypoint_depth_given) == (0.09, False)
    assert camera_error_field_coefficients(setup) != camera_error_field_coefficients(
        load_study(copy).setup
    )
    given = load_campaign(tmp_path, load_study(study)).study.setup
    assert given.robot.keypoint_depth_m == 0.04


def test_no_keypoints_at_all_are_said_and_stop_nothing(tmp_path):
    study = small_study(tmp_path / "study")
    for name in SMALL_STUDY_TRIALS:
        (study / f"keypoints/{name}.csv").write_text("")
        keypoints(study, tmp_path / "results", name)
    found = geometry_json(study, tmp_path / "results")
    assert found["likely"] == "unknown"
    assert found["scale"] is None
    assert "could not be checked" in found["sentence"]


def test_stated_deviations_of_positions_hold_the_calibrations(detected_study):
    study, results = detected_study
    tracks(study, results, SMALL_STUDY_TRIALS[0])
    track = read_track(ResultPaths(results).track(SMALL_STUDY_TRIALS[0]))
    camera = pool_camera(load_study(study).setup, None)
    xy = np.column_stack([track.x_m, track.y_m])
    cov = calibration_covariance_at_points(camera, xy, 0.04)
    assert (track.x_m_std**2 > cov[:, 0, 0]).all()
    assert (track.y_m_std**2 > cov[:, 1, 1]).all()
    assert (cov[:, 0, 0] > 0).all()


def test_the_figure_shows_the_map_and_the_hypotheses():
    base = exact_campaign()
    figure = draw("geometry", Campaign(**{**base.__dict__, "geometry": GEOMETRY_JSON}))
    left, middle, right = figure.axes[:3]
    assert left.collections[0].get_array().compressed() == pytest.approx([-1.4, -1.6])
    assert middle.get_title() == "likeliest source: scale error"
    assert [t.get_text() for t in right.get_yticklabels()] == ["scale error"]
    assert "-1.50 +- 0.20 %" in figure.get_suptitle()
    assert "keypoint depth 40 mm, from study.yaml" in figure.get_suptitle()


def test_the_figure_says_when_there_is_no_map():
    nothing = {**GEOMETRY_JSON, "map": None, "sentence": "no trial with keypoints"}
    base = exact_campaign()
    figure = draw("geometry", Campaign(**{**base.__dict__, "geometry": nothing}))
    assert "no trial with" in figure.axes[0].texts[-1].get_text()
