"""Slopes of the likelihood in `recursion` by the noise, all of them by one pass back, compiled.

What the likelihood loses by a change of a filter's matrices follows from one recursion backwards in
time (Segal and Weinstein, IEEE Trans. Inf. Theory 35 (1989), 682; Koopman and Shephard, Biometrika
79 (1992), 823), instead of one pass forward for every number. With u and U the slopes by the
deviation d and by its covariance P, of a frame with gain K = P H' V, V = S^-1, v = V e:

    B = (v v' - V - V g v' - v g' V) / 2,   g = H P u,   slope by S   B + K' U K,
    U <- (I - H' K') U (I - K H) + H' B H + (u v' H + H' v u') / 2,   u <- u + H' (v - V g),

and of the step before it, d = A (d - c) + (A - F) level, P = A P A' + Q:

    slope by Q   U,   by A   u (d - c + level)' + 2 U A P,   u <- A' u,   U <- A' U A.
"""

from __future__ import annotations

import numpy as np

from .recursion import (
    count_model_states,
    fill_transition_matrix,
    kalman_predict,
    kalman_update,
    njit_nogil_fast,
    reset_deviation_and_covariance,
)


@njit_nogil_fast
def log_likelihood_gradients(  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    counts, times, F, H, correction, level, residual, noise, cov, tau, variance, memory, scales,
    first, last, out, by_variance, by_memory, by_scales,
):  # fmt: skip
    """Log likelihoods into `out` (t,), and their slopes by variance and memory of the random states
    (t, a), and by the factors on `noise` (t, o, o), of trials `first` to `last`; arguments as in
    `recursion.fill_log_likelihoods`.
    """
    n, a, q = F.shape[1], F.shape[2], H.shape[2]
    m = count_model_states(tau)
    after, predicted = np.zeros((n, a)), np.zeros((n, a, a))
    filtered, roots, errors = np.zeros((n, a, a)), np.zeros((n, q, q)), np.zeros((n, q))
    d, P, A, AP = np.zeros((2, a)), np.zeros((a, a)), np.zeros((a, a)), np.zeros((a, a))
    PH, S, u, U = np.zeros((a, q)), np.zeros((q, q)), np.zeros((2, a)), np.zeros((a, a))
    square, wide, short = np.zeros((2, q, q)), np.zeros((4, q, a)), np.zeros((3, q))
    for t in range(first, last):
        out[t] = 0.0
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
            _copy_into(P, predicted[k])
            out[t] += kalman_update(d, P, PH, S, roots[k], errors[k], H[t, k], residual[t, k],
                                    noise[t, k], scales)  # fmt: skip
            _copy_into(P, filtered[k])
            for i in range(a):
                after[k, i] = d[0, i]
        _clear_gradients(u, U, by_variance[t], by_memory[t], by_scales[t])
        for k in range(counts[t] - 1, -1, -1):
            _adjoints_before_update(
                u[0], U, H[t, k], predicted[k], roots[k], errors[k], residual[t, k], noise[t, k],
                by_scales[t], square, wide, short,
            )  # fmt: skip
            if k > 0:
                dt = times[t, k] - times[t, k - 1]
                fill_transition_matrix(A, F[t, k], tau, memory, dt)
                _multiply_by_transition(U, A, AP, m)
                for i in range(a):
                    d[0, i] = after[k - 1, i] - correction[t, k - 1, i] + level[t, k - 1, i]
                _add_process_noise_score(u[0], U, AP, F[t, k], d[0], filtered[k - 1], tau,
                                         variance[t], memory, dt, by_variance[t],
                                         by_memory[t], m)  # fmt: skip
                _multiply_by_transposed_transition(A, AP, U, m)
                _apply_transpose(A, u)
        for i in range(a):
            if tau[i] > 0.0:
                by_variance[t, i] += U[i, i]


@njit_nogil_fast
def _copy_into(A, out) -> None:  # type: ignore[no-untyped-def]
    for i in range(A.shape[0]):
        for k in range(A.shape[1]):
            out[i, k] = A[i, k]


@njit_nogil_fast
def _clear_gradients(u, U, by_variance, by_memory, by_scales) -> None:  # type: ignore[no-untyped-def]
    """The arrays of the gradient at 0, before the first frame adds to them; u[1] is workspace."""
    for i in range(len(U)):
        u[0, i], by_variance[i], by_memory[i] = 0.0, 0.0, 0.0
        for k in range(len(U)):
            U[i, k] = 0.0
    for o in range(len(by_scales)):
        for p in range(len(by_scales)):
            by_scales[o, p] = 0.0


@njit_nogil_fast
def _multiply_into(A, B, out) -> None:  # type: ignore[no-untyped-def]
    """Out = A B; the inner loop runs along rows."""
    for i in range(A.shape[0]):
        for k in range(out.shape[1]):
            out[i, k] = 0.0
        for j in range(A.shape[1]):
            for k in range(out.shape[1]):
                out[i, k] += A[i, j] * B[j, k]


@njit_nogil_fast
def _transpose_multiply_into(A, B, out) -> None:  # type: ignore[no-untyped-def]
    """Out = A' B."""
    for i in range(A.shape[1]):
        for k in range(out.shape[1]):
            out[i, k] = 0.0
    for j in range(A.shape[0]):
        for i in range(A.shape[1]):
            for k in range(out.shape[1]):
                out[i, k] += A[j, i] * B[j, k]


@njit_nogil_fast
def _multiply_by_transition(U, A, out, m) -> None:  # type: ignore[no-untyped-def]
    """Out = U A, m states before the random ones."""
    for i in range(len(A)):
        for k in range(m):
            out[i, k] = 0.0
        for k in range(m, len(A)):
            out[i, k] = U[i, k] * A[k, k]
        for j in range(m):
            for k in range(len(A)):
                out[i, k] += U[i, j] * A[j, k]


