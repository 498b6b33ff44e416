"""Fits against the truth that keypoint studies were simulated from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from bluekoi.data import FlappingFrequency, Pose
from bluekoi.fitting import (
    FreeParameter,
    Noise,
    TrialEffect,
    TrialSeries,
    trial_normal_equations,
)
from bluekoi.model import TABLE_1, robot_scale_ratios, two_plate_system
from bluekoi.smoothing import smooth_pose
from bluekoi.study import Trial
from bluekoi.tuning import (
    HEAD_ANGLE_STD_RAD,
    coefficients_json_and_fit,
    compiled_trial_system,
    downsampled,
    downsampled_with_head_angle_changes,
    fit_all_trials,
    fit_paper_steps,
    simulation_columns_by_trial,
    study_series,
    table_1_coefficients,
    table_2_radius_errors,
    trial_series,
)
from bluekoi.tuning.series import INITIAL_STATE_STD, RESTING_VELOCITY_STD
from bluekoi.tuning.similar_robots import state_std_scaled_to_robot
from measured_studies import MeasuredStudy, measure_design
from paper_robot import PAPER_SETUP
from small_studies import published_model_design

TRUTH = {"C_T": 4.5e-3, "C_D0": 0.5, "C_La": 3.14, "C_Ma": 0.1}


@pytest.fixture(scope="module")
def table_1_study(tmp_path_factory: pytest.TempPathFactory) -> MeasuredStudy:
    return measure_design(published_model_design(table_1=True), tmp_path_factory.mktemp("table_1"))


@pytest.fixture(scope="module")
def published_model_study(tmp_path_factory: pytest.TempPathFactory) -> MeasuredStudy:
    return measure_design(published_model_design(), tmp_path_factory.mktemp("bare"))


def test_table_1_again(table_1_study: MeasuredStudy) -> None:
    """Studies simulated from the paper's Table I come back through the three steps as Table I."""
    m = table_1_study
    steps, _, _ = fit_paper_steps(m.study, m.series, m.steady)
    for power, published in TABLE_1.items():
        found = steps[str(power)]["coefficients"]
        for name, value in published.items():
            off = abs(found[name]["value"] - value) / found[name]["std"]
            assert off < student.ppf(0.995, 3), (power, name, found[name])
    assert steps["75"]["coefficients"]["C_Da"]["value"] == pytest.approx(2.5, rel=0.1)
    assert steps["100"]["coefficients"]["C_Da"]["value"] == pytest.approx(4.0, rel=0.1)


def test_bare_study_gives_back_what_it_determines(published_model_study: MeasuredStudy) -> None:
    found, joint = coefficients_json_and_fit(
        published_model_study.study, published_model_study.series, published_model_study.steady
    )
    table = found["joint"]["coefficients"]
    truth = {"C_T": 4.5e-3, "C_D0": 0.5, "C_La": 3.14, "C_Ma": 0.1} | _common_coefficients()
    reported = [name for name in truth if table[name]["determined"]]
    assert {"C_T", "C_D0", "C_La"} <= set(reported)
    for name in reported:
        assert table[name]["value"] == pytest.approx(truth[name], rel=0.1), name
        assert abs(table[name]["value"] - truth[name]) < student.ppf(0.975, 5) * table[name]["std"]
    for name in set(truth) - set(reported):
        assert table[name]["why"]
    assert joint.fit.outcome == "converged"
    assert found["joint"]["straight_swimming"]["stable"] is False


def test_a_head_angle_error_of_a_trial_hides_its_mean_and_not_its_changes(
    published_model_study: MeasuredStudy,
) -> None:
    """Information on an offset of the head angle stays that of one observation a trial; that on a
    servo which is late grows."""
    series = published_model_study.series
    once = downsampled(series, 5.0)
    changes = downsampled_with_head_angle_changes(series, 5.0)
    variance = series[0].noise[0, 3, 3] - HEAD_ANGLE_STD_RAD**2 * len(series[0].times)
    assert changes[0].noise[0, 3, 3] == pytest.approx(variance)
    kernel, base = (
        compiled_trial_system(series),
        compiled_trial_system(series).system.parameter_vector({}),
    )
    free = [FreeParameter("keypoint_bias.head_angle_offset"),
            FreeParameter("servo_lag.missing_share")]  # fmt: skip
    noise = Noise(np.zeros(6), np.ones(6), np.ones(4))
    own = TrialEffect("head_angle_error.angle", HEAD_ANGLE_STD_RAD)

    def information(trials: Sequence[TrialSeries], noise: Noise) -> np.ndarray:
        at = np.array([0.0, 1e-6])
        found = trial_normal_equations(kernel, trials, base, free, at, noise=noise)
        return np.diag(found.hessian.sum(axis=0))

    spread = information(once, noise)
    apart = information(changes, replace(noise, trial_effects=(own,)))
    assert apart[0] == pytest.approx(spread[0], rel=0.05)
    assert apart[0] == pytest.approx(len(series) / HEAD_ANGLE_STD_RAD**2, rel=0.05)
    assert apart[1] > 3.0 * spread[1]


