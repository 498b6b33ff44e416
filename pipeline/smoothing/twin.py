"""Compiled twin of the filterpy filter, for the search over the process noise.

The same recursions as `reference`, proved equal in the tests; the smoother is the modified
Bryson-Frazier form, which inverts only the innovation covariance.
Sources: Bierman, Automatica 9 (1973) 503; Kailath, Sayed, Hassibi, Linear Estimation, 10.2.
"""

from __future__ import annotations

import numba
import numpy as np

from ..data import Float
from .chain import Chain, Mask, Smoothed

LOG_2_PI = float(np.log(2 * np.pi))


def likelihood(chain: Chain, used: Mask, gate: float) -> float:
    """Minus twice the log likelihood, innovations beyond the gate counted as lying on it.

    sum_k log det(2 pi S_k) + min(y_k' S_k^-1 y_k, gate)
    """
    c = chain
    return float(_forward(c.F, c.Q, c.H, c.R, c.z, c.x0, c.P0, used, gate, False)[0])


def innovations(chain: Chain, used: Mask, gate: float) -> Float:
    """Squared normalised innovation y' S^-1 y of each time, (n,); NaN where nothing was measured.

    Measurements beyond the gate do not enter the filter.
    """
    c = chain
    return np.asarray(_forward(c.F, c.Q, c.H, c.R, c.z, c.x0, c.P0, used, gate, False)[1])


def smoothed(chain: Chain, used: Mask) -> Smoothed:
    """States given all measurements used: equal to `reference.filter_and_smooth`."""
    c = chain
    _, _, xp, Pp, Si, y = _forward(c.F, c.Q, c.H, c.R, c.z, c.x0, c.P0, used, np.inf, True)
    return Smoothed(*_backward(c.F, c.H, xp, Pp, Si, y, used))


@numba.njit(cache=True)
def _predict(F, x, P, Q):  # type: ignore[no-untyped-def]
    """State x <- F x, P <- F P F' + Q, zeros of F skipped."""
    d = len(x)
    new = np.zeros(d)
    half = np.zeros((d, d))
    full = np.zeros((d, d))
    for i in range(d):
        for k in range(d):
            f = F[i, k]
            if f != 0.0:
                new[i] += f * x[k]
                for j in range(d):
                    half[i, j] += f * P[k, j]
    for i in range(d):
        for k in range(d):
            f = F[i, k]
            if f != 0.0:
                for j in range(d):
                    full[i, j] += f * half[j, k]
    return new, full + Q


@numba.njit(cache=True)
def _inverse(S):  # type: ignore[no-untyped-def]
    """Inverse and determinant of a 1 x 1 or 2 x 2 matrix."""
    out = np.empty_like(S)
    if len(S) == 1:
        out[0, 0] = 1.0 / S[0, 0]
        return out, S[0, 0]
    det = S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]
    out[0, 0], out[1, 1] = S[1, 1] / det, S[0, 0] / det
    out[0, 1] = out[1, 0] = -S[0, 1] / det
    return out, det


@numba.njit(cache=True)
def _forward(F, Q, H, R, z, x0, P0, used, gate, keep):  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    n, p, d = H.shape
    size = n if keep else 1
    xp, Pp = np.zeros((size, d)), np.zeros((size, d, d))
    Sis, ys = np.zeros((size, p, p)), np.zeros((size, p))
    squares = np.full(n, np.nan)
    x, P, total = x0.copy(), P0.copy(), 0.0
    for k in range(n):
        if k:
            x, P = _predict(F[k], x, P, Q[k])
        if keep:
            xp[k], Pp[k] = x, P
        if not used[k]:
            continue
        HP = H[k] @ P
        S = HP @ H[k].T + R[k]
        y = z[k] - H[k] @ x
        Si, det = _inverse(S)
        square = y @ (Si @ y)
        squares[k] = square
        total += min(square, gate) + np.log(det) + p * LOG_2_PI
        if keep:
            Sis[k], ys[k] = Si, y
        if square <= gate:
            gain = Si @ HP
            x = x + y @ gain
            P = P - HP.T @ gain
    return total, squares, xp, Pp, Sis, ys


@numba.njit(cache=True)
def _backward(F, H, xp, Pp, Sis, ys, used):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Adjoints g, G backwards in time; x = xp - Pp g, P = Pp - Pp G Pp."""
    n, _, d = H.shape
    xs, Ps = np.empty_like(xp), np.empty_like(Pp)
    g, G = np.zeros(d), np.zeros((d, d))
    for k in range(n - 1, -1, -1):
        if used[k]:
            HS = H[k].T @ Sis[k]
            C = np.eye(d) - (Pp[k] @ HS) @ H[k]
            g = C.T @ g - HS @ ys[k]
            G = HS @ H[k] + C.T @ (G @ C)
        xs[k] = xp[k] - Pp[k] @ g
        Ps[k] = Pp[k] - Pp[k] @ (G @ Pp[k])
        if k:
            g = F[k].T @ g
            G = F[k].T @ (G @ F[k])
    return xs, Ps
