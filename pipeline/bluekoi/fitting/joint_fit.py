"""Joint maximum likelihood over all trials by prediction errors.

Sums of the trials' normal equations give the fit, resampled sums its uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem, Parameter, System
from .bounded_step import bounded_step
from .filtering import FilterResults
from .normal import NormalEquationsByTrial, trial_normal_equations
from .predictions import parameter_index_by_name
from .series import FreeParameter, Noise, TrialSeries

CONVERGED = "converged"
AT_BOUND_REASON = "at a bound: the data ask for more than is plausible, look for missing physics"
STALLED = "stalled: no step improves the fit; try other starts, or fewer free coefficients"
TRUST_REGION_STEP_TOLERANCE_FACTOR = 0.3
"""Part of the tolerance at which a step that the trust region shortens ends a fit."""
FAILED_STEP_TOLERANCE_FACTOR = 2.0
"""Part of the tolerance at which a step that fails ends a fit, unless the region shortens it."""
MIN_SHRINKAGE, MAX_SHRINKAGE = 0.1, 0.5
"""Limits of the factor on a step that failed: the top of the parabola through both ends and the
slope (Nocedal and Wright, Numerical Optimization (2006), sec. 3.5).
"""
GOOD_GAIN_SHARE, POOR_GAIN_SHARE = 0.75, 0.25
"""Shares of the predicted gain above which the region grows and below which it shrinks to half
the step (sec. 4.1)."""


@dataclass(frozen=True)
class ParameterFit:
    """A joint fit: free (p,), values (p,), the normal equations there, and a named outcome.

    definitions (p,): start and bounds of each free number.
    """

    free: tuple[FreeParameter, ...]
    values: Float
    normal: NormalEquationsByTrial
    outcome: str
    iterations: int
    definitions: tuple[Parameter, ...]

    @property
    def naive_cov(self) -> Float:
        """Inverse Fisher matrix (p, p): too small, since errors in a trial are correlated."""
        return regularised_fisher_inverse(self.normal.hessian.sum(axis=0))

    @property
    def log_likelihood(self) -> float:
        """Of all trials."""
        return float(self.normal.log_likelihood.sum())

    def values_by_label(self) -> dict[str, float]:
        """Fitted values by label."""
        return {f.label: float(v) for f, v in zip(self.free, self.values, strict=True)}


def parameter_definition(system: System, free: FreeParameter) -> Parameter:
    """The parameter that a free number is a value of."""
    return system.parameters[system.parameter_index[free.name]]


def free_parameter_definitions(
    system: System, free: Sequence[FreeParameter]
) -> tuple[Parameter, ...]:
    """The parameter that each free number is a value of."""
    return tuple(parameter_definition(system, f) for f in free)


def fit_parameters_jointly(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    free: Sequence[FreeParameter],
    noise: Noise,
    *,
    start: Mapping[str, float] | None = None,
    iterations: int = 25,
    tolerance: float = 1e-3,
    predictor: FilterResults | None = None,
    spreads: Mapping[str, float] | None = None,
    effects: Float | None = None,
) -> ParameterFit:
    """Newton's method on the prediction errors, in a trust region and within the bounds.

    start: values by label; without it the parameters' own starts. Ends with the step that changes
    the numbers by no more than `tolerance` of their standard deviations in the mean square: its
    gain follows from the quadratic model of the last normal equations. A step that is small because
    the region is ends the fit at `TRUST_REGION_STEP_TOLERANCE_FACTOR` of that, and is not taken:
    there the quadratic model has failed. A whole step that fails and is at most
    `FAILED_STEP_TOLERANCE_FACTOR` of the tolerance ends the fit where it is: the differences are no
    more exact than that. predictor, spreads: as in `trial_normal_equations`, and so are effects, at
    the start.
    """
    slots = parameter_index_by_name(kernel)
    parameters = [kernel.system.parameters[slots[f.name]] for f in free]
    lower, upper = (np.array([getattr(p, k) for p in parameters]) for k in ("lower", "upper"))
    given = start or {}
    x = np.array([given.get(f.label, given.get(f.name, base[slots[f.name]])) for f in free])
    x = np.clip(x, lower, upper)
    normal = trial_normal_equations(kernel, series, base, free, x, noise=noise, predictor=predictor,
                                    spreads=spreads, effects=effects)  # fmt: skip
    radius, outcome, count = np.inf, STALLED, 0
    while normal.all_finite and count < iterations:
        count += 1
        H, g = normal.hessian.sum(axis=0), normal.gradient.sum(axis=0)
        step = bounded_step(H, g, lower - x, upper - x, radius)
        longest = float(np.max(np.abs(step) * np.sqrt(np.maximum(np.diag(H), 0.0)), initial=0.0))
        whole = longest < (1 - 1e-9) * radius
        if _is_small_step(
            normal, step, tolerance * (1.0 if whole else TRUST_REGION_STEP_TOLERANCE_FACTOR)
        ):
            if whole:
                x, normal = (
                    np.clip(x + step, lower, upper),
                    _normal_equations_after_step(normal, step),
                )
            outcome = CONVERGED
            break
        trial = np.clip(x + step, lower, upper)
        candidate = trial_normal_equations(
            kernel, series, base, free, trial, noise=noise, predictor=predictor, spreads=spreads,
            effects=_trial_effects_after_step(normal, step),
        )  # fmt: skip
        gain = float(candidate.log_likelihood.sum() - normal.log_likelihood.sum())
        slope = float(g @ step)
        share = gain / (slope - 0.5 * float(step @ H @ step))
        if candidate.all_finite and gain >= 0:
            x, normal = trial, candidate
            if share > GOOD_GAIN_SHARE:
                radius = max(radius, 2.0 * longest)
            elif share < POOR_GAIN_SHARE:
                radius = 0.5 * longest
        elif whole and _is_small_step(normal, step, FAILED_STEP_TOLERANCE_FACTOR * tolerance):
            outcome = CONVERGED
            break
        else:
            top = 0.5 * slope / (slope - gain) if np.isfinite(gain) else 0.0
            radius = longest * float(np.clip(top, MIN_SHRINKAGE, MAX_SHRINKAGE))
    bound = (x <= lower) | (x >= upper)
    outcome = AT_BOUND_REASON if outcome == CONVERGED and bound.any() else outcome
    return ParameterFit(
        tuple(free), x, normal, outcome, count, free_parameter_definitions(kernel.system, free)
    )


def _is_small_step(normal: NormalEquationsByTrial, change: Float, tolerance: float) -> bool:
    """Whether a step lies within `tolerance` standard deviations: change' H change < tol^2."""
    return bool(change @ normal.hessian.sum(axis=0) @ change < tolerance**2 * max(len(change), 1))


