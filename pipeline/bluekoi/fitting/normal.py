"""Normal equations of prediction errors, each trial's kept apart.

The filter's gains are held while parameters are varied, so that all trials and all differences
run through one call of the integrator, sixteen at a time; starting states are eliminated by the
filter's own start, whose covariance is wide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem
from .filtering import FilterResults, filter_all
from .predictions import (
    ParameterChange,
    finite_difference_step,
    parameter_index_by_name,
    whitened_gram_matrices,
)
from .series import FreeParameter, Noise, TrialSeries
from .side_measurements import side_measurement_terms
from .trial_effects import NO_EFFECTS, MostProbableTrialEffects, marginal_gram_matrices_at_effects


@dataclass(frozen=True)
class NormalEquationsByTrial:
    """Normal equations of each trial at one point: trials t, free numbers p.

    hessian (t, p, p) = J'J, gradient (t, p) = J'e of the whitened errors, log_likelihood (t,).
    effects: the most probable trial effects at the point.
    """

    hessian: Float
    gradient: Float
    log_likelihood: Float
    effects: MostProbableTrialEffects = NO_EFFECTS

    @property
    def all_finite(self) -> bool:
        """Whether all of it is finite: a simulation that runs away makes it not so."""
        parts = (self.hessian, self.gradient, self.log_likelihood)
        return all(bool(np.isfinite(part).all()) for part in parts)


def trial_parameter_vector(
    kernel: CompiledSystem, base: Float, free: Sequence[FreeParameter], values: Float, group: str
) -> Float:
    """Full parameter vector of a trial of `group`: `base` with the free numbers put in."""
    out = base.copy()
    slots = parameter_index_by_name(kernel)
    for item, value in zip(free, values, strict=True):
        if item.group is None or item.group == group:
            out[slots[item.name]] = value
    return out


@np.errstate(
    over="ignore", invalid="ignore"
)  # `NormalEquationsByTrial.usable` is False for a model that diverges
def trial_normal_equations(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    free: Sequence[FreeParameter],
    values: Float,
    *,
    noise: Noise,
    predictor: FilterResults | None = None,
    spreads: Mapping[str, float] | None = None,
    effects: Float | None = None,
) -> NormalEquationsByTrial:
    """Normal equations at a point, from one filter pass and one batch of perturbed predictions.

    spreads: prior standard deviations about 0 by label, in place of `Parameter.spread`.
    effects (t, q): trial effects about which the predictions are linearised; without, the most
    probable ones at this point.
    predictor: gains of a filter at another point over the same series, held in place of a new
    pass; many candidates are then compared as predictors of one form, at a fraction of the cost.
    """
    points = [trial_parameter_vector(kernel, base, free, values, s.group) for s in series]
    passes = predictor or filter_all(kernel, series, points, noise)
    slots = parameter_index_by_name(kernel)
    groups = [s.group for s in series]
    own = [np.array([f.group in {None, g} for g in groups]) for f in free]
    changes = [
        ParameterChange(finite_difference_step(kernel, f, value), trials, {slots[f.name]: 1.0})
        for f, value, trials in zip(free, values, own, strict=True)
    ]
    products, constant, found = marginal_gram_matrices_at_effects(
        kernel, passes, points, changes, noise=noise, effects=effects
    )
    information, score, side = side_measurement_terms(kernel, series, free, points)
    known = prior_terms(kernel, free, values, len(series), spreads)
    return NormalEquationsByTrial(
        products[:, 1:, 1:] + information + known.hessian,
        products[:, 1:, 0] + score + known.gradient,
        passes.log_lik_const - 0.5 * products[:, 0, 0] + constant + side
        + known.log_likelihood,
        found,
    )  # fmt: skip


def prior_terms(
    kernel: CompiledSystem, free: Sequence[FreeParameter], values: Float, trials: int,
    spreads: Mapping[str, float] | None = None,
) -> NormalEquationsByTrial:  # fmt: skip
    """What is plausible before any data (`Parameter.spread` about `start`, or `spreads` about 0 by
    label), shared evenly among the trials.
    """
    parameters = [kernel.system.parameters[parameter_index_by_name(kernel)[f.name]] for f in free]
    known = spreads or {}
    stds = [known.get(f.label, p.spread) for f, p in zip(free, parameters, strict=True)]
    precision = np.array(stds) ** -2.0 / trials
    means = [0.0 if f.label in known else p.start for f, p in zip(free, parameters, strict=True)]
    off = np.array(means) - values
    return NormalEquationsByTrial(
        np.tile(np.diag(precision), (trials, 1, 1)),
        np.tile(precision * off, (trials, 1)),
        np.full(trials, -0.5 * float(precision @ off**2)),
    )


@np.errstate(over="ignore", invalid="ignore")
def log_likelihood_by_trial(
    kernel: CompiledSystem,
    points: Sequence[Float],
    *,
    noise: Noise,
    predictor: FilterResults,
) -> Float:
    """Log likelihood (trials,) of each trial at a full parameter vector of its own.

    The filter's gains are held. Side measurements and what is plausible beforehand stay out.
    """
    errors = whitened_gram_matrices(kernel, predictor, points, (), noise)
    return predictor.log_lik_const - 0.5 * errors[:, 0, 0]
