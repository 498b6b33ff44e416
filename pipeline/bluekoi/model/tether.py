"""Pull and torsion of a cable: residual terms of place and heading, from the start of the trial.

A cable pulls the robot towards a point at the distance d from it with the force

    F = k max(0, d - s),

where s is the slack of the cable and k its stiffness. The point is one of the pool, at the shares a
of its length and b of its width, or the place at which the trial began. A cable that the robot
twists acts with the moment N = -k (psi - psi0), where psi0 is the heading at the start.

Source: a linear spring and a linear torsion spring.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ..integrate import Effect, Parameter

EFFECT_KIND = "residual"
SurgeSwayYaw = tuple[float, float, float]
TRIED_POINTS = ((0.0, 0.0), (0.0, 0.5), (0.0, 1.0), (0.5, 0.0), (0.5, 1.0), (1.0, 0.0), (1.0, 0.5),
                (1.0, 1.0))  # fmt: skip
"""Corners of the pool and middles of its walls, besides the middle of the pool."""
ROUNDING_SHARE = 1e-3
"""Distance over which the force bends where the cable becomes taut, over the unit of length of the
robot: 1 mm for the published one."""
STIFFNESS = Parameter("stiffness", "N/m", 0.01, -50.0, 50.0, "force a metre of stretch", symbol="k")
TORSION_STIFFNESS = Parameter("stiffness", "N m", 0.001, -50.0, 50.0, "moment a radian of turn",
                              symbol="k")  # fmt: skip
SLACK = Parameter("slack", "m", 0.0, 0.0, 2.0, "length of the cable that is not stretched",
                  symbol="s")  # fmt: skip
POINT = (
    Parameter("length_share", "1", 0.5, 0.0, 1.0, "x of the point, over the length of the pool",
              tries=tuple(a for a, _ in TRIED_POINTS), symbol="a"),
    Parameter("width_share", "1", 0.5, 0.0, 1.0, "y of the point, over the width of the pool",
              tries=tuple(b for _, b in TRIED_POINTS), symbol="b"),
)  # fmt: skip


def pull_towards(
    dx: float, dy: float, cpsi: float, spsi: float, length_unit: float, k: float, s: float
) -> SurgeSwayYaw:
    """Surge and sway force (N) of a cable to a point (dx, dy) away in pool coordinates (m)."""
    rounding = ROUNDING_SHARE * length_unit
    distance = math.sqrt(dx * dx + dy * dy + rounding * rounding)
    stretch = 0.5 * (
        distance - s + math.sqrt((distance - s) * (distance - s) + rounding * rounding)
    )
    x, y = k * stretch * dx / distance, k * stretch * dy / distance
    return x * cpsi + y * spsi, y * cpsi - x * spsi, 0.0


def pull_to_pool_point(
    x: float, y: float, cpsi: float, spsi: float, L_pool: float, W_pool: float,
    length_unit: float, k: float, s: float, a: float, b: float,
) -> SurgeSwayYaw:  # fmt: skip
    """Surge and sway force (N)."""
    return pull_towards(a * L_pool - x, b * W_pool - y, cpsi, spsi, length_unit, k, s)


def pull_to_start(
    x: float, y: float, x0: float, y0: float, cpsi: float, spsi: float, length_unit: float,
    k: float, s: float,
) -> SurgeSwayYaw:  # fmt: skip
    """Surge and sway force (N)."""
    return pull_towards(x0 - x, y0 - y, cpsi, spsi, length_unit, k, s)


def torsion_since_start(psi: float, psi0: float, k: float) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, -k * (psi - psi0)


def _residual_effect(
    force: Callable[..., SurgeSwayYaw], statement: str, parameters: tuple[Parameter, ...],
    *, channels: tuple[str, ...], variable: str,
) -> Effect:  # fmt: skip
    return Effect(
        name=force.__name__,
        kind=EFFECT_KIND,
        statement=statement,
        parameters=parameters,
        hooks={"force": force},
        module=__name__,
        channels=channels,
        variables=(variable,),
    )


RESIDUAL_FORCE_EFFECTS = (
    _residual_effect(pull_to_pool_point, "A force pulls the robot towards one place of the pool.",
                     (STIFFNESS, SLACK, *POINT), channels=("surge", "sway"), variable="place"),
    _residual_effect(pull_to_start, "A force pulls the robot back to where the trial began.",
                     (STIFFNESS, SLACK), channels=("surge", "sway"),
                     variable="distance from the start"),
    _residual_effect(torsion_since_start, "A moment turns the robot back to its first heading.",
                     (TORSION_STIFFNESS,), channels=("yaw",), variable="angle turned"),
)  # fmt: skip
"""Residual terms of a cable."""
