"""Keypoint studies processed up to tracks, for tests of fits and of the search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bluekoi.camera import map_keypoints, pool_camera
from bluekoi.data import FlappingFrequency, SteadyState
from bluekoi.fitting import TrialSeries, free_runs
from bluekoi.integrate import compile_system
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial
from bluekoi.model import two_plate_system
from bluekoi.motor import trial_flapping
from bluekoi.pose import rigid_pose
from bluekoi.smoothing import smooth_pose
from bluekoi.stages.clock_measurement import with_clock_measurement
from bluekoi.steady import steady_state
from bluekoi.study import Study, load_study
from bluekoi.synthetic.synthetic_study_design import StudyDesign
from bluekoi.tuning import JointFit, session_order_fractions, trial_series
from validation.tracking_noise import keypoint_study


@dataclass(frozen=True)
class MeasuredStudy:
    """A study with its trials as the fit takes them and its steady states."""

    study: Study
    series: list[TrialSeries]
    steady: dict[str, SteadyState]
    flapping: dict[str, FlappingFrequency]


def measure_design(design: StudyDesign, folder: Path) -> MeasuredStudy:
    """A design simulated, tracked with noise, and measured again."""
    keypoint_study(design, folder / "study", folder / "truth")
    study = load_study(folder / "study")
    camera = pool_camera(study.setup)
    out = MeasuredStudy(study, [], {}, {})
    before = [0.0, *(trial.head_angle_rad for trial in study.trials)]
    places = session_order_fractions(len(study.trials))
    for trial, angle, place in zip(study.trials, before, places, strict=False):
        found = read_keypoints_of_trial(study.paths(trial)[0], trial, {})
        positions = map_keypoints(camera, found, study.setup.robot.keypoint_depth_m)
        flapping = trial_flapping(study, trial, positions)
        pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
        track = smooth_pose(pose, flapping.flap_hz)
        out.steady[trial.trial_id] = steady_state(track, flapping, trial.head_angle_rad)
        out.flapping[trial.trial_id] = flapping
        one = trial_series(trial, study.setup, pose, track, flapping, angle_before_rad=angle,
                           session_place=place)  # fmt: skip
        out.series.append(one)
    out.series[:] = with_clock_measurement(out.series, out.flapping)
    return out


def series_with_effect(
    series: Sequence[TrialSeries], model: JointFit, effect: str, numbers: dict[str, float]
) -> list[TrialSeries]:
    """The trials as they would have been had an effect been there: each path changed by what it
    changes in a simulation of `model` from the same start.
    """
    kernel = compile_system(two_plate_system())
    still = model.parameter_vectors_by_trial(kernel, series)
    moved = [
        with_effect_parameters(v, {f"{effect}.{k}": x for k, x in numbers.items()}) for v in still
    ]
    begun = [replace(s, mean=run.start)
             for s, run in zip(series, free_runs(kernel, series, still), strict=True)]  # fmt: skip
    both = [free_runs(kernel, begun, values, iterations=0) for values in (still, moved)]
    return [replace(s, seen=s.seen + b.observed - a.observed)
            for s, a, b in zip(series, *both, strict=True)]  # fmt: skip


def with_effect_parameters(values: np.ndarray, numbers: dict[str, float]) -> np.ndarray:
    out = values.copy()
    for name, value in numbers.items():
        out[two_plate_system().parameter_index[name]] = value
    return out
