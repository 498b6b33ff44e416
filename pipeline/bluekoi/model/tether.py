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
POOL_CENTRE_FRACTIONS = (0.5, 0.5)
WALL_ANCHOR_POINT_FRACTIONS = tuple(
    (a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 0.5, 1.0) if (a, b) != POOL_CENTRE_FRACTIONS
)
TRIED_SLACK_OVER_POOL_LENGTH = 0.25
"""Slack that is tried besides none, over the length of the pool: a start of fits, without a part in
the evidence."""
TRIED_ANCHOR_POINTS_AND_SLACKS = (
    *((*point, 0.0) for point in WALL_ANCHOR_POINT_FRACTIONS),
    *(
        (*point, TRIED_SLACK_OVER_POOL_LENGTH)
        for point in (POOL_CENTRE_FRACTIONS, *WALL_ANCHOR_POINT_FRACTIONS)
    ),
)
"""Points and slacks that are tried, besides the middle of the pool without slack."""
CABLE_SMOOTHING_LENGTH_RATIO = 1e-3
"""e above, over the unit of length of the robot: 1 mm for the published one."""
CABLE_STIFFNESS_PARAMETER = Parameter(
    "stiffness", "N/m", 0.01, -50.0, 50.0, "force per metre of extension", symbol="k"
)
CABLE_TORSION_STIFFNESS_PARAMETER = Parameter(
    "stiffness", "N m", 0.001, -50.0, 50.0, "moment per radian", symbol="k"
)


def _cable_slack_parameter(tries: tuple[float, ...]) -> Parameter:
    return Parameter("slack", "1", 0.0, 0.0, 1.0, "slack of the cable, over the pool's length",
                     tries=tries, symbol="s")  # fmt: skip


ANCHOR_POINT_PARAMETERS = (
    Parameter("length_share", "1", POOL_CENTRE_FRACTIONS[0], 0.0, 1.0,
              "x of the point, over the pool's length", symbol="a",
              tries=tuple(a for a, _, _ in TRIED_ANCHOR_POINTS_AND_SLACKS)),
    Parameter("width_share", "1", POOL_CENTRE_FRACTIONS[1], 0.0, 1.0,
              "y of the point, over the pool's width", symbol="b",
              tries=tuple(b for _, b, _ in TRIED_ANCHOR_POINTS_AND_SLACKS)),
)  # fmt: skip


def cable_force_towards_point(
    dx: float, dy: float, cpsi: float, spsi: float, length_unit: float, k: float, s: float
) -> SurgeSwayYaw:
    """Surge and sway force (N) of a cable to a point (dx, dy) away in pool coordinates (m)."""
    rounding = CABLE_SMOOTHING_LENGTH_RATIO * length_unit
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
    return cable_force_towards_point(dx, dy, cpsi, spsi, length_unit, k, s * L_pool)


def pull_to_start(
    x: float, y: float, x0: float, y0: float, cpsi: float, spsi: float, L_pool: float,
    length_unit: float, k: float, s: float,
) -> SurgeSwayYaw:  # fmt: skip
    """Surge and sway force (N)."""
    return cable_force_towards_point(x0 - x, y0 - y, cpsi, spsi, length_unit, k, s * L_pool)


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
    _residual_effect(
        pull_to_pool_point,
        "A force acts towards a point in the pool, or away from it.",
        (
            CABLE_STIFFNESS_PARAMETER,
            _cable_slack_parameter(tuple(s for _, _, s in TRIED_ANCHOR_POINTS_AND_SLACKS)),
            *ANCHOR_POINT_PARAMETERS,
        ),
        channels=("surge", "sway"),
        variable="distance from a point",
    ),
    _residual_effect(
        pull_to_start,
        "A force acts towards the start of the trial, or away from it.",
        (CABLE_STIFFNESS_PARAMETER, _cable_slack_parameter((TRIED_SLACK_OVER_POOL_LENGTH,))),
        channels=("surge", "sway"),
        variable="distance from the start",
    ),
    _residual_effect(
        torsion_since_start,
        "A moment acts in proportion to the angle turned.",
        (CABLE_TORSION_STIFFNESS_PARAMETER,),
        channels=("yaw",),
        variable="angle turned",
    ),
)
"""Residual terms of a cable."""
