"""Process noise by maximum posterior, outliers by deletion residuals from both sides in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from ..data import BoolNDArray, Float
from . import kalman_numba
from .likelihood_gradient import likelihood_gradient
from .linear_gaussian import LinearGaussianModel
from .motion_model import NoiseParametrisedModel
from .quasi_newton import minimise

GATE_TAIL_PROBABILITY = 1e-5
"""A right measurement is refused about so often."""


@dataclass(frozen=True)
class FittedMotionModel:
    """A model with its most likely noise; the measurements of the first round and those used last.

    logs: logarithms of the noise over its units. cost: -2 log posterior, outliers at the gate.
    noise_ratio: variance of the measurement noise found, white and coloured, over that stated.
    coloured: whether some of it is coloured.
    """

    model: LinearGaussianModel
    first: BoolNDArray
    used: BoolNDArray
    logs: Float
    cost: float
    noise_ratio: float
    coloured: bool = False

    @property
    def white_noise_logs(self) -> Float:
        """`logs` without those of coloured noise."""
        return np.concatenate([self.logs[:-3], self.logs[-1:]]) if self.coloured else self.logs


def fit_process_noise(
    model_of_noise: NoiseParametrisedModel,
    seen: BoolNDArray,
    *,
    first: BoolNDArray,
    spread: Float,
    starts: Sequence[Float],
    rounds: int = 4,
) -> FittedMotionModel:
    """Model whose noise has the greatest posterior, outliers rejected.

    -2 log p = -2 log L(z | noise) + sum (log noise / spread)^2; the prior is weak (a factor
    e^spread about the unit) and keeps a noise that the data do not show from running off to zero.
    A measurement is rejected if it lies beyond the gate of what all the others, before and after
    it, predict (deletion residual); those rejected are tried again in each round and count in the
    cost as lying on the gate.

    model_of_noise: the model for logarithms of the noise (m,). seen: (n,) measured at all; first:
    (n,) used in the first round. starts: logarithms to search from, the best end counts: motions
    disturbed in their rate and in their acceleration are separate minima.
    """
    used, places = first, starts
    gate = outlier_gate(model_of_noise.model_at_log_noise(starts[0]).z.shape[1])
    for turn in range(rounds):
        limit = gate if turn == 0 else np.inf
        ends = [
            _minimise_noise_cost(model_of_noise, used, limit, place, spread) for place in places
        ]
        logs = min(ends, key=lambda end: end[1])[0]
        places = [logs]
        model = model_of_noise.model_at_log_noise(logs)
        kept = seen & (
            _squared_deletion_residuals(model, _measurements_within_gate(model, used, limit))
            <= gate
        )
        if np.array_equal(kept, used):
            break
        used = kept if kept.sum() > 0.5 * seen.sum() else used
    model = model_of_noise.model_at_log_noise(logs)
    cost = _neg_two_log_posterior(model, seen, used, gate) + _neg_log_noise_prior(logs, spread)
    return FittedMotionModel(model, first, used, logs, cost, float(np.exp(logs[-1])))


def outlier_gate(size: int) -> float:
    """Squared normalised distance beyond which a measurement of `size` numbers is refused."""
    return float(chdtri(size, GATE_TAIL_PROBABILITY))


def _neg_log_noise_prior(logs: Float, spread: Float) -> float:
    return float(np.sum((logs / spread) ** 2))


def _neg_two_log_posterior(
    model: LinearGaussianModel, seen: BoolNDArray, used: BoolNDArray, gate: float
) -> float:
    """Minus twice the log likelihood, rejected measurements as if they lay on the gate."""
    rejected = model.R[seen & ~used]
    return kalman_numba.minus_two_log_likelihood(model, used, np.inf) + float(
        np.sum(gate + np.linalg.slogdet(2 * np.pi * rejected)[1])
    )


def _measurements_within_gate(
    model: LinearGaussianModel, used: BoolNDArray, gate: float
) -> BoolNDArray:
    if not np.isfinite(gate):
        return used
    squares = kalman_numba.normalised_innovations_squared(model, used, gate)
    return used & ~(squares > gate)


def _minimise_noise_cost(
    model_of_noise: NoiseParametrisedModel,
    used: BoolNDArray,
    gate: float,
    start: Float,
    spread: Float,
) -> tuple[Float, float]:
    """Logarithms of least cost, and the cost, outliers counted as lying on the gate."""

    def cost(at: Float) -> tuple[float, Callable[[], Float]]:
        model = model_of_noise.model_at_log_noise(at)
        forward = kalman_numba.filter_pass(model, used, gate)

        def gradient() -> Float:
            by_matrices = likelihood_gradient(model, used, gate, forward)
            return model_of_noise.gradient(at, by_matrices) + 2 * at / spread**2

        if not np.isfinite(forward.cost):
            return 1e12, lambda: np.zeros(len(at))
        return forward.cost + _neg_log_noise_prior(at, spread), gradient

    return minimise(cost, start)


def _squared_deletion_residuals(model: LinearGaussianModel, used: BoolNDArray) -> Float:
    """Squared normalised distance of each measurement from what all the others say, (n,).

    With e = z - H x, and V = R - H P H' where the measurement was used, R + H P H' where not, the
    form e' V^-1 e is the deletion residual's; NaN measurements give 0.
    """
    state = kalman_numba.compiled_filter_and_smooth(model, used)
    error = np.nan_to_num(model.z - np.einsum("npd,nd->np", model.H, state.x))
    seen = np.einsum("npd,nde,nqe->npq", model.H, state.P, model.H)
    V = model.R + np.where(used, -1.0, 1.0)[:, None, None] * seen
    return np.einsum("np,np->n", error, np.linalg.solve(V, error[..., None])[..., 0])
