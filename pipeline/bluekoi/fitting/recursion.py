"""Kalman's recursion along a path whose matrices are known, compiled; shapes as in `linear`.

Of the deviation from the path: d = A d, P = A P A' + Q, then each observation's correction.

The states of the motion and of the effects come first, the random states last. The row of A of a
random state has one nonzero element, on the diagonal; products leave out the zeros.
Arrays are filled by plain loops: an assignment to a slice takes half a second to compile.
"""

from __future__ import annotations

import numpy as np

from ..numba_settings import njit

HALF_LOG_2PI = 0.9189385332046727
FASTMATH_FLAGS = {"reassoc", "contract", "nsz", "arcp"}
njit_nogil_fast = njit(cache=True, error_model="numpy", nogil=True, fastmath=FASTMATH_FLAGS)


@njit_nogil_fast
def fill_log_likelihoods(  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    counts, times, F, H, correction, level, residual, noise, cov, tau, variance, memory, scales,
    first, last, out,
):  # fmt: skip
    """Log likelihoods into `out` of trials `first` to `last`; shapes as in `linear.Linear`.

    variance (t, a), memory (a,): of the random states, 0 for others; scales (o, o): factors on
    `noise`.
    """
    a, q = F.shape[2], H.shape[2]
    m = count_model_states(tau)
    d, e = np.zeros((2, a)), np.zeros(q)  # deviations from the path; the second row is workspace
    P, A, AP = np.zeros((a, a)), np.zeros((a, a)), np.zeros((a, a))
    PH, S, W = np.zeros((a, q)), np.zeros((q, q)), np.zeros((q, q))
    for t in range(first, last):
        logl = 0.0
        reset_deviation_and_covariance(d, P, cov[t], tau, variance[t])
        for k in range(counts[t]):
            if k > 0:
                dt = times[t, k] - times[t, k - 1]
                kalman_predict(
                    d,
                    P,
                    A,
                    AP,
                    F[t, k],
                    correction[t, k - 1],
                    level[t, k - 1],
                    tau,
                    variance[t],
                    memory,
                    dt,
                    m,
                )
            logl += kalman_update(d, P, PH, S, W, e, H[t, k], residual[t, k], noise[t, k], scales)
        out[t] = logl


@njit_nogil_fast
def count_model_states(tau) -> int:  # type: ignore[no-untyped-def]
    """How many states come before the random ones."""
    m = 0
    while m < len(tau) and tau[m] == 0.0:
        m += 1
    return m


@njit_nogil_fast
def reset_deviation_and_covariance(d, P, cov, tau, variance) -> None:  # type: ignore[no-untyped-def]
    """No deviation, and the covariance before the first frame."""
    for i in range(len(P)):
        d[0, i] = 0.0
        for k in range(len(P)):
            P[i, k] = cov[i, k]
        P[i, i] = variance[i] if tau[i] > 0.0 else P[i, i]


@njit_nogil_fast
def kalman_predict(  # type: ignore[no-untyped-def]  # noqa: PLR0917
    d, P, A, AP, F, correction, level, tau, variance, memory, dt, m
) -> None:
    """D = A (d - correction) + (A - F) level and P = A P A' + Q, to the next frame.

    m: how many states come before the random ones.
    """
    fill_transition_matrix(A, F, tau, memory, dt)
    _propagate_deviation(d, A, F, correction, level)
    _propagate_covariance(P, A, AP, variance, memory, dt, m)


@njit_nogil_fast
def kalman_update(  # type: ignore[no-untyped-def]  # noqa: PLR0917
    d, P, PH, S, W, e, H, residual, noise, scales
) -> float:
    """Deviation and covariance after a frame; its log likelihood. Into e and W the innovation and
    the inverse root of its covariance.
    """
    _write_innovation(e, PH, S, H, residual, d[0], P)
    _add_observation_noise(S, noise, scales, residual)
    _invert_cholesky_factor(S, W)
    return _correct_deviation(d[0], P, PH, W, e, residual)


@njit_nogil_fast
def fill_transition_matrix(A, F, tau, memory, dt) -> None:  # type: ignore[no-untyped-def]
    """A = F with other memories: a column goes with tau (1 - exp(-dt / tau))."""
    for k in range(len(tau)):
        lead = 1.0
        if tau[k] > 0.0:
            was, now = tau[k] * (1.0 - np.exp(-dt / tau[k])), np.exp(-dt / memory[k])
            lead = memory[k] * (1.0 - now) / was
        for i in range(len(tau)):
            A[i, k] = F[i, k] * lead
        if tau[k] > 0.0:
            A[k, k] = now


