"""Whether a filmed trial that was refused is right with a head angle of the other sign.

A template with the head turned to the wrong side fits nothing, or the robot backwards. The robot
is therefore sought once more with the other sign. Whoever exchanged the sign reads so, and nobody
else: the second detection must pass every check that the first one failed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..camera.pool_projection import PoolCamera, map_keypoints
from ..errors import InputError, InputIssue
from ..pose import rigid_pose
from ..pose.plausibility import plausibility_findings
from ..study import Study, Trial
from .keypoints import detect_in_footage

MIN_FOUND_SHARE = 0.5
"""Share of the frames in which the robot must be found with the other sign."""


def head_angle_sign_finding(
    study: Study, trial: Trial, camera: PoolCamera, depth_m: float
) -> InputIssue | None:
    """The head angle of the other sign, if the robot in the footage passes all checks with it."""
    angle = trial.head_angle_deg
    if trial.reads_keypoints or angle == 0:
        return None
    other = trial.model_copy(update={"head_angle_deg": -angle})
    found = _pose_share_or_zero(lambda: _pose_share_if_plausible(study, other, camera, depth_m))
    if found < MIN_FOUND_SHARE:
        return None
    return InputIssue(
        str(study.root / "trials.csv"),
        f"trial {trial.trial_id}, column head_angle_deg",
        f"{angle:g}, with which the robot in the video is not found as it is",
        f"{-angle:g}, with which it is found in {100 * found:.0f} % of the frames and swims ahead",
        "Change the sign if the head really turned to the other side (positive: to the robot's "
        "right). If it did not, the video is mirrored.",
    )


def _pose_share_if_plausible(
    study: Study, trial: Trial, camera: PoolCamera, depth_m: float
) -> float:
    """Share of the frames with a pose, of a trial that passes all checks; otherwise 0."""
    keypoints, _ = detect_in_footage(study, trial, threads=1)
    positions = map_keypoints(camera, keypoints, depth_m)
    pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
    if plausibility_findings(study, trial, positions, pose):
        return 0.0
    return float(np.isfinite(pose.values[:, 0]).mean())


def _pose_share_or_zero(share: Callable[[], float]) -> float:
    """A share of frames; 0 if nothing can be detected."""
    try:
        return share()
    except (InputError, np.linalg.LinAlgError, ArithmeticError):
        return 0.0
