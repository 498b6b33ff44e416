"""The chains of a pose: an angle for itself, and the position in the frame of the heading."""

from __future__ import annotations

import numpy as np

from ..data import Float
from .chain import Chain, Mask
from .grid import Grid
from .motion import heading_matrices, planar_matrices, planar_measurement
from .search import Found, most_likely

# Spread of the weak prior: log of time constant, noise of rate and of acceleration, recoil
# variances, scale of the measurement variance
SPREAD_TAU, SPREAD_NOISE, SPREAD_RECOIL, SPREAD_R = 1.0, 3.0, 3.0, 1.0


def angle_chain(angle: Float, variance: Float, grid: Grid, flap_hz: float) -> Found:
    """Most likely chain of an angle (nodes,) [rad, unwrapped] with its variance, NaN unseen."""
    seen = np.isfinite(angle) & np.isfinite(variance)
    R = np.where(seen, variance, 1.0)[:, None, None]
    z = np.where(seen, angle, 0.0)[:, None]
    rate, recoil = _scales(grid, z, R, seen)
    H = np.zeros((len(z), 1, 5 if flap_hz > 0 else 3))
    H[:, 0, 0] = 1.0
    H[:, 0, 3:4] = 1.0

    def build(logs: Float) -> Chain:
        noise = _noise(logs, grid, rate, recoil)
        F, Q = heading_matrices(noise, grid.dt_s, flap_hz)
        x0, P0 = _prior(z, seen, (rate, grid.scale_s), noise[3:], flap_hz > 0)
        return Chain(F, Q, H, R * np.exp(logs[-1]), z, x0, P0)

    start, spread = _start(1)
    return most_likely(build, seen, start=start, spread=spread)


def planar_chain(xy: Float, cov: Float, grid: Grid, *, theta: Float, flap_hz: float) -> Found:
    """Most likely chain of a position (nodes, 2) [m] with its covariance (nodes, 2, 2).

    theta: (nodes,) mean heading, rad.
    """
    seen = np.isfinite(xy).all(axis=1) & np.isfinite(cov).all(axis=(1, 2))
    R = np.where(seen[:, None, None], cov, np.eye(2))
    z = np.where(seen[:, None], xy, 0.0)
    speed, recoil = _scales(grid, z, R, seen)
    H = planar_measurement(theta, flap_hz)

    def build(logs: Float) -> Chain:
        noise = _noise(logs, grid, speed, recoil)
        F, Q = planar_matrices(noise, grid.dt_s, flap_hz, theta)
        x0, P0 = _prior(z, seen, (speed, grid.scale_s), noise[3:], flap_hz > 0)
        return Chain(F, Q, H, R * np.exp(logs[-1]), z, x0, P0)

    start, spread = _start(2)
    return most_likely(build, seen, start=start, spread=spread)


def _start(recoils: int) -> tuple[Float, Float]:
    """Start and spread of the logs: tau, rate noise, acceleration noise, recoils, scale of R."""
    spread = [SPREAD_TAU, SPREAD_NOISE, SPREAD_NOISE, *[SPREAD_RECOIL] * recoils, SPREAD_R]
    return np.zeros(len(spread)), np.array(spread)


def _noise(logs: Float, grid: Grid, speed: float, variance: float) -> Float:
    """Time constant tau (s), density of rate noise, density of acceleration noise, recoil variances."""
    T = grid.scale_s
    units = [2 * T, (0.05 * speed) ** 2 / T, (0.3 * speed / T) ** 2 / T]
    return np.array([*units, *[variance] * (len(logs) - 4)]) * np.exp(logs[:-1])


def _scales(grid: Grid, z: Float, R: Float, seen: Mask) -> tuple[float, float]:
    """Usual speed of a coordinate (per s) and measurement variance: the units of the noise."""
    t, at, variance = grid.time_s[seen], z[seen], float(np.median(np.trace(R[seen].T)))
    lag = max(min(10, len(t) // 3), 1)
    rates = np.abs(at[lag:] - at[:-lag]).max(axis=1) / (t[lag:] - t[:-lag])
    floor = np.sqrt(variance) / max(float(np.ptp(t)), 1e-9)
    return float(max(np.quantile(rates, 0.8), floor)), variance / z.shape[1]


def _prior(
    z: Float, seen: Mask, scales: tuple[float, float], recoil: Float, oscillates: bool
) -> tuple[Float, Float]:
    """Prior of the first state: wide in position, rate and acceleration; recoil stationary."""
    speed, T = scales
    m = z.shape[1]
    start = np.median(z[seen][:5], axis=0)
    reach = float(np.ptp(z[seen], axis=0).max()) + speed * T
    widths = [reach**2] * m + [(10 * speed) ** 2] * m + [(10 * speed / T) ** 2] * m
    x0 = np.concatenate([start, np.zeros(2 * m)])
    if oscillates:
        widths += [float(v) for v in np.repeat(recoil, 2)]
        x0 = np.concatenate([x0, np.zeros(2 * len(recoil))])
    return x0, np.diag(widths)
