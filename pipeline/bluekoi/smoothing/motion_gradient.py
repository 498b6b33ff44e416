"""Derivatives with respect to the logs of the noise, of a cost whose derivatives by F, Q are known.

The chain rule through `motion`: dc/d ln(noise_j) = sum(dc/dF * dF/d ln(noise_j)) + the same of Q.
"""

from __future__ import annotations

import numpy as np

from ..numba_settings import njit
from .motion import MIN_RECOIL_COHERENCE_BEATS, mean_direction


@njit(cache=True)
def heading_noise_gradient(noise, dt, hz, nominal, by_F, by_Q):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Derivatives (noise,) of a cost with respect to the logs of the noise of a heading.

    noise, dt, hz, nominal: as in `motion.heading_matrices`. by_F, by_Q: (n, 5, 5), derivatives with
    respect to the matrices that it returns.
    """
    out = np.zeros(len(noise))
    gF, gQ = np.empty((3, 3)), np.empty((3, 3))
    for k in range(1, len(dt)):
        for i in range(3):
            for j in range(3):
                gF[i, j], gQ[i, j] = by_F[k, i, j], by_Q[k, i, j]
        _add_mean_motion_gradient(gF, gQ, dt[k], noise, nominal[k], 0, out)
        if hz > 0:
            slopes = _recoil_gradient(by_F[k], by_Q[k], dt[k] * hz, noise[4:], nominal[k, 0], 3)
            for j in range(3):
                out[4 + j] += slopes[j]
    return out


@njit(cache=True)
def planar_noise_gradient(noise, dt, hz, nominal, theta, by_F, by_Q):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """As `heading_noise_gradient`, of the noise and matrices of `motion.planar_matrices`."""
    out = np.zeros(len(noise))
    gF, gQ = np.empty((3, 3)), np.empty((3, 3))
    for k in range(1, len(dt)):
        c, s, chord = mean_direction(theta[k - 1], theta[k])
        for i in range(2):  # surge, sway
            _derivatives_in_body_frame(by_F[k], by_Q[k], c, s, chord, i, gF, gQ)
            _add_mean_motion_gradient(gF, gQ, dt[k], noise, nominal[k], i, out)
        if hz > 0:
            for i in range(2):
                recoil = np.array([noise[5 + i], noise[7], noise[8]])
                slopes = _recoil_gradient(
                    by_F[k], by_Q[k], dt[k] * hz, recoil, nominal[k, 0], 6 + 2 * i
                )
                out[5 + i] += slopes[0]
                out[7] += slopes[1]
                out[8] += slopes[2]
    return out


@njit(cache=True)
def _derivatives_in_body_frame(by_F, by_Q, c, s, chord, i, gF, gQ):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Fill the derivatives (3, 3) for position, rate and acceleration along axis i of the body:
    transposed rotation of `motion._rotate_to_pool_frame`.
    """
    x, y = (c, s) if i == 0 else (-s, c)  # the axis in the pool frame
    for m in range(3):
        for n in range(3):
            row, column = 2 * m + i, 2 * n + i
            gF[m, n], gQ[m, n] = by_F[row, column], by_Q[row, column]
    gQ[0, 0] = x * x * by_Q[0, 0] + 2 * x * y * by_Q[0, 1] + y * y * by_Q[1, 1]
    for n in range(1, 3):
        column = 2 * n + i
        gF[0, n] = chord * (x * by_F[0, column] + y * by_F[1, column])
        gQ[0, n] = gQ[n, 0] = x * by_Q[0, column] + y * by_Q[1, column]


@njit(cache=True)
def _add_mean_motion_gradient(gF, gQ, dt, noise, nominal, i, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Add derivatives with respect to tau, densities, start-up factor, share of sway (i = 1)."""
    tau = noise[0] / nominal[1]
    decay = np.exp(-dt / tau)
    gain = -tau * np.expm1(-dt / tau)
    out[0] += (
        gF[1, 2] * (gain - dt * decay)
        + gF[2, 2] * decay * dt / tau
        + gF[0, 2] * tau * (dt - 2.0 * gain + dt * decay)
    )
    by_qv = gQ[0, 0] * dt**3 / 3 + gQ[1, 1] * dt + gQ[0, 1] * dt**2
    by_qa = (
        gQ[0, 0] * dt**5 / 20 + gQ[1, 1] * dt**3 / 3 + gQ[2, 2] * dt
        + gQ[0, 1] * dt**4 / 4 + gQ[0, 2] * dt**3 / 3 + gQ[1, 2] * dt**2
    )  # fmt: skip
    share = noise[4] if i == 1 else 1.0
    rate, steady = share * noise[1] * by_qv, share * noise[2] * by_qa
    start_up = steady * noise[3] * nominal[0]
    out[1] += rate
    out[2] += steady + start_up
    out[3] += start_up
    if i == 1:
        out[4] += rate + steady + start_up


@njit(cache=True)
def _recoil_gradient(by_F, by_Q, beats, recoil, onset, at):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Derivatives with respect to variance, coherence and decay rate of one recoil, as in
    `motion._fill_recoil_blocks`.
    """
    variance, coherence_beats = recoil[0], MIN_RECOIL_COHERENCE_BEATS + recoil[1]
    decay = np.exp(-beats * (1.0 / coherence_beats + recoil[2] * onset))
    c, s = np.cos(2 * np.pi * beats), np.sin(2 * np.pi * beats)
    by_variance = by_Q[at, at] + by_Q[at + 1, at + 1]
    by_decay = (
        c * (by_F[at, at] + by_F[at + 1, at + 1]) + s * (by_F[at + 1, at] - by_F[at, at + 1])
        - 2.0 * variance * decay * by_variance
    )  # fmt: skip
    return (
        by_variance * variance * (1 - decay**2),
        by_decay * decay * beats * recoil[1] / coherence_beats**2,
        -by_decay * decay * beats * recoil[2] * onset,
    )