def test_a_trial_knows_the_head_angle_of_the_one_before(
    published_model_study: MeasuredStudy,
) -> None:
    """In the order of trials.csv, whether that one was measured or not."""
    trials = published_model_study.study.trials
    times = np.arange(40) / 30
    values = np.column_stack([0.3 * times, *np.zeros((3, 40))])
    pose = Pose(times, values, np.tile(1e-6 * np.eye(4), (40, 1, 1)))
    track, flapping = smooth_pose(pose, 3.0), FlappingFrequency(3.0, 0.0, "flap_hz")
    measured = [trials[0].trial_id, *(t.trial_id for t in trials[2:])]
    found = study_series(
        published_model_study.study,
        *(dict.fromkeys(measured, one) for one in (pose, track)),
        dict.fromkeys(measured, flapping),
    )
    place = two_plate_system().constants.index("phi0")
    before = {one.name: one.constants[place] for one in found}
    assert before[trials[0].trial_id] == 0.0
    assert before[trials[2].trial_id] == pytest.approx(trials[1].head_angle_rad)


def _common_coefficients() -> dict[str, float]:
    from bluekoi.synthetic.ground_truth_physics import Coefficients

    common = Coefficients()
    return {"C_Da": common.C_Da, "C_Md": common.C_Md}


def test_a_frame_in_which_two_labels_changed_places_is_left_out(
    published_model_study: MeasuredStudy,
) -> None:
    """40 mm off and stated with 35: within what it states, yet of no use; one of 4 mm is kept."""
    trial, n = published_model_study.study.trials[0], 200
    t = np.arange(n) / 30
    values = np.column_stack([0.5 + 0.2 * t, np.full(n, 0.8), np.zeros(n), np.zeros(n)])
    cov = np.tile(np.diag([2e-4, 2e-4, 1.6e-3, 1.6e-3]) ** 2, (n, 1, 1))
    values += np.random.default_rng(2).multivariate_normal(np.zeros(4), cov[0], n)
    values[90, :2] += 0.04
    cov[90] *= 175**2
    cov[50] *= 6**2
    pose = Pose(t, values, cov)
    flapping = published_model_study.flapping[trial.trial_id]
    one = trial_series(
        trial,
        published_model_study.study.setup,
        pose,
        smooth_pose(pose, flapping.flap_hz),
        flapping,
    )
    assert np.flatnonzero(np.isnan(one.seen[:, 0])).tolist() == [90]


def test_the_error_of_the_recoil_counts_where_it_builds_up(
    published_model_study: MeasuredStudy,
) -> None:
    """What exceeds the usual variance is added once a quarter of a beat, and no frame is lost."""
    study, n = published_model_study, 90
    trial, t = study.study.trials[0], np.arange(90) / 30
    values = np.column_stack([0.5 + 0.2 * t, np.full(n, 0.8), np.zeros(n), np.zeros(n)])
    values += np.random.default_rng(2).normal(0, 2e-4, (n, 4))
    pose = Pose(t, values, np.tile(np.diag([2e-4, 2e-4, 2e-4, 2e-4]) ** 2, (n, 1, 1)))
    track = smooth_pose(pose, 2.5)
    known = replace(track, recoil_std=np.full_like(track.recoil, 0.001))
    doubtful = replace(known, recoil_std=known.recoil_std.copy())
    doubtful.recoil_std[:12] = 0.002
    flapping = FlappingFrequency(2.5, 0.0, "flap_hz")
    one, other = (
        trial_series(trial, study.study.setup, pose, each, flapping) for each in (known, doubtful)
    )
    frames = 0.25 / 2.5 / float(np.median(np.diff(one.times)))
    excess = np.diag([*[frames * (0.002**2 - 0.001**2)] * 3, 0.0])
    assert other.noise[:12] - one.noise[:12] == pytest.approx(np.tile(excess, (12, 1, 1)))
    np.testing.assert_array_equal(other.noise[12:], one.noise[12:])
    np.testing.assert_array_equal(np.isfinite(other.seen), np.isfinite(one.seen))


def test_the_start_of_smoothed_keypoints_is_left_out(published_model_study: MeasuredStudy) -> None:
    """The rest of the trial begins while the robot swims; of a short trial nothing is left out."""
    trial, t = published_model_study.study.trials[0], np.arange(150) / 30
    values = np.column_stack([0.5 + 0.02 * t**2, np.full(150, 0.8), np.zeros(150), np.zeros(150)])
    pose = Pose(t, values, np.tile(np.diag([2e-4, 2e-4, 1.6e-3, 1.6e-3]) ** 2, (150, 1, 1)))
    flapping = published_model_study.flapping[trial.trial_id]
    given = (trial, published_model_study.study.setup, pose, smooth_pose(pose, flapping.flap_hz))
    whole, rest, all_of_it = (
        trial_series(*given, flapping, skipped_s=skipped) for skipped in (0.0, 0.5, 60.0)
    )
    assert rest.times[0] == pytest.approx(whole.times[0] + 0.5, abs=0.04)
    assert rest.mean[3] > whole.mean[3]
    assert rest.constants[two_plate_system().constants.index("t_start")] < -100.0
    np.testing.assert_array_equal(all_of_it.times, whole.times)


