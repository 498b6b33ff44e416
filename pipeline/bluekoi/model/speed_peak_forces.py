"""Forces that rise or fall about one speed: residual terms with a speed and a width of their own.

    surge  dX = -h (1/2 rho A) V u R      sway  dY = h R      yaw  dN = h R,
    R = 1 / (1 + ((V - c) / w)^2)^2

as where waves of the robot and of the pool's walls meet, or where the flow separates on one side.
Source: own statement.
"""

from __future__ import annotations

from collections.abc import Callable

from ..integrate import Effect, Parameter

EFFECT_KIND = "residual"
ASYMMETRIC_SPEED_VARIABLE_LABEL = "speed, to one side"
"""Variable of side forces and moments: no mirror-symmetric law leaves them as its remainder."""
SurgeSwayYaw = tuple[float, float, float]
TRIED_SPEEDS_M_S = (0.15, 0.2, 0.26, 0.42, 0.53)
TRIED_WIDTH_M_S = 0.05
"""Other speeds are tried with this width: tries of several shapes go together, one by one."""
SHAPE_PARAMETERS = (
    Parameter("centre_speed", "m/s", 0.33, 0.05, 1.0, "speed of the largest change",
              tries=TRIED_SPEEDS_M_S, symbol="c"),
    Parameter("width", "m/s", 0.07, 0.03, 0.25, "width in speed",
              tries=(TRIED_WIDTH_M_S,) * len(TRIED_SPEEDS_M_S), symbol="w"),
)  # fmt: skip
STRENGTH_PARAMETERS = {
    "surge": Parameter("added_drag", "1", 0.1, -5.0, 5.0,
                       "drag coefficient added at that speed, of the head plate", symbol="h"),
    "sway": Parameter("force", "N", 0.01, -1.0, 1.0, "force at that speed", symbol="h"),
    "yaw": Parameter("moment", "N m", 0.001, -1.0, 1.0, "moment at that speed", symbol="h"),
}  # fmt: skip


def peak_about_speed(V: float, c: float, w: float) -> float:
    """R of the equation above."""
    q = (V - c) / w
    e = 1.0 + q * q
    return 1.0 / (e * e)


def surge_near_speed(
    rho: float, A: float, uc: float, V: float, h: float, c: float, w: float
) -> SurgeSwayYaw:
    """Surge force (N)."""
    return -h * 0.5 * rho * A * V * uc * peak_about_speed(V, c, w), 0.0, 0.0


def sway_near_speed(V: float, h: float, c: float, w: float) -> SurgeSwayYaw:
    """Sway force (N)."""
    return 0.0, h * peak_about_speed(V, c, w), 0.0


def yaw_near_speed(V: float, h: float, c: float, w: float) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, h * peak_about_speed(V, c, w)


def _residual_effect(force: Callable[..., SurgeSwayYaw]) -> Effect:
    channel = force.__name__.split("_", maxsplit=1)[0]
    return Effect(
        name=force.__name__,
        kind=EFFECT_KIND,
        statement=f"A {channel} force rises or falls about one speed.",
        parameters=(STRENGTH_PARAMETERS[channel], *SHAPE_PARAMETERS),
        hooks={"force": force},
        module=__name__,
        channels=(channel,),
        variables=("speed",) if channel == "surge" else (ASYMMETRIC_SPEED_VARIABLE_LABEL,),
    )


RESIDUAL_FORCE_EFFECTS = tuple(
    _residual_effect(force) for force in (surge_near_speed, sway_near_speed, yaw_near_speed)
)
"""Residual terms about one speed, one for each channel."""
