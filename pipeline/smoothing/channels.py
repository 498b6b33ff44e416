"""The chains of a pose: an angle for itself, and the position in the frame of the heading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from .chain import Chain, Mask
from .grid import Grid
from .motion import heading_matrices, planar_matrices, planar_measurement
from .search import Found, gate_of, most_likely
from .twin import likelihood

SPREADS = (1.0, 4.0, 4.0, 3.0)
"""Spread of the weak prior of log tau, noise of rate, noise of acceleration, start-up factor."""
SPREAD_RECOIL, SPREAD_R = 3.0, 0.7
AT_REST = 0.01
"""A body at rest at the first frame moves at less than this share of its usual speed."""
MOVING = 3.0
"""Prior width of a rate, in usual speeds, where it moves."""


@dataclass(frozen=True)
class _Measured:
    """Measurements z (nodes, m) with variance R (nodes, m, m) where seen (nodes,).

    plausible: (nodes,) those not far off the line between their neighbours.
    kick: (nodes,) start-up window. speed: usual rate of change of z. variance: usual one of R.
    """

    z: Float
    R: Float
    seen: Mask
    plausible: Mask
    kick: Float
    speed: float
    variance: float


def angle_chain(
    angle: Float, variance: Float, grid: Grid, *, flap_hz: float, resting: bool
) -> Found:
    """Most likely chain of an angle (nodes,) [rad, unwrapped] with its variance, NaN unseen.

    resting: whether it does not turn in the first frame.
    """
    data = _measured(angle[:, None], variance[:, None, None], grid)
    kick = data.kick * resting
    H = np.zeros((len(angle), 1, 5 if flap_hz > 0 else 3))
    H[:, 0, 0] = 1.0
    H[:, 0, 3:4] = 1.0
    return _found(
        data,
        grid,
        H,
        lambda noise: heading_matrices(noise, grid.dt_s, flap_hz, kick),
        resting=resting,
    )


def planar_chain(
    xy: Float, cov: Float, grid: Grid, *, theta: Float, flap_hz: float, resting: bool
) -> Found:
    """Most likely chain of a position (nodes, 2) [m] with its covariance (nodes, 2, 2).

    theta: (nodes,) mean heading, rad. resting: whether it is at rest in the first frame.
    """
    data = _measured(xy, cov, grid)
    kick = data.kick * resting
    return _found(
        data,
        grid,
        planar_measurement(theta, flap_hz),
        lambda noise: planar_matrices(noise, grid.dt_s, flap_hz, kick, theta),
        resting=resting,
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
    data: _Measured,
    grid: Grid,
    H: Float,
    matrices: Callable[[Float], tuple[Float, Float]],
    *,
    resting: bool,
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
        P0 = np.diag(np.concatenate([np.repeat(first, m), np.repeat(noise[4:], 2)]))
        return Chain(F, Q, H, data.R * np.exp(logs[-1]), data.z, x0, P0)

    spread = np.array([*SPREADS, *[SPREAD_RECOIL] * recoils, SPREAD_R])
    return most_likely(build, data.seen, first=data.plausible, spread=spread)


def _measured(z: Float, R: Float, grid: Grid) -> _Measured:
    seen = np.asarray(np.isfinite(z).all(axis=1) & np.isfinite(R).all(axis=(1, 2)))
    m = z.shape[1]
    R = np.where(seen[:, None, None], R, np.eye(m))
    z = np.where(seen[:, None], z, 0.0)
    plausible = seen.copy()
    plausible[seen] = _near_neighbours(z[seen])
    t, at = grid.time_s[plausible], z[plausible]
    variance = float(np.median(np.trace(R[plausible].T))) / m
    # over whole beats, in which the recoil is back where it was
    beats = round(grid.scale_s / float(np.median(np.diff(t))))
    lag = max(min(beats, len(t) // 3), 1)
    rates = np.abs(at[lag:] - at[:-lag]).max(axis=1) / (t[lag:] - t[:-lag])
    floor = np.sqrt(variance) / max(float(np.ptp(t)), 1e-9)
    speed = float(max(np.quantile(rates, 0.8), floor))
    return _Measured(z, R, seen, plausible, _kick(grid, t, at), speed, variance)


def _near_neighbours(z: Float) -> Mask:
    """Points (n,) within 8 robust deviations of what their neighbours say.

    Neighbours say the median of (z[k-j] + z[k+j]) / 2, j = 1, 2, 3, and at the ends that of the
    lines 2 z[k+j] - z[k+2j]. Only gross errors: recoil and start pass.
    """
    n = len(z)
    k, j = np.arange(n), np.array([1, 2, 3])[:, None]
    inside = (k - 3 >= 0) & (k + 3 < n)
    ahead = np.where(k < n / 2, 1, -1)
    near, far = np.clip(k + ahead * j, 0, n - 1), np.clip(k + 2 * ahead * j, 0, n - 1)
    between = 0.5 * (z[np.clip(k - j, 0, n - 1)] + z[np.clip(k + j, 0, n - 1)])
    told = np.where(inside[:, None], between, 2 * z[near] - z[far])
    away = np.abs(z - np.median(told, axis=0))
    scale = 1.4826 * np.median(away, axis=0)
    return np.asarray((away <= 8 * np.maximum(scale, 1e-12)).all(axis=1))


def _kick(grid: Grid, time_s: Float, z: Float) -> Float:
    """Window exp(-|t - t_start| / T) around the onset of the motion, (nodes,).

    Onset: where the path leaves its first place by a fiftieth of its extent.
    """
    away = np.linalg.norm(z - np.median(z[:5], axis=0), axis=1)
    moved = away > 0.02 * max(float(np.quantile(away, 0.95)), 1e-300)
    lasting = np.minimum.accumulate(moved[::-1])[::-1]
    onset = time_s[int(np.argmax(lasting))] if lasting.any() else time_s[0]
    return np.asarray(
        np.exp(-np.abs(grid.time_s - max(onset - grid.scale_s, time_s[0])) / grid.scale_s)
    )


def _units(data: _Measured, grid: Grid, recoils: int) -> Float:
    """Units of tau (s), density of rate noise and of acceleration noise, start-up, recoils."""
    T, speed = grid.scale_s, data.speed
    densities = [2 * T, (0.0004 * speed) ** 2 / T, (0.002 * speed / T) ** 2 / T]
    return np.array([*densities, 3.0, *[data.variance] * recoils])


def _prior(data: _Measured, T: float, recoils: int, resting: bool) -> tuple[Float, Float]:
    """Mean of the first state, and prior variances of position, rate and acceleration.

    From rest the acceleration is anything; in motion it is that of the process, and a little more.
    """
    z, m = data.z[data.plausible], data.z.shape[1]
    reach = float(np.ptp(z, axis=0).max()) + data.speed * T
    rate = (AT_REST if resting else MOVING) * data.speed
    push = (3.0 if resting else 0.05) * data.speed / T
    x0 = np.zeros(3 * m + 2 * recoils)
    x0[:m] = np.median(z[:5], axis=0)
    return x0, np.array([reach**2, rate**2, push**2])