def test_random_forces_go_with_the_flapping_frequency(
    published_model_study: MeasuredStudy,
) -> None:
    """3.5 Hz is the size 1 for the published robot, whose unit of time is 1 s."""
    by_power = {s.group: s.force_size for s in published_model_study.series}
    hz = {
        s.group: published_model_study.flapping[s.name].flap_hz
        for s in published_model_study.series
    }
    assert len(by_power) > 1
    for group, size in by_power.items():
        assert size == pytest.approx(hz[group] / 3.5, rel=0.02)


def test_straight_runs_alone_leave_the_turning_coefficients_open(
    published_model_study: MeasuredStudy,
) -> None:
    straight = [
        s
        for s in published_model_study.series
        if published_model_study.study.trial(s.name).head_angle_deg == 0
    ]
    steps, _, second = fit_paper_steps(
        published_model_study.study, straight, published_model_study.steady
    )
    assert second is None
    cells = steps["100"]["coefficients"]
    assert cells["C_T"]["determined"]
    assert not cells["C_Da"]["determined"]
    assert "straight runs hold alpha at 0" in cells["C_Da"]["why"]


def test_tables_have_the_paper_beside_the_study(table_1_study: MeasuredStudy) -> None:
    m = table_1_study
    steps, _, _ = fit_paper_steps(m.study, m.series, m.steady)
    one, two = table_1_coefficients(steps), table_2_radius_errors(m.study, steps)
    assert one["power_pct"] == [50, 75, 100]
    assert one["paper_C_Md_kg_m2"] == [0.145, 0.130, 0.104]
    assert set(two["head_angle_deg"]) == {30, 45}
    assert [two["used_in_tuning"][i] for i in range(3)] == [True, True, False]
    assert np.nanmax(np.abs(two["difference_pct"])) < 5
    assert two["paper_difference_pct"][0] == 2.77


def test_simulated_paths_lie_on_the_measured_turns(published_model_study: MeasuredStudy) -> None:
    turns = [
        s
        for s in published_model_study.series
        if published_model_study.study.trial(s.name).head_angle_deg != 0
    ]
    joint = fit_all_trials(turns)
    steps, _, _ = fit_paper_steps(
        published_model_study.study, published_model_study.series, published_model_study.steady
    )
    for one, columns in zip(
        turns, simulation_columns_by_trial(turns, joint, steps).values(), strict=True
    ):
        apart = np.hypot(
            columns["joint_x_m"] - one.seen[:, 0], columns["joint_y_m"] - one.seen[:, 1]
        )
        assert np.nanmedian(apart) < 0.004


@pytest.mark.parametrize(("speed_m_s", "swims"), [(0.0, False), (0.02, False), (0.3, True)])
def test_the_motor_of_a_trial_that_begins_swimming_started_long_before(
    speed_m_s: float, swims: bool
) -> None:
    """Its spin-up, or a delay of its start, has no part in such a trial."""
    times = np.arange(0, 5, 1 / 30)
    speed = 0.4 - (0.4 - speed_m_s) * np.exp(-2.0 * times)
    pose = Pose(
        times,
        np.column_stack([1 + np.cumsum(speed) / 30, *np.full((3, len(times)), 0.0)])
        + np.random.default_rng(8).normal(0, 1e-3, (len(times), 4)),
        np.tile(np.diag([1e-6, 1e-6, 1e-5, 1e-5]), (len(times), 1, 1)),
    )
    trial = Trial(trial_id="T1", source="keypoints/T1.csv", power_pct=50.0, head_angle_deg=0.0,
                  head_length_m=0.12, fps=30.0)  # fmt: skip
    flapping = FlappingFrequency(2.4, 0.0, "flap_hz")
    one = trial_series(trial, PAPER_SETUP, pose, smooth_pose(pose, 2.4), flapping)
    started = one.constants[two_plate_system().constants.index("t_start")]
    assert (started < -100.0) == swims
    assert one.times[0] == 0.0
    units, expected = robot_scale_ratios(PAPER_SETUP.robot), np.ones(6)
    expected[3:] = INITIAL_STATE_STD[3:] if swims else RESTING_VELOCITY_STD
    assert np.sqrt(np.diag(one.cov))[3:6] == pytest.approx(
        state_std_scaled_to_robot(units, expected)[3:]
    )
    assert one.mean[3] == (0.0 if not swims else pytest.approx(speed_m_s, abs=0.03))
