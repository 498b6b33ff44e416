"""A robot that sinks during the trial.

A sinking robot moves away from the camera. Its image shrinks towards the point c below the camera:
a point at the position `true` is measured at the position `seen`. The trim of the robot also
changes with the depth, so that an additional drag D acts:

    seen = c + (1 - g s(t)) (true - c),    D = -1/2 rho A c_g g s(t) V^2 v_hat
    s(t) = t ((1 - w) + w t / t_1) (1 - exp(-b t)) / (b t),  t since the start, t_1 = 4 s

g is the rate at which the image shrinks, V the speed and v_hat the direction of motion. The drag
coefficient grows by c_g times the relative shrinking g s(t) of the image.

s(t) describes how the depth changes with time. If w = 0 and b t is much smaller than 1, the robot
sinks at a constant rate: s(t) = t. w is the weight of a term proportional to t^2 (accelerated
sinking). b (1/s) is the rate at which the robot approaches a constant depth.

Source: own statement (the paper reports slight sinking, sec. III-A).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("time",)
EFFECT_DESCRIPTION = (
    "The robot sinks during the trial: its image shrinks towards the point below the camera, and "
    "its drag changes."
)
MOST_VISIBLE_WHERE = "the late part of long trials"
CONFUSED_WITH = ("battery_sag", "wake_reentry")
EFFECT_PARAMETERS = (
    Parameter("shrink_rate", "1/s", 0.002, 0.0, 0.05,
              "rate at which its image approaches the point below the camera", symbol="g"),
    Parameter("drag_growth_ratio", "1", 10.0, 0.0, 60.0,
              "growth of the drag coefficient over the shrinking of the image", spread=15.0,
              symbol="c_g"),
    Parameter("quadratic_share", "1", 0.0, 0.0, 1.0, "part that grows as time squared",
              spread=0.5, symbol="w"),
    Parameter("settling_rate", "1/s", 0.002, 1e-4, 1.0, "rate at which the depth settles",
              spread=0.3, symbol="b"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "steady": {},
    "accelerated": {"quadratic_share": 1.0},
    "settling": {"settling_rate": 0.25},
}


def effective_sinking_time_s(t: float, time_unit: float, w: float, b: float) -> float:
    """s(t) of the equations above (s)."""
    return (1.0 + w * (0.25 * t / time_unit - 1.0)) * (1.0 - exponential(-b * t)) / b


def force(
    rho: float, A: float, t: float, time_unit: float, uc: float, vc: float, V: float, g: float,
    c_g: float, w: float, b: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N)."""
    s = -0.5 * rho * A * c_g * g * effective_sinking_time_s(t, time_unit, w, b) * V
    return s * uc, s * vc, 0.0


def observe(
    t: float,
    time_unit: float,
    x: float,
    y: float,
    x_cam: float,
    y_cam: float,
    g: float,
    w: float,
    b: float,
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    s = -g * effective_sinking_time_s(t, time_unit, w, b)
    return s * (x - x_cam), s * (y - y_cam), 0.0, 0.0
