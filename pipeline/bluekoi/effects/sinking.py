"""A robot that sinks during the trial.

A sinking robot moves away from the camera, so that its image shrinks towards the point c below the
camera. The trim of the robot also changes with the depth, which causes an additional drag D. A
point at the position `true` is measured at the position `seen`:

    seen = c + (1 - g s(t)) (true - c),    D = -1/2 rho A c_g g s(t) V^2 v_hat
    s(t) = t ((1 - w) + w t / t_1) (1 - exp(-b t)) / (b t),  t since the start, t_1 = 4 s

- g: rate at which the image shrinks (1/s), so that g s(t) is the relative shrinking;
- c_g: growth of the drag coefficient over the relative shrinking of the image;
- rho: density of the water; A: area of the head plate; V, v_hat: speed and direction of motion;
- s(t): form of the sinking over time (s). At a constant rate of sinking, s(t) = t. This is the case
  if w = 0 and b t is much smaller than 1;
- w: weight of a term proportional to t^2 (accelerated sinking);
- b: rate at which the robot approaches a constant depth (1/s).

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
              "rate at which the image shrinks towards the point below the camera", symbol="g"),
    Parameter("drag_growth_ratio", "1", 10.0, 0.0, 60.0,
              "growth of the drag coefficient over the shrinking of the image", spread=15.0,
              symbol="c_g"),
    Parameter("quadratic_share", "1", 0.0, 0.0, 1.0, "weight of a term proportional to t^2",
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
