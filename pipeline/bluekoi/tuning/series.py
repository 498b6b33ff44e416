"""Measured trials of a study as the fit takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import FlappingFrequency, Float, Pose, Track, has_excess_variance
from ..fitting import TrialSeries
from ..fitting.block_average import DEFAULT_BLOCK_RATE_HZ
from ..model import RobotScaleRatios, constants_of_robot_trial, robot_scale_ratios, two_plate_system
from ..observation import camera_error_inputs
from ..study import Study, StudySettings, Trial
from .similar_robots import HEAD_ANGLE_COLUMN, downsampled, state_std_scaled_to_robot

OUTLIER_SIGMA = 6.0
HEAD_ANGLE_STD_RAD = 0.01
"""ASSUME 0.6 degrees: standard deviation of the error of the measured head angle that is constant
within a trial. In the search for causes, the servo's error (`SERVO_STD_RAD`) has a part of its
own."""
RECOIL_ERROR_CORRELATION_BEATS = 0.25
"""Beats for which an error of the recoil keeps its sign: an oscillation is on one side for half a
beat, and its mean over longer blocks falls. Once a beat makes the true causes of 14 known studies
less likely, by 13 in the median (docs/decisions/052)."""
NOISE_REFERENCE_FLAP_HZ = 3.5
"""Flapping frequency of the published robot at which `Noise.disturbance` states the forces."""
INITIAL_STATE_STD = np.array([0.1, 0.1, 0.05, 0.05, 0.05, 0.3])  # m, m, rad, m/s, m/s, rad/s
"""For the published robot; of the place as much as the centre of mass may be off the keypoint."""
RESTING_VELOCITY_STD = np.array([0.01, 0.01, 0.06])  # m/s, m/s, rad/s
"""ASSUME standard deviations of the velocities of a robot at rest in the first frame: residual
motion of robot and water, for the published robot. In ten studies of `tidal_lock` 9402, the log
likelihood without causes changes by 10, 10, -21 and -61 in the median with 1/4, 1/2, 2 and 5 times
these values (`python -m validation first-frame`; at worst by -16, -12, -39 and -100)."""
MIN_START_OVER_STEADY_SPEED = 0.3
"""Speed in the first frame, over that of the second half, above which a trial begins swimming. Of
1600 simulated trials from rest, one has more than 0.12 (0.17); the true speeds of 405 simulated
trials that begin swimming give 0.32 to 0.99 (`campus_pool`)."""
ASSUMED_PRIOR_MOTOR_RUN_S = 600.0
"""Time since which the motor of a trial that begins swimming runs: its start has no part in it."""


def study_series(
    study: Study,
    poses: Mapping[str, Pose],
    tracks: Mapping[str, Track],
    flapping: Mapping[str, FlappingFrequency],
    *,
    skipped_s: float = 0.0,
) -> list[TrialSeries]:
    """A `TrialSeries` for every trial that has a pose, a track and a flapping frequency.

    skipped_s: of `trial_series`, in trials whose keypoints are read from files.
    """
    before = [0.0, *(trial.head_angle_rad for trial in study.trials)]
    places = session_order_fractions(len(study.trials))
    return [
        trial_series(trial, study.setup, poses[i], tracks[i], flapping[i], angle_before_rad=angle,
                     session_place=float(place),
                     skipped_s=skipped_s if trial.reads_keypoints else 0.0)
        for trial, angle, place in zip(study.trials, before, places, strict=False)
        for i in [trial.trial_id]
        if i in poses and i in tracks and i in flapping
    ]  # fmt: skip


def session_order_fractions(trials: int) -> Float:
    """Place (trials,) of each trial of a session, from 0, the first, to 1; 0.5 of a single one."""
    return np.linspace(0.0, 1.0, trials) if trials > 1 else np.full(trials, 0.5)


def trial_series(
    trial: Trial, setup: StudySettings, pose: Pose, track: Track, flapping: FlappingFrequency, *,
    angle_before_rad: float = 0.0, session_place: float = 0.5, skipped_s: float = 0.0,
) -> TrialSeries:  # fmt: skip
    """One trial: poses without the tail-beat recoil, outliers and frames that were hardly seen, and
    what was commanded, from the start of the motor on. angle_before_rad: head angle commanded in
    the trial before. session_place: place of the trial in the session, from 0 to 1. skipped_s:
    duration after the first frame that is left out of trials more than twice as long.

    The initial state is that of the track, known to `INITIAL_STATE_STD`; at rest, its velocities
    are 0, known to `RESTING_VELOCITY_STD`.

    The head angle of a trial counts as one observation of `HEAD_ANGLE_STD_RAD`, spread over its
    frames, since its error is the same in every frame (`downsampled_with_head_angle_changes`).
    """
    started = float(np.nan_to_num(flapping.start_s))
    started = started if started < 0.5 * track.time_s[-1] else 0.0
    skipped = skipped_s if 2.0 * skipped_s < np.ptp(track.time_s) else 0.0
    first = max(track.time_s[0], pose.time_s[0] + started) + skipped - 1e-6
    last = track.time_s[-1] + 1e-6
    inside = (pose.time_s >= first) & (pose.time_s <= last)
    times = pose.time_s[inside]
    seen = _without_recoil(pose.values[inside], times, track)
    noise = pose.cov[inside].copy()
    noise[:, 3, :3] = noise[:, :3, 3] = 0.0
    noise[:, 3, 3] += _head_angle_variance_per_frame(len(times))
    unusable = ~np.all(np.isfinite(noise), axis=(1, 2)) | _is_far_from_track(
        seen, noise, times, track
    )
    unusable |= _is_poorly_seen(noise, unusable)
    noise += _recoil_covariance(times, track, flapping.flap_hz)
    seen[unusable] = np.nan
    noise[unusable] = np.eye(4)
    start = _initial_state_from_track(times, track)
    swims = skipped > 0 or _swims_in_first_frame(track)
    start_std = INITIAL_STATE_STD.copy()
    if not swims and started >= 0.0:
        start[3:], start_std[3:] = 0.0, RESTING_VELOCITY_STD
    start_std = state_std_scaled_to_robot(robot_scale_ratios(setup.robot), start_std)
    others = len(two_plate_system().all_states) - len(start_std)
    return TrialSeries(
        name=trial.trial_id,
        group=format(trial.power_pct, "g"),
        condition=condition_label(trial),
        times=times - pose.time_s[0],
        inputs=np.tile([trial.head_angle_rad, flapping.flap_hz], (len(times), 1)),
        constants=constants_of_robot_trial(
            setup,
            trial.head_length_m,
            heading_rad=start[2],
            place_m=(start[0], start[1]),
            angle_before_rad=angle_before_rad,
            start_s=-ASSUMED_PRIOR_MOTOR_RUN_S if swims else started,
            view=camera_error_inputs(setup, session_place),
        ),
        seen=seen,
        noise=noise,
        mean=np.concatenate([start, np.zeros(others)]),
        cov=np.diag(np.concatenate([start_std, np.full(others, 1e-6)]) ** 2),
        force_size=_random_force_size(flapping.flap_hz, robot_scale_ratios(setup.robot)),
    )


def downsampled_with_head_angle_changes(
    series: Sequence[TrialSeries], rate_hz: float = DEFAULT_BLOCK_RATE_HZ
) -> list[TrialSeries]:
    """As `downsampled`, but changes of the head angle within a trial count: its noise is that of
    the frames, for fits that have the error which is constant within a trial as a `TrialEffect`.

    series: as `trial_series` makes them.
    """
    out, o = [], HEAD_ANGLE_COLUMN
    for one in series:
        noise = one.noise.copy()
        noise[:, o, o] -= _head_angle_variance_per_frame(len(one.times))
        out.append(replace(one, noise=noise))
    return downsampled(out, rate_hz, constant=())


def _head_angle_variance_per_frame(frames: int) -> float:
    """Variance of a frame's head angle (rad^2) for which `frames` of them are one observation."""
    return HEAD_ANGLE_STD_RAD**2 * frames


