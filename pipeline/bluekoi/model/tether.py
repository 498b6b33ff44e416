"""Pull and torsion of a cable: residual terms of the position and the heading.

A cable pulls the robot towards a point at the distance d from it with the force

    F = k max(0, d - s),

where s is the slack of the cable and k its stiffness. The point is (a L, b W), with the length L
and the width W of the pool, or the position at the start of the trial. The force acts at the centre
of mass. A cable that the robot twists acts with the moment N = -k (psi - psi0), where psi0 is the
heading at the start. With a negative k, the robot is pushed away from the point or turned further.

The maximum is rounded to ((d - s) + ((d - s)^2 + e^2)^(1/2)) / 2, and e^2 is added to d^2: at the
taut point and at d = 0, the force would have no derivative with respect to the position.

Source: Hooke's law for extension and torsion.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ..integrate import Effect, Parameter

EFFECT_KIND = "residual"
SurgeSwayYaw = tuple[float, float, float]
MIDDLE = (0.5, 0.5)
POINTS_AT_THE_WALLS = ((0.0, 0.0), (0.0, 0.5), (0.0, 1.0), (0.5, 0.0), (0.5, 1.0), (1.0, 0.0),
                       (1.0, 0.5), (1.0, 1.0))  # fmt: skip
"""Corners of the pool and middles of its walls, in its length and width."""
TRIED_SLACK = 0.25
"""Slack that is tried besides none, over the length of the pool: a start of fits, without a part in
the evidence."""
TRIES = (*((*point, 0.0) for point in POINTS_AT_THE_WALLS),
         *((*point, TRIED_SLACK) for point in (MIDDLE, *POINTS_AT_THE_WALLS)))  # fmt: skip
"""Points and slacks that are tried, besides the middle of the pool without slack."""
ROUNDING_SHARE = 1e-3
"""e above, over the unit of length of the robot: 1 mm for the published one."""
STIFFNESS = Parameter("stiffness", "N/m", 0.01, -50.0, 50.0, "force per metre of extension",
                      symbol="k")  # fmt: skip
TORSION_STIFFNESS = Parameter("stiffness", "N m", 0.001, -50.0, 50.0, "moment per radian",
                              symbol="k")  # fmt: skip


def _slack(tries: tuple[float, ...]) -> Parameter:
    return Parameter("slack", "1", 0.0, 0.0, 1.0, "slack of the cable, over the pool's length",
                     tries=tries, symbol="s")  # fmt: skip


POINT = (
    Parameter("length_share", "1", MIDDLE[0], 0.0, 1.0, "x of the point, over the pool's length",
              tries=tuple(a for a, _, _ in TRIES), symbol="a"),
    Parameter("width_share", "1", MIDDLE[1], 0.0, 1.0, "y of the point, over the pool's width",
              tries=tuple(b for _, b, _ in TRIES), symbol="b"),
)  # fmt: skip


def pull_towards(
    dx: float, dy: float, cpsi: float, spsi: float, length_unit: float, k: float, s: float
) -> SurgeSwayYaw:
    """Surge and sway force (N) of a cable to a point (dx, dy) away in pool coordinates (m)."""
    rounding = ROUNDING_SHARE * length_unit
    distance = math.sqrt(dx * dx + dy * dy + rounding * rounding)
    extension = 0.5 * (
        distance - s + math.sqrt((distance - s) * (distance - s) + rounding * rounding)
    )
    x, y = k * extension * dx / distance, k * extension * dy / distance
    return x * cpsi + y * spsi, y * cpsi - x * spsi, 0.0


def pull_to_pool_point(
    x: float, y: float, cpsi: float, spsi: float, L_pool: float, W_pool: float,
    length_unit: float, k: float, s: float, a: float, b: float,
) -> SurgeSwayYaw:  # fmt: skip
    """Surge and sway force (N)."""
    dx, dy = a * L_pool - x, b * W_pool - y
    return pull_towards(dx, dy, cpsi, spsi, length_unit, k, s * L_pool)


def pull_to_start(
    x: float, y: float, x0: float, y0: float, cpsi: float, spsi: float, L_pool: float,
    length_unit: float, k: float, s: float,
) -> SurgeSwayYaw:  # fmt: skip
    """Surge and sway force (N)."""
    return pull_towards(x0 - x, y0 - y, cpsi, spsi, length_unit, k, s * L_pool)


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
    _residual_effect(pull_to_pool_point,
                     "A force acts towards a point in the pool, or away from it.",
                     (STIFFNESS, _slack(tuple(s for _, _, s in TRIES)), *POINT),
                     channels=("surge", "sway"), variable="distance from a point"),
    _residual_effect(pull_to_start, "A force acts towards the start of the trial, or away from it.",
                     (STIFFNESS, _slack((TRIED_SLACK,))), channels=("surge", "sway"),
                     variable="distance from the start"),
    _residual_effect(torsion_since_start, "A moment acts in proportion to the angle turned.",
                     (TORSION_STIFFNESS,), channels=("yaw",), variable="angle turned"),
)  # fmt: skip
"""Residual terms of a cable."""
