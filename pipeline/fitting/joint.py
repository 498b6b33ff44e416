"""Joint maximum likelihood over all trials by prediction errors.

The filter's gains are held while parameters are varied, so that all trials and all differences
run through one call of the integrator, sixteen at a time; starting states are eliminated by the
filter's own start, whose covariance is wide. Each trial's normal equations are kept apart: sums
over trials give the fit, resampled sums its uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate
from .filtering import Filtered, disturbance_slots, filter_all
from .series import Free, Noise, Series

CONVERGED = "converged"
AT_BOUND = "at a bound: the data ask for more than is plausible, look for missing physics"
STALLED = "stalled: no step improves the fit; try other starts, or fewer free coefficients"


@dataclass(frozen=True)
class Normal:
    """Normal equations of each trial at one point: trials t, free numbers p.

    hessian (t, p, p) = J'J, gradient (t, p) = J'e of the whitened errors, log_likelihood (t,).
    """

    hessian: Float
    gradient: Float
    log_likelihood: Float


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
    return Normal(hessian + side.hessian, gradient + side.gradient, logl + side.log_likelihood)


def _evidence(
    kernel: Kernel, series: Sequence[Series], free: Sequence[Free], points: Sequence[Float]
) -> Normal:
    """Side measurements as further prediction errors: each effect says what it predicts."""
    n, p = len(series), len(free)
    hessian, gradient, logl = np.zeros((n, p, p)), np.zeros((n, p)), np.zeros(n)
    for i, (one, point) in enumerate(zip(series, points, strict=True)):
        for name, (value, std) in one.evidence.items():
            predicted, slope = _predicted_evidence(kernel, name, free, point)
            error, row = (value - predicted) / std, slope / std
            hessian[i] += np.outer(row, row)
            gradient[i] += row * error
            logl[i] -= 0.5 * error * error + np.log(std) + 0.5 * np.log(2 * np.pi)
    return Normal(hessian, gradient, logl)


def _predicted_evidence(
    kernel: Kernel, name: str, free: Sequence[Free], point: Float
) -> tuple[float, Float]:
    total, slope = 0.0, np.zeros(len(free))
    slots = slots_by_name(kernel)
    for effect in kernel.system.effects:
        for own, weight in effect.evidence.items():
            if own == name:
                parameter = f"{effect.name}.{effect.parameters[0].name}"
                total += weight * point[slots[parameter]]
                slope += [weight * (f.name == parameter) for f in free]
    return total, slope


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
    if disturbance_slots(kernel):
        name = next(e.name for e in system.effects if e.kind == "disturbance")
        present, tau = system.slots(name)
        values[:, present], values[:, tau] = 1.0, noise.tau
    frames = np.array([len(series[t].times) for t, _ in chunks])
    observed, _ = propagate(
        kernel, state, values, constants, times=times, inputs=inputs, frames=frames, seen=seen,
        gains=gains,
    )  # fmt: skip
    return observed


def _step(kernel: Kernel, free: Free, value: float) -> float:
    parameter = kernel.system.parameters[slots_by_name(kernel)[free.name]]
    span = max(abs(value), 0.05 * abs(parameter.start), 1e-6)
    step = 1e-4 * span
    return -step if value + step > parameter.upper else step


def fit(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    free: Sequence[Free],
    noise: Noise,
    *,
    start: Mapping[str, float] | None = None,
    iterations: int = 25,
    tolerance: float = 1e-3,
    predictor: Sequence[Filtered] | None = None,
) -> Fit:
    """Levenberg-Marquardt on the prediction errors, within the parameters' bounds.

    start: values by label; without it the parameters' own starts. Ends when a step changes no
    number by more than `tolerance` of its standard deviation. predictor: as in `normal_equations`.
    """
    slots = slots_by_name(kernel)
    parameters = [kernel.system.parameters[slots[f.name]] for f in free]
    lower, upper = (np.array([getattr(p, k) for p in parameters]) for k in ("lower", "upper"))
    given = start or {}
    x = np.array([given.get(f.label, given.get(f.name, base[slots[f.name]])) for f in free])
    x = np.clip(x, lower, upper)
    normal = normal_equations(kernel, series, base, free, x, noise=noise, predictor=predictor)
    damping, outcome, count = 1e-4, STALLED, 0
    while count < iterations and damping < 1e8:
        count += 1
        step = damped_step(normal, damping, x, lower, upper)
        trial = np.clip(x + step, lower, upper)
        candidate = normal_equations(
            kernel, series, base, free, trial, noise=noise, predictor=predictor
        )
        gain = candidate.log_likelihood.sum() - normal.log_likelihood.sum()
        small = _is_small(normal, trial - x, tolerance)
        if np.isfinite(gain) and gain >= -1e-9:
            x, normal, damping = trial, candidate, max(damping * 0.2, 1e-9)
        else:
            damping *= 8.0
        if small:
            outcome = CONVERGED
            break
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


def pseudo_inverse(matrix: Float) -> Float:
    """Inverse of a Fisher matrix; directions that the data do not touch get a huge variance."""
    scale = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    inverse = vectors[1] / np.maximum(vectors[0], 1e-12) @ vectors[1].T
    return inverse / np.outer(scale, scale)
