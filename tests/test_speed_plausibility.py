"""Implausible speeds are detected without a motor log; no input ends in a traceback."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bluekoi.errors import InputError
from bluekoi.files import read_json, write_json
from bluekoi.motor import trial_flapping
from bluekoi.motor.swimming_plausibility import (
    PLAUSIBLE_RANGES,
    clock_and_length_warnings,
    dimensionless_swimming_numbers,
    implausible_numbers_text,
    tail_length_warnings,
)
from bluekoi.pose import rigid_pose
from bluekoi.pose.plausibility import plausibility_findings
from bluekoi.smoothing import smooth_pose
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.outcome import outcome
from bluekoi.stages.status import with_numerical_failures_explained
from bluekoi.stages.tracks import tracks
from bluekoi.steady import steady_state
from bluekoi.study import load_study
from small_studies import SMALL_STUDY_TRIALS, edit_trials_csv, mapped_turn, small_study

QUALITIES = {"good", "short_arc", "straight", "not_steady", "no_data"}


@pytest.fixture(scope="module")
def mapped_study(tmp_path_factory):
    """A study with its trial T10 mapped into the pool."""
    return mapped_turn(load_study(small_study(tmp_path_factory.mktemp("swimming") / "study")))


def analyse_trial(study, trial, positions):
    """Steady state and swimming numbers, as the stage makes them; InputError where refused."""
    flapping = trial_flapping(study, trial, positions)
    pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
    if wrong := plausibility_findings(study, trial, positions, pose):
        raise InputError(wrong)
    steady = steady_state(smooth_pose(pose, flapping.flap_hz), flapping, trial.head_angle_rad)
    return steady, dimensionless_swimming_numbers(steady, flapping, positions, study.setup.robot)


def test_the_small_study_swims_plausibly(mapped_study):
    _, numbers = analyse_trial(*mapped_study)
    assert implausible_numbers_text([numbers]) == ""
    assert numbers["strouhal"] == pytest.approx(0.7, abs=0.2)


@pytest.mark.parametrize("factor", [4.0, 8.0])
def test_a_clock_several_times_too_fast_is_noticed_without_a_motor_log(mapped_study, factor):
    study, trial, positions = mapped_study
    bare = trial.model_copy(update={"motor_log": None, "flap_hz": None})
    _, numbers = analyse_trial(study, bare, replace(positions, time_s=positions.time_s / factor))
    assert "Froude number" in implausible_numbers_text([numbers])


def test_strouhal_number_and_stride_from_the_video_do_not_depend_on_the_clock(mapped_study):
    study, trial, positions = mapped_study
    bare = trial.model_copy(update={"motor_log": None})
    numbers = [
        analyse_trial(study, bare, replace(positions, time_s=positions.time_s / k))[1]
        for k in (1, 2)
    ]
    for name in ("strouhal", "stride_lengths"):
        assert numbers[1][name] == pytest.approx(numbers[0][name], rel=0.05)


def test_four_times_the_frame_rate_in_all_trials_is_reported_with_the_factor(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, **{name: {"fps": "119.88"} for name in SMALL_STUDY_TRIALS})
    results = tmp_path / "results"
    for name in SMALL_STUDY_TRIALS:
        keypoints(study, results, name)
        tracks(study, results, name)
        status = read_json(results / "status" / f"{name}.json")
        assert status["flapping"]["ratio"] == pytest.approx(4.0, rel=1e-3)
        assert 0 < status["flapping"]["ratio_std"] < 0.01
        assert "clocks disagree" in " ".join(status["remarks"])
    assert outcome(study, results) == []
    (warning,) = read_json(results / "outcome.json")["warnings"]
    assert "all 3 trials: the tail beats 4 times as fast" in warning
    assert "clock_error" in warning


def status_with_ratio(ratio=None, flap_hz=2.0, **swimming):
    agrees = ratio is None or abs(ratio - 1) < 0.01
    flapping = {"ratio": ratio, "flap_hz": flap_hz, "agrees": agrees}
    return {"ok": True, "flapping": flapping, "swimming": swimming}


def test_warnings_group_the_trials_that_share_a_doubt():
    statuses = {
        "A": status_with_ratio(4.0),
        "B": status_with_ratio(4.01),
        "C": status_with_ratio(0.5),
        "D": status_with_ratio(1.0),
    }
    first, second = clock_and_length_warnings({**statuses, "E": {"ok": False}})
    assert first.startswith("trials A, B: the tail beats 4.005 times as fast")
    assert second.startswith("trial C: the tail beats 0.5 times as fast")
    (slow,) = clock_and_length_warnings(
        {"A": status_with_ratio(froude=0.2, strouhal=4.0), "B": status_with_ratio(froude=0.2)}
    )
    assert slow.startswith("trial A: a Strouhal number of 4 (plausible: 0.1 to 2). Check fps")


def test_recordings_of_two_powers_that_are_exchanged_are_named_by_their_clocks():
    statuses = {
        "slow": status_with_ratio(2.5 / 2.0, flap_hz=2.0),
        "fast": status_with_ratio(2.01 / 2.5, flap_hz=2.5),
        "wrong fps": status_with_ratio(2.0, flap_hz=2.0),
        "good": status_with_ratio(1.0, flap_hz=2.5),
    }
    exchanged, other = clock_and_length_warnings(statuses)
    assert exchanged.startswith("trials slow and fast: in each one's video the tail beats as the")
    assert other.startswith("trial wrong fps: the tail beats 2 times as fast")


def test_a_frame_rate_that_is_one_percent_wrong_is_no_exchange_of_repeats():
    """Two trials of one power, whose motors differ by less than the tolerance of a pair."""
    statuses = {"one": status_with_ratio(1.0105, 5.80), "other": status_with_ratio(1.0105, 5.86)}
    (warning,) = clock_and_length_warnings(statuses)
    assert "exchanged" not in warning
    assert "the tail beats 1.01" in warning
    assert "or frames are missing within the recording" in warning


def test_a_trial_that_could_be_exchanged_with_two_others_is_in_no_pair():
    statuses = {
        "slow": status_with_ratio(1.25, flap_hz=2.0),
        "fast": status_with_ratio(0.8, flap_hz=2.5),
        "fast too": status_with_ratio(0.8, flap_hz=2.5),
    }
    assert not any("exchanged" in text for text in clock_and_length_warnings(statuses))


@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(
    clock=st.sampled_from([0.01, 0.25, 1.0, 8.0, 100.0]),
    scale=st.sampled_from([1e-6, 0.1, 0.9, 1.0, 1.3, 1e6]),
    shift=st.sampled_from([0.0, -3.0, 1e6]),
    parts=st.permutations(range(5)) | st.just(list(range(5))),
    mirrored=st.booleans(),
    frames=st.integers(0, 60) | st.none(),
    every=st.sampled_from([1, 7]),
    logged=st.booleans(),
)
def test_any_scaled_shifted_permuted_mirrored_or_truncated_trial_ends_in_a_named_outcome(
    mapped_study, clock, scale, shift, parts, mirrored, frames, every, logged
):
    study, trial, positions = mapped_study
    some = slice(None, frames, every)
    xy = scale * positions.xy_m[some] * ([1, -1] if mirrored else [1, 1]) + shift
    changed = replace(
        positions,
        time_s=positions.time_s[some] / clock,
        names=tuple(positions.names[i] for i in parts),
        xy_m=xy,
        cov_m2=positions.cov_m2[some],
        likelihood=positions.likelihood[some],
    )
    row = trial if logged else trial.model_copy(update={"motor_log": None})
    try:
        steady, numbers = analyse_trial(study, row, changed)
    except InputError:
        return
    assert steady.quality in QUALITIES
    assert steady.quality == "no_data" or np.isfinite(steady.speed_m_s)
    assert set(numbers) == set(PLAUSIBLE_RANGES)


def test_a_fit_without_a_solution_ends_in_words_with_the_doubts_about_the_trials(tmp_path):
    @with_numerical_failures_explained
    def fit(study, results):
        np.linalg.cholesky(-np.eye(2))

    write_json(tmp_path / "status" / "A.json", status_with_ratio(4.0))
    with pytest.raises(InputError, match="a fit without a solution") as raised:
        fit(tmp_path / "study", tmp_path)
    assert "trial A: the tail beats 4 times as fast" in str(raised.value)


def test_a_tail_measured_from_the_hinge_is_warned_about_and_a_right_one_is_not(tmp_path):
    """The distance of the keypoints is 66 mm; hinge to tail tip is 277 mm."""
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    for name in SMALL_STUDY_TRIALS:
        keypoints(study, results, name)
        tracks(study, results, name)
    statuses = {name: read_json(results / f"status/{name}.json") for name in SMALL_STUDY_TRIALS}
    assert tail_length_warnings(statuses, 0.066) == []
    assert tail_length_warnings({}, 0.066) == []
    (said,) = tail_length_warnings(statuses, 0.277)
    assert "277 mm" in said
    setup = yaml.safe_load((study / "study.yaml").read_text())
    setup["robot"]["tail_length_m"] = 0.277
    (study / "study.yaml").write_text(yaml.safe_dump(setup))
    outcome(study, results)
    assert said in read_json(results / "outcome.json")["warnings"]
