"""Trials whose motor log or video does not begin with the other are named."""

import numpy as np
import pytest

from bluekoi.motor.log_synchrony import (
    lag_deviations_from_majority,
    lag_groups_of_repeats,
    log_synchrony_warnings,
)
from bluekoi.study import Trial


def trial(name, log="", source=""):
    return Trial(trial_id=name, source=source or f"{name}.csv", power_pct=50.0, head_angle_deg=0.0,
                 head_length_m=0.12, motor_log=log or None, fps=30.0)  # fmt: skip


def status(lag_rad, **other):
    beat = {"agrees": True, "beat_lag_rad": lag_rad, "flap_hz": 2.35}
    return {"ok": True, "flapping": beat | other}


@pytest.mark.parametrize("off", [-2.5, 1.0, 3.0])
def test_one_lag_that_differs_from_the_others_is_out_of_step(off):
    lag = np.array([2.06, 2.07, 2.06 + off, 2.05, 2.0, 2.1])
    hz = np.array([2.35, 2.36, 2.34, 5.8, 5.8, 5.81])
    found = lag_deviations_from_majority(hz, lag)
    assert np.flatnonzero(found).tolist() == [2]
    assert found[2] == pytest.approx(off, abs=0.05)


def test_lags_about_half_a_turn_are_alike_on_both_sides_of_it():
    lag = np.array([3.1, -3.1, 3.13, -3.05])
    assert not lag_deviations_from_majority(np.full(4, 2.0), lag).any()


def test_trials_of_one_power_that_agree_have_a_common_delay():
    delay_s, hz = 0.1, np.array([2.35, 2.35, 2.35, 2.35, 5.8, 5.8])
    lag = np.angle(np.exp(1j * (2.0 + 2 * np.pi * delay_s * hz)))
    assert not lag_deviations_from_majority(hz, lag).any()


@pytest.mark.parametrize("lag", [[0.0, 2.0], [0.0, 2.0, -2.0], [0.0, 0.1, 2.0, 2.1], []])
def test_without_a_majority_no_trial_is_accused(lag):
    assert not lag_deviations_from_majority(np.full(len(lag), 2.35), np.array(lag)).any()


def test_the_trial_is_named_with_the_time_and_the_cure():
    lags = {"A": 2.06, "B": 2.07, "C": -2.36, "D": 2.05}
    (sentence,) = log_synchrony_warnings({}, {k: status(v) for k, v in lags.items()})
    assert sentence.startswith("Trial C: the tail beats 126 ms after")
    assert "motor_log and start_s" in sentence


def test_trials_without_a_clear_beat_or_a_log_say_nothing():
    alike = {name: status(0.0) for name in "ABC"}
    unknown = {"D": status(None), "E": {"ok": False, "flapping": None}}
    other_clock = {"F": status(2.0, agrees=False, video_hz=4.7)}
    seen = alike | unknown | other_clock
    assert log_synchrony_warnings({}, seen) == []


def test_a_log_of_two_recordings_is_named_and_one_of_two_parts_is_not():
    two = {"A": trial("A", "motor/1.csv"), "B": trial("B", "motor/1.csv")}
    (sentence,) = log_synchrony_warnings(two, {})
    assert "Trials A, B" in sentence
    assert "motor/1.csv" in sentence
    parts = {n: trial(n, "motor/1.csv", "one.mp4") for n in "AB"}
    assert log_synchrony_warnings(parts, {}) == []


def test_the_log_of_another_trial_of_the_same_power_is_named():
    lags = {"A": status(2.06), "B": status(2.07), "D": status(2.05)}
    other = status(-0.49, agrees=False, video_hz=0.993 * 2.35)  # as newcomers exchanged them
    (sentence,) = log_synchrony_warnings({}, lags | {"C": other})
    assert sentence.startswith("Trial C: ")


def test_logs_that_are_late_in_half_of_the_trials_are_named():
    """A demo whose logs are 0.4 s late in 12 of its 24 trials: at 2.36 Hz that is nearly a beat."""
    hz = np.repeat([2.36, 4.04, 5.83], 8) + np.tile([0.0, 0.01], 12)
    late = np.tile([0, 0, 0, 1, 1, 1, 1, 1], 3)
    late[16:] = [0, 0, 0, 1, 1, 0, 0, 0]
    lag = np.angle(np.exp(1j * (2.07 - 2 * np.pi * 0.4 * late * hz)))
    found = lag_groups_of_repeats(hz, lag)
    assert [(g.largest.tolist(), g.second.tolist(), g.others.tolist()) for g in found] == [
        ([11, 12, 13, 14, 15], [8, 9, 10], []), ([16, 17, 18, 21, 22, 23], [19, 20], []),
    ]  # fmt: skip
    beats = {f"T{i}": status(x, flap_hz=f) for i, (f, x) in enumerate(zip(hz, lag, strict=True))}
    first, second = log_synchrony_warnings({}, beats)
    assert first.startswith("Trials T11, T12, T13, T14, T15 and trials T8, T9, T10 flap")
    assert "beat 94 ms earlier" in first
    assert "beat 57 ms earlier" in second


def test_arbitrary_delays_of_all_logs_are_no_two_groups():
    lag = np.array([0.1, -0.2, 0.3, 2.0, 2.2, -1.6, -2.7, 1.2])
    beats = {f"T{i}": status(x, flap_hz=2.36) for i, x in enumerate(lag)}
    (sentence,) = log_synchrony_warnings({}, beats)
    assert sentence.startswith("Trials T0, T1, T2, T3, T4, T5, T6, T7 flap")
    assert "most of these logs do not begin together with their videos" in sentence


def test_a_lag_of_most_trials_is_not_said_to_be_arbitrary():
    lag = np.array([0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 2.0, 2.1, -1.6, -2.7])
    beats = {f"T{i}": status(x, flap_hz=2.36) for i, x in enumerate(lag)}
    found = log_synchrony_warnings({}, beats)
    assert not any("most of these logs" in sentence for sentence in found)
    assert any(s.startswith("Trials T0, T1, T2, T3, T4, T5 and trials T6, T7") for s in found)


def test_one_delay_of_all_logs_gives_no_groups():
    rng = np.random.default_rng(1)
    hz = np.repeat([1.6, 2.35, 4.0], 6)
    lag = np.angle(np.exp(1j * (2.0 + 2 * np.pi * 0.2 * hz + rng.normal(0, 0.1, 18))))
    assert lag_groups_of_repeats(hz, lag) == []
    assert lag_groups_of_repeats(np.zeros(0), np.zeros(0)) == []


def test_single_arbitrary_lags_rarely_make_a_group():
    """98 % of the lags alike, as in `LAG_TOLERANCE_RAD`, the others arbitrary; twelve trials."""
    rng, draws = np.random.default_rng(0), 2000
    lags = rng.normal(0.0, 0.02, (draws, 12))
    arbitrary = rng.random(lags.shape) < 0.02
    lags[arbitrary] = rng.uniform(-np.pi, np.pi, arbitrary.sum())
    found = sum(bool(lag_groups_of_repeats(np.full(12, 2.0), lag)) for lag in lags)
    assert found < 0.01 * draws
