"""State-space models of the two channels of a pose, fitted: an angle, and the planar position."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..data import Float
from .grid import FilterTimeGrid
from .kalman_numba import minus_two_log_likelihood
from .motion import heading_matrices, planar_matrices, planar_observation_matrix
from .motion_gradient import heading_noise_gradient, planar_noise_gradient
from .motion_model import ColouredNoiseModel, MotionMatrices, MotionModel
from .noise_fit import FittedMotionModel, fit_process_noise, outlier_gate
from .nominal_motion import nominal_motion
from .screening import ScreenedMeasurements, screen_measurements

PRIOR_STDS_OF_LOG_NOISE = (1.0, 6.0, 6.0, 3.0)
"""Prior deviation of the logs of tau, rate noise, acceleration noise and start-up factor."""
PRIOR_STD_OF_LOG_SWAY_SHARE, PRIOR_STD_OF_LOG_RECOIL, PRIOR_STD_OF_LOG_R = 4.0, 3.0, 0.7
RECOIL_COHERENCE_UNIT_BEATS, RECOIL_ONSET_DECAY_UNIT_PER_BEAT = 300.0, 0.15
"""Prior medians of the recoil's coherence and of its decay rate at the onset, where the search
starts. Estimates in five simulated studies have medians of 23 to 33,000 and 0.02 to 0.15."""
PRIOR_STDS_OF_LOG_RECOIL_COHERENCE = (3.0, 3.0)
"""Prior deviations of the logs of both."""
NOISE_UNIT_STANDARD_ERRORS = 2.0
"""Unit of process noise: the density that moves a rate by so many standard errors over a trial. A
larger unit overstates the deviations of a steady motion, a smaller one understates those of a
hardly disturbed one."""
MAX_RELATIVE_NOISE_DENSITIES = 0.3, 7.0
"""Largest density of the rate, in speed^2 / T, and of the acceleration, in (speed / T)^2 / T. The
search starts there: no motion looks like an outlier. From below, it may end at a measurement noise
that explains everything, or a quick start."""
LOG_START_ONSET_FACTOR, LOG_START_RECOIL_NOISE = 3.0, 5.0
"""Logs of the factor on the acceleration's noise at the onset, and of the noise of the recoil, from
which the search starts."""
MAX_LOG_NOISE_RATIO_COLOURED = -0.4
"""Below this log of white over stated noise, part of the error may be coloured."""
MIN_LR_STATISTIC_COLOURED_NOISE = 10.0
"""Gain in twice the log likelihood that coloured noise must bring."""
CORRELATION_TIME_UNIT_FRAMES, PRIOR_LOG_COLOURED_STDS = 3.0, (2.0, 1.0)
"""Unit of the correlation time, in frames; prior deviations of log variance and log time."""
RELATIVE_START_STDS_RESTING, RELATIVE_START_STDS_MOVING = (0.01, 3.0), (3.0, 1.0)
"""Prior standard deviations of the initial rate of change, over the trial's usual one
(`ScreenedMeasurements.speed`), and of the initial acceleration, over usual rate / T: for a start
from rest, and for one in motion."""
STEADY_ACCELERATION_VARIANCE_SHARE = 1e-4
"""Prior variance of the initial acceleration of a body in steady motion, over that of a body that
gains speed in the first frames (a hundredth of its standard deviation). The yaw rate is taken to be
steady: its growth at the start of a turn and the recoil of the heading look alike."""
RESTING_RECOIL_VARIANCE_SHARE = 1e-4
"""Prior variance of the recoil of a body at rest, over that of the recoil in motion. Where the
first frames show a recoil of full size (the tail beats while the body is held), it is 1."""
MIN_LR_STATISTIC_MOVING_START = 12.0
"""Gain in twice the log likelihood that decides between a start from rest and one in motion, of
body or tail; in doubt they start from rest, as in most trials."""


@dataclass(frozen=True)
class KnownMotion:
    """What is known at the nodes (nodes,) before the position is smoothed.

    theta, theta_std, rate_std: heading, its standard deviation and its rate's, rad and rad/s.
    speed: m/s.
    """

    theta: Float
    theta_std: Float
    rate_std: Float
    speed: Float

    @property
    def apparent_sway_noise_density(self) -> Float:
        """Density (nodes,), m^2/s^3, of the apparent sway that errors of the heading cause.

        An error e of the heading turns speed u into a sway u e; e changes at the rate's error,
        which lasts theta_std / rate_std: u^2 rate_std^2 (theta_std / rate_std).
        """
        return np.asarray(self.speed**2 * self.theta_std * self.rate_std)


def fit_angle(
    angle: Float,
    variance: Float,
    grid: FilterTimeGrid,
    *,
    speed: Float,
    flap_hz: float,
    resting: bool,
    coloured: bool = False,
    near: FittedMotionModel | None = None,
    onset: Float | None = None,
) -> FittedMotionModel:
    """Most likely model of an angle (nodes,) [rad, unwrapped] with its variance, NaN if not seen.

    speed: (nodes,) of the body, m/s. resting: it does not turn in the first frame. coloured: try
    coloured noise even if the white noise left does not call for it. near: search from its noise as
    well. onset: (nodes,) window of the start-up, where the position shows it better than the angle,
    which in a straight run leaves its first value by recoil alone.
    """
    data = screen_measurements(angle[:, None], variance[:, None, None], grid)
    if onset is not None:
        data = replace(data, onset=onset)
    nominal = nominal_motion(data, speed, np.zeros(len(speed)), resting=resting)
    H = np.zeros((len(angle), 1, 5 if flap_hz > 0 else 3))
    H[:, 0, 0] = 1.0
    H[:, 0, 3:4] = 1.0
    given = (grid.dt_s, flap_hz, nominal)
    matrices = MotionMatrices(
        lambda noise: heading_matrices(noise, *given),
        lambda noise, by_F, by_Q: heading_noise_gradient(noise, *given, by_F, by_Q),
    )
    return _fit_motion_model(data, grid, H, matrices, resting=resting, coloured=coloured, near=near)


def fit_position(
    xy: Float,
    cov: Float,
    grid: FilterTimeGrid,
    *,
    known: KnownMotion,
    flap_hz: float,
    resting: bool,
    coloured: bool = False,
    near: FittedMotionModel | None = None,
) -> FittedMotionModel:
    """Most likely model of a position (nodes, 2) [m] with its covariance (nodes, 2, 2).

    resting: at rest in the first frame. coloured, near: as for `fit_angle`.
    """
    data = screen_measurements(xy, cov, grid)
    nominal = nominal_motion(data, known.speed, known.apparent_sway_noise_density, resting=resting)
    given = (grid.dt_s, flap_hz, nominal, known.theta)
    matrices = MotionMatrices(
        lambda noise: planar_matrices(noise, *given),
        lambda noise, by_F, by_Q: planar_noise_gradient(noise, *given, by_F, by_Q),
    )
    H = planar_observation_matrix(known.theta, flap_hz)
    return _fit_motion_model(data, grid, H, matrices, resting=resting, coloured=coloured, near=near)


def cost_with_moving_start(fitted: FittedMotionModel) -> float:
    """Cost of a model fitted from rest, were the body moving in the first frame; same noise."""
    m = fitted.model.z.shape[1]
    factor = (RELATIVE_START_STDS_MOVING[0] / RELATIVE_START_STDS_RESTING[0]) ** 2
    P0 = fitted.model.P0.copy()
    P0[np.arange(m, 2 * m), np.arange(m, 2 * m)] *= factor
    return _cost_with_initial_covariance(fitted, P0)


def _cost_with_initial_covariance(fitted: FittedMotionModel, P0: Float) -> float:
    """Cost of a model, were P0 the covariance of its first state; same noise."""
    model, gate = fitted.model, outlier_gate(fitted.model.z.shape[1])
    other = minus_two_log_likelihood(replace(model, P0=P0), fitted.first, gate)
    return fitted.cost + other - minus_two_log_likelihood(model, fitted.first, gate)


def _fit_motion_model(
    data: ScreenedMeasurements,
    grid: FilterTimeGrid,
    H: Float,
    matrices: MotionMatrices,
    *,
    resting: bool,
    coloured: bool,
    near: FittedMotionModel | None,
) -> FittedMotionModel:
    """Most likely model of these measurements."""
    m = data.z.shape[1]
    recoils = (H.shape[2] - 3 * m) // 2
    x0, variances = _initial_state_prior(data, grid.scale_s, recoils, resting)
    units = _noise_units(data, grid, recoils)
    free = MotionModel(data, matrices, H, units, x0, variances, not resting, recoil_share=1.0)
    steady = replace(
        free, start_variances=variances * [1.0, 1.0, STEADY_ACCELERATION_VARIANCE_SHARE]
    )
    model_of_noise: MotionModel = free
    other: MotionModel | None = steady
    least_gain = -MIN_LR_STATISTIC_MOVING_START
    if resting:
        model_of_noise, other = replace(free, recoil_share=RESTING_RECOIL_VARIANCE_SHARE), free
        least_gain = MIN_LR_STATISTIC_MOVING_START
    elif m == 1:
        model_of_noise, other = steady, None
    spread = np.array(
        [
            *PRIOR_STDS_OF_LOG_NOISE,
            *[PRIOR_STD_OF_LOG_SWAY_SHARE] * (m - 1),
            *[PRIOR_STD_OF_LOG_RECOIL] * recoils,
            *(PRIOR_STDS_OF_LOG_RECOIL_COHERENCE if recoils else ()),
            PRIOR_STD_OF_LOG_R,
        ]
    )
    T = grid.scale_s
    largest = np.log(
        np.array(MAX_RELATIVE_NOISE_DENSITIES) * data.speed**2 / [T, T**3] / units[1:3]
    )
    starts = _starting_log_noise(m, recoils, np.maximum(largest, 0.0))
    common: dict[str, Any] = {"first": data.plausible, "spread": spread}
    found = fit_process_noise(
        model_of_noise,
        data.seen,
        starts=starts if near is None else [near.white_noise_logs, *starts],
        **common,
    )
    if (
        other
        and _cost_with_initial_covariance(found, other.model_at_log_noise(found.logs).P0)
        < found.cost - least_gain
    ):
        model_of_noise = other
        found = fit_process_noise(model_of_noise, data.seen, starts=[found.logs, *starts], **common)
    if found.logs[-1] > MAX_LOG_NOISE_RATIO_COLOURED and not coloured:
        return found
    return _with_coloured_noise_if_better(found, model_of_noise, data, grid, spread=spread)


def _with_coloured_noise_if_better(
    found: FittedMotionModel,
    white: MotionModel,
    data: ScreenedMeasurements,
    grid: FilterTimeGrid,
    *,
    spread: Float,
) -> FittedMotionModel:
    """The model with coloured noise, where it is clearly better than the one found."""
    frame = float(np.median(grid.dt_s[1:]))
    quiet = found.logs.copy()
    quiet[1:3] = 0.0
    other = fit_process_noise(
        ColouredNoiseModel(white, grid.dt_s, data.variance, CORRELATION_TIME_UNIT_FRAMES * frame),
        data.seen,
        first=data.plausible,
        spread=np.concatenate([spread[:-1], PRIOR_LOG_COLOURED_STDS, spread[-1:]]),
        starts=[np.concatenate([s[:-1], [0.0, 0.0, -1.0]]) for s in (quiet, found.logs)],
    )
    if other.cost > found.cost - MIN_LR_STATISTIC_COLOURED_NOISE:
        return found
    ratio = other.noise_ratio + float(np.exp(other.logs[-3]))
    return replace(other, noise_ratio=ratio, coloured=True)


def _starting_log_noise(m: int, recoils: int, logs: Float) -> list[Float]:
    """Logs to search from: a motion disturbed in its rate, and one in its acceleration.

    The tail beats sideways: the recoil along the body is taken to be small; as a large one, which
    may hide the start of a motion, it is tried as well.
    """
    shares, loud = [0.0] * (m - 1), [LOG_START_RECOIL_NOISE] * recoils
    quiet = [*[0.0] * (recoils - 1), *loud[:1]]
    rate, acceleration = (logs[0], 0.0, 0.0), (0.0, logs[1], LOG_START_ONSET_FACTOR)
    pairs = [(rate, quiet), (acceleration, quiet)] + [(acceleration, loud)] * (recoils > 1)
    coherence = [0.0, 0.0] if recoils else []
    return [np.array([0.0, *pair, *shares, *beats, *coherence, 0.0]) for pair, beats in pairs]


def _noise_units(data: ScreenedMeasurements, grid: FilterTimeGrid, recoils: int) -> Float:
    """Units of tau (s), density of rate and acceleration noise, start-up, share of sway, recoils,
    their coherence (beats) and decay at the onset (per beat).

    Variance of a steady rate: 12 R / (frames span^2), slope of a line through white noise.
    """
    steady = 12 * data.variance / (data.plausible.sum() * data.span_s**2)
    densities = (
        NOISE_UNIT_STANDARD_ERRORS**2 * steady * np.array([1 / data.span_s, 3 / data.span_s**3])
    )
    shares = [1.0] * (data.z.shape[1] - 1)
    coherence = [RECOIL_COHERENCE_UNIT_BEATS, RECOIL_ONSET_DECAY_UNIT_PER_BEAT] if recoils else []
    return np.array(
        [2 * grid.scale_s, *densities, 3.0, *shares, *[data.variance] * recoils, *coherence]
    )


def _initial_state_prior(
    data: ScreenedMeasurements, T: float, recoils: int, resting: bool
) -> tuple[Float, Float]:
    """Mean of the first state, and prior variances of position, rate and acceleration.

    From rest the acceleration is free; in motion it is that of the process, and a little more.
    """
    z, m = data.z[data.plausible], data.z.shape[1]
    reach = float(np.ptp(z, axis=0).max()) + data.speed * T
    stds = RELATIVE_START_STDS_RESTING if resting else RELATIVE_START_STDS_MOVING
    rate, acceleration = stds[0] * data.speed, stds[1] * data.speed / T
    x0 = np.zeros(3 * m + 2 * recoils)
    x0[:m] = np.median(z[:5], axis=0)
    return x0, np.array([reach**2, rate**2, acceleration**2])