def _trial_effects_after_step(normal: NormalEquationsByTrial, step: Float) -> Float:
    """Most probable trial effects (t, q) a step further, to first order."""
    return normal.effects.values + normal.effects.slopes @ step


def _normal_equations_after_step(
    normal: NormalEquationsByTrial, step: Float
) -> NormalEquationsByTrial:
    """The normal equations a step further, by their own parabola."""
    bend = normal.hessian @ step
    return replace(
        normal,
        gradient=normal.gradient - bend,
        log_likelihood=normal.log_likelihood + (normal.gradient - 0.5 * bend) @ step,
        effects=replace(normal.effects, values=_trial_effects_after_step(normal, step)),
    )


def regularised_fisher_inverse(matrix: Float) -> Float:
    """Inverse of a Fisher matrix (..., p, p); directions that no data touch get a huge variance."""
    diagonal = np.einsum("...pp->...p", matrix)
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scales = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(matrix / scales)
    weighted = vectors / np.maximum(values, 1e-12)[..., None, :]
    return weighted @ np.swapaxes(vectors, -1, -2) / scales


def sensitivity_to_other_parameters(
    hessian: Float, own: Sequence[int], others: Sequence[int]
) -> Float:
    """-H_oo^-1 H_ox (own, others): how some numbers of a fit go along with a change of others."""
    return -regularised_fisher_inverse(hessian[np.ix_(own, own)]) @ hessian[np.ix_(own, others)]
