"""A trial that contradicts its row of trials.csv is refused with a message; the others go on."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_campaign import exact_campaign

from bluekoi.camera import pool_camera
from bluekoi.camera.pool_edge_check import deviating_edge_warnings
from bluekoi.camera.rigid_length_warnings import MIN_LENGTH_ERROR_SHARE, rigid_length_warnings
from bluekoi.campaign import Campaign
from bluekoi.cli import main
from bluekoi.data import FlappingFrequency, Pose, SteadyState, Track
from bluekoi.data.majority_deviation import deviations_from_majority
from bluekoi.errors import InputError
from bluekoi.files import read_json
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial, write_keypoints_csv
from bluekoi.motor import (
    flapping_compared_with_video,
    trial_flapping,
    video_to_motor_frequency_ratio,
)
from bluekoi.motor.power_consistency import power_warnings
from bluekoi.pose import rigid_pose
from bluekoi.pose.plausibility import checked_rigid_pose, first_jump, plausibility_findings
from bluekoi.pose.trial_comparison import comparison_warnings
from bluekoi.preparation.input_check import check_files, file_findings
from bluekoi.stages.geometry import geometry
from bluekoi.stages.head_angle_sign import head_angle_sign_finding
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.tracks import _with_clock_remark, tracks
from bluekoi.stages.trial_exclusion import (
    contradicted_trials,
    contradiction_warning,
    few_trials_warning,
)
from bluekoi.stages.tuning import campaign_flapping, campaign_series
from bluekoi.study import load_study, missing_files_of_trial
from bluekoi.study.setup_warnings import inertia_warnings, setup_warnings
from bluekoi.trial_warnings import trial_warnings, unchecked_frame_rate_notes
from small_studies import edit_trials_csv, mapped_turn, small_study


@pytest.fixture(scope="module")
def study_with_turn(tmp_path_factory):
    """A study with three good trials and the positions of its turn T10 (30 degrees, 1x head)."""
    return mapped_turn(load_study(small_study(tmp_path_factory.mktemp("plausible") / "study")))


def finding_messages(study, trial, positions):
    pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
    return [str(one) for one in plausibility_findings(study, trial, positions, pose)]


def test_a_good_trial_passes(study_with_turn):
    assert finding_messages(*study_with_turn) == []


def test_scale_errors_are_left_to_the_search(study_with_turn):
    study, trial, positions = study_with_turn
    assert finding_messages(study, trial, replace(positions, xy_m=1.2 * positions.xy_m)) == []


@pytest.mark.parametrize("size", [0.2, 1.0, 5.0])
@pytest.mark.parametrize(("body_lengths", "accepted"), [(0.05, True), (0.08, False)])
def test_misplaced_keypoints_are_judged_by_the_size_of_the_robot(
    study_with_turn, size, body_lengths, accepted
):
    study, trial, positions = study_with_turn
    setup = study.setup
    lengths = {name: size * getattr(setup.robot, name)
               for name in ("body_length_m", "head_length_m", "head_span_m", "hinge_to_com_m",
                            "tail_length_m", "keypoint_depth_m")}  # fmt: skip
    sides = {name: size * getattr(setup.pool, name) for name in ("length_m", "width_m", "depth_m")}
    robot = setup.robot.model_copy(update=lengths)
    scaled = setup.model_copy(update={"robot": robot, "pool": setup.pool.model_copy(update=sides)})
    xy = size * positions.xy_m
    core, hinge = (positions.names.index(name) for name in ("core_center", "hinge"))
    along = xy[:, core] - xy[:, hinge]
    along /= np.linalg.norm(along, axis=1)[:, None]
    xy[:, core] += body_lengths * robot.body_length_m * along
    found = finding_messages(
        study.model_copy(update={"setup": scaled}),
        trial.model_copy(update={"head_length_m": size * trial.head_length_m}),
        replace(positions, xy_m=xy),
    )
    assert any("hinge to core_center" in text for text in found) != accepted


def test_another_head_s_length_is_named(study_with_turn):
    study, trial, positions = study_with_turn
    (text,) = finding_messages(study, trial.model_copy(update={"head_length_m": 0.175}), positions)
    assert "head_tip to hinge of 120 mm; expected 175 mm" in text.replace(" in the pool", "")


def test_the_wrong_side_is_named(study_with_turn):
    study, trial, positions = study_with_turn
    (text,) = finding_messages(study, trial.model_copy(update={"head_angle_deg": -30.0}), positions)
    assert "a head angle of 30 degrees" in text
    assert "expected head_angle_deg -30" in text
    assert "The sign is the other one: change it in trials.csv" in text
    assert "are x and y exchanged" in text
    (text,) = finding_messages(study, trial.model_copy(update={"head_angle_deg": -60.0}), positions)
    assert "Is it another trial's row?" in text


def test_a_filmed_trial_that_is_right_with_the_other_sign_is_told_so(study_with_turn, monkeypatch):
    """The robot in the picture has its head at 30 degrees."""
    study, trial, _ = study_with_turn
    found = read_keypoints_of_trial(study.paths(trial)[0], trial, study.setup.bodyparts)
    asked = []

    def detect(study, trial, threads):
        asked.append(trial.head_angle_deg)
        return found, {}

    monkeypatch.setattr("bluekoi.stages.head_angle_sign.detect_in_footage", detect)
    camera, depth = pool_camera(study.setup), study.setup.robot.keypoint_depth_m

    def finding(angle: float, **changed):
        other = {"source": "v.mp4", "head_angle_deg": angle, **changed}
        return head_angle_sign_finding(study, trial.model_copy(update=other), camera, depth)

    text = str(finding(-30.0))
    assert "trial T10, column head_angle_deg: found -30" in text
    assert "Change the sign" in text
    assert asked == [30]
    assert finding(-60.0) is None
    assert finding(-30.0, head_length_m=0.175) is None
    assert finding(0.0) is None
    assert finding(-30.0, source=trial.source) is None
    assert asked == [30, 60, 30]


def test_exchanged_keypoints_are_named(study_with_turn):
    study, trial, positions = study_with_turn
    names = ("tail_base", "core_center", "hinge", "head_tip", "tail_tip")
    texts = finding_messages(study, trial, replace(positions, names=names))
    assert "core_center to tail_base of 120 mm" in " ".join(texts)
    assert "each keypoint bear its own name" in texts[0]


def test_a_cut_in_the_recording_is_named(study_with_turn):
    study, trial, positions = study_with_turn
    xy = positions.xy_m.copy()
    xy[60:] += (0.3, 0.1)
    (text,) = finding_messages(study, trial, replace(positions, xy_m=xy))
    assert "jumps 0.3" in text
    assert "keypoints/T10.csv" in text


def test_hinge_and_core_exchanged_are_named_though_their_distance_is_right(study_with_turn):
    study, trial, positions = study_with_turn
    names = ("head_tip", "core_center", "hinge", "tail_base", "tail_tip")
    assert set(names) == set(positions.names)
    texts = finding_messages(study, trial, replace(positions, names=names))
    assert any("hinge, core_center and tail_base in another order" in text for text in texts)


def test_a_slow_robot_at_a_much_too_high_frame_rate_does_not_swim_backwards(study_with_turn):
    """Steps between frames are then noise, which has no direction."""
    study, trial, positions = study_with_turn
    noise = np.random.default_rng(3).normal(0, 4e-3, positions.xy_m.shape)
    fast = replace(positions, xy_m=positions.xy_m + noise, time_s=positions.time_s / 64)
    pose = rigid_pose(fast, study.setup.robot, trial.head_length_m)
    assert [
        str(f) for f in plausibility_findings(study, trial, fast, pose) if "backwards" in str(f)
    ] == []


def test_a_robot_that_swims_backwards_is_named(study_with_turn):
    study, trial, positions = study_with_turn
    back = replace(positions, xy_m=positions.xy_m[::-1].copy())
    assert "a robot that swims backwards for 1." in finding_messages(study, trial, back)[0]


def test_an_outlier_that_comes_back_or_a_gap_is_no_jump():
    t = np.arange(100) / 30
    way = np.column_stack([0.5 * t, 0 * t])
    assert first_jump(t, way, 0.15) is None
    spike = way.copy()
    spike[40] += 1.0
    assert first_jump(t, spike, 0.15) is None
    kept = (t < 1) | (t > 2)
    assert first_jump(t[kept], way[kept], 0.15) is None
    cut = way + np.where(t > 1.5, 0.4, 0)[:, None]
    assert first_jump(t, cut, 0.15) == 45


def test_a_frame_rate_that_is_double_is_remarked(study_with_turn):
    study, trial, positions = study_with_turn
    assert trial_flapping(study, trial, positions).agrees
    fast = replace(positions, time_s=positions.time_s / 2)
    found = trial_flapping(study, trial, fast)
    assert not found.agrees
    assert found.ratio == pytest.approx(2.0, rel=1e-3)
    assert f"motor = {found.ratio:.4f}" in found.remarks[-1]
    assert "check fps" in found.remarks[-1]


def test_noise_without_a_beat_gives_no_ratio_of_clocks(study_with_turn):
    _, _, positions = study_with_turn
    motor = FlappingFrequency(5.0, 0.01, "motor_log")
    for seed in range(10):
        noise = np.random.default_rng(seed).normal(0, 5e-4, positions.xy_m.shape)
        still = replace(positions, xy_m=positions.xy_m[:1] + noise)
        assert np.isnan(video_to_motor_frequency_ratio(still, motor)).all()


def test_a_robot_that_never_moved_and_another_s_log_are_kept_from_the_fits():
    base = exact_campaign(powers=(100,))
    poses = {name: _pose_of_track(track) for name, track in base.tracks.items()}
    still = base.analysed[0].trial_id
    flap = {"flap_hz": 5.8, "flap_hz_std": 0.01, "source": "motor_log", "video_hz": None,
            "video_hz_std": None, "agrees": True}  # fmt: skip
    statuses = {name: {"ok": True, "flapping": flap} for name in base.tracks}
    odd = base.analysed[-1].trial_id
    statuses[odd] = {"ok": True, "flapping": {**flap, "agrees": False}}
    steady = {**base.steady, still: replace(base.steady[still], quality="no_data")}
    given = replace(base, poses=poses, statuses=statuses, steady=steady)
    used = [s.name for s in campaign_series(given)]
    assert used == [trial.trial_id for trial in base.analysed[1:-1]]


def test_trials_that_agree_on_a_wrong_clock_stay_in_the_fits():
    base = exact_campaign(powers=(100,))
    poses = {name: _pose_of_track(track) for name, track in base.tracks.items()}
    flap = {"flap_hz": 5.8, "flap_hz_std": 0.01, "source": "motor_log", "video_hz": None,
            "video_hz_std": None, "ratio": 4.0, "ratio_std": 1e-3, "agrees": False}  # fmt: skip
    statuses = {name: {"ok": True, "flapping": flap} for name in base.tracks}
    odd = base.analysed[-1].trial_id
    right = {**flap, "video_hz": 5.8, "video_hz_std": 0.001, "ratio": 1.0, "agrees": True}
    statuses[odd] = {"ok": True, "flapping": right}
    used = [s.name for s in campaign_series(replace(base, poses=poses, statuses=statuses))]
    assert used == [trial.trial_id for trial in base.analysed[:-1]]


def exact_campaign_with_statuses(**of_last_trial) -> Campaign:
    """Exact trials whose statuses agree with trials.csv; those of the last one are given."""
    base = exact_campaign(powers=(100,))
    flap = {"flap_hz": 5.8, "flap_hz_std": 0.01, "source": "motor_log", "video_hz": None,
            "video_hz_std": None, "agrees": True}  # fmt: skip
    statuses = {
        t.trial_id: {"ok": True, "flapping": flap,
                     "body": {"head_angle_deg": t.head_angle_deg, "length_ratios": {}}}
        for t in base.analysed
    }  # fmt: skip
    last = base.analysed[-1].trial_id
    statuses[last] = statuses[last] | of_last_trial
    poses = {name: _pose_of_track(track) for name, track in base.tracks.items()}
    return replace(base, poses=poses, statuses=statuses)


def test_a_trial_with_another_head_angle_than_stated_is_kept_from_the_fits():
    right = exact_campaign_with_statuses()
    last = right.analysed[-1]
    body = {"head_angle_deg": last.head_angle_deg + 2.5, "length_ratios": {}}
    given = exact_campaign_with_statuses(body=body)
    flapping = campaign_flapping(given)
    assert contradicted_trials(given, flapping) == {last.trial_id: "head angle"}
    assert [s.name for s in campaign_series(given)] == [t.trial_id for t in right.analysed[:-1]]
    warning = contradiction_warning(contradicted_trials(given, flapping))
    assert f"contradicts trials.csv: {last.trial_id} (head angle)" in warning
    assert contradicted_trials(right, campaign_flapping(right)) == {}
    assert contradiction_warning({}) == ""


def test_a_verdict_on_a_minority_of_the_trials_says_so():
    assert few_trials_warning(12, 4, 24) == ""
    assert "9 of 24 trials, none with a turned head" in few_trials_warning(9, 0, 24)
    assert "11 of 24 trials, 2 of them with a turned head" in few_trials_warning(11, 2, 24)


def test_a_trial_with_other_body_lengths_is_kept_from_the_fits():
    right = exact_campaign_with_statuses()
    last = right.analysed[-1].trial_id
    lengths = {t.trial_id: {"excess": 1e-4 * k, "std": 1e-4, "number": k}
               for k, t in enumerate(right.analysed)}  # fmt: skip
    slightly, much = (
        replace(right, geometry={"by_trial": lengths | {last: {"excess": x, "std": 1e-4}}})
        for x in (0.015, -0.1)
    )
    assert contradicted_trials(slightly, campaign_flapping(slightly)) == {}
    assert contradicted_trials(much, campaign_flapping(much)) == {last: "rigid lengths"}


def test_a_zoomed_picture_is_kept_from_the_fits():
    """No end of the tail where the others have it, and edges of the pool elsewhere."""
    right = exact_campaign_with_statuses()
    last = right.analysed[-1].trial_id

    def with_edges(off_m: float) -> Campaign:
        edges = {i: {"off_m": off_m if i == last else 1e-3, "off_std_m": 2e-4, "moved": False}
                 for i in right.statuses}  # fmt: skip
        statuses = {i: s | {"pool_edges": edges[i]} for i, s in right.statuses.items()}
        return replace(right, statuses=statuses, geometry={"trials_without_tail_end": [last]})

    zoomed, dark = with_edges(12e-3), with_edges(2e-3)
    assert contradicted_trials(zoomed, campaign_flapping(zoomed)) == {last: "edges of the pool"}
    assert contradicted_trials(dark, campaign_flapping(dark)) == {}
    edges, *_ = deviating_edge_warnings(zoomed.statuses, zoomed.study.setup.pool)
    assert edges.startswith(f"Trial {last}: the pool's edges lie up to 12 mm from the corners")
    assert "in most other recordings 1 mm" in edges
    assert list(deviating_edge_warnings(dark.statuses, dark.study.setup.pool)) == []
    (tail,) = rigid_length_warnings(zoomed.geometry, None)
    assert tail.startswith(f"Trial {last}: no frame shows the end of the robot's tail")
    assert rigid_length_warnings(zoomed.geometry, None, failed=[last]) == []


def test_where_half_of_the_trials_contradict_the_table_none_is_kept_from_the_fits():
    right = exact_campaign_with_statuses()
    half = [t.trial_id for t in right.analysed[: (len(right.analysed) + 1) // 2]]
    statuses = {i: s | {"flapping": {**s["flapping"], "agrees": i not in half}}
                for i, s in right.statuses.items()}  # fmt: skip
    given = replace(right, statuses=statuses)
    assert contradicted_trials(given, campaign_flapping(given)) == {}


def _pose_of_track(track: Track) -> Pose:
    values = np.column_stack([track.x_m, track.y_m, track.heading_rad, track.head_angle_rad])
    cov = np.tile(np.diag([1e-6, 1e-6, 1e-5, 1e-5]), (len(values), 1, 1))
    return Pose(track.time_s, values, cov)


SLOW_STEADY_STATE = SteadyState(
    2.35, 0.24, 0.001, 0.4, 0.004, 40.0, 2.0, 4.0, "short_arc", "film for longer"
)


@pytest.mark.parametrize(("apart", "doubted"), [(2.0, True), (1.02, True), (1.004, False)])
def test_a_clock_that_is_wrong_is_the_reason_to_doubt_a_steady_state(apart, doubted):
    motor = FlappingFrequency(
        flap_hz=2.35, flap_hz_std=0.001, source="motor_log", remarks=("before",)
    )
    found = flapping_compared_with_video(motor, apart, 0.0006)
    assert not found.agrees
    reason = _with_clock_remark(SLOW_STEADY_STATE, found).reason
    assert ("clocks disagree" in reason) == doubted
    assert reason.endswith(SLOW_STEADY_STATE.reason)
    assert _with_clock_remark(SLOW_STEADY_STATE, motor) is SLOW_STEADY_STATE


def test_a_robot_outside_of_the_pool_is_named(study_with_turn):
    study, trial, positions = study_with_turn
    (text,) = finding_messages(
        study, trial, replace(positions, xy_m=positions.xy_m + np.array([2.0, 0.0]))
    )
    assert "a robot outside of the pool, near x = 3" in text
    assert "pool_corners_px those of this recording?" in text
    inside = replace(positions, xy_m=positions.xy_m + np.array([0.2, 0.0]))
    assert finding_messages(study, trial, inside) == []


def test_parts_in_one_place_give_no_pose_and_no_traceback(tmp_path):
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    path = study / "keypoints/T10.csv"
    head, rows = path.read_text().splitlines()[:3], path.read_text().splitlines()[3:]
    same = [",".join([r.split(",")[0], *(5 * r.split(",")[1:4])]) for r in rows]
    path.write_text("\n".join([*head, *same]) + "\n")
    keypoints(study, results, "T10")
    tracks(study, results, "T10")
    status = read_json(results / "status/T10.json")
    assert not status["ok"]
    assert "several parts in one place" in status["message"]
    assert "defect" not in status["message"]


def test_rigid_lengths_of_another_size_are_a_warning_unless_the_verdict_says_why():
    off = {"scale": 1.0068, "scale_std": 2e-4}
    (text,) = rigid_length_warnings(off, {"causes": []})
    assert "rigid lengths come out +0.7 +- 0.0 %" in text
    assert "refractive_index" in text
    assert rigid_length_warnings(off, {"causes": [{"name": "uncorrected_refraction"}]}) == []
    assert len(rigid_length_warnings(off, {"causes": [{"name": "sinking", "weight": 0.39}]})) == 1
    assert rigid_length_warnings({"scale": 1.004, "scale_std": 2e-4}, None) == []
    assert rigid_length_warnings({"scale": 1.05, "scale_std": 0.02}, None) == []
    assert (
        rigid_length_warnings(None, None)
        == rigid_length_warnings({"scale": None, "scale_std": None}, {})
        == []
    )


def test_an_error_of_the_camera_that_the_verdict_does_not_name_is_a_warning():
    found = {"likely": "camera_shift", "rivals": ["lens_error"], "sentence": "turned by 0.02 rad"}
    (text,) = rigid_length_warnings(found, {"causes": []})
    assert "shows camera_shift, which the verdict does not name: turned by 0.02 rad" in text
    assert rigid_length_warnings(found, {"causes": [{"name": "lens_error", "weight": 0.9}]}) == []
    assert rigid_length_warnings(found | {"likely": "keypoint_bias", "rivals": []}, None) == []


@pytest.mark.parametrize(
    ("index", "words"),
    [
        (1.0, "refractive_index is 1 in study.yaml, water has 1.333"),
        (1.333, "Check keypoint_depth_m and the water's depth; refractive_index is 1.333"),
    ],
)
def test_refraction_that_the_verdict_does_not_name_is_looked_for_in_its_keys(index, words):
    found = {"likely": "uncorrected_refraction", "rivals": [], "sentence": "index +0.233"}
    (text,) = rigid_length_warnings(found, {"causes": []}, index)
    assert words in text
    assert "pool_corners_px" not in text


SPEED_DEVIATIONS = np.array([-0.07, -0.03, 0.13, 0.05, -0.05, -0.10, 0.02, 0.17, -0.17]) * 1e-2


def test_up_to_half_of_the_trials_may_differ_from_the_others():
    std, least = np.full(9, 6e-4), MIN_LENGTH_ERROR_SHARE
    assert not deviations_from_majority(SPEED_DEVIATIONS, std, least).any()
    for wrong in ([3], [0, 2, 5, 7]):
        shares = SPEED_DEVIATIONS.copy()
        shares[wrong] += 0.015
        off = deviations_from_majority(shares, std, least)
        assert np.flatnonzero(off).tolist() == wrong
        assert off[wrong] == pytest.approx(0.015, abs=0.003)
    assert not deviations_from_majority(np.array([0.0, 0.1]), np.zeros(2), least).any()
    usual = np.random.default_rng(0).normal(0, 0.01, 9)
    assert not deviations_from_majority(usual, std, least).any()


def test_a_keypoint_file_of_another_camera_is_a_warning(tmp_path):
    """A picture zoomed by 3 %: as where one trial's file is turned, mirrored or cropped beside a
    lens that is not above the middle of the pool."""
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    path = study / "keypoints/T11.csv"
    head, rows = path.read_text().splitlines()[:3], path.read_text().splitlines()[3:]
    table = np.array([[float(v or "nan") for v in row.split(",")] for row in rows])
    for column, centre in ((1, 960), (2, 540)):
        table[:, column::3] = centre + 1.03 * (table[:, column::3] - centre)
    lines = [",".join(f"{v:.4f}" for v in row) for row in table]
    path.write_text("\n".join([*head, *lines]) + "\n")
    for trial in ("T09", "T10", "T11"):
        keypoints(study, results, trial)
    geometry(study, results)
    (text,) = rigid_length_warnings(read_json(results / "geometry.json"), {"causes": []})
    assert text.startswith("Trial T11: the robot's rigid lengths come out +3.")
    assert "turned, mirrored, cropped, zoomed" in text


def test_a_stated_frequency_that_contradicts_the_log_is_refused(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T10={"flap_hz": "2.0"}, T11={"flap_hz": "5.9"})
    (finding,) = file_findings(load_study(study))
    assert str(finding).endswith(
        "trials.csv: trial T10, flap_hz: found 2; expected 5.84 Hz, as motor/T10.csv has it. Leave "
        "flap_hz empty where there is a log; is the log this trial's?"
    )


@pytest.mark.parametrize("density", [1e6, 0.998])
def test_a_density_that_is_no_liquid_s_is_refused(tmp_path, density):
    study = small_study(tmp_path / "study")
    path = study / "study.yaml"
    path.write_text(path.read_text().replace("1000.0", str(density)))
    with pytest.raises(InputError, match=r"water\.density_kg_m3"):
        load_study(study)


def make_flapping(**hz):
    return {name: {"ok": True, "flapping": {"flap_hz": value}} for name, value in hz.items()}


def test_a_power_that_does_not_go_with_the_flapping_frequency_is_a_warning():
    powers = {"A": 50.0, "B": 50.0, "C": 100.0, "D": 100.0}
    assert power_warnings(make_flapping(A=2.35, B=2.4, C=5.8, D=5.6), powers) == []
    wrong = make_flapping(A=2.35, B=5.8, C=5.8, D=5.6)
    (text,) = power_warnings(wrong, powers)
    assert text.startswith("Trials at 50 % power flap at 2.35 Hz (A) to 5.80 Hz (B).")
    (text,) = power_warnings(make_flapping(A=5.8, B=5.8, C=2.4, D=2.4), powers)
    assert "100 % power flap at 2.40 Hz, more slowly than those at 50 %" in text
    assert power_warnings({name: {"ok": False} for name in powers}, powers) == []


IMPOSSIBLE_BODIES = [
    {"mass_kg": 6.8},
    {"yaw_inertia_kg_m2": 0.0009},
    {"yaw_inertia_kg_m2": 0.0095 * 0.38},
    {"yaw_inertia_kg_m2": 0.0095 * 1.7},
]


@pytest.mark.parametrize("change", IMPOSSIBLE_BODIES)
def test_mass_and_inertia_that_are_not_one_body_s_are_a_warning(study_with_turn, change):
    study, _, _ = study_with_turn
    assert setup_warnings(study.setup) == []
    robot = study.setup.robot.model_copy(update=change)
    text, *_ = setup_warnings(study.setup.model_copy(update={"robot": robot}))
    assert "a radius of gyration of 0." in text
    assert "(expected: 0.19, a spindle, to 0.38, a rod with its mass at the ends" in text
    assert "all coefficients are proportional to mass_kg" in text


def test_a_cause_that_a_wrong_inertia_looks_like_asks_to_check_it(study_with_turn):
    robot = study_with_turn[0].setup.robot
    (text,) = inertia_warnings(robot, {"probabilities": {"thrust_line_offset": 0.72}})
    assert "study.yaml has 0.0095 kg m2 and 0.68 kg: check that both were measured" in text
    assert inertia_warnings(robot, {"probabilities": {"thrust_line_offset": 0.42}}) == []
    assert inertia_warnings(robot, {"probabilities": {"wave_drag": 0.9}}) == []
    assert inertia_warnings(robot, {}) == inertia_warnings(robot, None) == []


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_head_span_that_is_not_the_body_s_height_is_a_warning(study_with_turn, factor):
    """No motion shows it: coefficients of forces would come out inversely proportional."""
    study, _, _ = study_with_turn
    span = factor * study.setup.robot.head_span_m
    robot = study.setup.robot.model_copy(update={"head_span_m": span})
    (text,) = setup_warnings(study.setup.model_copy(update={"robot": robot}))
    assert f"head_span_m {span:g}" in text
    assert "inversely proportional to head_span_m" in text


def test_a_copied_recording_is_no_further_trial(tmp_path):
    study = small_study(tmp_path / "study")
    copy, original = study / "keypoints/T11.csv", study / "keypoints/T10.csv"
    copy.write_bytes(original.read_bytes())
    finding, *others = file_findings(load_study(study))
    assert "T11.csv, whole, as trial T10 has it (the same content as T10.csv)" in str(finding)
    assert all("found a head angle of 30 degrees" in str(other) for other in others)


def test_check_finds_what_a_run_would_refuse(tmp_path):
    """Lengths, sides and the clock of the log, before anything is computed."""
    study = small_study(tmp_path / "study")
    assert file_findings(load_study(study)) == []
    edit_trials_csv(study, T10={"head_angle_deg": "-30"}, T11={"head_length_m": "0.3"})
    log = study / "motor/T09.csv"
    header, *rows = log.read_text().split()
    shifted = (f"{float(t) + 1.7e9:.3f},{a}" for t, a in (row.split(",") for row in rows))
    log.write_text("\n".join([header, *shifted]) + "\n")
    said = [str(one) for one in file_findings(load_study(study))]
    for text in (
        "trial T10: found a head angle of 30 degrees",
        "trial T11: found head_tip to hinge of",
        "T09.csv: time_s: found times from 1700000000",
    ):
        assert any(text in one for one in said), text


def test_keypoints_outside_of_the_picture_are_named_as_such(tmp_path):
    study = small_study(tmp_path / "study")
    path = study / "keypoints/T10.csv"
    trial = load_study(study).trial("T10")
    found = read_keypoints_of_trial(path, trial)
    write_keypoints_csv(path, replace(found, xy_px=found.xy_px + np.array([2500.0, 0.0])))
    (finding,) = file_findings(load_study(study))
    assert "T10.csv: found 100 % of the points outside of the picture, such as" in str(finding)
    assert "pixels of a picture of 1920 x 1080" in str(finding)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda px: px / [1920.0, 1080.0], "found coordinates from 0.*multiply x by its width"),
        (lambda px: np.where(np.arange(len(px))[:, None, None] % 5, px, -1.0), r"place \(-1, -1\)"),
    ],
)
def test_numbers_that_are_no_pixels_are_named_as_such(tmp_path, change, message):
    study = small_study(tmp_path / "study")
    found = read_keypoints_of_trial(
        path := study / "keypoints/T10.csv", load_study(study).trial("T10")
    )
    write_keypoints_csv(path, replace(found, xy_px=change(found.xy_px)))
    (finding,) = file_findings(load_study(study))
    assert re.search(message, str(finding))


def test_lengths_that_contradict_a_hinge_stated_at_the_centre_of_mass_are_named(study_with_turn):
    study, trial, positions = study_with_turn
    robot = study.setup.robot.model_copy(update={"hinge_to_com_m": 0.0})
    wrong = study.model_copy(update={"setup": study.setup.model_copy(update={"robot": robot})})
    with pytest.raises(InputError, match=r"hinge to core_center of \d+ mm.*expected 0 mm"):
        checked_rigid_pose(wrong, trial, positions)


def test_check_warns_of_what_a_run_would_warn_of(tmp_path):
    """A motor log of another trial, and a motor that is said to stand still."""
    study = small_study(tmp_path / "study")
    log = study / "motor/T09.csv"
    assert "Warning" not in CliRunner().invoke(main, ["check", str(study)]).output
    content = log.read_bytes()
    header, *rows = log.read_text().split()
    slower = (f"{2.4 * float(t):.4f},{a}" for t, a in (row.split(",") for row in rows))
    log.write_text("\n".join([header, *slower]) + "\n")
    said = CliRunner().invoke(main, ["check", str(study)]).output
    assert "Warning: trial T09: the tail beats 2.4 times as fast in the video" in said
    assert "no other error found" in said
    log.write_bytes(content)
    edit_trials_csv(study, T09={"motor_log": "", "flap_hz": "0"})
    said = CliRunner().invoke(main, ["check", str(study)]).output
    assert re.search(r"Warning: trial T09: flap_hz is 0, but the tail beats at \d\.\d+ Hz", said)


def test_check_warns_beside_an_error_in_another_trial(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T09={"motor_log": "", "flap_hz": "0"})
    (study / "keypoints/T10.csv").write_text("scorer\n")
    said = CliRunner().invoke(main, ["check", str(study)])
    assert said.exit_code == 1
    assert "Warning: trial T09: flap_hz is 0, but the tail beats at" in said.output
    assert "T10.csv" in said.output


def test_a_flapping_frequency_that_no_robot_has_is_refused_with_its_row(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T09={"motor_log": "", "flap_hz": "1e-9"})
    with pytest.raises(InputError, match=r"T09\), flap_hz: found 1e-09; expected tail beats per s"):
        load_study(study)


def test_keypoints_that_repeat_are_named_as_such(study_with_turn):
    study, trial, positions = study_with_turn
    stopped = replace(positions, xy_m=positions.xy_m[np.arange(len(positions.xy_m)) // 20 * 20])
    with pytest.raises(InputError, match=r"that stay in place, to the last digit, in 9[0-9] %"):
        checked_rigid_pose(study, trial, stopped)


def test_a_log_of_a_part_of_the_recording_is_remarked(study_with_turn):
    study, trial, positions = study_with_turn
    assert not any("covers" in r for r in trial_flapping(study, trial, positions).remarks)
    longer = replace(positions, time_s=positions.time_s * 4)
    remarks = trial_flapping(study, trial, longer).remarks
    assert any("the motor log covers 2" in r and "% of the recording" in r for r in remarks)


def test_the_frame_rate_of_a_trial_without_a_log_is_checked_by_the_logs_of_its_power():
    powers = dict.fromkeys("ABC", 50.0)
    found = make_flapping(A=2.35, B=2.36, C=1.96)
    for name, source in (("A", "motor_log"), ("B", "motor_log"), ("C", "video")):
        found[name]["flapping"]["source"] = source
    (text,) = power_warnings(found, powers)
    assert text.startswith("Trial C, without a motor log, flaps 0.83 times as fast")
    assert "Check fps" in text
    found["C"]["flapping"]["source"] = "motor_log"
    assert power_warnings(found, powers)[0].startswith("Trials at 50 % power flap at 1.96 Hz (C)")


def test_powers_that_are_fractions_are_doubted():
    assert "is it a fraction? It is in percent" in power_warnings({}, {"A": 0.5, "B": 1.0})[0]
    assert power_warnings({}, {"A": 0.5, "B": 50.0}) == []
    assert power_warnings({}, {"A": 0.0}) == []


def test_what_is_found_in_place_of_a_file_is_named(tmp_path):
    study = load_study(small_study(tmp_path / "study"))
    (path,) = study.paths(study.trial("T10"))
    said = []
    for make in (path.mkdir, partial(os.mkfifo, path), partial(path.symlink_to, path.name)):
        path.rmdir() if path.is_dir() else path.unlink()
        make()
        said += [f.found for f in missing_files_of_trial(study, study.trial("T10"))]
    path.unlink()
    said += [f.found for f in missing_files_of_trial(study, study.trial("T10"))]
    name = "'keypoints/T10.csv'"
    assert said == [f"a folder {name}", f"a pipe or a device {name}, not a file",
                    f"a link {name} that leads nowhere", f"no file {name}"]  # fmt: skip


def warnings_of_check(study):
    return trial_warnings(loaded := load_study(study), check_files(loaded)[1])


def test_exchanged_files_of_two_trials_are_named(tmp_path):
    """Angles of 15 and 30 degrees at one power: each trial alone is within what is refused."""
    study = small_study(tmp_path / "study")
    assert not any("Are their files exchanged" in text for text in warnings_of_check(study))
    angles = {t.trial_id: t.head_angle_deg for t in load_study(study).trials}
    other = f"{angles['T10'] - 15:g}"
    statuses = {
        name: {"ok": True, "body": {"head_angle_deg": seen, "length_ratios": {}}}
        for name, seen in (("T09", angles["T09"]), ("T10", float(other)), ("T11", angles["T10"]))
    }
    edit_trials_csv(study, T11={"head_angle_deg": other})
    one, two = comparison_warnings(load_study(study), statuses)
    assert one.startswith("Trial T10: the head is turned by 15 degrees, as trial T11 states")
    assert two.startswith("Trial T11: the head is turned by 30 degrees, as trial T10 states")
    assert one.endswith("Are their files exchanged?")


def test_a_head_angle_that_only_one_trial_has_wrong_is_a_warning(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T10={"head_angle_deg": "20"})
    (text,) = (one for one in warnings_of_check(study) if "head is turned" in one)
    assert text.startswith("Trial T10: the head is turned by 30 degrees, head_angle_deg is 20")


@pytest.mark.parametrize(
    ("seen_deg", "question"),
    [(15.0, "Is it the file of another trial?"), (34.0, "is the camera's")],
)
def test_only_an_angle_that_another_trial_states_may_be_that_trials_file(
    tmp_path, seen_deg, question
):
    """A wrong lens turns the head by a few degrees more or less than it was, in some trials."""
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T11={"head_angle_deg": "15"})
    loaded = load_study(study)
    stated = {t.trial_id: t.head_angle_deg for t in loaded.trials}
    seen = {"T09": stated["T09"], "T10": seen_deg, "T11": 15.0}
    statuses = {name: {"ok": True, "body": {"head_angle_deg": angle, "length_ratios": {}}}
                for name, angle in seen.items()}  # fmt: skip
    (text,) = comparison_warnings(loaded, statuses)
    assert text.startswith(f"Trial T10: the head is turned by {seen_deg:g} degrees")
    assert question in text


def test_a_part_of_a_recording_is_no_further_trial(tmp_path):
    study = small_study(tmp_path / "study")
    header, *rows = (study / "keypoints/T10.csv").read_text().splitlines(keepends=True)
    (study / "keypoints/T11.csv").write_text("".join([header, *rows[:2], *rows[40:]]))
    (study / "keypoints/T11.cov.csv").unlink(missing_ok=True)
    edit_trials_csv(study, T11={"head_angle_deg": "30", "head_length_m": "0.12", "power_pct": "50"})
    (text,) = (one for one in warnings_of_check(study) if "its frames" in one)
    assert text.startswith("Trial T11: many of its frames have the keypoints of trial T10")


def test_a_wrong_head_length_of_the_robot_is_found_by_check(tmp_path):
    study = small_study(tmp_path / "study")
    assert not any("on the scale of the other parts" in text for text in warnings_of_check(study))
    path = study / "study.yaml"
    content = yaml.safe_load(path.read_text())
    content["robot"]["head_length_m"] -= 0.02
    path.write_text(yaml.safe_dump(content))
    (text,) = (one for one in warnings_of_check(study) if "on the scale" in one)
    assert text.startswith("core_center to tail_base measures")
    assert "robot.body_length_m - robot.head_length_m - robot.hinge_to_com_m" in text


def test_heads_that_are_all_stated_a_centimetre_too_long_are_a_warning(tmp_path):
    study = small_study(tmp_path / "study")
    path = study / "study.yaml"
    content = yaml.safe_load(path.read_text())
    content["robot"]["head_length_m"] += 0.01
    path.write_text(yaml.safe_dump(content))
    lengths = {t.trial_id: f"{t.head_length_m + 0.01:g}" for t in load_study(study).trials}
    edit_trials_csv(study, **{name: {"head_length_m": head} for name, head in lengths.items()})
    found = [one for one in warnings_of_check(study) if "on the scale" in one]
    assert any("head_length_m in trials.csv" in text for text in found)


def test_a_log_that_covers_little_of_a_recording_is_a_warning(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T10={"fps": "1"})
    statuses = {"T10": {"ok": True, "logged_share": 0.03}, "T11": {"ok": True, "logged_share": 1.0}}
    (text,) = trial_warnings(load_study(study), statuses)
    assert text.startswith("trial T10: the motor log covers 3 % of the recording.")


def test_an_image_size_that_does_not_go_with_the_matrix_is_a_warning(study_with_turn):
    study, _, _ = study_with_turn
    camera = study.setup.camera
    width, height = camera.image_size_px
    larger = camera.model_copy(update={"image_size_px": (2 * width, 2 * height)})
    (text,) = setup_warnings(study.setup.model_copy(update={"camera": larger}))
    assert "25 % of the picture from the middle" in text


def test_a_track_that_is_interpolated_in_most_frames_is_a_warning(tmp_path):
    study = load_study(small_study(tmp_path / "study"))
    shares = {"T09": 0.9, "T10": 0.08}
    statuses = {name: {"ok": True, "body": {"head_angle_deg": 0.0, "length_ratios": {},
                                            "pose_share": share}}
                for name, share in shares.items()}  # fmt: skip
    (text,) = (t for t in comparison_warnings(study, statuses) if "interpolated" in t)
    assert text.startswith("Trial T10: 8 % of the frames show a pose")


@pytest.mark.parametrize(("index", "warned"), [(1.0, 1), (1.45, 1), (1.334, 0), (1.341, 0)])
def test_a_refractive_index_that_is_not_that_of_water_is_a_warning(tmp_path, index, warned):
    setup = load_study(small_study(tmp_path / "study")).setup
    water = setup.water.model_copy(update={"refractive_index": index})
    found = setup_warnings(setup.model_copy(update={"water": water}))
    assert [text.startswith(f"refractive_index is {index:g}") for text in found] == [True] * warned


def test_check_says_where_nothing_can_check_the_frame_rate(tmp_path):
    study = small_study(tmp_path / "study")
    assert "nothing can check fps" not in CliRunner().invoke(main, ["check", str(study)]).output
    edit_trials_csv(
        study, **{name: {"motor_log": "", "flap_hz": ""} for name in ("T09", "T10", "T11")}
    )
    found = CliRunner().invoke(main, ["check", str(study)])
    assert found.exit_code == 0, found.output
    assert "No trial has a motor_log or flap_hz: nothing can check fps." in found.output


def test_a_run_without_any_clock_says_so_in_its_outcome(tmp_path):
    study = load_study(small_study(tmp_path / "study"))
    assert unchecked_frame_rate_notes(study, {}) == []
    bare = [t.model_copy(update={"motor_log": None, "flap_hz": None}) for t in study.trials]
    (text,) = unchecked_frame_rate_notes(study.model_copy(update={"trials": tuple(bare)}), {})
    assert text.startswith("No trial has a motor_log or flap_hz: nothing can check fps.")


def test_a_stated_frequency_without_log_and_tail_beat_is_called_unchecked(tmp_path):
    """A flap_hz of twice the true frequency makes C_T a quarter; nothing else shows it."""
    study = load_study(small_study(tmp_path / "study"))
    stated = [t.model_copy(update={"motor_log": None, "flap_hz": 2.4}) for t in study.trials]
    bare = study.model_copy(update={"trials": tuple(stated)})
    unseen = {"T09": {"ok": True, "flapping": {"flap_hz": 2.4, "video_hz": None}}}
    seen = {**unseen, "T10": {"ok": True, "flapping": {"flap_hz": 2.4, "video_hz": 2.41}}}
    (text,) = unchecked_frame_rate_notes(bare, unseen)
    assert "nothing can check flap_hz" in text
    assert unchecked_frame_rate_notes(bare, seen) == unchecked_frame_rate_notes(study, unseen) == []


def test_a_depth_measured_from_the_floor_is_doubted(tmp_path):
    """0.26 m of 0.3 m of water; 0.04 m, from the surface, is usual."""
    setup = load_study(small_study(tmp_path / "study")).setup
    robot = setup.robot.model_copy(update={"keypoint_depth_m": 0.26})
    assert setup_warnings(setup) == []
    (text,) = setup_warnings(setup.model_copy(update={"robot": robot}))
    assert "Is it measured from the floor?" in text


@pytest.mark.parametrize(
    ("times", "warned"), [(0.5, True), (0.7, False), (3.5, False), (4.0, True)]
)
def test_a_robot_of_another_size_than_those_of_the_validation_is_a_warning(tmp_path, times, warned):
    """Similar robots, 0.331 m times a factor; 0.2 to 1.2 m were validated."""
    setup = load_study(small_study(tmp_path / "study")).setup
    robot = setup.robot
    powers = {"body_length_m": 1, "head_length_m": 1, "head_span_m": 1, "tail_length_m": 1,
              "hinge_to_com_m": 1, "mass_kg": 3, "yaw_inertia_kg_m2": 5}  # fmt: skip
    size = {name: getattr(robot, name) * times**power for name, power in powers.items()}
    found = setup_warnings(setup.model_copy(update={"robot": robot.model_copy(update=size)}))
    length = f"body_length_m {size['body_length_m']:g} is outside 0.2 to 1.2 m"
    assert [text.startswith(length) for text in found] == [True] * warned


def test_pictures_of_another_size_than_most_are_named(tmp_path):
    study = load_study(small_study(tmp_path / "study"))
    sizes = {"T09": [1920, 1080], "T10": [1920, 1080], "T11": [1280, 720]}
    statuses = {name: {"ok": True, "size_px": size} for name, size in sizes.items()}
    (text,) = [t for t in trial_warnings(study, statuses) if "px" in t]
    assert text.startswith("trial T11: pictures of 1280 x 720 px, in most other trials of 1920")
    alike = {name: {"ok": True, "size_px": [1920, 1080]} for name in sizes}
    assert not any("px" in t for t in trial_warnings(study, alike))
