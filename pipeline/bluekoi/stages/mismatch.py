"""What was left out: mismatch.json, its details, and the extended model's paths."""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..camera.geometry_hypotheses import SYSTEMATIC_LENGTH_ERROR_SHARE
from ..camera.rigid_distances import STATED_LENGTH_STD_SHARE
from ..camera.rigid_length_windows import windows_from_columns, windows_without_trials
from ..campaign import load_campaign
from ..data import FlappingFrequency, write_columns
from ..errors import input_error
from ..files import write_json
from ..fitting import TrialSeries, free_runs
from ..mismatch import find_mismatch
from ..mismatch.camera_displacement import with_displacement_constants
from ..mismatch.displaced_keypoints import with_keypoint_bias_cause
from ..mismatch.laws import cause_force_curves, partial_residuals
from ..mismatch.results_json import mismatch_detail_json, mismatch_json
from ..mismatch.rigid_lengths import rigid_length_measurement
from ..mismatch.wrong_clock import CLOCK_CAUSE, trials_with_wrong_clock
from ..model import robot_system, two_plate_system
from ..motor import log_lead_from_beat_phases
from ..study import StudySettings, load_study
from ..study.data_split import held_out_trials
from ..tuning import compiled_trial_system, downsampled, session_order_fractions
from .clock_factor import correct_clock, with_clock_cause
from .clock_measurement import with_clock_measurement
from .compiling import precompile_model_with_effects as preload
from .motor_measurements import with_frequency_drift, with_spin_up_time_measurement
from .result_paths import ResultPaths, remove_files
from .status import has_measured_lengths, with_numerical_failures_explained
from .trial_exclusion import contradicted_trials, contradiction_warning, few_trials_warning
from .tuning import campaign_flapping, campaign_series

__all__ = ["mismatch", "preload"]

MIN_TRIALS_TO_FIT = 2
"""Fewer trials determine neither the coefficients nor what is missing."""

stage_logger = logging.getLogger(__name__)


@with_numerical_failures_explained
def mismatch(study: Path, results: Path) -> None:
    """Write mismatch.json, mismatch_detail.json and the extended model's paths, extended/ID.csv.

    Needs the tracks, the steady states and the geometry check, not the stage `tuning`.
    """
    campaign = load_campaign(results, load_study(study), measured=True)
    loaded = campaign.study
    campaign, flapping, factors = correct_clock(campaign, campaign_flapping(campaign))
    series = with_clock_measurement(campaign_series(campaign, flapping), flapping)
    refuse_single_trial(study, len(series))
    fitted = len(series) - len(held_out_trials(loaded, [s.name for s in series]))
    series = with_motor_log_delay_evidence(series, flapping, fitted=fitted)
    series = with_spin_up_time_measurement(series, flapping, fitted=fitted)
    series = with_frequency_drift(series, flapping, fitted=fitted)
    left_out = contradicted_trials(campaign, flapping)
    series = with_rigid_length_measurement(
        series, campaign.geometry or {}, loaded.setup, fitted=fitted, left_out=left_out.keys(),
        order=[trial.trial_id for trial in loaded.trials],
    )  # fmt: skip
    series = with_keypoint_distances_from_nose(series, ResultPaths(results))
    found = find_mismatch(
        loaded, series, campaign.steady, progress=stage_logger.info,
        smoothed_keypoints=campaign.keypoint_smoothing_s > 0,
    )  # fmt: skip
    kernel = compiled_trial_system(series)
    series = with_displacement_constants(kernel, series, found.displacements)
    runs = free_runs(kernel, series, found.extended.parameter_vectors_by_trial(kernel, series))
    remove_files((results / "extended").glob("*.csv"))
    for one, run in zip(series, runs, strict=True):
        path = {f"extended_{k}": run.observed[:, i]
                for i, k in enumerate(("x_m", "y_m", "heading_rad"))}  # fmt: skip
        times = one.times / (factors[one.name].value if one.name in factors else 1.0)
        write_columns(results / "extended" / f"{one.name}.csv", {"time_s": times} | path)
    detail = mismatch_detail_json(found)
    for name in factors.keys() & detail["forces"].keys():
        detail["forces"][name]["time_s"] = detail["forces"][name]["time_s"] / factors[name].value
    trials = {trial.trial_id: trial for trial in loaded.trials}
    along = (kernel, downsampled(series), found.forces, found.extended, trials)
    laws = cause_force_curves(*along)
    detail["partial_residuals"] = partial_residuals(*along, laws=laws, noise=found.baseline.noise)
    write_json(results / "mismatch_detail.json", detail)
    content = mismatch_json(found, loaded, series)
    turns = sum(trials[one.name].head_angle_deg != 0 for one in series)
    own = (contradiction_warning(left_out), few_trials_warning(len(series), turns, len(trials)))
    content["warnings"] = [*filter(None, own), *content["warnings"]]
    for cause in content["causes"]:
        if cause["name"] in laws:
            cause["law"] = laws[cause["name"]]
        if cause["name"] == CLOCK_CAUSE and (part := trials_with_wrong_clock(series)):
            cause["regime"] = f"trials {', '.join(part)}"
    fitted_factors = {s.name: factors[s.name] for s in series if s.name in factors}
    content = with_clock_cause(content, fitted_factors, len(series))
    content = with_keypoint_bias_cause(
        content, campaign.keypoint_displacements, [s.name for s in series]
    )
    write_json(ResultPaths(results).mismatch, content)


