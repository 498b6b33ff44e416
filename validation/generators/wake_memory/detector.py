"""Detectability of a hidden effect to an ideal observer, in sigma.

Along each simulated path the base model is linearised (Jacobians by central differences). An
effect acts on the linear error system as an acceleration d(t) = a(all effects) - a(all but this
one) at the true state, or as a change e(t) of the observed x, y, heading. A Kalman filter whose
state holds motion, water motion, correlated tracking errors and the trial's servo and frequency
errors whitens the observations: the effect's innovations, divided by their standard deviation,
are its signal. Starting states are diffuse. What the six coefficients and other effects produce
is projected out by least squares. Measurement errors are also seen through head angle, body
length (tape measure 0.3 %) and, for the clock, through the tail-beat frequency against the motor
log.

Checked by brute force (test_generator_wake_memory.py): on a batch of gust and noise realisations
the generalised least-squares norm with the sample covariance agrees with the filter's norm.
"""
# Compiled laws take no keywords.
# ruff: noqa: PLR0917

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from . import dynamics as dy
from .effects import C_T

Array = NDArray[np.float64]
FILTER_STATE_SIZE = 14
LENGTH_STD_SHARE = 0.003


class ErrorModel(NamedTuple):
    """Standard deviations of block means: white and correlated (x, y, heading), water, trial."""

    white: Array
    tracking: Array
    tracking_s: float
    gust: Array
    gust_s: float
    servo: float
    flap: float


@njit(cache=True)
def _acceleration_vector(t, s, trial, R, E, stream, moment):
    """Accelerations as (3,)."""
    a, r_dot = dy.acceleration(t, s, trial, R, E, stream, moment)
    return np.array([a.real, a.imag, r_dot])


@njit(cache=True)
def block_jacobians(times, path, wakes, trial, R, E):
    """Jacobians (blocks, 3, 11) for motion, gust, servo, frequency; (blocks, 3, 6) coefficients."""
    n = len(times)
    J, G = np.zeros((n, 3, 11)), np.zeros((n, 3, 6))
    for i in range(n):
        t, stream = times[i], complex(wakes[i, 0], wakes[i, 1])
        for c in range(6):
            h = np.zeros(18)
            h[c] = 1e-4
            up = _acceleration_vector(t, path[i] + h, trial, R, E, stream, 0.0)
            J[i, :, c] = (
                up - _acceleration_vector(t, path[i] - h, trial, R, E, stream, 0.0)
            ) / 2e-4
        here = _acceleration_vector(t, path[i], trial, R, E, stream, 0.0)
        J[i, :, 6] = (
            _acceleration_vector(t, path[i], trial, R, E, stream + 1e-4, 0.0) - here
        ) / 1e-4
        J[i, :, 7] = (
            _acceleration_vector(t, path[i], trial, R, E, stream + 1e-4j, 0.0) - here
        ) / 1e-4
        J[i, :, 8] = (_acceleration_vector(t, path[i], trial, R, E, stream, 1e-5) - here) / 1e-5
        for c in range(2):
            moved = trial.copy()
            moved[c] = moved[c] + 1e-4 if c == 0 else moved[c] * (1 + 1e-4)
            J[i, :, 9 + c] = (
                _acceleration_vector(t, path[i], moved, R, E, stream, 0.0) - here
            ) / 1e-4
        for c in range(6):
            moved = R.copy()
            moved[C_T + c] *= 1 + 1e-3
            G[i, :, c] = (
                _acceleration_vector(t, path[i], trial, moved, E, stream, 0.0) - here
            ) / 1e-3
    return J, G


@njit(cache=True)
def accelerations(times, path, wakes, trial, R, E):
    """Accelerations (blocks, 3) along a path."""
    out = np.zeros((len(times), 3))
    for i in range(len(times)):
        out[i] = _acceleration_vector(
            times[i], path[i], trial, R, E, complex(wakes[i, 0], wakes[i, 1]), 0.0
        )
    return out


