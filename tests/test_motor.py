"""Flapping frequency from shaft logs of known motion, and from keypoints of a known beat."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.data import FlappingFrequency, KeypointPositions
from bluekoi.errors import InputError
from bluekoi.motor import (
    common_clock_ratio,
    flapping_compared_with_video,
    flapping_from_log,
    flapping_from_stated_frequency,
    log_lead_from_beat_phases,
    read_log,
    tail_beat_from_video,
    tail_beat_lag,
    trials_with_deviating_clock,
    video_to_motor_frequency_ratio,
)
from bluekoi.motor.beat_regression import misfit_spectrum, slow_trend_basis
from bluekoi.motor.motor_log import motor_log_coverage
from bluekoi.motor.shaft_angle import wrap_angle
from bluekoi.motor.stated_frequency import rounded_frequency_warnings


def write_log(path, time_s, angle_deg, header="time_s,angle_deg"):
    rows = "\n".join(f"{t:.4f},{a:.4f}" for t, a in zip(time_s, angle_deg, strict=True))
    path.write_text(f"{header}\n{rows}\n")
    return path


def shaft_log(rng, *, hz=2.37, seconds=6.0, tau=0.0, sag=0.0, dead=13.0, stuck=True, noise=0.5):
    """Times and wrapped readings of a shaft: f(t) = hz (1 - exp(-t/tau)) (1 - sag t/T)."""
    t = np.arange(0, seconds, 0.005)
    rate = hz * (1 - sag * t / seconds) * (1 - (np.exp(-t / tau) if tau else 0.0))
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * 0.005)])
    true = (360 * turns + rng.uniform(0, 360)) % 360
    read = np.clip(true + rng.normal(0, noise, len(t)), 0, 360)
    inside = true > 360 - dead
    filler = 360 - dead if stuck else rng.uniform(0, 360, len(t))
    return t, np.where(inside, filler, read)


@pytest.mark.parametrize("hz", [0.8, 2.37, -4.02, 5.82])
@pytest.mark.parametrize("stuck", [True, False])
def test_constant_rate_with_dead_zone(tmp_path, hz, stuck):
    t, a = shaft_log(np.random.default_rng(1), hz=hz, stuck=stuck)
    found = flapping_from_log(write_log(tmp_path / "m.csv", t, a))
    assert found.flap_hz == pytest.approx(abs(hz), rel=5e-4)
    assert abs(found.flap_hz - abs(hz)) < 5 * found.flap_hz_std
    assert found.hz == pytest.approx(abs(hz), rel=0.05)
    assert found.source == "motor_log"


@pytest.mark.parametrize("rate_hz", [20.0, 50.0])
def test_sparse_readings_are_read_as_long_as_a_turn_has_a_few(tmp_path, rate_hz):
    """Windows of a quarter of a second then hold fewer readings than a line takes."""
    time_s = np.arange(0, 3.4, 1 / rate_hz)
    angle = 360 * 5.84 * time_s % 360
    path = tmp_path / "log.csv"
    rows = [f"{t:.6g},{a:.6g}" for t, a in zip(time_s, angle, strict=True) if a < 345]
    path.write_text("\n".join(["time_s,angle_deg", *rows]) + "\n")
    assert flapping_from_log(path).flap_hz == pytest.approx(5.84, rel=1e-3)


def test_stated_deviation_has_the_right_width(tmp_path):
    rng = np.random.default_rng(2)
    pulls = []
    for _ in range(25):
        hz = rng.uniform(2, 6)
        found = flapping_from_log(
            write_log(tmp_path / "m.csv", *shaft_log(rng, hz=hz, seconds=2.0, noise=1.0))
        )
        pulls.append((found.flap_hz - hz) / found.flap_hz_std)
    assert 0.6 < np.sqrt(np.mean(np.square(pulls))) < 1.5


def test_dead_zone_is_found(tmp_path):
    t, a = shaft_log(np.random.default_rng(3), dead=40.0, stuck=False)
    found = flapping_from_log(write_log(tmp_path / "m.csv", t, a))
    width = float(found.remarks[0].split()[-2])
    assert width == pytest.approx(40.0, abs=6.0)


def test_spin_up_gives_the_final_rate_and_shows_over_time(tmp_path):
    t, a = shaft_log(np.random.default_rng(4), hz=4.0, tau=0.4, seconds=4.0)
    found = flapping_from_log(write_log(tmp_path / "m.csv", t, a))
    assert found.flap_hz == pytest.approx(4.0, rel=0.003)
    assert found.hz[0] < 2.5 < found.hz[-1]
    assert any("spins up" in remark for remark in found.remarks)


def log_of_frequency(path, t, hz_of_t, *, rest_deg=40.0, seed=9):
    """A log of a shaft that rests at `rest_deg` and turns at hz(t), read to half a degree."""
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (hz_of_t[1:] + hz_of_t[:-1]) * np.diff(t))])
    read = rest_deg + 360 * turns + np.random.default_rng(seed).normal(0, 0.5, len(t))
    return flapping_from_log(write_log(path / "m.csv", t, read % 360))


@pytest.mark.parametrize("hz", [2.4, 5.8])
@pytest.mark.parametrize("lead", [0.0, 0.4, 0.9])
@pytest.mark.parametrize(("form", "lost"), [("at once", 0.0), ("first order", 0.08),
                                            ("ramp", 0.1), ("s-curve", 0.1)])  # fmt: skip
def test_a_log_shows_when_the_motor_starts_and_what_its_spin_up_costs(
    tmp_path, form, lost, lead, hz
):
    t = np.arange(0, 6, 0.005)
    z = np.clip((t - lead) / 0.2, 0.0, 1.0)
    rate = {
        "at once": np.where(t >= lead, 1.0, 0.0),
        "first order": 1.0 - np.exp(-np.maximum(t - lead, 0.0) / 0.08),
        "ramp": z,
        "s-curve": z * z * (3 - 2 * z),
    }[form]
    found = log_of_frequency(tmp_path, t, hz * rate)
    assert found.start_s == pytest.approx(lead, abs=0.06)
    assert found.start_s + found.lost_time_s == pytest.approx(lead + lost, abs=0.005)
    assert found.drift_per_s == pytest.approx(0.0, abs=2e-4)


def test_a_log_shows_the_drift_of_the_frequency(tmp_path):
    t = np.arange(0, 8, 0.005)
    found = log_of_frequency(tmp_path, t, 4.0 * (1 - 0.004 * t))
    assert found.drift_per_s == pytest.approx(-0.004, rel=0.05)
    assert found.lost_time_s == pytest.approx(0.0, abs=0.002)


def test_falling_battery_is_reported_and_the_mean_rate_taken(tmp_path):
    t, a = shaft_log(np.random.default_rng(5), hz=4.0, sag=0.05)
    found = flapping_from_log(write_log(tmp_path / "m.csv", t, a))
    assert found.flap_hz == pytest.approx(3.9, rel=0.003)
    assert any("-5." in remark or "-4.9" in remark for remark in found.remarks)


def test_a_sensor_whose_scale_is_off_still_counts_turns(tmp_path):
    t = np.arange(0, 5, 0.005)
    true = (360 * 3.1 * t) % 360
    read = np.where(true < 345, true * 360 / 345, 359.9)
    found = flapping_from_log(write_log(tmp_path / "m.csv", t, read))
    assert found.flap_hz == pytest.approx(3.1, rel=1e-3)


def test_holes_are_bridged_or_reported(tmp_path):
    t, a = shaft_log(np.random.default_rng(6), hz=4.0)
    short = (t < 2.0) | (t > 2.2)
    found = flapping_from_log(write_log(tmp_path / "short.csv", t[short], a[short]))
    assert found.flap_hz == pytest.approx(4.0, rel=1e-3)
    long = (t < 1.5) | (t > 3.0)
    found = flapping_from_log(write_log(tmp_path / "long.csv", t[long], a[long]))
    assert found.flap_hz == pytest.approx(4.0, rel=1e-3)
    assert any("hole" in remark for remark in found.remarks)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("swapped", "swapped"),
        ("milliseconds", "milliseconds"),
        ("radians", "radians"),
        ("turns", "look like turns"),
        ("counts", "sensor's counts"),
        ("still", "never turned"),
        ("empty", "an empty file"),
        ("header_only", "0 rows"),
        ("column", "a column angle_deg"),
        ("text", "numbers"),
        ("slow", "cannot be counted"),
        ("short", "turns of the shaft"),
        ("back", "Sort the rows"),
    ],
)
def test_wrong_logs_are_reported_with_their_cure(tmp_path, name, message):
    t, a = shaft_log(np.random.default_rng(7), hz=2.0)
    path = tmp_path / f"{name}.csv"
    {
        "swapped": lambda: write_log(path, a, t),
        "milliseconds": lambda: write_log(path, 1000 * t, a),
        "radians": lambda: write_log(path, t, np.radians(a)),
        "turns": lambda: write_log(path, t, a / 360),
        "counts": lambda: write_log(path, t, a * 1023 / 360),
        "still": lambda: write_log(path, t, 100 + 0 * a),
        "empty": lambda: path.write_text(""),
        "header_only": lambda: path.write_text("time_s,angle_deg\n"),
        "column": lambda: write_log(path, t, a, header="time_s,angle"),
        "text": lambda: path.write_text("time_s,angle_deg\n0.0,x\n"),
        "slow": lambda: write_log(path, t[::20], a[::20]),
        "short": lambda: write_log(path, t[:80], a[:80]),
        "back": lambda: write_log(path, np.concatenate([t[:500], t[400:]]), np.append(a, a[:100])),
    }[name]()
    with pytest.raises(InputError, match=message) as raised:
        flapping_from_log(path)
    assert path.name in str(raised.value)


def test_a_recording_that_begins_after_its_log_is_asked_for_its_frame_numbers(tmp_path):
    log = write_log(tmp_path / "m.csv", *shaft_log(np.random.default_rng(3)))
    with pytest.raises(
        InputError, match=r"first frame used is at 33\.37 s: do frame numbers begin"
    ):
        motor_log_coverage(log, flapping_from_log(log), (33.37, 37.3))


def test_rows_without_numbers_are_left_out(tmp_path):
    t, a = shaft_log(np.random.default_rng(8))
    a[100:103] = np.nan
    text = (write_log(tmp_path / "m.csv", t, a)).read_text().replace("nan", "")
    (tmp_path / "m.csv").write_text(text)
    times, _, remarks = read_log(tmp_path / "m.csv")
    assert len(times) == len(t) - 3
    assert "3 rows" in remarks[0]


def positions_with_tail_beat(
    rng, hz, *, frames=180, fps=30000 / 1001, amplitude=0.35, noise=0.02, jitter=0.0
):
    """Positions of a robot that turns slowly and beats its tail."""
    t = np.arange(frames) / fps + jitter * rng.uniform(-0.3, 0.3, frames) / fps
    return positions_with_tail_angles(
        t, amplitude * np.sin(2 * np.pi * hz * t + 0.7) + rng.normal(0, noise, frames)
    )


def positions_with_tail_angles(t, tail):
    """Positions of a robot that turns slowly, with its tail at these angles."""
    frames, course = len(t), 0.4 * t
    core = np.column_stack([1 + 0.2 * t, 0.8 + 0 * t])
    back = np.column_stack([np.cos(course), np.sin(course)])
    flick = np.column_stack([np.cos(course + tail), np.sin(course + tail)])
    xy = np.stack([core, core - 0.08 * back, core - 0.08 * back - 0.066 * flick], axis=1)
    cov = np.tile(1e-6 * np.eye(2), (frames, 3, 1, 1))
    names = ("core_center", "tail_base", "tail_tip")
    return KeypointPositions(t, names, xy, cov, np.ones((frames, 3)))


@pytest.mark.parametrize("hz", [2.37, 5.82, 11.0])
@pytest.mark.parametrize("guess", [float("nan"), 1.05])
def test_tail_beat_in_the_video(hz, guess):
    found, std = tail_beat_from_video(
        positions_with_tail_beat(np.random.default_rng(9), hz), guess * hz
    )
    assert abs(found - hz) < 4 * std
    assert std < 0.003 * hz


def test_tail_beat_above_half_the_frame_rate_is_found_from_a_guess():
    found, std = tail_beat_from_video(
        positions_with_tail_beat(np.random.default_rng(10), 18.2, jitter=1.0), 18.0
    )
    assert abs(found - 18.2) < 4 * std


@pytest.mark.parametrize("hz", [2.37, 3.91, 5.82])
def test_a_tail_seen_in_every_tenth_frame_shows_no_wrong_clock(hz):
    """At three frames a second the beat has aliases, and a slow turn looks like a beat."""
    t = np.arange(300) / 30
    for seed in range(5):
        noise = 0.02 * np.random.default_rng(seed).normal(size=300)
        tail = 0.3 * np.sin(2 * np.pi * hz * t) + 0.3 * np.exp(-t / 3) + noise
        few = positions_with_tail_angles(t, tail)
        few = replace(few, likelihood=np.where(np.arange(300)[:, None] % 10, 0, few.likelihood))
        ratio, std = video_to_motor_frequency_ratio(few, flapping_from_stated_frequency(hz))
        assert np.isnan(ratio) or abs(ratio - 1) < max(0.01, 3 * std)


def test_tail_beat_deviation_has_the_right_width():
    rng = np.random.default_rng(11)
    pulls = []
    for _ in range(30):
        hz = rng.uniform(2, 6)
        found, std = tail_beat_from_video(
            positions_with_tail_beat(rng, hz, frames=120, noise=0.08), hz
        )
        pulls.append((found - hz) / std)
    assert 0.7 < np.sqrt(np.mean(np.square(pulls))) < 1.4


def test_no_beat_is_nan():
    quiet = positions_with_tail_beat(np.random.default_rng(12), 3.0, amplitude=0.0)
    assert np.isnan(tail_beat_from_video(quiet, 3.0)).all()
    assert np.isnan(
        tail_beat_from_video(positions_with_tail_beat(np.random.default_rng(1), 3.0, frames=8), 3.0)
    ).all()


def test_tail_beat_follows_the_motor_through_spin_up():
    t = np.linspace(0, 6, 200)
    hz = 4.0 * (1 - np.exp(-t / 0.5))
    motor = FlappingFrequency(4.0, 0.001, "motor_log", t, hz)
    seen = positions_with_tail_beat(np.random.default_rng(13), 4.0)
    turns = np.interp(
        seen.time_s, t, np.concatenate([[0], np.cumsum(0.5 * (hz[1:] + hz[:-1]) * 6 / 199)])
    )
    tail = 0.35 * np.sin(2 * np.pi * turns)
    course = 0.4 * seen.time_s + tail
    xy = seen.xy_m.copy()
    xy[:, 2] = xy[:, 1] - 0.066 * np.column_stack([np.cos(course), np.sin(course)])
    warped = KeypointPositions(seen.time_s, seen.names, xy, seen.cov_m2, seen.likelihood)
    found, _ = tail_beat_from_video(warped, 4.0, flapping=motor)
    assert found == pytest.approx(4.0, rel=0.004)


def test_clocks_that_disagree_are_named_with_their_ratio():
    motor = FlappingFrequency(4.0, 0.0005, "motor_log")
    same = flapping_compared_with_video(motor, 1.0005, 0.0003)
    assert same.agrees
    assert same.video_hz == pytest.approx(4.002)
    other = flapping_compared_with_video(motor, 1.02, 0.0005)
    assert not other.agrees
    assert "1.0200 +- 0.0005" in other.remarks[-1]
    assert flapping_compared_with_video(motor, float("nan"), float("nan")) == motor


@pytest.mark.parametrize("factor", [1 / 8, 1 / 4, 1 / 2, 29.97 / 50, 1.0, 1.02, 2.0, 4.0, 8.0])
@pytest.mark.parametrize("hz", [1.9, 5.8])
def test_a_frame_rate_stated_too_high_by_a_factor_shows_in_the_ratio_of_the_clocks(factor, hz):
    seen = positions_with_tail_beat(np.random.default_rng(14), hz, frames=240)
    motor = FlappingFrequency(hz, 1e-4 * hz, "motor_log")
    ratio, std = video_to_motor_frequency_ratio(replace(seen, time_s=seen.time_s / factor), motor)
    assert ratio == pytest.approx(factor, rel=1e-3)
    assert abs(ratio - factor) < 5 * std


def test_the_ratio_of_the_clocks_is_found_through_spin_up():
    t = np.linspace(0, 8, 400)
    hz = 4.0 * (1 - np.exp(-t / 0.5))
    turns = np.concatenate([[0], np.cumsum(0.5 * (hz[1:] + hz[:-1]) * np.diff(t))])
    video = np.arange(230) / 29.97
    beat = positions_with_tail_angles(video, 0.35 * np.sin(2 * np.pi * np.interp(video, t, turns)))
    ratio, _ = video_to_motor_frequency_ratio(
        replace(beat, time_s=video / 4), FlappingFrequency(4.0, 1e-3, "log", t, hz)
    )
    assert ratio == pytest.approx(4.0, rel=0.004)


@pytest.mark.parametrize("count", [1, 7, 70])
def test_the_spectrum_is_what_least_squares_leaves_at_each_frequency(count):
    rng = np.random.default_rng(6)
    t = np.sort(rng.uniform(0, 7, 240))
    signal = 0.3 * np.sin(2 * np.pi * 2.4 * t) + 0.05 * t + rng.normal(0, 0.1, len(t))
    weights, background = rng.uniform(0.1, 1.0, len(t)), slow_trend_basis(t, 2.4)
    hz = 1.9 + 0.014 * np.arange(count)
    left = []
    for f in hz:
        phase = 2 * np.pi * f * t
        design = np.column_stack([np.cos(phase), np.sin(phase), background])
        root = np.sqrt(weights)
        value = np.linalg.lstsq(design * root[:, None], signal * root, rcond=None)[0]
        left.append(np.sum(weights * (signal - design @ value) ** 2))
    assert misfit_spectrum(hz, t, signal, background, weights) == pytest.approx(left, rel=1e-9)


def test_a_strong_harmonic_is_not_taken_for_the_beat():
    t = np.arange(240) / 29.97
    tail = 0.3 * np.sin(2 * np.pi * 2.4 * t) + 0.2 * np.sin(2 * np.pi * 4.8 * t)
    seen = positions_with_tail_angles(t, tail + np.random.default_rng(15).normal(0, 0.02, len(t)))
    assert video_to_motor_frequency_ratio(seen, FlappingFrequency(2.4, 1e-3, "motor_log"))[
        0
    ] == pytest.approx(1.0, rel=1e-3)


def flapping_with_ratio(value):
    return FlappingFrequency(4.0, 0.001, "motor_log", ratio=value, agrees=abs(value - 1) < 0.01)


def test_trials_agree_on_a_ratio_only_by_majority():
    four = [flapping_with_ratio(4.001), flapping_with_ratio(3.998), flapping_with_ratio(4.0)]
    assert common_clock_ratio(four)[0] == pytest.approx(4.0, abs=1e-3)
    assert common_clock_ratio([*four, flapping_with_ratio(1.0)])[0] == pytest.approx(4.0, abs=1e-3)
    assert common_clock_ratio([flapping_with_ratio(4.0), flapping_with_ratio(1.0)]) is None
    assert common_clock_ratio([flapping_with_ratio(4.0), flapping_with_ratio(float("nan"))]) is None


def flappings(*ratios):
    return {f"T{k:02d}": flapping_with_ratio(ratio) for k, ratio in enumerate(ratios)}


def test_a_trial_with_the_clock_of_another_camera_deviates():
    assert trials_with_deviating_clock(flappings(4.001, 3.998, 4.0, 1.0)) == ["T03"]
    assert trials_with_deviating_clock(flappings(4.001, 3.998, 4.0)) == []
    assert trials_with_deviating_clock(flappings(4.0, 1.0)) == ["T00"]
    assert trials_with_deviating_clock(flappings(1.0, 1.001, 0.999, 1.0, 1.2)) == ["T04"]


def test_a_stated_frequency_that_is_not_quite_right_is_no_other_clock():
    scatter = (1.0, 1.015, 0.985, 1.01, 0.99, 1.03, 0.97)
    assert trials_with_deviating_clock(flappings(*scatter)) == []
    assert trials_with_deviating_clock(flappings(*scatter, 1.2)) == ["T07"]


def test_given_frequency():
    assert flapping_from_stated_frequency(2.5).flap_hz == 2.5
    assert flapping_from_stated_frequency(2.5).source == "flap_hz"


@pytest.mark.parametrize("delay_s", [0.0, 0.14, -0.35])
def test_a_log_ahead_of_the_video_shows_in_the_phase_of_the_beat(tmp_path, delay_s):
    """A tail 0.7 rad behind its shaft; the log's time is the video's plus the delay."""
    rng = np.random.default_rng(31)
    reported = []
    for k, hz in enumerate([1.8, 3.0, 4.2, 5.6] * 2):
        first, log_s = rng.uniform(0, 2 * np.pi), np.arange(0, 6, 0.005)
        shaft = first + 2 * np.pi * hz * (log_s - delay_s)
        angle = (np.degrees(shaft) + 0.3 * rng.standard_normal(len(log_s))) % 360
        flapping = flapping_from_log(write_log(tmp_path / f"{k}.csv", log_s, angle))
        video = np.arange(180) / 29.97
        beat = 0.3 * np.cos(first + 2 * np.pi * hz * video - 0.7)
        lag, std = tail_beat_lag(
            positions_with_tail_angles(video, beat + 0.02 * rng.standard_normal(180)), flapping
        )
        assert std < 0.05
        assert wrap_angle(lag - (0.7 - 2 * np.pi * hz * delay_s)) == pytest.approx(0, abs=5 * std)
        reported.append((flapping.flap_hz, lag, std))
    value, std = log_lead_from_beat_phases(*np.array(reported).T)
    assert value == pytest.approx(delay_s, abs=0.01)
    assert std == pytest.approx(0.03, abs=0.01)


def test_inconsistent_phases_give_no_delay():
    rng = np.random.default_rng(32)
    hz, std = np.repeat([1.8, 3.0, 4.2, 5.6], 6), np.full(24, 0.02)
    assert log_lead_from_beat_phases(hz, rng.uniform(-np.pi, np.pi, 24), std) is None
    assert log_lead_from_beat_phases(hz[:4], np.zeros(4), std[:4]) is None
    alike = np.full(24, 3.0)
    assert log_lead_from_beat_phases(alike, np.full(24, 0.3), std) is None


def test_a_log_of_noise_is_no_turning_shaft(tmp_path):
    time_s = np.arange(0, 4, 0.005)
    noise = np.random.default_rng(0).uniform(0, 360, len(time_s))
    lines = [f"{t:.3f},{a:.3f}" for t, a in zip(time_s, noise, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time_s,angle_deg", *lines]))
    with pytest.raises(InputError, match="expected a shaft that turns steadily"):
        flapping_from_log(path)


def test_frequencies_rounded_to_a_tenth_of_a_hertz_are_asked_about():
    """2.04 Hz written as 2.0 gave a loss of thrust that does not exist."""
    assert rounded_frequency_warnings([2.04, 2.88, 3.5]) == []
    assert rounded_frequency_warnings([7.1, 8.2]) == []
    assert rounded_frequency_warnings([2.0]) == []
    (said,) = rounded_frequency_warnings([2.0, 2.9, 3.5, 0.0])
    assert "flap_hz is stated to 0.1 Hz, up to 2.5 % off at 2 Hz" in said
    assert "State it to 0.01 Hz" in said