def refuse_single_trial(study: Path, count: int) -> None:
    """Raises: InputError where fewer trials than `MIN_TRIALS` are left to fit."""
    if count < MIN_TRIALS_TO_FIT:
        raise input_error(
            study / "trials.csv", "", f"{count} trial that can be used",
            f"{MIN_TRIALS_TO_FIT} or more, of which one swims straight and one turns",
            "One trial does not determine the coefficients. Its track is in the results, in "
            "tracks/ and steady.csv; add trials.",
        )  # fmt: skip


def with_motor_log_delay_evidence(
    series: Sequence[TrialSeries], flapping: Mapping[str, FlappingFrequency], *, fitted: int
) -> list[TrialSeries]:
    """Series with what the phases of the tail beat say of log and video as evidence, one
    measurement shared by the `fitted` trials.
    """
    beats = [flapping[s.name] for s in series]
    usable = [
        b for b in beats if b.agrees and np.isfinite([b.beat_lag_rad, b.beat_lag_std_rad]).all()
    ]
    columns = ("flap_hz", "beat_lag_rad", "beat_lag_std_rad")
    found = log_lead_from_beat_phases(
        *(np.array([getattr(b, name) for b in usable]) for name in columns)
    )
    if found is None:
        return list(series)
    shared = {"delay": (found[0], found[1] * max(fitted, 1) ** 0.5)}
    return [replace(s, evidence=s.evidence | shared) for s in series]


def with_rigid_length_measurement(
    series: Sequence[TrialSeries], geometry: Mapping[str, Any], setup: StudySettings, *,
    fitted: int | None = None, left_out: Collection[str] = (), order: Sequence[str] = (),
) -> list[TrialSeries]:  # fmt: skip
    """Series with what rigid lengths say of errors of the camera, measured once for all trials.

    fitted: trials that are not held out, whose shares make up the measurement. left_out: trials
    whose lengths have no part in it. order: names of all trials in the order of filming.
    """
    if not (series and geometry.get("windows")):
        return list(series)
    by_trial = geometry.get("by_trial") or {}
    numbers = [by_trial[i]["number"] for i in left_out if "number" in by_trial.get(i, {})]
    places = {by_trial[name]["number"]: float(place)
              for name, place in zip(order, session_order_fractions(len(order)), strict=True)
              if "number" in by_trial.get(name, {})}  # fmt: skip
    windows = windows_without_trials(windows_from_columns(geometry["windows"]), numbers)
    system, camera = robot_system(setup.robot), setup.camera
    by_homography = camera is not None and camera.matrix is None
    shared = rigid_length_measurement(
        system, dict(zip(system.constants, series[0].constants, strict=True)),
        windows, trials=max(fitted or len(series), 1),
        depth_given=setup.robot.keypoint_depth_given and not by_homography,
        systematic=_detector_error_share(geometry), session_places=places,
    )  # fmt: skip
    return [replace(s, shared=shared) for s in series]


def _detector_error_share(geometry: Mapping[str, Any]) -> float:
    """Relative error of the detector that is the same in all trials; a whole length's `min_share`
    contains that of the stated lengths.
    """
    if "min_share" not in geometry:
        return SYSTEMATIC_LENGTH_ERROR_SHARE
    return float(np.sqrt(max(geometry["min_share"] ** 2 - STATED_LENGTH_STD_SHARE**2, 0.0)))


def with_keypoint_distances_from_nose(
    series: Sequence[TrialSeries], layout: ResultPaths
) -> list[TrialSeries]:
    """Series that know where their keypoints were placed back from the nose at stated lengths."""
    slots = two_plate_system().constants
    head, hinge, ahead = (slots.index(name) for name in ("h", "x_hinge", "ahead"))
    out = []
    for one in series:
        constants = one.constants.copy()
        if not has_measured_lengths(layout.detection_status(one.name)):
            constants[ahead] = constants[head] * np.cos(one.inputs[0, 0]) + constants[hinge]
        out.append(replace(one, constants=constants))
    return out
