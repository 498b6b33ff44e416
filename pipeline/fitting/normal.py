"""Normal equations of prediction errors, each trial's kept apart.

The filter's gains are held while parameters are varied, so that all trials and all differences
run through one call of the integrator, sixteen at a time; starting states are eliminated by the
filter's own start, whose covariance is wide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel, System
from ..integrate.batch import propagate
from .filtering import STEP_S, Filtered, filter_all, with_noise
from .series import Free, Noise, Series


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
    kernel: Kernel, base: Float, free: Sequence[Free], values: Float, group: str
) -> Float:
    """Full parameter vector of a trial of `group`: `base` with the free numbers put in."""
    out = base.copy()
    slots = slots_by_name(kernel)
    for item, value in zip(free, values, strict=True):
        if item.group is None or item.group == group:
            out[slots[item.name]] = value
    return out


def slots_by_name(kernel: Kernel) -> dict[str, int]:
    """Place of every parameter by name."""
    return kernel.system.slot


@np.errstate(over="ignore", invalid="ignore")  # of a model that runs away `Normal.usable` tells
def normal_equations(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    free: Sequence[Free],
    values: Float,
    *,
    noise: Noise,
    predictor: Sequence[Filtered] | None = None,
) -> Normal:
    """Normal equations at a point, from one filter pass and one batch of perturbed predictions.

    predictor: gains of a filter at another point, held in place of a new pass; many candidates
    are then compared as predictors of one form, at a fraction of the cost.
    """
    points = [trial_values(kernel, base, free, values, s.group) for s in series]
    filtered = predictor or filter_all(kernel, series, points, noise)
    jacobian, errors = _jacobians(kernel, series, points, free, values, noise=noise,
                                  filtered=filtered)  # fmt: skip
    hessian = np.array([np.einsum("nop,noq->pq", j, j) for j in jacobian])
    gradient = np.array(
        [np.einsum("nop,no->p", j, e) for j, e in zip(jacobian, errors, strict=True)]
    )
    logl = np.array([
        f.log_likelihood + 0.5 * float(np.sum(f.innovations**2) - np.sum(e**2))
        for f, e in zip(filtered, errors, strict=True)
    ])  # fmt: skip
    side = _evidence(kernel, series, free, points)
    known = _plausible(kernel, free, values, len(series))
    return Normal(
        hessian + side.hessian + known.hessian,
        gradient + side.gradient + known.gradient,
        logl + side.log_likelihood + known.log_likelihood,
    )


def _plausible(kernel: Kernel, free: Sequence[Free], values: Float, trials: int) -> Normal:
    """What is plausible before any data (`Parameter.spread`), shared evenly among the trials."""
    parameters = [kernel.system.parameters[slots_by_name(kernel)[f.name]] for f in free]
    precision = np.array([p.spread for p in parameters]) ** -2.0 / trials
    off = np.array([p.start for p in parameters]) - values
    return Normal(
        np.tile(np.diag(precision), (trials, 1, 1)),
        np.tile(precision * off, (trials, 1)),
        np.full(trials, -0.5 * float(precision @ off**2)),
    )


def side_log_likelihoods(
    kernel: Kernel, series: Sequence[Series], points: Sequence[Float]
) -> Float:
    """Log likelihood (trials,) of the side measurements at a full parameter vector for each."""
    return _evidence(kernel, series, (), points).log_likelihood


def _evidence(
    kernel: Kernel, series: Sequence[Series], free: Sequence[Free], points: Sequence[Float]
) -> Normal:
    """Side measurements as further prediction errors: each effect says what it predicts."""
    n, p = len(series), len(free)
    hessian, gradient, logl = np.zeros((n, p, p)), np.zeros((n, p)), np.zeros(n)
    slots = np.array([slots_by_name(kernel)[f.name] for f in free], dtype=int)
    for i, (one, point) in enumerate(zip(series, points, strict=True)):
        own = np.array([f.group in (None, one.group) for f in free])
        for name, (value, std) in one.evidence.items():
            weights = evidence_weights(kernel.system, name)
            error = (value - float(weights @ point)) / std
            row = weights[slots] * own / std
            hessian[i] += row[:, None] * row
            gradient[i] += row * error
            logl[i] -= 0.5 * error * error + np.log(std) + 0.5 * np.log(2 * np.pi)
    return Normal(hessian, gradient, logl)


@lru_cache(maxsize=64)
def evidence_weights(system: System, name: str) -> Float:
    """A side measurement as a sum over parameters (parameters,): effects tell of their first."""
    weights = np.zeros(len(system.parameters))
    for effect in system.effects:
        weights[system.slots(effect.name)[:1]] += effect.evidence.get(name, 0.0)
    return weights


@np.errstate(over="ignore", invalid="ignore")
def log_likelihoods(
    kernel: Kernel,
    series: Sequence[Series],
    points: Sequence[Float],
    *,
    noise: Noise,
    predictor: Sequence[Filtered],
) -> Float:
    """Log likelihood (trials,) of each trial at a full parameter vector of its own.

    The filter's gains are held. Side measurements and what is plausible beforehand stay out.
    """
    seen = _perturbed(kernel, series, points, [(t, []) for t in range(len(series))],
                      noise=noise, filtered=predictor)  # fmt: skip
    out = np.array([f.log_likelihood + 0.5 * float(np.sum(f.innovations**2)) for f in predictor])
    for t, one in enumerate(series):
        error = np.nan_to_num(one.seen - seen[t, : len(one.times), :, 0])
        out[t] -= 0.5 * float(np.sum((predictor[t].roots @ error[:, :, None]) ** 2))
    return out


def _jacobians(
    kernel: Kernel,
    series: Sequence[Series],
    points: Sequence[Float],
    free: Sequence[Free],
    values: Float,
    *,
    noise: Noise,
    filtered: Sequence[Filtered],
) -> tuple[list[Float], list[Float]]:
    """A trial's derivatives of the whitened predictions (n, observations, p), and its errors."""
    slots = slots_by_name(kernel)
    steps = np.array([_step(kernel, f, v) for f, v in zip(free, values, strict=True)])
    own = [[k for k, f in enumerate(free) if f.group in (None, s.group)] for s in series]
    chunks = [(t, ks[i : i + LANES - 1]) for t, ks in enumerate(own)
              for i in range(0, max(len(ks), 1), LANES - 1)]  # fmt: skip
    observed = _perturbed(kernel, series, points, [
        (t, [(slots[free[k].name], steps[k]) for k in ks]) for t, ks in chunks],
        noise=noise, filtered=filtered)  # fmt: skip
    out = [np.zeros((*f.innovations.shape, len(free))) for f in filtered]
    errors = [np.zeros(f.innovations.shape) for f in filtered]
    for (t, ks), seen in zip(chunks, observed, strict=True):
        n = len(series[t].times)
        base = seen[:n, :, :1]
        change = (seen[:n, :, 1 : len(ks) + 1] - base) / steps[ks]
        out[t][:, :, ks] = filtered[t].roots @ change
        error = np.nan_to_num(series[t].seen - base[:, :, 0])
        errors[t] = (filtered[t].roots @ error[:, :, None])[:, :, 0]
    return out, errors


