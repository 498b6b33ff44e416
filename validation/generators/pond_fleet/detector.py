"""The ideal detector: what a refit without a cause leaves over, and how sure its size can be.

Two measures of a hidden cause. Both use the true forms of all that is free.

path error  of the best model without the cause (coefficients, fin and other hidden causes free),
            after the starts of segments: root mean square distance, also over the floor
sigma       square root of the misfit left when, beside these, the strengths of seven other causes,
            a scale and a clock error are free with priors of plausible size
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .experiment import PER_SEGMENT, SEGMENTS, Experiment, Variant
from .law import Law
from .plan import FAMILIES
from .robots import Array
from .scatter import Scatter, flat

Fault = Callable[[Array], Array]
"""An error of measurement: observation (..., trials, SAMPLES, 3) as it appears."""

RIVALS = (
    ("viscous_drag", "stokes", 0.1), ("linear_yaw_damping", "linear", 0.08),
    ("crossflow_drag", "even_depth", 0.3), ("trim_moment", "trim_by_speed", 0.01),
    ("head_angle_offset", "fixed_offset", 0.02), ("uniform_current", "constant_current", 0.02),
    ("thrust_line_offset", "sine_lever", 0.03),
)  # fmt: skip
"""Other causes that the detector fits: name, form, prior standard deviation of the size."""
SCALE_PRIOR, CLOCK_PRIOR = 0.003, 0.003
PRIOR = np.concatenate([np.full(6, 1.2), [1.0, 0.15]])
"""Prior of the logarithms of coefficients and fin area, and of the fin's shift (L)."""
STEP = 1e-3
ROUNDS = 7


@dataclass(frozen=True)
class Model:
    """A model that is fitted: its laws, their start sizes, and the errors of measurement in it.

    starts: true states at the starts of segments, (rows, segments).
    """

    experiment: Experiment
    starts: Array
    laws: Sequence[Law]
    sizes: tuple[float, ...]
    fault: Fault | None = None

    @property
    def priors(self) -> Array:
        """Standard deviations of the parameters: coefficients, fin, relative sizes."""
        fin = PRIOR if self.experiment.robot.fin else PRIOR[:6]
        return np.concatenate([fin, np.full(len(self.laws), 2.0)])

    def variant(self, parameters: Array) -> Variant:
        """Parameters as a variant; sizes are relative to their start."""
        finned = 8 if self.experiment.robot.fin else 6
        fin = parameters[6:finned] if finned == 8 else (0.0, 0.0)
        sizes = tuple(s * (1 + p) for s, p in zip(self.sizes, parameters[finned:], strict=True))
        return Variant(parameters[:6], float(fin[0]), float(fin[1]), sizes)

    def show(self, points: Sequence[Array]) -> Array:
        """Observations at parameters, (points, trials, n)."""
        seen = self.experiment.observe([self.variant(p) for p in points], self.laws, self.starts)
        return flat(self.fault(seen) if self.fault else seen)


@dataclass(frozen=True)
class Measured:
    """How much of a cause is left over: sigma, path error (m) and that over the floor."""

    sigma: float
    path_error: float
    ratio: float


def refit(model: Model, truth: Array, precision: Array) -> tuple[Array, Array, Array]:
    """Parameters, residual (trials, n) and Jacobian (trials, n, parameters) of the best fit.

    Damped Gauss-Newton with the precision of the scatter; truth: (trials, n).
    """
    priors = model.priors
    best, damping = np.zeros(len(priors)), 1e-3
    residual, slopes, cost = _linearised(model, best, truth, precision)
    for _ in range(ROUNDS):
        weighted = np.einsum("tni,tnm->tim", slopes, precision)
        normal = np.einsum("tim,tmj->ij", weighted, slopes) + np.diag(priors**-2.0)
        gradient = np.einsum("tim,tm->i", weighted, residual) - best / priors**2
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient)
        trial = best + np.clip(step, -0.7, 0.7)
        found = _linearised(model, trial, truth, precision)
        if not found[2] < cost:
            damping = max(30 * damping, 0.03)
            continue
        gained = cost - found[2]
        best, (residual, slopes, cost), damping = trial, found, damping / 10
        if gained < 0.01 * cost + 0.3:
            break
    return best, residual, slopes