def _swims_in_first_frame(track: Track) -> bool:
    """Whether the trial begins while the robot swims: the motor started long before."""
    steady = float(np.nanmedian(track.speed_m_s[len(track.time_s) // 2 :]))
    return float(track.speed_m_s[0]) > MIN_START_OVER_STEADY_SPEED * steady


def _random_force_size(flap_hz: float, units: RobotScaleRatios) -> float:
    """Size of the random forces in a trial, over that at the usual flapping frequency.

    Water that moves at random by w changes the dynamic pressure by rho V w, and the speed V goes
    with the flapping frequency. The trials of the search's generators are likelier with forces of
    this size than with equal ones (docs/decisions/052).
    """
    beats = flap_hz * units.time / NOISE_REFERENCE_FLAP_HZ
    return beats if np.isfinite(beats) and beats > 0 else 1.0


def condition_label(trial: Trial) -> str:
    """What repeats of a trial share, both turning sides apart: `50 % -30 deg 0.12 m`."""
    return f"{trial.power_pct:g} % {trial.head_angle_deg:g} deg {trial.head_length_m:g} m"


def _without_recoil(values: Float, times: Float, track: Track) -> Float:
    out = values.copy()
    for i in range(3):
        out[:, i] -= np.interp(times, track.time_s, track.recoil[:, i])
    smooth = np.interp(times, track.time_s, track.heading_rad)
    out[:, 2] += 2 * np.pi * np.round((smooth - out[:, 2]) / (2 * np.pi))
    return out


def _recoil_covariance(times: Float, track: Track, flap_hz: float) -> Float:
    """Covariance (n, 4, 4) that the error of the recoil adds to a frame where it is larger than
    usual: mean motion and recoil are confused where the recoil builds up.

    The usual error oscillates with the beat and averages out. The excess keeps its sign for
    `RECOIL_ERROR_CORRELATION_BEATS`: it counts once in that time, not once a frame.
    """
    step = float(np.median(np.diff(times)))
    lasting = max(RECOIL_ERROR_CORRELATION_BEATS / (flap_hz * step), 1.0) if flap_hz > 0 else 1.0
    out = np.zeros((len(times), 4, 4))
    for i, variance in enumerate(track.recoil_std.T**2):
        excess = np.maximum(variance - np.median(variance), 0.0)
        out[:, i, i] = lasting * np.interp(times, track.time_s, excess)
    return out


def _is_far_from_track(seen: Float, noise: Float, times: Float, track: Track) -> np.ndarray:
    """Frames where x, y or heading lies far from the smoothed track, by robust deviation."""
    smooth = [np.interp(times, track.time_s, k) for k in (track.x_m, track.y_m, track.heading_rad)]
    off = (seen[:, :3] - np.column_stack(smooth)) / np.sqrt(np.einsum("nii->ni", noise[:, :3, :3]))
    spread = 1.4826 * np.nanmedian(np.abs(off), axis=0)
    return np.any(np.abs(off) > OUTLIER_SIGMA * np.maximum(spread, 1e-9), axis=1)


def _is_poorly_seen(noise: Float, unusable: np.ndarray) -> np.ndarray:
    """Frames whose x, y or heading is poorly seen (two labels that changed places: 35 mm in place
    of 0.2); in the fit a frame is averaged evenly with its neighbours.
    """
    variance = np.einsum("nii->ni", noise[:, :3, :3])
    usual = np.median(variance[~unusable], axis=0) if not unusable.all() else np.inf
    return np.any(has_excess_variance(variance, usual), axis=1)


def _initial_state_from_track(times: Float, track: Track) -> Float:
    """x, y, heading, surge, sway, yaw rate at the first frame, from the track."""
    at = [
        float(np.interp(times[0], track.time_s, value))
        for value in (track.x_m, track.y_m, track.heading_rad, track.vx_m_s, track.vy_m_s,
                      track.yaw_rate_rad_s)
    ]  # fmt: skip
    c, s = np.cos(at[2]), np.sin(at[2])
    return np.array([*at[:3], at[3] * c + at[4] * s, at[4] * c - at[3] * s, at[5]])
