"""Derivatives of the filter's likelihood with respect to its model's matrices, by one pass back.

With the cost c = -2 log L, a and A its derivatives with respect to the state's mean and covariance
after a step:
    prediction  x <- F x, P <- F P F' + Q:
        dc/dQ = A,  dc/dF = a x' + 2 A F P,  a <- F' a,  A <- F' A F
    correction  x <- x + K y, P <- P - K H P,  K = P H' S^-1,  v = S^-1 y:
        D = S^-1 - v v' + K' A K,  dc/dR = D - (K'a v' + v a'K) / 2
        b = a - H' K' a,  B = A K - (b v' + H' D) / 2
        A <- A - B H - H' B',  a <- b - 2 H' v
A measurement beyond the gate adds H' S^-1 H to A, S^-1 to dc/dR. Derivatives with respect to
symmetric matrices are symmetric: dc = sum(dc/dQ * dQ).
Reverse differentiation of the recursions in Bar-Shalom, Li, Kirubarajan, Estimation, 2001, sect.
5.2; the sums over all parameters are those of Koopman and Shephard, Biometrika 79 (1992) 823.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import BoolNDArray, Float
from ..numba_settings import njit
from .kalman_numba import (
    FilterPass,
    copy_matrix,
    copy_vector,
    correct_in_place,
    fill_measurement_cross_covariance,
    nonzero_pattern,
)
from .linear_gaussian import LinearGaussianModel


@dataclass(frozen=True)
class LikelihoodGradient:
    """Derivatives of -2 log L with respect to F, Q (n, d, d), R (n, p, p) and P0 (d, d).

    Of F, only those entries that are not zero at all times.
    """

    F: Float
    Q: Float
    R: Float
    P0: Float


def likelihood_gradient(
    model: LinearGaussianModel, used: BoolNDArray, gate: float, forward: FilterPass
) -> LikelihoodGradient:
    """Gradient of `minus_two_log_likelihood` from the filter's pass over the same measurements."""
    return LikelihoodGradient(
        *_derivatives_backward(
            model.F, model.H, forward.means, forward.covs, forward.inverses, forward.innovations,
            forward.squares, used, gate,
        )
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def _derivatives_backward(F, H, xp, Pp, Sis, ys, squares, used, gate):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    n, p, d = H.shape
    pattern = nonzero_pattern(F)
    gF, gQ, gR = np.zeros((n, d, d)), np.zeros((n, d, d)), np.zeros((n, p, p))
    a, A, x, P = np.zeros(d), np.zeros((d, d)), np.empty(d), np.empty((d, d))
    work = (np.empty((p, d)), np.empty((d, p)), np.empty(p), np.empty((d, p)), np.empty(p))
    step = (np.empty((d, d)), np.empty(d), np.empty((d, d)))
    for k in range(n - 1, -1, -1):
        if used[k] and squares[k] <= gate:
            _correction_backward(H[k], Pp[k], Sis[k], ys[k], a, A, gR[k], work)
        elif used[k]:
            _rejected_measurement_backward(H[k], Sis[k], A, gR[k], work[3])
        if k == 0:
            break
        copy_matrix(A, gQ[k])
        copy_vector(xp[k - 1], x)
        copy_matrix(Pp[k - 1], P)
        if used[k - 1] and squares[k - 1] <= gate:
            _gain_and_weighted_innovation(H[k - 1], P, Sis[k - 1], ys[k - 1], work)
            correct_in_place(x, P, work[0], Sis[k - 1], ys[k - 1])
        _mean_backward(F[k], pattern, x, a, gF[k], step[1])
        _covariance_backward(F[k], pattern, P, A, gF[k], step)
    return gF, gQ, gR, A


@njit(cache=True, error_model="numpy")
def _gain_and_weighted_innovation(H, P, Si, y, work):  # type: ignore[no-untyped-def]
    """Fill the first three arrays of work: H P, K = P H' S^-1 and v = S^-1 y."""
    p, d = H.shape
    HP, K, v = work[0], work[1], work[2]
    fill_measurement_cross_covariance(H, P, HP)
    for q in range(p):
        v[q] = 0.0
        for r in range(p):
            v[q] += Si[q, r] * y[r]
        for i in range(d):
            K[i, q] = 0.0
            for r in range(p):
                K[i, q] += HP[r, i] * Si[r, q]


@njit(cache=True, error_model="numpy")
def _correction_backward(H, P, Si, y, a, A, gR, work):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Derivatives before a correction from those after it: a and A in place, gR filled."""
    p, d = H.shape
    _gain_and_weighted_innovation(H, P, Si, y, work)
    _, K, v, B, Ka = work
    _multiply_by_gain(a, A, K, Ka, B)
    for q in range(p):
        for r in range(p):
            D = Si[q, r] - v[q] * v[r]
            for m in range(d):
                D += K[m, q] * B[m, r]
            gR[q, r] = D
    _subtract_transposed_observation(H, Ka, a)
    for q in range(p):
        for i in range(d):
            B[i, q] -= 0.5 * a[i] * v[q]
    _subtract_half_transposed_product(H, gR, B)
    _subtract_product_and_transpose(B, H, A)
    _subtract_transposed_observation(H, 2.0 * v, a)
    for q in range(p):
        for r in range(p):
            gR[q, r] -= 0.5 * (Ka[q] * v[r] + v[q] * Ka[r])


@njit(cache=True, error_model="numpy")
def _multiply_by_gain(a, A, K, Ka, AK):  # type: ignore[no-untyped-def]
    """Fill K' a and A K, of a symmetric A."""
    d, p = K.shape
    for q in range(p):
        Ka[q] = 0.0
        for m in range(d):
            Ka[q] += K[m, q] * a[m]
            AK[m, q] = 0.0
        for i in range(d):
            for m in range(d):
                AK[m, q] += K[i, q] * A[i, m]


@njit(cache=True, error_model="numpy")
def _rejected_measurement_backward(H, Si, A, gR, B):  # type: ignore[no-untyped-def]
    """Of a measurement beyond the gate, log det S counts alone."""
    copy_matrix(Si, gR)
    B[:, :] = 0.0
    _subtract_half_transposed_product(H, gR, B)
    _subtract_product_and_transpose(B, H, A)


@njit(cache=True, error_model="numpy")
def _subtract_transposed_observation(H, y, a):  # type: ignore[no-untyped-def]
    """Vector a <- a - H' y."""
    p, d = H.shape
    for q in range(p):
        for i in range(d):
            a[i] -= H[q, i] * y[q]


@njit(cache=True, error_model="numpy")
def _subtract_half_transposed_product(H, D, B):  # type: ignore[no-untyped-def]
    """Matrix B <- B - H' D / 2."""
    p, d = H.shape
    for q in range(p):
        for r in range(p):
            for i in range(d):
                B[i, q] -= 0.5 * H[r, i] * D[r, q]


@njit(cache=True, error_model="numpy")
def _subtract_product_and_transpose(B, H, A):  # type: ignore[no-untyped-def]
    """A <- A - B H - H' B'."""
    p, d = H.shape
    for q in range(p):
        for i in range(d):
            h = H[q, i]
            if h != 0.0:
                for m in range(d):
                    A[i, m] -= h * B[m, q]
                    A[m, i] -= h * B[m, q]


@njit(cache=True, error_model="numpy")
def _mean_backward(F, pattern, x, a, gF, new):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Derivatives before a prediction from those after it, by the mean x: a in place, gF filled."""
    rows, columns = pattern
    for i in range(len(a)):
        new[i] = 0.0
    for e in range(len(rows)):
        i, j = rows[e], columns[e]
        gF[i, j] = a[i] * x[j]
        new[j] += F[i, j] * a[i]
    copy_vector(new, a)


@njit(cache=True, error_model="numpy")
def _covariance_backward(F, pattern, P, A, gF, step):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """The same by the covariance P: A in place, added to gF."""
    rows, columns = pattern
    FA, _, new = step
    d = len(A)
    for i in range(d):
        for m in range(d):
            FA[i, m] = new[i, m] = 0.0
    for e in range(len(rows)):
        i, j = rows[e], columns[e]
        for m in range(d):
            FA[j, m] += F[i, j] * A[i, m]
    for e in range(len(rows)):
        i, j = rows[e], columns[e]
        for m in range(d):
            gF[i, j] += 2.0 * FA[m, i] * P[m, j]
            new[m, j] += F[i, j] * FA[m, i]
    for i in range(d):
        for m in range(i + 1):  # an unsymmetric part, by rounding, would grow
            A[i, m] = A[m, i] = 0.5 * (new[i, m] + new[m, i])
