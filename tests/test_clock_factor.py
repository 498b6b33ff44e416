"""A frame rate that is wrong by a factor is read from tail beats and taken out before any fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from exact_campaign import exact_campaign

from bluekoi.campaign import Campaign
from bluekoi.data import FlappingFrequency, Pose
from bluekoi.stages.clock_factor import clock_factors, correct_clock, with_clock_cause
from bluekoi.stages.trial_exclusion import contradicted_trials
from bluekoi.stages.tuning import campaign_series

EMPTY_VERDICT = {"verdict": "none", "sentence": "Nothing.", "causes": [], "rivals": [],
           "probabilities": {"clock_error": 0.01}}  # fmt: skip


def logged_flapping(ratio: float) -> FlappingFrequency:
    return FlappingFrequency(
        5.8, 0.001, "motor_log", ratio=ratio, ratio_std=1e-3, agrees=ratio == 1
    )


def with_frame_rates(base: Campaign, fps: dict[str, float]) -> Campaign:
    trials = [t.model_copy(update={"fps": fps.get(t.trial_id, t.fps)}) for t in base.study.trials]
    study = base.study.model_copy(update={"trials": tuple(trials)})
    poses = {name: Pose(t.time_s, np.column_stack([t.x_m, t.y_m, t.heading_rad, t.head_angle_rad]),
                        np.tile(np.diag([1e-6, 1e-6, 1e-5, 1e-5]), (len(t.time_s), 1, 1)))
             for name, t in base.tracks.items()}  # fmt: skip
    return replace(base, study=study, poses=poses)


@pytest.mark.parametrize("factor", [0.125, 0.5, 2.0, 4.0, 8.0])
def test_the_factor_is_named_and_both_fits_run_in_true_time(factor):
    base = with_frame_rates(exact_campaign(powers=(100,)), {})
    beats = {name: logged_flapping(factor) for name in base.tracks}
    corrected, flapping, factors = correct_clock(base, beats)
    assert set(factors) == set(base.tracks)
    for name, track in base.tracks.items():
        assert corrected.tracks[name].time_s == pytest.approx(factor * track.time_s)
        assert corrected.tracks[name].speed_m_s == pytest.approx(track.speed_m_s / factor)
        assert corrected.tracks[name].yaw_rate_rad_s == pytest.approx(track.yaw_rate_rad_s / factor)
        assert corrected.steady[name].speed_m_s == pytest.approx(
            base.steady[name].speed_m_s / factor
        )
        assert flapping[name].agrees
        assert flapping[name].video_hz == pytest.approx(5.8)
    series = campaign_series(corrected, flapping)
    assert len(series) == len(base.tracks)
    result = with_clock_cause(EMPTY_VERDICT, factors, len(series))
    assert result["verdict"] == "measurement"
    assert result["causes"][0]["name"] == "clock_error"
    assert result["causes"][0]["parameters"]["rate_error"]["value"] == pytest.approx(factor - 1)
    assert f"fps is {factor:g} times the true frame rate" in result["sentence"]
    assert f"the motor log counts {1 / factor:.4g} turns a tail beat" in result["sentence"]
    assert result["probabilities"]["clock_error"] == 1.0


def test_what_the_search_finds_of_the_clock_besides_is_part_of_the_factor():
    base = with_frame_rates(exact_campaign(powers=(100,)), {})
    _, _, factors = correct_clock(base, {name: logged_flapping(4.0) for name in base.tracks})
    fine = {"name": "clock_error", "parameters": {"rate_error": {"value": 0.01}}}
    damping = {"name": "linear_yaw_damping", "parameters": {}}
    content = {**EMPTY_VERDICT, "causes": [damping, fine]}
    result = with_clock_cause(content, factors, len(base.tracks))
    assert [c["name"] for c in result["causes"]] == ["clock_error", "linear_yaw_damping"]
    assert result["causes"][0]["parameters"]["rate_error"]["value"] == pytest.approx(4.04 - 1)


def test_trials_of_one_frame_rate_share_their_factor_and_no_others_do():
    base = exact_campaign(powers=(100,))
    names = sorted(base.tracks)
    wrong = names[: len(names) // 2]
    base = with_frame_rates(base, dict.fromkeys(wrong, 119.88))
    beats = {name: logged_flapping(4.0 if name in wrong else 1.0) for name in names}
    factors = clock_factors(base.study, beats)
    assert sorted(factors) == wrong
    result = with_clock_cause(EMPTY_VERDICT, factors, len(names))
    assert f"in {len(wrong)} of {len(names)} trials" in result["sentence"]
    assert result["causes"][0]["regime"] == f"trials {', '.join(wrong)}"


def test_deviating_trials_of_several_powers_share_a_factor():
    """A session of `harbour_dock` 9204-001: the frame rate is 1.06 times as high from H09 on."""
    base = exact_campaign(powers=(50, 100))
    power = {t.trial_id: t.power_pct for t in base.study.trials}
    names = sorted(base.tracks, key=lambda name: (name[-1], name))
    wrong = names[: len(names) // 2 - 1]
    assert {power[name] for name in wrong} == {50, 100}
    beats = {name: logged_flapping(1.06 if name in wrong else 1.0) for name in names}
    factors = clock_factors(base.study, beats)
    assert set(factors) == set(wrong)
    _, flapping, _ = correct_clock(base, beats)
    assert contradicted_trials(base, beats).keys() == set(wrong)
    assert contradicted_trials(base, flapping) == {}
    assert (
        "turns a tail beat" not in with_clock_cause(EMPTY_VERDICT, factors, len(names))["sentence"]
    )
    result = with_clock_cause(EMPTY_VERDICT, factors, len(names))
    assert f"1.06 times the true frame rate in {len(wrong)} of {len(names)}" in result["sentence"]


@pytest.mark.parametrize(("most", "few"), [(1.06, 1.0), (1.03, 1.09)])
def test_where_the_clock_of_most_trials_is_wrong_no_part_of_them_has_a_factor(most, few):
    base = exact_campaign(powers=(50, 100))
    names = sorted(base.tracks, key=lambda name: (name[-1], name))
    part = names[: len(names) // 2 - 1]
    beats = {name: logged_flapping(few if name in part else most) for name in names}
    assert clock_factors(base.study, beats) == {}


def test_deviating_trials_of_one_power_or_of_other_ratios_have_other_logs():
    base = exact_campaign(powers=(50, 100))
    names = sorted(base.tracks)
    slow = [t.trial_id for t in base.study.trials if t.power_pct == 50 and t.trial_id in names]
    right = {name: logged_flapping(1.0) for name in names}
    one_power = dict.fromkeys(slow[: len(names) // 2 - 1], logged_flapping(1.06))
    assert clock_factors(base.study, right | one_power) == {}
    scattered = {n: logged_flapping(1.06 + 0.03 * i) for i, n in enumerate((*slow[:2], names[-1]))}
    assert clock_factors(base.study, right | scattered) == {}


@pytest.mark.parametrize("ratios", [(1.0, 1.0), (1.1, 1.1), (4.0, 0.25), (np.nan, np.nan)])
def test_no_factor_without_trials_that_agree_on_one_far_from_1(ratios):
    base = exact_campaign(powers=(100,))
    beats = {name: logged_flapping(ratios[i % 2]) for i, name in enumerate(sorted(base.tracks))}
    assert clock_factors(base.study, beats) == {}
    assert with_clock_cause(EMPTY_VERDICT, {}, len(beats)) == EMPTY_VERDICT


def test_a_stated_frequency_is_a_clock_where_no_trial_has_a_log():
    base = exact_campaign(powers=(100,))
    beats = {name: replace(logged_flapping(4.0), source="flap_hz") for name in base.tracks}
    factors = clock_factors(base.study, beats)
    assert set(factors) == set(base.tracks)
    assert {f.value for f in factors.values()} == {4.0}
    in_video = {name: replace(flap, source="video") for name, flap in beats.items()}
    assert clock_factors(base.study, in_video) == {}
    first = sorted(base.tracks)[:2]
    assert clock_factors(base.study, beats | {name: logged_flapping(1.0) for name in first}) == {}
