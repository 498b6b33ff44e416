"""Uniform current in the pool.

At the time t since the start of a trial, the water has the velocity w, in the axes of the pool:

    w = (c_x (1 + a eta), c_y (1 + a xi)) (1 + b (t - 3 s) / 3 s)
    xi = 2 x / L - 1,  eta = 2 y / W - 1

- x, y: position in the pool; L, W: length and width of the pool (m). xi and eta grow from -1 at one
  wall to 1 at the opposite wall;
- c_x, c_y: current in the middle of the pool at t = 3 s (m/s);
- a: shear, the relative change of the current across its direction, from the middle to a wall. With
  a = 0, the current is uniform;
- b: relative change of the current from 3 s to 6 s after the start of a trial.

All forces depend on the velocity of the robot relative to the water.

Source: Fossen (2011), sec. 8.3 (relative velocity in an irrotational current).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("current",)
EFFECT_DESCRIPTION = (
    "The water moves with the same velocity everywhere and carries the robot along: circles drift."
)
MOST_VISIBLE_WHERE = "all trials, in a fixed direction of the pool"
CONFUSED_WITH = ("pool_gyre", "keypoint_bias", "trim_moment")
STRENGTH_PARAMETER_COUNT = 2
EFFECT_PARAMETERS = (
    Parameter("c_x", "m/s", 0.005, -0.3, 0.3, "current along the pool's x"),
    Parameter("c_y", "m/s", 0.005, -0.3, 0.3, "current along the pool's y"),
    Parameter("shear", "1", 0.0, -1.0, 1.0,
              "relative change of the current from the middle to a wall", spread=0.5, symbol="a"),
    Parameter("growth", "1", 0.0, -1.0, 1.0, "relative change of the current in 3 s",
              spread=0.3, symbol="b"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "constant": {},
    "sheared": {"shear": 1.0},
    "drifting": {"growth": 0.5},
}


def ambient_flow(
    t: float, x: float, y: float, L_pool: float, W_pool: float, time_unit: float,
    c_x: float, c_y: float, a: float, b: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Velocity of the water in the pool frame (m/s); its turning (rad/s) is left out."""
    now = 1.0 + b * (t / time_unit - 3.0) / 3.0
    xi, eta = 2.0 * x / L_pool - 1.0, 2.0 * y / W_pool - 1.0
    return now * c_x * (1.0 + a * eta), now * c_y * (1.0 + a * xi), 0.0, 0.0
