"""Motion models: a mean motion whose acceleration decays, and the tail-beat recoil on top.

Mean motion of one coordinate (integrated Ornstein-Uhlenbeck acceleration, after Singer 1970):
    p' = v,  v' = a + w_v,  a' = -(s / tau) a + w_a
s = speed / usual speed: against a drag D v^2 with steady thrust, m v' = T - D v^2, the
acceleration obeys a' = -(2 D v / m) a, so that a start from rest (v_inf tanh) and a steady motion
both are free of noise; so is the yaw rate of a turn from rest, which keeps its radius. Around the
start w_a is larger, by a factor that is searched with the rest: forces set in there.

Recoil: a damped stochastic oscillator at the flapping frequency, of constant variance. Its
autocorrelation over b beats is
    cos(2 pi b) exp(-b / M - b d onset)
with the coherence M in beats and the decay rate d at the onset, where the recoil builds up. Both
are searched: the recoil of a motor at constant speed is nearly periodic, that of a fish is not. A
recoil of too little coherence describes measurement noise and slow motions (docs/decisions/061).

In the plane v and a are surge and sway in the frame of the mean heading theta(t), known from the
heading's own model: in a steady turn they are constant, which they are not in the pool frame.
    (x, y)' = Rot(theta) v ;  measured = (x, y) + Rot(theta) recoil
Source of the exact discretisation: Bar-Shalom, Li, Kirubarajan, Estimation, 2001, sect. 6.2, 8.2.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..numba_settings import njit

MIN_RECOIL_COHERENCE_BEATS = 15.0
"""The recoil keeps its amplitude and phase over about so many tail beats at least. One of a few
beats would describe any disturbance of the motion."""


@njit(cache=True)
def heading_matrices(noise, dt, hz, nominal):  # type: ignore[no-untyped-def]
    """F, Q (n, 5, 5) of an angle: angle, rate, acceleration, recoil and its quadrature.

    noise: (tau s, density of w_v, density of w_a, start-up factor, recoil variance, coherence above
    `MIN_RECOIL_COHERENCE_BEATS` in beats, decay rate at the onset per beat). dt: (n,) s, dt[0]
    unused. nominal: (n, 3): onset from 0 to 1, by which start-up factor and decay rate are
    multiplied; relative speed; heading noise, a density added to that of sway's w_v.
    """
    n, d = len(dt), 5 if hz > 0 else 3
    F, Q = np.zeros((n, d, d)), np.zeros((n, d, d))
    for i in range(d):
        F[0, i, i] = 1.0
    for k in range(1, n):
        _fill_mean_motion_blocks(F[k], Q[k], dt[k], noise, nominal[k])
        if hz > 0:
            _fill_recoil_blocks(F[k], Q[k], dt[k] * hz, noise[4:], nominal[k, 0], 3)
    return F, Q


@njit(cache=True)
def planar_matrices(noise, dt, hz, nominal, theta):  # type: ignore[no-untyped-def]
    """F, Q (n, 10, 10): x, y, surge, sway, their accelerations, recoil in surge and sway.

    noise, dt, nominal as `heading_matrices`, but noise[4] is the share of sway, its densities over
    those of surge, and in place of one recoil variance there are two, of surge and of sway.
    theta: (n,) mean heading, rad.
    """
    n, d = len(dt), 10 if hz > 0 else 6
    F, Q = np.zeros((n, d, d)), np.zeros((n, d, d))
    for i in range(d):
        F[0, i, i] = 1.0
    for k in range(1, n):
        _fill_mean_motion_blocks(F[k], Q[k], dt[k], noise, nominal[k])
        c, s, chord = mean_direction(theta[k - 1], theta[k])
        _rotate_to_pool_frame(F[k], Q[k], c, s, chord)
        if hz > 0:
            sway = noise[6:]
            surge = np.array([noise[5], sway[1], sway[2]])
            _fill_recoil_blocks(F[k], Q[k], dt[k] * hz, surge, nominal[k, 0], 6)
            _fill_recoil_blocks(F[k], Q[k], dt[k] * hz, sway, nominal[k, 0], 8)
    return F, Q


@njit(cache=True)
def mean_direction(before, after):  # type: ignore[no-untyped-def]
    """Cosine and sine of the mean of two headings, and chord over arc of the steady turn between
    them: with it the step is exact where surge and sway are constant.
    """
    half = 0.5 * (after - before)
    chord = 1.0 if abs(half) < 1e-9 else np.sin(half) / half
    return np.cos(after - half), np.sin(after - half), chord


@njit(cache=True)
def _fill_mean_motion_blocks(F, Q, dt, noise, nominal):  # type: ignore[no-untyped-def]
    """Fill the blocks of the m = 1 or 2 coordinates, order p (m), v (m), a (m)."""
    m = 1 if len(F) in (3, 5) else 2
    tau = noise[0] / nominal[1]
    decay = np.exp(-dt / tau)
    gain = -tau * np.expm1(-dt / tau)
    for i in range(m):
        v, a = m + i, 2 * m + i
        share = noise[4] if i == 1 else 1.0
        qv = share * noise[1] + i * nominal[2]
        qa = share * noise[2] * (1.0 + noise[3] * nominal[0])
        F[i, i] = F[v, v] = 1.0
        F[i, v] = dt
        F[v, a], F[a, a] = gain, decay
        F[i, a] = tau * (dt - gain)
        Q[i, i] = qv * dt**3 / 3 + qa * dt**5 / 20
        Q[v, v] = qv * dt + qa * dt**3 / 3
        Q[a, a] = qa * dt
        Q[i, v] = Q[v, i] = qv * dt**2 / 2 + qa * dt**4 / 8
        Q[i, a] = Q[a, i] = qa * dt**3 / 6
        Q[v, a] = Q[a, v] = qa * dt**2 / 2


@njit(cache=True)
def _rotate_to_pool_frame(F, Q, c, s, chord):  # type: ignore[no-untyped-def]
    """Turn what drives x and y from the body into the pool frame."""
    for column in (2, 4):
        f = F[0, column] * chord
        F[0, column], F[0, column + 1] = c * f, -s * f
        F[1, column], F[1, column + 1] = s * f, c * f
        q, w = Q[0, column], Q[1, column + 1]
        Q[0, column] = Q[column, 0] = c * q
        Q[0, column + 1] = Q[column + 1, 0] = -s * w
        Q[1, column] = Q[column, 1] = s * q
        Q[1, column + 1] = Q[column + 1, 1] = c * w
    along, across = Q[0, 0], Q[1, 1]
    Q[0, 0], Q[1, 1] = c * c * along + s * s * across, s * s * along + c * c * across
    Q[0, 1] = Q[1, 0] = c * s * (along - across)


@njit(cache=True)
def _fill_recoil_blocks(F, Q, beats, recoil, onset, at):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Blocks of the oscillator over a step of so many beats.

    recoil: variance, coherence above the least in beats, decay rate at the onset per beat.
    """
    variance = recoil[0]
    coherence_beats = MIN_RECOIL_COHERENCE_BEATS + recoil[1]
    keep = np.exp(-beats * (1.0 / coherence_beats + recoil[2] * onset))
    c, s = keep * np.cos(2 * np.pi * beats), keep * np.sin(2 * np.pi * beats)
    F[at, at] = F[at + 1, at + 1] = c
    F[at, at + 1], F[at + 1, at] = -s, s
    Q[at, at] = Q[at + 1, at + 1] = variance * (1 - keep**2)


def planar_observation_matrix(theta: Float, hz: float) -> Float:
    """H (n, 2, d): measured x, y = mean position + recoil turned into the pool frame."""
    H = np.zeros((len(theta), 2, 10 if hz > 0 else 6))
    H[:, 0, 0] = H[:, 1, 1] = 1.0
    if hz > 0:
        H[:, 0, 6], H[:, 0, 8] = np.cos(theta), -np.sin(theta)
        H[:, 1, 6], H[:, 1, 8] = np.sin(theta), np.cos(theta)
    return H
