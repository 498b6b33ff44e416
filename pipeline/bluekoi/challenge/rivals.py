"""What people would use otherwise, on the same smoothed tracks and the same trials to fit.

sparse_regression   sequentially thresholded least squares (PySINDy's STLSQ) over the six
                    coefficients and the search's own candidates; names what survives
linear_residual     the published model plus a linear residual in 18 simple terms; names nothing
retuning            the paper's three steps at each power; names nothing
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..integrate import Kernel
from .accelerations import NAMES, Problem, Samples, problem

THRESHOLDS = tuple(np.geomspace(0.003, 0.5, 12))
RIDGE = 1e-6
FOLDS = 4
LEAST_EFFECT = 1e-6
"""Columns below this share of the accelerations' spread at their starting strength are noise."""


@dataclass(frozen=True)
class Answer:
    """A rival's answer: names, and coefficients and effects of its model."""

    names: tuple[str, ...]
    coefficients: dict[str, float]
    effects: dict[str, dict[str, float]]


def least_squares(X: Float, y: Float, ridge: float = RIDGE) -> Float:
    """Ridge solution `(X'X + ridge n I)^-1 X'y` for columns of unit size."""
    gram = X.T @ X + ridge * len(y) * np.eye(X.shape[1])
    return np.asarray(np.linalg.solve(gram, X.T @ y))


def stlsq(X: Float, y: Float, threshold: float) -> Float:
    """Sequentially thresholded least squares: what is below the threshold is dropped, refitted.

    Source: Brunton, Proctor and Kutz, PNAS 113 (2016), 3932, as in PySINDy's STLSQ.
    """
    kept = np.ones(X.shape[1], dtype=bool)
    w = least_squares(X, y)
    for _ in range(20):
        keep = np.abs(w) >= threshold
        if np.array_equal(keep, kept) or not keep.any():
            break
        kept = keep
        w = np.zeros(X.shape[1])
        w[kept] = least_squares(X[:, kept], y)
    return np.where(np.abs(w) >= threshold, w, 0.0)


def pysindy_stlsq(X: Float, y: Float, threshold: float) -> Float:
    """The same by PySINDy itself; ImportError where it is not installed (extra `rivals`)."""
    from pysindy import STLSQ  # noqa: PLC0415  optional

    found = STLSQ(threshold=threshold, alpha=RIDGE * len(y)).fit(X, y[:, None])
    return np.asarray(found.coef_[0], dtype=float)


def sparse(told: Problem, solve: Callable[[Float, Float, float], Float]) -> Float:
    """Coefficients of the columns, the threshold chosen by conditions left out.

    The sparsest solution whose held-out error is within one standard error of the least.
    """
    size = np.sqrt(np.mean(told.columns**2, axis=0))
    X = told.columns / np.maximum(size, 1e-12)
    X[:, size < 1e-12] = 0.0
    fold = told.condition % FOLDS
    errors: list[tuple[float, float]] = []
    for threshold in THRESHOLDS:
        each = []
        for out in (fold == k for k in range(FOLDS) if np.any(fold == k)):
            w = solve(X[~out], told.y[~out], threshold)
            each.append(float(np.mean((told.y[out] - X[out] @ w) ** 2)))
        errors.append((float(np.mean(each)), float(np.std(each) / np.sqrt(len(each)))))
    least, spread = min(errors)
    good = [t for t, (e, _) in zip(THRESHOLDS, errors, strict=True) if e <= least + spread]
    w = solve(X, told.y, max(good))
    return np.where(size < 1e-12, 0.0, w / np.maximum(size, 1e-12))


def sparse_regression(kernel: Kernel, data: Samples, candidates: Sequence[str]) -> Answer:
    """Names and model of sparse regression; needs no model but its library of terms."""
    try:
        import pysindy  # noqa: F401, PLC0415  optional

        solve = pysindy_stlsq
    except ImportError:
        solve = stlsq
    plain = problem(kernel, data, (), None)
    at = least_squares(plain.columns, plain.y, 0.0)
    known = [n for n in candidates if not kernel.system.effect(n).states]
    told = _felt(problem(kernel, data, known, at))
    return _answer(told, sparse(told, solve))


def _felt(told: Problem) -> Problem:
    """The problem without columns that accelerations do not feel (faults of what is seen)."""
    size = np.sqrt(np.mean(told.columns**2, axis=0)) * told.sizes
    kept = np.flatnonzero(size > LEAST_EFFECT)
    return replace(told, columns=told.columns[:, kept], sizes=told.sizes[kept],
                   names=tuple(told.names[k] for k in kept))  # fmt: skip


def linear_residual(kernel: Kernel, data: Samples) -> Answer:
    """The published model and the 18 terms of the nameless residual, by least squares."""
    told = problem(kernel, data, ("residual",), None)
    size = np.maximum(np.sqrt(np.mean(told.columns**2, axis=0)), 1e-12)
    answer = _answer(told, least_squares(told.columns / size, told.y, 1e-5) / size)
    return Answer((), answer.coefficients, answer.effects)


def _answer(told: Problem, w: Float) -> Answer:
    coefficients = {n: float(v) for n, v in zip(told.names, w, strict=True) if n in NAMES}
    effects: dict[str, dict[str, float]] = {}
    for name, value in zip(told.names, w, strict=True):
        if name not in NAMES and value != 0.0:
            effect, parameter = name.split(".", 1)
            effects.setdefault(effect, {})[parameter] = float(value)
    return Answer(tuple(effects), coefficients, effects)
