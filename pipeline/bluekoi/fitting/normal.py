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
from .predictions import ParameterChange, whitened_products
from .series import Free, Noise, Series
from .side_measurements import side_measurement_terms


@dataclass(frozen=True)
class Normal:
    """Normal equations of each trial at one point: trials t, free numbers p.

    hessian (t, p, p) = J'J, gradient (t, p) = J'e of the whitened errors, log_likelihood (t,).
    """

    hessian: Float
    gradient: Float
    log_likelihood: Float

    @property
    def usable(self) -> bool:
        """Whether all of it is finite: a simulation that runs away makes it not so."""
        parts = (self.hessian, self.gradient, self.log_likelihood)
        return all(bool(np.isfinite(part).all()) for part in parts)


def trial_values(
    kernel: CompiledSystem, base: Float, free: Sequence[Free], values: Float, group: str
) -> Float:
    """Full parameter vector of a trial of `group`: `base` with the free numbers put in."""
    out = base.copy()
    slots = slots_by_name(kernel)
    for item, value in zip(free, values, strict=True):
        if item.group is None or item.group == group:
            out[slots[item.name]] = value
    return out


def slots_by_name(kernel: CompiledSystem) -> dict[str, int]:
    """Place of every parameter by name."""
    return kernel.system.slot


@np.errstate(over="ignore", invalid="ignore")  # `Normal.usable` is False for a model that diverges
def normal_equations(
    kernel: CompiledSystem, series: Sequence[Series], base: Float, free: Sequence[Free],
    values: Float, *, noise: Noise, predictor: FilterResults | None = None,
    spreads: Mapping[str, float] | None = None,
) -> Normal:  # fmt: skip
    """Normal equations at a point, from one filter pass and one batch of perturbed predictions.

    spreads: prior standard deviations about 0 by label, in place of `Parameter.spread`.
    predictor: gains of a filter at another point over the same series, held in place of a new
    pass; many candidates are then compared as predictors of one form, at a fraction of the cost.
    """
    points = [trial_values(kernel, base, free, values, s.group) for s in series]
    passes = predictor or filter_all(kernel, series, points, noise)
    slots = slots_by_name(kernel)
    groups = [s.group for s in series]
    own = [np.array([f.group in {None, g} for g in groups]) for f in free]
    changes = [ParameterChange(difference_step(kernel, f, value), trials, {slots[f.name]: 1.0})
               for f, value, trials in zip(free, values, own, strict=True)]  # fmt: skip
    changes += trial_effect_changes(kernel, points, noise)
    products, constant = marginal_products(
        whitened_products(kernel, passes, points, changes, noise),
        trial_effect_stds(kernel, points, noise),
    )
    information, score, side = side_measurement_terms(kernel, series, free, points)
    known = prior_terms(kernel, free, values, len(series), spreads)
    return Normal(
        products[:, 1:, 1:] + information + known.hessian,
        products[:, 1:, 0] + score + known.gradient,
        passes.log_lik_const - 0.5 * products[:, 0, 0] + constant + side
        + known.log_likelihood,
    )  # fmt: skip


def trial_effect_changes(
    kernel: CompiledSystem, points: Sequence[Float], noise: Noise
) -> list[ParameterChange]:
    """Differences in the parameters that vary from trial to trial."""
    every, slots = np.ones(len(points), dtype=bool), slots_by_name(kernel)
    out = []
    for effect in noise.trial_effects:
        slot = slots[effect.parameter]
        free = Free(effect.parameter)
        out.append(
            ParameterChange(
                difference_step(kernel, free, float(points[0][slot])), every, {slot: 1.0}
            )
        )
    return out


def trial_effect_stds(kernel: CompiledSystem, points: Sequence[Float], noise: Noise) -> Float:
    """Standard deviations (trials, effects) of the parameters that vary from trial to trial."""
    slots, at = slots_by_name(kernel), np.array(points)
    columns = [e.std * (np.abs(at[:, slots[e.parameter]]) if e.relative else np.ones(len(at)))
               for e in noise.trial_effects]  # fmt: skip
    return np.array(columns).T.reshape(len(at), len(columns))


def marginal_products(products: Float, stds: Float) -> tuple[Float, Float]:
    """Products (t, n, n) of columns of which the last q have normal coefficients, integrated out.

    With the errors e, columns J and random columns Z of covariance D = diag(stds^2), a trial's
    marginal likelihood has the products P - P_z (P_zz + D^-1)^-1 P_z' and the constant
    -1/2 log|I + D P_zz| (t,).  (Laird and Ware, Biometrics 38 (1982), 963)
    """
    q = stds.shape[1]
    if q == 0:
        return products, np.zeros(len(products))
    kept = products.shape[1] - q
    scaled = products[:, :, kept:] * stds[:, None, :]  # P_z D^1/2
    inner = np.eye(q) + scaled[:, kept:] * stds[:, :, None]
    solved = np.linalg.solve(inner, np.swapaxes(scaled[:, :kept], 1, 2))
    with np.errstate(invalid="ignore"):  # of a trial in which the model runs away
        constant = -0.5 * np.linalg.slogdet(inner)[1]
    return products[:, :kept, :kept] - scaled[:, :kept] @ solved, constant


def prior_terms(
    kernel: CompiledSystem, free: Sequence[Free], values: Float, trials: int,
    spreads: Mapping[str, float] | None = None,
) -> Normal:  # fmt: skip
    """What is plausible before any data (`Parameter.spread` about `start`, or `spreads` about 0 by
    label), shared evenly among the trials.
    """
    parameters = [kernel.system.parameters[slots_by_name(kernel)[f.name]] for f in free]
    known = spreads or {}
    stds = [known.get(f.label, p.spread) for f, p in zip(free, parameters, strict=True)]
    precision = np.array(stds) ** -2.0 / trials
    means = [0.0 if f.label in known else p.start for f, p in zip(free, parameters, strict=True)]
    off = np.array(means) - values
    return Normal(
        np.tile(np.diag(precision), (trials, 1, 1)),
        np.tile(precision * off, (trials, 1)),
        np.full(trials, -0.5 * float(precision @ off**2)),
    )


@np.errstate(over="ignore", invalid="ignore")
def log_likelihoods(
    kernel: CompiledSystem,
    points: Sequence[Float],
    *,
    noise: Noise,
    predictor: FilterResults,
) -> Float:
    """Log likelihood (trials,) of each trial at a full parameter vector of its own.

    The filter's gains are held. Side measurements and what is plausible beforehand stay out.
    """
    errors = whitened_products(kernel, predictor, points, (), noise)
    return predictor.log_lik_const - 0.5 * errors[:, 0, 0]


def difference_step(kernel: CompiledSystem, free: Free, value: float) -> float:
    """Size of the difference in a free number, away from its upper bound."""
    parameter = kernel.system.parameters[slots_by_name(kernel)[free.name]]
    span = max(abs(value), 0.05 * abs(parameter.start), 1e-6)
    step = 1e-4 * span
    return -step if value + step > parameter.upper else step
