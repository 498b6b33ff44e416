"""Errors that are constant in a trial and differ between trials, integrated out.

The predictions are linearised about the most probable effects of each trial, not about 0: only
there does the slope of the marginal likelihood follow from the slopes of the predictions
(Lindstrom and Bates, Biometrics 46 (1990), 673).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem
from .filtering import FilterResults
from .predictions import (
    ParameterChange,
    finite_difference_step,
    parameter_index_by_name,
    whitened_gram_matrices,
)
from .series import FreeParameter, Noise

NEWTON_STEPS = 2
"""Newton steps to the most probable effects: they are small, and the predictions nearly linear."""


@dataclass(frozen=True)
class MostProbableTrialEffects:
    """Most probable trial effects at a point: values (t, q), slopes (t, q, p) by its numbers."""

    values: Float
    slopes: Float


RELATIVE_ROUNDING_ERROR, NEGLIGIBLE_ERROR = 1e-14, 1e-3
"""Rounding error of a marginal sum of squares, over the sum before: tens of units in the last place
of a double; and one that makes no difference to a log likelihood."""
NO_EFFECTS = MostProbableTrialEffects(np.zeros((1, 0)), np.zeros((1, 0, 1)))
"""Of a model without such effects."""


def marginal_gram_matrices_at_effects(
    kernel: CompiledSystem, passes: FilterResults, points: Sequence[Float],
    changes: Sequence[ParameterChange], *, noise: Noise, effects: Float | None = None,
) -> tuple[Float, Float, MostProbableTrialEffects]:  # fmt: skip
    """Marginal products and constants, as `marginal_gram_matrices`, at full parameter vectors, one
    a trial, linearised about `effects` (t, q) or, without, the most probable ones there.
    """
    stds = _effect_stds(points, noise)
    if effects is None:
        effects = most_probable_trial_effects(kernel, passes, points, noise)
    more = [*changes, *trial_effect_parameter_changes(kernel, points, noise)]
    at = parameter_vectors_with_trial_effects(kernel, points, effects, noise)
    products = whitened_gram_matrices(kernel, passes, at, more, noise)
    return marginal_gram_matrices(_gram_matrices_at_zero_effects(products, effects), stds)


def most_probable_trial_effects(
    kernel: CompiledSystem, passes: FilterResults, points: Sequence[Float], noise: Noise
) -> Float:
    """Most probable trial effects (t, q), by Newton steps from 0."""
    found: Float = np.zeros((len(points), len(noise.trial_effects)))
    if not noise.trial_effects:
        return found
    stds = _effect_stds(points, noise)
    changes = trial_effect_parameter_changes(kernel, points, noise)
    for _ in range(NEWTON_STEPS):
        at = parameter_vectors_with_trial_effects(kernel, points, found, noise)
        products = whitened_gram_matrices(kernel, passes, at, changes, noise)
        found = marginal_gram_matrices(_gram_matrices_at_zero_effects(products, found), stds)[
            2
        ].values
    return found


def _effect_stds(points: Sequence[Float], noise: Noise) -> Float:
    """Standard deviations (t, q) of the effects."""
    return np.tile([e.std for e in noise.trial_effects], (len(points), 1))


def parameter_vectors_with_trial_effects(
    kernel: CompiledSystem, points: Sequence[Float], effects: Float, noise: Noise
) -> list[Float]:
    """Full parameter vectors, one a trial, with the effects (t, q) of each added."""
    slots = [parameter_index_by_name(kernel)[e.parameter] for e in noise.trial_effects]
    out = np.array(points)
    out[:, slots] += effects
    return list(out)


def sample_trial_effects(known: Float, trials: Sequence[str], rng: np.random.Generator) -> Float:
    """Random effects (points, q), the same for all points of a trial, drawn from the most probable
    effects `known` (n, q) of the fitted trials; trials: that of each point.
    """
    drawn = {name: known[rng.integers(len(known))] for name in dict.fromkeys(trials)}
    return np.array([drawn[name] for name in trials])


def _gram_matrices_at_zero_effects(products: Float, effects: Float) -> Float:
    """Products (t, n, n) whose errors e, found at effects b, are those without: e + Z b."""
    q = effects.shape[1]
    if q == 0:
        return products
    out = products.copy()
    out[:, 0] += np.einsum("tq,tqn->tn", effects, products[:, -q:])
    out[:, :, 0] += np.einsum("tq,tnq->tn", effects, out[:, :, -q:])
    return out


def trial_effect_parameter_changes(
    kernel: CompiledSystem, points: Sequence[Float], noise: Noise
) -> list[ParameterChange]:
    """Differences in the parameters that vary from trial to trial."""
    every, slots = np.ones(len(points), dtype=bool), parameter_index_by_name(kernel)
    out = []
    for effect in noise.trial_effects:
        slot = slots[effect.parameter]
        free = FreeParameter(effect.parameter)
        out.append(
            ParameterChange(
                finite_difference_step(kernel, free, float(points[0][slot])), every, {slot: 1.0}
            )
        )
    return out


def marginal_gram_matrices(
    products: Float, stds: Float
) -> tuple[Float, Float, MostProbableTrialEffects]:
    """Products (t, n, n) of columns of which the last q have normal coefficients, integrated out.

    With the errors e, columns J and random columns Z of covariance D = diag(stds^2), a trial's
    marginal likelihood has the products P - P_z (P_zz + D^-1)^-1 P_z' and the constant
    -1/2 log|I + D P_zz| (t,); the most probable coefficients are (P_zz + D^-1)^-1 Z'(e - J d).
    All are NaN for a trial in which the model runs away: by rounding errors, I + D P_zz is then not
    positive definite, or the marginal e'e not known.
    (Laird and Ware, Biometrics 38 (1982), 963)
    """
    q = stds.shape[1]
    kept = products.shape[1] - q
    if q == 0:
        none = MostProbableTrialEffects(
            np.zeros((len(products), 0)), np.zeros((len(products), 0, kept - 1))
        )
        return products, np.zeros(len(products)), none
    scaled = products[:, :, kept:] * stds[:, None, :]  # P_z D^1/2
    inner = np.eye(q) + scaled[:, kept:] * stds[:, :, None]
    with np.errstate(invalid="ignore"):  # of a trial in which the model runs away
        sign, log_determinant = np.linalg.slogdet(inner)
    definite = (sign > 0)[:, None, None]
    solved = np.linalg.solve(
        np.where(definite, inner, np.eye(q)), np.swapaxes(scaled[:, :kept], 1, 2)
    )
    marginal = products[:, :kept, :kept] - scaled[:, :kept] @ solved
    rounding = RELATIVE_ROUNDING_ERROR * products[:, :1, :1]
    solvable = definite & ((marginal[:, :1, :1] > rounding) | (rounding < NEGLIGIBLE_ERROR))
    solved, marginal = (np.where(solvable, found, np.nan) for found in (solved, marginal))
    probable = stds[:, :, None] * solved
    effects = MostProbableTrialEffects(probable[:, :, 0], -probable[:, :, 1:])
    return marginal, np.where(solvable[:, 0, 0], -0.5 * log_determinant, np.nan), effects
