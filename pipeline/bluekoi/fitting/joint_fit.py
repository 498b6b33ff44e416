"""Joint maximum likelihood over all trials by prediction errors.

Sums of the trials' normal equations give the fit, resampled sums its uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem
from .filtering import FilterResults
from .normal import Normal, normal_equations, slots_by_name
from .series import Free, Noise, Series

CONVERGED = "converged"
AT_BOUND = "at a bound: the data ask for more than is plausible, look for missing physics"
STALLED = "stalled: no step improves the fit; try other starts, or fewer free coefficients"
INITIAL_DAMPING, DAMPED_TOLERANCE = 1e-4, 0.3
"""Marquardt's parameter at the start, and the part of the tolerance at which a step that is damped
more than that ends a fit.
"""
FAILED_STEP_TOLERANCE = 2.0
"""Part of the tolerance at which an undamped step that fails ends a fit."""


@dataclass(frozen=True)
class Fit:
    """A joint fit: free (p,), values (p,), the normal equations there, and a named outcome."""

    free: tuple[Free, ...]
    values: Float
    normal: Normal
    outcome: str
    iterations: int

    @property
    def naive_cov(self) -> Float:
        """Inverse Fisher matrix (p, p): too small, since errors in a trial are correlated."""
        return pseudo_inverse(self.normal.hessian.sum(axis=0))

    @property
    def log_likelihood(self) -> float:
        """Of all trials."""
        return float(self.normal.log_likelihood.sum())

    def by_label(self) -> dict[str, float]:
        """Fitted values by label."""
        return {f.label: float(v) for f, v in zip(self.free, self.values, strict=True)}


def fit(
    kernel: CompiledSystem, series: Sequence[Series], base: Float, free: Sequence[Free],
    noise: Noise, *, start: Mapping[str, float] | None = None, iterations: int = 25,
    tolerance: float = 1e-3, predictor: FilterResults | None = None,
    spreads: Mapping[str, float] | None = None,
) -> Fit:  # fmt: skip
    """Levenberg-Marquardt on the prediction errors, within the parameters' bounds.

    start: values by label; without it the parameters' own starts. Ends with the step that changes
    the numbers by no more than `tolerance` of their standard deviations in the mean square: its
    gain follows from the quadratic model of the last normal equations. A step that is small because
    it is damped ends the fit at `DAMPED_TOLERANCE` of that, and is not taken: there the quadratic
    model has failed.
    An undamped step that fails and is at most `FAILED_STEP_TOLERANCE` of the tolerance ends the fit
    where it is: the differences are no more exact than that.
    predictor, spreads: as in `normal_equations`.
    """
    slots = slots_by_name(kernel)
    parameters = [kernel.system.parameters[slots[f.name]] for f in free]
    lower, upper = (np.array([getattr(p, k) for p in parameters]) for k in ("lower", "upper"))
    given = start or {}
    x = np.array([given.get(f.label, given.get(f.name, base[slots[f.name]])) for f in free])
    x = np.clip(x, lower, upper)
    normal = normal_equations(kernel, series, base, free, x, noise=noise, predictor=predictor,
                              spreads=spreads)  # fmt: skip
    damping, outcome, count = INITIAL_DAMPING, STALLED, 0
    while normal.usable and count < iterations and damping < 1e8:
        count += 1
        step = damped_step(normal, damping, x, lower, upper)
        trial = np.clip(x + step, lower, upper)
        undamped = damping <= INITIAL_DAMPING
        if _is_small(normal, trial - x, tolerance if undamped else DAMPED_TOLERANCE * tolerance):
            if undamped:
                x, normal = trial, _normal_after_step(normal, trial - x)
            outcome = CONVERGED
            break
        candidate = normal_equations(
            kernel, series, base, free, trial, noise=noise, predictor=predictor, spreads=spreads
        )
        gain = candidate.log_likelihood.sum() - normal.log_likelihood.sum()
        if candidate.usable and gain >= -1e-9:
            x, normal, damping = trial, candidate, max(damping * 0.2, 1e-9)
        elif undamped and _is_small(normal, trial - x, FAILED_STEP_TOLERANCE * tolerance):
            outcome = CONVERGED
            break
        else:
            damping *= 8.0
    bound = (x <= lower) | (x >= upper)
    outcome = AT_BOUND if outcome == CONVERGED and bound.any() else outcome
    return Fit(tuple(free), x, normal, outcome, count)


def damped_step(normal: Normal, damping: float, x: Float, lower: Float, upper: Float) -> Float:
    """(H + damping diag H)^-1 g over the numbers that are not held at a bound by g."""
    H, g = normal.hessian.sum(axis=0), normal.gradient.sum(axis=0)
    held = ((x <= lower) & (g < 0)) | ((x >= upper) & (g > 0))
    move = ~held & (np.diag(H) > 0)
    step = np.zeros(len(x))
    if move.any():
        A = H[np.ix_(move, move)]
        scale = 1.0 / np.sqrt(np.diag(A))
        scaled = A * np.outer(scale, scale) + damping * np.eye(len(A))
        step[move] = scale * np.linalg.lstsq(scaled, scale * g[move], rcond=1e-12)[0]
    return step


def _is_small(normal: Normal, change: Float, tolerance: float) -> bool:
    """Whether a step lies within `tolerance` standard deviations: change' H change < tol^2."""
    return bool(change @ normal.hessian.sum(axis=0) @ change < tolerance**2 * max(len(change), 1))


def _normal_after_step(normal: Normal, step: Float) -> Normal:
    """The normal equations a step further, by their own parabola."""
    bend = normal.hessian @ step
    return Normal(
        normal.hessian,
        normal.gradient - bend,
        normal.log_likelihood + (normal.gradient - 0.5 * bend) @ step,
    )


def pseudo_inverse(matrix: Float) -> Float:
    """Inverse of a Fisher matrix (..., p, p); directions that no data touch get a huge variance."""
    diagonal = np.einsum("...pp->...p", matrix)
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scales = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(matrix / scales)
    weighted = vectors / np.maximum(values, 1e-12)[..., None, :]
    return weighted @ np.swapaxes(vectors, -1, -2) / scales


def conditional_response(hessian: Float, own: Sequence[int], others: Sequence[int]) -> Float:
    """-H_oo^-1 H_ox (own, others): how some numbers of a fit go along with a change of others."""
    return -pseudo_inverse(hessian[np.ix_(own, own)]) @ hessian[np.ix_(own, others)]
