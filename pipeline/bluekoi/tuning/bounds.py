"""Numbers that a fit leaves at a bound: which, and how far from it they may still lie.

A number at its bound has no deviation of its own. Its interval is one-sided: from the bound to
where the interval would end if nothing were bounded.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..fitting import ParameterFit, newton_step_ignoring_bounds
from ..integrate.system import Parameter

LOWER, UPPER = "lower", "upper"


def bound_sides(found: ParameterFit) -> list[str]:
    """For each fitted number `lower`, `upper`, or nothing where it is off its bounds."""
    return [
        _bound_side_of_value(p, v) for p, v in zip(found.definitions, found.values, strict=True)
    ]


def _bound_side_of_value(parameter: Parameter, value: float) -> str:
    if value <= parameter.lower:
        return LOWER
    return UPPER if value >= parameter.upper else ""


def intervals_at_bounds(found: ParameterFit) -> dict[int, Float]:
    """Number -> its 95 % interval (2,), for those at a bound, the bound at one end.

    The other end is the bound on the other side where the trials say nothing; NaN at both ends
    where the data ask for values beyond the bound alone.
    """
    held = {i: side for i, side in enumerate(bound_sides(found)) if side}
    if not held:
        return {}
    change, spread = newton_step_ignoring_bounds(found.normal)
    middle, half = found.values + change, spread.half_widths()
    return {
        i: _clip_interval_to_bounds(
            found.definitions[i], side, np.array([-half[i], half[i]]) + middle[i]
        )
        for i, side in held.items()
    }


def _clip_interval_to_bounds(parameter: Parameter, side: str, wanted: Float) -> Float:
    """What of an interval lies inside the bounds, the number's own bound always in it."""
    if side == LOWER:
        ends = np.array([parameter.lower, min(wanted[1], parameter.upper)])
    else:
        ends = np.array([max(wanted[0], parameter.lower), parameter.upper])
    return ends if ends[0] < ends[1] else np.full(2, np.nan)