@njit_nogil_fast
def _multiply_by_transposed_transition(A, UA, out, m) -> None:  # type: ignore[no-untyped-def]
    """Out = A' U A, symmetric, from U A; m states before the random ones."""
    for i in range(len(A)):
        lead = 0.0 if i < m else A[i, i]
        for k in range(i + 1):
            out[i, k] = lead * UA[i, k]
        for j in range(m):
            for k in range(i + 1):
                out[i, k] += A[j, i] * UA[j, k]
    for i in range(len(A)):
        for k in range(i):
            out[k, i] = out[i, k]


@njit_nogil_fast
def _apply_transpose(A, u) -> None:  # type: ignore[no-untyped-def]
    """u[0] = A' u[0]; u[1] is workspace."""
    for k in range(len(A)):
        u[1, k] = 0.0
        for i in range(len(A)):
            u[1, k] += A[i, k] * u[0, i]
    for k in range(len(A)):
        u[0, k] = u[1, k]


@njit_nogil_fast
def _adjoints_before_update(  # type: ignore[no-untyped-def]  # noqa: PLR0917
    u, U, H, P, W, e, residual, noise, by_scales, square, wide, short
):
    """Slopes before a frame's correction, from those after it; what the frame says on its noise.

    The last three arguments are workspace. U is multiplied by I - K H from the right, then by its
    transpose from the left. The expanded form U - U K H - H' K' U + H' K' U K H loses its
    significant digits by cancellation.
    """
    V, B = square
    HP, K, KU, BH = wide  # K turned
    v, g, Vg = short
    _innovation_precision(V, W, residual)
    _multiply_into(H, P, HP)
    _multiply_into(V, HP, K)
    _multiply_into(K, U, KU)
    _innovation_products(v, g, Vg, V, HP, e, u)
    for o in range(len(e)):
        for p in range(len(e)):
            B[o, p] = 0.5 * (v[o] * v[p] - V[o, p] - Vg[o] * v[p] - v[o] * Vg[p])
            total = B[o, p]
            for i in range(len(u)):
                total += KU[o, i] * K[p, i]
            by_scales[o, p] += total * noise[o, p]
    _subtract_transpose_product(KU, H, U)
    _multiply_into(K, U, KU)
    _subtract_transpose_product(H, KU, U)
    _multiply_into(B, H, BH)
    _add_observation_terms(u, U, H, BH, v, Vg)


@njit_nogil_fast
def _subtract_transpose_product(A, B, out) -> None:  # type: ignore[no-untyped-def]
    """Out less A' B."""
    for i in range(A.shape[1]):
        for j in range(A.shape[0]):
            for k in range(B.shape[1]):
                out[i, k] -= A[j, i] * B[j, k]


@njit_nogil_fast
def _innovation_precision(V, W, residual) -> None:  # type: ignore[no-untyped-def]
    """V = W' W of what is seen, else 0."""
    _transpose_multiply_into(W, W, V)
    for o in range(len(V)):
        for p in range(len(V)):
            if not (np.isfinite(residual[o]) and np.isfinite(residual[p])):
                V[o, p] = 0.0


@njit_nogil_fast
def _innovation_products(v, g, Vg, V, HP, e, u) -> None:  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """V = V e, g = H P u, and V g."""
    for o in range(len(e)):
        v[o], g[o] = 0.0, 0.0
        for p in range(len(e)):
            v[o] += V[o, p] * e[p]
        for i in range(len(u)):
            g[o] += HP[o, i] * u[i]
    for o in range(len(e)):
        Vg[o] = 0.0
        for p in range(len(e)):
            Vg[o] += V[o, p] * g[p]


@njit_nogil_fast
def _add_observation_terms(u, U, H, BH, v, Vg) -> None:  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Add H' B H + (u v' H + H' v u') / 2 to U, then H' (v - V g) to u."""
    for o in range(len(v)):
        for i in range(len(u)):
            for k in range(len(u)):
                both = u[i] * H[o, k] + H[o, i] * u[k]
                U[i, k] += H[o, i] * BH[o, k] + 0.5 * v[o] * both
    for o in range(len(v)):
        for i in range(len(u)):
            u[i] += H[o, i] * (v[o] - Vg[o])


@njit_nogil_fast
def _add_process_noise_score(  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    u, U, UA, F, d, P, tau, variance, memory, dt, by_variance, by_memory, m
):
    """What a step says on the variances and memories of its random states.

    d: deviation before it, less the correction, plus the level; P: its covariance. Of a state that
    forgets within m, now = exp(-dt / m) stays, and its column goes with m (1 - now).
    """
    for k in range(m, len(u)):
        was, now = tau[k] * (1.0 - np.exp(-dt / tau[k])), np.exp(-dt / memory[k])
        by_lead, by_now = 0.0, u[k] * d[k]
        for j in range(len(u)):
            by_now += 2.0 * UA[k, j] * P[k, j]
        for i in range(m):
            by_entry = u[i] * d[k]
            for j in range(len(u)):
                by_entry += 2.0 * UA[i, j] * P[k, j]
            by_lead += by_entry * F[i, k]
        slope = now * dt / memory[k] ** 2  # of now, by the memory
        by_variance[k] += U[k, k] * (1.0 - now * now)
        by_memory[k] += by_now * slope + by_lead * (1.0 - now - memory[k] * slope) / was
        by_memory[k] -= U[k, k] * variance[k] * 2.0 * now * slope
