"""BFGS minimisation of a smooth cost over a few parameters, which are logarithms.

A search stops if the next step promises a small gain; no step is longer than a factor e^2. Compared
with scipy's BFGS in decision 075.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..data import Float

CostWithGradientFunction = Callable[[Float], tuple[float, Callable[[], Float]]]
"""Value at a point, and a function that computes the gradient there, which a line search needs only
at the point that it accepts."""
MAX_STEP = 2.0
MIN_RESTART_GAIN = 1.0
"""A search is begun again at its end, without what it has learned of the curvature, until that
lowers the cost (twice a log likelihood) by less: a poor estimate of the curvature ends it early."""


def minimise(
    cost: CostWithGradientFunction, start: Float, *, enough: float = 0.2, steps: int = 16
) -> tuple[Float, float]:
    """Point and value of a minimum of `cost` by BFGS.

    Ends where the next step promises less than `enough`, or after `steps`, and begins again there.
    """
    found = _minimise_once(cost, start, enough, steps)
    again = _minimise_once(cost, found[0], enough, steps)
    while again[1] < found[1] - MIN_RESTART_GAIN:
        found, again = again, _minimise_once(cost, again[0], enough, steps)
    return min(found, again, key=lambda end: end[1])


def _minimise_once(
    cost: CostWithGradientFunction, start: Float, enough: float, steps: int
) -> tuple[Float, float]:
    """Point and value where BFGS ends. Source: Nocedal, Wright, Numerical Optimization, 2006,
    algorithm 6.1, backtracking line search 3.1.
    """
    at = start
    value, gradient = cost(at)
    slope = gradient()
    inverse = np.eye(len(at)) / max(float(np.abs(slope).max()), 1.0)
    for _ in range(steps):
        direction = -(inverse @ slope)
        direction *= min(1.0, MAX_STEP / max(float(np.abs(direction).max()), 1e-12))
        predicted_decrease = -float(slope @ direction)
        if predicted_decrease < enough:
            break
        found = _backtracking_line_search(cost, at, direction, (value, predicted_decrease))
        if found is None:
            break
        there, lower, gradient = found
        new_slope = gradient()
        inverse = _bfgs_update(inverse, there - at, new_slope - slope)
        at, value, slope = there, lower, new_slope
    return at, value


def _backtracking_line_search(
    cost: CostWithGradientFunction, at: Float, direction: Float, known: tuple[float, float]
) -> tuple[Float, float, Callable[[], Float]] | None:
    """Point, cost and gradient of the first step that lowers the cost by enough; otherwise None."""
    value, predicted_decrease = known
    step_length = 1.0
    while step_length > 0.02:
        there = at + step_length * direction
        lower, gradient = cost(there)
        if lower < value - 1e-3 * step_length * predicted_decrease:
            return there, lower, gradient
        step_length *= 0.4
    return None


def _bfgs_update(inverse: Float, moved: Float, change: Float) -> Float:
    """Inverse Hessian after a step, BFGS; left as it is where the cost does not curve upwards."""
    curve = float(moved @ change)
    if curve <= 1e-9:
        return inverse
    turn = np.eye(len(moved)) - np.outer(moved, change) / curve
    return np.asarray(turn @ inverse @ turn.T + np.outer(moved, moved) / curve)