@njit_nogil_fast
def _propagate_deviation(d, A, F, correction, level) -> None:  # type: ignore[no-untyped-def]
    """Deviation from the predicted path, from that of the frame before."""
    for i in range(len(A)):
        total = 0.0
        for k in range(len(A)):
            total += A[i, k] * (d[0, k] - correction[k]) + (A[i, k] - F[i, k]) * level[k]
        d[1, i] = total
    for i in range(len(A)):
        d[0, i] = d[1, i]


@njit_nogil_fast
def _propagate_covariance(P, A, AP, variance, memory, dt, m) -> None:  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """P = A P A' + Q with Q = sigma^2 (1 - exp(-2 dt / tau)) of the random states."""
    a = len(A)
    for i in range(m):
        for k in range(a):
            AP[i, k] = 0.0
        for j in range(a):
            for k in range(a):
                AP[i, k] += A[i, j] * P[j, k]
    _complete_covariance_product(P, A, AP, m)
    for k in range(m, a):
        P[k, k] += variance[k] * (1.0 - np.exp(-2.0 * dt / memory[k]))


@njit_nogil_fast
def _complete_covariance_product(P, A, AP, m) -> None:  # type: ignore[no-untyped-def]
    """P = A P A', from P and the first m rows of A P."""
    a = len(A)
    for i in range(m):
        for k in range(i + 1):
            total = 0.0
            for j in range(a):
                total += AP[i, j] * A[k, j]
            P[i, k] = P[k, i] = total
    for k in range(m, a):
        for i in range(m):
            P[i, k] = P[k, i] = AP[i, k] * A[k, k]
        for i in range(m, a):
            P[i, k] *= A[i, i] * A[k, k]


@njit_nogil_fast
def _write_innovation(e, PH, S, H, residual, d, P) -> None:  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Innovation e = y - h - H d, and S = H P H' with P H'."""
    for o in range(len(e)):
        e[o] = residual[o] if np.isfinite(residual[o]) else 0.0
        for i in range(len(d)):
            e[o] -= H[o, i] * d[i]
            total = 0.0
            for k in range(len(d)):
                total += P[i, k] * H[o, k]
            PH[i, o] = total
    for o in range(len(e)):
        for p in range(o + 1):
            total = 0.0
            for i in range(len(d)):
                total += H[o, i] * PH[i, p]
            S[o, p] = S[p, o] = total


@njit_nogil_fast
def _add_observation_noise(S, noise, scales, residual) -> None:  # type: ignore[no-untyped-def]
    """S + R where both are seen; unit rows where one is missing."""
    for o in range(len(S)):
        for p in range(len(S)):
            if np.isfinite(residual[o]) and np.isfinite(residual[p]):
                S[o, p] += noise[o, p] * scales[o, p]
            else:
                S[o, p] = 1.0 if o == p else 0.0


@njit_nogil_fast
def _invert_cholesky_factor(S, W) -> None:  # type: ignore[no-untyped-def]
    """Cholesky's factor L of S over S, its inverse into W."""
    for o in range(len(S)):
        for p in range(o + 1):
            total = S[o, p]
            for j in range(p):
                total -= S[o, j] * S[p, j]
            S[o, p] = np.sqrt(total) if o == p else total / S[p, p]
        for p in range(o + 1):
            total = 1.0 if o == p else 0.0
            for j in range(p, o):
                total -= S[o, j] * W[j, p]
            W[o, p] = total / S[o, o]


@njit_nogil_fast
def _correct_deviation(d, P, PH, W, e, residual) -> float:  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Deviation and covariance after the frame, one whitened observation after the other."""
    logl = 0.0
    b = np.zeros(len(d))
    for o in range(len(e)):
        white = 0.0
        for p in range(o + 1):
            white += W[o, p] * e[p]
        logl += np.log(W[o, o])
        if np.isfinite(residual[o]):
            logl -= 0.5 * white * white + HALF_LOG_2PI
        for i in range(len(d)):
            b[i] = 0.0
            for p in range(o + 1):
                b[i] += W[o, p] * PH[i, p]
            d[i] += b[i] * white
        for i in range(len(d)):
            for k in range(len(d)):
                P[i, k] -= b[i] * b[k]
    return logl
