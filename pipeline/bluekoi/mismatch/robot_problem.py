"""The robot's trials, coefficients and candidate causes as the engine takes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..camera.rigid_distances import STATED_LENGTH_STD_SHARE
from ..camera.smoothing_detection import CAUSES_CONFOUNDED_WITH_SMOOTHING
from ..engine import CauseSearchProblem, PriorInclusionProbabilities, candidates_from_effects
from ..fitting import Noise, TrialEffect, TrialSeries
from ..integrate import CompiledSystem, System
from ..model import MOTION_VARIABLES, RobotScaleRatios, residual_channels_and_variables
from ..model.two_plate_model import CONTROL_INPUT_NAMES
from ..tuning import HEAD_ANGLE_STD_RAD, JointFit, robot_units_of_trials
from .camera_displacement import (
    CAMERA_SHIFT_EFFECT,
    NULL_DISTRIBUTION_TAIL_FACTOR,
    CameraDisplacement,
)
from .wrong_clock import CLOCK_CAUSE, candidates_with_constant_clock_error, trials_with_wrong_clock

SERVO_STD_RAD = np.radians(0.3)  # ASSUME a hobby servo repeats a commanded angle to 0.3 degrees
LOGGED_FREQUENCY_STD_SHARE = (
    0.003  # ASSUME the log's flapping frequency is right to 0.3 % in each trial
)
START_TIME_STD_S = 1 / 60
"""ASSUME standard deviation of the time between first frame and start of the motor in careful work:
half a frame interval at 30 frames/s. It holds for the error common to all trials and for the
independent error of each trial. In ten studies of `tidal_lock` 9402, of which one has starts that
scatter, the log likelihood without causes changes by 1.0, 0.7, -2.5 and -7.9 in the median with
1/4, 1/2, 2 and 4 times the error of each trial (`python -m validation first-frame`): they are
compatible with this value and smaller ones."""
PRIOR_INCLUSION_PROBABILITIES = PriorInclusionProbabilities(
    cause=0.03, unlisted=0.10, likely={"tail_fin_lift": 0.5}
)
"""About one of 30 causes acts in a study, one study in ten has a force that is not listed, and the
published model cannot swim straight without a fin (docs/paper.md, Audit)."""
KEYPOINT_LABEL_STD_M = 0.001  # ASSUME keypoints are labelled to 1 mm on the published body
CORE_LABEL_DISTANCE_M, HEAD_LABEL_DISTANCE_M = (
    0.2,
    0.12,
)  # lengths over which labels define the directions of core and head
UNKNOWN_DEPTH_SCALE_ERROR_STD = 0.02
"""Error of positions, as a share, where the keypoints' depth is not known: those d below the plane
are seen too near the middle by d / (1.33 H), 2 % for d = 4 cm and a camera at H = 1.5 m."""
TOLERATED_ERRORS_WITH_HOMOGRAPHY = {"scale_error.length_error": UNKNOWN_DEPTH_SCALE_ERROR_STD}
"""A homography from the pool's corners puts keypoints on the water's plane."""
INITIAL_WATER_CURRENT_STD_M_S = 0.003
"""Standard deviation of each component of the random current with which the estimate of the noise
begins, for the published robot: a start, no prior. From a tenth and from ten times of it, the log
joint densities of five sets of three studies become higher by 0.3 at most (`python -m validation
noise-starts`; docs/decisions/064)."""
MIN_TURNED_HEAD_ANGLE_RAD = np.radians(2.0)
"""Head angles up to this are straight swimming with an error of the servo."""
CAUSE_KINDS = ("physics", "measurement", "residual")


def robot_cause_search_problem(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    baseline: JointFit,
    *,
    displaced: Sequence[CameraDisplacement],
    by_homography: bool = False,
    smoothed_keypoints: bool = False,
    progress: Callable[[str], None],
) -> CauseSearchProblem:
    """`CauseSearchProblem` of a campaign.

    series: of `downsampled_with_head_angle_changes`, since the constant error of the measured head
    angle is a trial effect here.
    displaced: camera displacements found; only with them is `camera_shift` a candidate. Their
    moments were chosen from many, which lowers its prior probability, as that of a wrong clock in
    some trials, which were split at one of as many places as there are trials. by_homography:
    whether the camera has no matrix, so that the keypoints' depth is not corrected.
    smoothed_keypoints: whether the keypoints were smoothed before they were read; then
    `CAUSES_CONFOUNDED_WITH_SMOOTHING` are not candidates.
    """
    system, units = kernel.system, robot_units_of_trials(series)
    smoothed = CAUSES_CONFOUNDED_WITH_SMOOTHING if smoothed_keypoints else ()
    left_out = {*undetermined_causes(system, series), *smoothed}
    names = [e.name for e in system.effects if e.kind in CAUSE_KINDS and e.name not in left_out
             and (displaced or e.name != CAMERA_SHIFT_EFFECT)]  # fmt: skip
    odds = PRIOR_INCLUSION_PROBABILITIES.cause * np.exp(
        -NULL_DISTRIBUTION_TAIL_FACTOR * sum(np.log(len(series) * d.moments) for d in displaced)
    )
    likely = {**(PRIOR_INCLUSION_PROBABILITIES.likely or {}), CAMERA_SHIFT_EFFECT: float(odds)}
    if trials_with_wrong_clock(series):
        likely[CLOCK_CAUSE] = PRIOR_INCLUSION_PROBABILITIES.cause / len(series)
    priors = replace(PRIOR_INCLUSION_PROBABILITIES, likely=likely)
    candidates = candidates_from_effects(system, names, priors, residual_channels_and_variables())
    return CauseSearchProblem(
        kernel=kernel,
        series=tuple(series),
        base=baseline.base,
        coefficients=baseline.fit.free,
        candidates=candidates_with_constant_clock_error(candidates, series),
        noise=replace(
            noise_with_random_water_current(baseline.noise, system, units),
            trial_effects=_trial_error_effects(baseline),
            fixed_scales=(),
        ),
        tolerances={
            **keypoint_label_offset_stds(units),
            "time_offset.start_delay": START_TIME_STD_S,
            "scale_error.length_error": STATED_LENGTH_STD_SHARE,
            **(TOLERATED_ERRORS_WITH_HOMOGRAPHY if by_homography else {}),
        },
        state_variables=MOTION_VARIABLES,
        progress=progress,
    )


def noise_with_random_water_current(noise: Noise, system: System, units: RobotScaleRatios) -> Noise:
    """The noise of a baseline, which has random forces and tracking errors alone, with a random
    current.
    """
    std = INITIAL_WATER_CURRENT_STD_M_S * units.speed_ratio
    tau = system.parameters[system.parameter_index["random_current.tau"]].start
    return replace(noise, disturbance=np.concatenate([noise.disturbance, [std, std]]),
                   tau=np.concatenate([noise.tau, [tau, tau]]))  # fmt: skip


def keypoint_label_offset_stds(units: RobotScaleRatios) -> dict[str, float]:
    """Parameters of `keypoint_bias` -> lasting offset (m, rad) that is careful work, not an error
    of the measurement to be named; labels are placed by parts of the body, so that it goes with the
    length of the robot.
    """
    heading = KEYPOINT_LABEL_STD_M / CORE_LABEL_DISTANCE_M
    return {
        "keypoint_bias.forward_offset": KEYPOINT_LABEL_STD_M * units.length,
        "keypoint_bias.left_offset": KEYPOINT_LABEL_STD_M * units.length,
        "keypoint_bias.heading_offset": heading,
        "keypoint_bias.head_angle_offset": float(
            np.hypot(heading, KEYPOINT_LABEL_STD_M / HEAD_LABEL_DISTANCE_M)
        ),
    }


def undetermined_causes(system: System, series: Sequence[TrialSeries]) -> list[str]:
    """Names of the effects that these trials do not identify, whatever their size."""
    angles = np.array(
        [np.median(s.inputs[:, CONTROL_INPUT_NAMES.index("head_angle")]) for s in series]
    )
    if (angles > MIN_TURNED_HEAD_ANGLE_RAD).any() and (angles < -MIN_TURNED_HEAD_ANGLE_RAD).any():
        return []
    return [e.name for e in system.effects if e.needs_both_sides]


def undetermined_cause_warnings(system: System, series: Sequence[TrialSeries]) -> list[str]:
    """A sentence for each of `undetermined_causes`: what to film."""
    return [
        f"{name} cannot be judged, because the fitted trials do not turn to both sides. Film the "
        "same head angles to the other side as well, and do not hold out all turns to one side."
        for name in undetermined_causes(system, series)
    ]


def _trial_error_effects(baseline: JointFit) -> tuple[TrialEffect, ...]:
    """Errors of the commanded head angle, of the thrust, which goes with the square of the
    flapping frequency, of the measured head angle, and of the time of the start, in each trial.
    """
    thrust = abs(baseline.fit.values_by_label()["C_T"])
    return (
        TrialEffect("servo_error.angle", float(SERVO_STD_RAD)),
        TrialEffect("C_T", 2.0 * LOGGED_FREQUENCY_STD_SHARE * thrust),
        TrialEffect("head_angle_error.angle", HEAD_ANGLE_STD_RAD),
        TrialEffect("time_offset.start_delay", START_TIME_STD_S),
    )
