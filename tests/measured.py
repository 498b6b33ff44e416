"""Keypoint studies taken through the measuring half, for tests of fits and of the search."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeline.camera import map_keypoints, pool_camera
from pipeline.data import Flapping, Steady
from pipeline.fitting import Series
from pipeline.keypoints.deeplabcut import read
from pipeline.pose import rigid_pose
from pipeline.smoothing import smooth
from pipeline.stages.mismatch import with_clock
from pipeline.stages.tracks import flapping_of
from pipeline.steady import steady_state
from pipeline.study import Study, load_study
from pipeline.synthetic.design import Design
from pipeline.synthetic.tracking import keypoint_study
from pipeline.tuning import trial_series


@dataclass(frozen=True)
class Measured:
    """A study with its trials as the fit takes them and its steady states."""

    study: Study
    series: list[Series]
    steady: dict[str, Steady]
    flapping: dict[str, Flapping]


def measured(design: Design, folder: Path) -> Measured:
    """A design simulated, tracked with noise, and measured again."""
    keypoint_study(design, folder / "study", folder / "truth")
    study = load_study(folder / "study")
    camera = pool_camera(study.setup)
    out = Measured(study, [], {}, {})
    for trial in study.trials:
        found = read(study.paths(trial)[0], trial, {})
        positions = map_keypoints(camera, found, study.setup.robot.keypoint_depth_m)
        flapping = flapping_of(study, trial, positions)
        pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
        track = smooth(pose, flapping.flap_hz)
        out.steady[trial.trial_id] = steady_state(track, flapping, trial.head_angle_rad)
        out.flapping[trial.trial_id] = flapping
        one = trial_series(trial, study.setup, pose, track, flapping)
        out.series.append(one)
    out.series[:] = with_clock(out.series, out.flapping)
    return out
