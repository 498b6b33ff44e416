"""Random current: water that moves and carries the robot.

Each component of the velocity w of the water, in the axes of the pool, is a first-order
Gauss-Markov process:

    dw/dt = -w / tau + white noise

All forces depend on the velocity of the robot relative to the water. The current is the same all
along the robot. It differs from a random force on the hull: a current that changes slowly carries
the robot along and hardly turns it.

Present in the filters of the search for causes (its strength is estimated), absent from
simulations. Source: Fossen (2011), sec. 8.3 (current as a Gauss-Markov process).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "disturbance"
EFFECT_DESCRIPTION = "The water moves at random and carries the robot along."
EFFECT_PARAMETERS = (
    Parameter("present", "1", 1.0, 0.0, 1.0, "1 where the water moves"),
    Parameter("tau", "s", 1.0, 0.05, 5.0, "correlation time of the current"),
)
EFFECT_STATE_NAMES = ("w_x", "w_y")


def ambient_flow(w_x: float, w_y: float) -> tuple[float, float, float, float]:
    """Velocity of the water in the pool frame (m/s); its turning (rad/s) is left out."""
    return w_x, w_y, 0.0, 0.0


def effect_state_derivatives(w_x: float, w_y: float, tau: float) -> tuple[float, float]:
    """Derivatives of both components (m/s2)."""
    return -w_x / tau, -w_y / tau