@njit(cache=True)
def whitened_innovations(J, d, e, dt, white, tracking, tracking_s, gust, gust_s, servo, flap):
    """Whitened innovations (blocks * 3, signals) of accelerations d and offsets e."""
    n, m = d.shape[0], d.shape[2]
    P, err = np.zeros((FILTER_STATE_SIZE, FILTER_STATE_SIZE)), np.zeros((FILTER_STATE_SIZE, m))
    Q, H, Rn = (
        np.zeros((FILTER_STATE_SIZE, FILTER_STATE_SIZE)),
        np.zeros((3, FILTER_STATE_SIZE)),
        np.zeros((3, 3)),
    )
    for c in range(3):
        P[c, c], P[c + 3, c + 3] = 4.0, 1.0
        P[c + 6, c + 6], P[c + 11, c + 11] = gust[c] ** 2, tracking[c] ** 2
        Q[c + 6, c + 6] = gust[c] ** 2 * (1 - np.exp(-2 * dt / gust_s))
        Q[c + 11, c + 11] = tracking[c] ** 2 * (1 - np.exp(-2 * dt / tracking_s))
        H[c, c], H[c, c + 11], Rn[c, c] = 1.0, 1.0, white[c] ** 2
    P[9, 9], P[10, 10] = servo**2, flap**2
    out = np.zeros((3 * n, m))
    for i in range(n):
        S = H @ P @ H.T + Rn
        innovation = np.ascontiguousarray(H @ err + e[i])
        out[3 * i : 3 * i + 3] = np.linalg.solve(np.linalg.cholesky(S), innovation)
        K = np.linalg.solve(S, H @ P).T.copy()
        err = err - K @ innovation
        I_KH = np.eye(FILTER_STATE_SIZE) - K @ H
        P = I_KH @ P @ I_KH.T + K @ Rn @ K.T
        A = np.zeros((FILTER_STATE_SIZE, FILTER_STATE_SIZE))
        for c in range(3):
            A[c, c + 3] = dt
            A[c + 3, :11] = J[i, c] * dt
            A[c + 6, c + 6], A[c + 11, c + 11] = -dt / gust_s, -dt / tracking_s
        F, term = np.eye(FILTER_STATE_SIZE), np.eye(FILTER_STATE_SIZE)
        for order in range(1, 7):
            term = term @ A / order
            F = F + term
        push = np.zeros((FILTER_STATE_SIZE, m))
        push[3:6] = d[i] * dt
        err = F @ err + push + 0.5 * A @ push
        P = F @ P @ F.T + Q
    return out


def projected_norm(signal: Array, nuisance: Array) -> float:
    """Norm of a whitened signal after the nuisance columns are projected out."""
    scale = np.linalg.norm(nuisance, axis=0)
    basis, weights, _ = np.linalg.svd(
        nuisance[:, scale > 0] / scale[scale > 0], full_matrices=False
    )
    basis = basis[:, weights > 1e-7 * weights[0]]
    return float(np.linalg.norm(signal - basis @ (basis.T @ signal)))


def head_angle_and_length_sigma(
    change: list[Array], std: tuple[float, float], servo: float
) -> float:
    """Sigma of head angle and log length changes (blocks, 2) per trial, beyond servo and tape."""
    total, weighted, weight = 0.0, 0.0, 1 / LENGTH_STD_SHARE**2
    for part in change:
        phi, length, n = part[:, 0], part[:, 1], len(part)
        spread = np.sum((phi - phi.mean()) ** 2) / std[0] ** 2
        total += spread + phi.mean() ** 2 / (servo**2 + std[0] ** 2 / n)
        total += np.sum(length**2) / std[1] ** 2
        weighted += np.sum(length) / std[1] ** 2
        weight += n / std[1] ** 2
    return float(np.sqrt(max(total - weighted**2 / weight, 0.0)))