def _linearised(
    model: Model, point: Array, truth: Array, precision: Array
) -> tuple[Array, Array, float]:
    points = [point, *(point + STEP * row for row in np.eye(len(point)))]
    shown = model.show(points)
    residual = truth - shown[0]
    slopes = np.moveaxis((shown[1:] - shown[0]) / STEP, 0, 2)
    cost = np.einsum("tn,tnm,tm->", residual, precision, residual)
    cost = float(cost + ((point / model.priors) ** 2).sum())
    return residual, slopes, cost if np.isfinite(cost) else np.inf


def measured(model: Model, truth: Array, scatter: Scatter, cause: str) -> Measured:
    """What `model`, which lacks `cause`, leaves over of a true observation (trials, n)."""
    if not np.isfinite(truth).all():
        return Measured(np.inf, np.inf, np.inf)
    with np.errstate(over="ignore", invalid="ignore"):
        point, residual, slopes = refit(model, truth, scatter.precision)
    path_error = scatter.path_error(residual)
    if not (np.isfinite(residual).all() and np.isfinite(slopes).all()):
        return Measured(np.inf, np.inf, np.inf)
    others, widths = _other_slopes(model, point, cause)
    every = np.concatenate([slopes, others], axis=2)
    priors = np.concatenate([model.priors, widths])
    weighted = np.einsum("tni,tnm->tim", every, scatter.precision)
    normal = np.einsum("tim,tmj->ij", weighted, every) + np.diag(priors**-2.0)
    gradient = np.einsum("tim,tm->i", weighted, residual)
    misfit = np.einsum("tn,tnm,tm->", residual, scatter.precision, residual)
    left = float(misfit - gradient @ np.linalg.solve(normal, gradient))
    return Measured(float(np.sqrt(max(left, 0))), path_error, path_error / scatter.floor)


def _other_slopes(model: Model, point: Array, cause: str) -> tuple[Array, Array]:
    """Effects of other causes (trials, n, others) and their prior widths, in units of the slope."""
    taken = {cause, *(law.family.name for law in model.laws)}
    rivals = [(n, form, width) for n, form, width in RIVALS if n not in taken]
    laws = [Law(FAMILIES[n], form, 0.0, shape) for n, form, _ in rivals for shape in _shapes(n)]
    widths = [width for n, _, width in rivals for _ in _shapes(n)]
    base = model.variant(point)
    zeros = (0.0,) * len(laws)
    variants = [Variant(base.coefficients, base.fin_area, base.fin_arm, base.sizes + zeros)]
    for k, width in enumerate(widths):
        extra = tuple(0.1 * width if i == k else 0.0 for i in range(len(laws)))
        variants.append(Variant(base.coefficients, base.fin_area, base.fin_arm, base.sizes + extra))
    shown = model.experiment.observe(variants, [*model.laws, *laws], model.starts)
    shown = model.fault(shown) if model.fault else shown
    slopes = list(flat(shown[1:] - shown[0]) / 0.1) + _of_measurement(shown[0], cause)
    ones = np.ones(len(slopes))
    return np.moveaxis(np.array(slopes), 0, 2), ones


def _shapes(name: str) -> tuple[float, ...]:
    return (0.0, 0.25) if name == "uniform_current" else (0.5,)


def _of_measurement(shown: Array, cause: str) -> list[Array]:
    """Effects of a scale and a clock error of prior size on an observation."""
    slopes = []
    if cause != "scale_error":
        scaled = shown - shown.mean(axis=(0, 1))
        scaled[..., 2] = 0
        slopes.append(flat(SCALE_PRIOR * scaled))
    if cause != "clock_error":
        parts = shown.reshape(len(shown), SEGMENTS, PER_SEGMENT, 3)
        steps = np.arange(1, PER_SEGMENT + 1)[None, None, :, None]
        late = CLOCK_PRIOR * steps * np.gradient(parts, axis=2)
        slopes.append(flat(late.reshape(shown.shape)))
    return slopes
