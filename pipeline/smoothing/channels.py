"""The chains of a pose: an angle for itself, and the position in the frame of the heading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from .chain import Chain
from .course import course
from .grid import Grid
from .lasting import with_lasting
from .measured import Measured, measured
from .motion import heading_matrices, planar_matrices, planar_measurement
from .search import Found, gate_of, most_likely
from .twin import likelihood

SPREADS = (1.0, 6.0, 6.0, 3.0)
"""Spread of the weak prior of log tau, noise of rate, noise of acceleration, start-up factor."""
SPREAD_SHARE, SPREAD_RECOIL, SPREAD_R = 4.0, 3.0, 0.7
HARDLY = 2.0
"""Units of process noise change a rate in a trial by so many deviations with which a steady one
would be known: noise that the trial could just show. A larger unit makes stated deviations of a
steady motion too wide, a smaller one makes those of a hardly disturbed motion too narrow."""
LIVELY, LIVELY_RECOIL = 14.0, 5.0
"""Logarithms over the units from which the search starts, so that no motion looks like an outlier:
from below, it may run off to a huge measurement noise that explains everything."""
LIVELIEST = 0.3, 7.0
"""Densities above which nothing moves: of the rate, speed^2 per unit of time T, and of the
acceleration, (speed / T)^2 per T."""
TOO_WHITE = -0.4
"""Logarithm of the white noise over what is stated, below which some of it may be of a kind that
lasts, and looks like motion."""
SURELY_LASTS = 10.0
"""Twice the log likelihood that errors which last must be better by."""
FRAMES_LASTING, SPREAD_LASTING = 3.0, (2.0, 1.0)
"""Unit of the frames that they last; spread of the prior of their variance and of that time."""
AT_REST = 0.01
"""A body at rest at the first frame moves at less than this share of its usual speed."""
MOVING = 3.0
"""Prior width of a rate, in usual speeds, where it moves."""
STARTING, GOING = 3.0, 0.01
"""Prior width of an acceleration, in usual speeds per unit of time, from rest and in motion."""


@dataclass(frozen=True)
class Going:
    """What is known of the motion before its position is smoothed, at the nodes.

    theta, theta_std, rate_std: (nodes,) mean heading, its deviation and its rate's, rad, rad/s.
    speed: (nodes,) m/s.
    """

    theta: Float
    theta_std: Float
    rate_std: Float
    speed: Float

    @property
    def slip(self) -> Float:
        """Density (nodes,), m^2/s^3, of the sway that an error of the heading looks like.

        An error e of the heading turns speed u into a sway u e; e changes at the rate's error,
        which lasts theta_std / rate_std: u^2 rate_std^2 (theta_std / rate_std).
        """
        return np.asarray(self.speed**2 * self.theta_std * self.rate_std)


def angle_chain(
    angle: Float,
    variance: Float,
    grid: Grid,
    *,
    speed: Float,
    flap_hz: float,
    resting: bool,
    lasting: bool = False,
) -> Found:
    """Most likely chain of an angle (nodes,) [rad, unwrapped] with its variance, NaN unseen.

    speed: (nodes,) of the body, m/s. resting: whether it does not turn in the first frame.
    lasting: try errors that last even where the noise left does not ask for them.
    """
    data = measured(angle[:, None], variance[:, None, None], grid)
    way = course(data, speed, np.zeros(len(speed)), resting=resting)
    H = np.zeros((len(angle), 1, 5 if flap_hz > 0 else 3))
    H[:, 0, 0] = 1.0
    H[:, 0, 3:4] = 1.0
    return _found(
        data,
        grid,
        H,
        lambda noise: heading_matrices(noise, grid.dt_s, flap_hz, way),
        resting=resting,
        lasting=lasting,
    )


def planar_chain(
    xy: Float,
    cov: Float,
    grid: Grid,
    *,
    going: Going,
    flap_hz: float,
    resting: bool,
    lasting: bool = False,
) -> Found:
    """Most likely chain of a position (nodes, 2) [m] with its covariance (nodes, 2, 2).

    resting: whether it is at rest in the first frame. lasting: as for `angle_chain`.
    """
    data = measured(xy, cov, grid)
    way = course(data, going.speed, going.slip, resting=resting)
    return _found(
        data,
        grid,
        planar_measurement(going.theta, flap_hz),
        lambda noise: planar_matrices(noise, grid.dt_s, flap_hz, way, going.theta),
        resting=resting,
        lasting=lasting,
    )


def moving_cost(found: Found) -> float:
    """Cost of a chain found at rest, were it moving in the first frame; the noise unchanged."""
    chain = found.chain
    m = chain.z.shape[1]
    P0 = chain.P0.copy()
    rates = np.arange(m, 2 * m)
    P0[rates, rates] *= (MOVING / AT_REST) ** 2
    gate = gate_of(m)
    other = replace(chain, P0=P0)
    return found.cost + likelihood(other, found.first, gate) - likelihood(chain, found.first, gate)


def _found(
    data: Measured,
    grid: Grid,
    H: Float,
    matrices: Callable[[Float], tuple[Float, Float]],
    *,
    resting: bool,
    lasting: bool,
) -> Found:
    """Most likely chain of these measurements, matrices (F, Q) given the noise."""
    m = data.z.shape[1]
    recoils = (H.shape[2] - 3 * m) // 2
    units = _units(data, grid, recoils)
    x0, widths = _prior(data, grid.scale_s, recoils, resting)

    def build(logs: Float) -> Chain:
        noise = units * np.exp(logs[:-1])
        F, Q = matrices(noise)
        steady = 0.0 if resting else 0.5 * noise[0] * noise[2]
        first = np.concatenate([widths[:2], widths[2:] + steady])
        beats = noise[len(noise) - recoils :]
        P0 = np.diag(np.concatenate([np.repeat(first, m), np.repeat(beats, 2)]))
        return Chain(F, Q, H, data.R * np.exp(logs[-1]), data.z, x0, P0)

    shares = [SPREAD_SHARE] * (m - 1)
    spread = np.array([*SPREADS, *shares, *[SPREAD_RECOIL] * recoils, SPREAD_R])
    T = grid.scale_s
    top = np.log(np.array(LIVELIEST) * data.speed**2 / np.array([T, T**3]) / units[1:3])
    found = most_likely(
        build,
        data.seen,
        first=data.plausible,
        spread=spread,
        starts=_starts(m, recoils, np.full(2, LIVELY)),
        livelier=_starts(m, recoils, np.maximum(top, LIVELY)),
    )
    if found.logs[-1] > TOO_WHITE and not lasting:
        return found
    return _lasting(found, build, data, grid, spread=spread)


def _lasting(
    found: Found, build: Callable[[Float], Chain], data: Measured, grid: Grid, *, spread: Float
) -> Found:
    """The chain with errors that last, where it is surely better than the one found."""
    frame = float(np.median(grid.dt_s[1:]))

    def lasting(logs: Float) -> Chain:
        white = build(np.concatenate([logs[:-3], logs[-1:]]))
        size, time = np.exp(logs[-3:-1])
        return with_lasting(white, grid.dt_s, data.variance * size, FRAMES_LASTING * frame * time)

    quiet = found.logs.copy()
    quiet[1:3] = 0.0
    other = most_likely(
        lasting,
        data.seen,
        first=data.plausible,
        spread=np.concatenate([spread[:-1], SPREAD_LASTING, spread[-1:]]),
        starts=[np.concatenate([s[:-1], [0.0, 0.0, -1.0]]) for s in (quiet, found.logs)],
    )
    if other.cost > found.cost - SURELY_LASTS:
        return found
    return replace(other, shown=other.shown + float(np.exp(other.logs[-3])), lasts=True)


def _starts(m: int, recoils: int, lively: Float) -> list[Float]:
    """Logarithms from which to search: lively in the rate, and lively in the acceleration."""
    others = [*[0.0] * (m - 1), *[LIVELY_RECOIL] * recoils, 0.0]
    pairs = ((lively[0], 0.0, 0.0), (0.0, lively[1], 1.0))
    return [np.array([0.0, *pair, *others]) for pair in pairs]


def _units(data: Measured, grid: Grid, recoils: int) -> Float:
    """Units of tau (s), density of rate and acceleration noise, start-up, share of sway, recoils.

    A steady rate is known to 12 R / (frames span^2) (slope of a line through white noise).
    """
    steady = 12 * data.variance / (data.plausible.sum() * data.span_s**2)
    densities = HARDLY**2 * steady * np.array([1 / data.span_s, 3 / data.span_s**3])
    shares = [1.0] * (data.z.shape[1] - 1)
    return np.array([2 * grid.scale_s, *densities, 3.0, *shares, *[data.variance] * recoils])


def _prior(data: Measured, T: float, recoils: int, resting: bool) -> tuple[Float, Float]:
    """Mean of the first state, and prior variances of position, rate and acceleration.

    From rest the acceleration is anything; in motion it is that of the process, and a little more.
    """
    z, m = data.z[data.plausible], data.z.shape[1]
    reach = float(np.ptp(z, axis=0).max()) + data.speed * T
    rate = (AT_REST if resting else MOVING) * data.speed
    push = (STARTING if resting else GOING) * data.speed / T
    x0 = np.zeros(3 * m + 2 * recoils)
    x0[:m] = np.median(z[:5], axis=0)
    return x0, np.array([reach**2, rate**2, push**2])