def _perturbed(
    kernel: Kernel,
    series: Sequence[Series],
    points: Sequence[Float],
    chunks: Sequence[tuple[int, list[tuple[int, float]]]],
    *,
    noise: Noise,
    filtered: Sequence[Filtered],
) -> Float:
    """Predicted observations (chunks, frames, observations, 16); lane 0 is the point itself."""
    system = kernel.system
    longest = max(len(s.times) for s in series)
    count = len(chunks)
    times = np.zeros((count, longest))
    inputs = np.zeros((count, longest, len(system.inputs)))
    seen = np.zeros((count, longest, len(system.observations)))
    gains = np.zeros((count, longest, len(system.all_states), len(system.observations)))
    values = np.zeros((count, len(system.parameters), LANES))
    state = np.zeros((count, len(system.all_states), LANES))
    constants = np.zeros((count, len(system.constants), LANES))
    for c, (t, perturbations) in enumerate(chunks):
        one, n = series[t], len(series[t].times)
        times[c, :n], times[c, n:] = one.times, one.times[-1]
        inputs[c, :n] = one.inputs
        seen[c, :n] = np.nan_to_num(one.seen)
        gains[c, :n] = filtered[t].gains
        values[c] = points[t][:, None]
        for lane, (slot, step) in enumerate(perturbations, start=1):
            values[c, slot, lane] += step
        state[c], constants[c] = one.mean[:, None], one.constants[:, None]
    values = np.moveaxis(with_noise(kernel, np.moveaxis(values, 1, 0), noise), 0, 1)
    frames = np.array([len(series[t].times) for t, _ in chunks])
    observed, _ = propagate(
        kernel, state, values, constants, times=times, inputs=inputs, frames=frames, seen=seen,
        gains=gains, step_s=STEP_S,
    )  # fmt: skip
    return observed


def _step(kernel: Kernel, free: Free, value: float) -> float:
    parameter = kernel.system.parameters[slots_by_name(kernel)[free.name]]
    span = max(abs(value), 0.05 * abs(parameter.start), 1e-6)
    step = 1e-4 * span
    return -step if value + step > parameter.upper else step
