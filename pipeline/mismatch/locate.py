"""Where a model's missing force sits: along the paths, and in what it depends on.

The disturbing states of the filter around the fitted model, smoothed, are the force that the model
lacks, with its uncertainty. What it depends on is told by how well a smooth curve over a variable,
fitted to the other conditions, foretells it in a condition left out: correlated errors within a
trial cannot feign that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import Noise, Series, disturbance_slots, filter_all, smooth
from ..integrate import Kernel
from .judge import folds

DEGREE = 3
LEAST_SHARE = 0.05


@dataclass(frozen=True)
class MissingForce:
    """Smoothed missing force of one trial: force and std (n, channels), states (n, states)."""

    name: str
    times: Float
    force: Float
    std: Float
    states: Float


@dataclass(frozen=True)
class Dependence:
    """Share of all the missing force that a variable foretells in a channel, in conditions left
    out; channels are made comparable by what remains random in each.
    """

    channel: int
    variable: str
    share: float
    trials: tuple[str, ...]


def missing_force(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise
) -> list[MissingForce]:
    """`MissingForce` of every trial around a fitted model."""
    slots = disturbance_slots(kernel, acting=True)
    out = []
    for one, result in zip(series, filter_all(kernel, series, values, noise), strict=True):
        mean, cov = smooth(result)
        std = np.sqrt(np.maximum(np.einsum("nii->ni", cov[:, slots][:, :, slots]), 0.0))
        out.append(MissingForce(one.name, one.times, mean[:, slots], std, mean))
    return out


def dependences(
    series: Sequence[Series],
    forces: Sequence[MissingForce],
    variables: Sequence[Mapping[str, Float]],
    units: Float,
) -> list[Dependence]:
    """Dependences of every channel on every variable, the largest share first.

    variables: one mapping a trial, name -> (n,), as `forces` has frames. units (channels,): size
    of a force in each channel that means as much as in the others.
    """
    parts = folds(series)
    scaled = [f.force / units for f in forces]
    total = max(sum(float(np.sum(y**2)) for y in scaled), 1e-300)
    found = []
    for channel in range(len(units)):
        force = [y[:, channel] for y in scaled]
        for name in variables[0]:
            x = [v[name] for v in variables]
            gained = foretold(x, force, parts)
            order = [int(t) for t in np.argsort(-gained) if gained[t] > 0]
            trials = tuple(forces[t].name for t in order[: max(3, len(order) // 4)])
            found.append(Dependence(channel, name, max(0.0, float(gained.sum())) / total, trials))
    return sorted(found, key=lambda d: -d.share)


def foretold(x: Sequence[Float], y: Sequence[Float], parts: Sequence[np.ndarray]) -> Float:
    """Sum of squares of y that a smooth curve over x foretells across folds, (trials,)."""
    low, high = (float(f([f(v) for v in x])) for f in (np.min, np.max))
    scaled = [2 * (v - low) / max(high - low, 1e-12) - 1 for v in x]
    design = [np.polynomial.chebyshev.chebvander(v, DEGREE) for v in scaled]
    grams = [d.T @ d for d in design]
    moments = [d.T @ v for d, v in zip(design, y, strict=True)]
    gained = np.zeros(len(y))
    for part in parts:
        rest = [t for t in range(len(y)) if t not in set(part.tolist())]
        A = sum(grams[t] for t in rest) + 1e-6 * np.eye(DEGREE + 1)
        coefficients = np.linalg.solve(A, sum(moments[t] for t in rest))
        for t in part:
            error = y[t] - design[t] @ coefficients
            gained[t] = float(y[t] @ y[t] - error @ error)
    return gained
