"""Straight swimming at constant thrust: u' = a (V_0^2 - u^2), each command with a speed of its own.

State: x, y [m] of the light (x along the tank, y from the edge y = 0), course psi [rad], speed u
[m/s]. The course wanders at random; what is asked is what the speed depends on.
"""

from __future__ import annotations

import math

from bluekoi.integrate import Parameter, Stage, System
from bluekoi.integrate.branchless import sin_cos

from ..effect import effect
from ..randomness import lasting_errors, pushes

Two = tuple[float, float]
COEFFICIENTS = (
    Parameter("V_0", "m/s", 0.3, 0.02, 1.5, "speed far from the edges, of each command"),
    Parameter("a", "1/m", 2.0, 0.2, 20.0, "drag over mass: 1 / (a V_0) is the time to speed"),
)


def effort(V_0: float, a: float, u: float) -> Two:
    """Acceleration (m/s2) and turning of the course (rad/s)."""
    return a * (V_0 * V_0 - u * u), 0.0


def motion(psi: float, u: float, X: float, w: float) -> tuple[float, float, float, float]:
    """Derivatives of x, y, psi, u."""
    s, c = sin_cos(psi)
    return u * c, u * s, w, X


def seen(x: float, y: float) -> Two:
    """The light as the camera gives it (m)."""
    return x, y


def near_edge(y: float, u: float, a: float, k: float, d: float) -> Two:
    """X = -k a u^2 exp(-y / d): the tank's edge at y = 0 holds water and robot back."""
    return -k * a * u * u * math.exp(-max(y, 0.0) / d), 0.0


def far_edge(y: float, W: float, u: float, a: float, k: float) -> Two:
    """X = -k a u^2 exp(-(W - y) / 0.1 m): so at the far edge."""
    return -k * a * u * u * math.exp(-max(W - y, 0.0) / 0.1), 0.0


def sagging(t: float, u: float, a: float, k: float) -> Two:
    """X = -k a u^2 t: the batteries give out."""
    return -k * a * u * u * t, 0.0


def end_wall(x: float, L: float, u: float, a: float, k: float) -> Two:
    """X = -k a u^2 (exp(-x / 0.3 m) + exp(-(L - x) / 0.3 m)): the tank's ends."""
    near = math.exp(-max(x, 0.0) / 0.3) + math.exp(-max(L - x, 0.0) / 0.3)
    return -k * a * u * u * near, 0.0


def edge_scale(x: float, y: float, L: float, k: float) -> Two:
    """Lengths along the edge y = 0 are seen (1 - k exp(-y / 0.1 m)) as long as they are."""
    return -k * (x - 0.5 * L) * math.exp(-max(y, 0.0) / 0.1), 0.0


def barrel(x: float, L: float, k: float) -> Two:
    """The lens shows the tank's ends shorter: x - k m z^3, z = (x - m) / m, m = L / 2."""
    m = 0.5 * L
    z = (x - m) / m
    return -k * m * z * z * z, 0.0


EFFECTS = (
    pushes("The course wanders.", "effort", ("surge", "yaw"), (1.0, 0.1, 20.0)),
    lasting_errors(
        "The light swings with the body and is not always found.", 2, (0.3, 0.05, 2.0)),
    effect("wall_effect", "Close to the tank's edge the robot is slowed.", {"effort": near_edge},
           (("k", "1", 0.5, 0.0, 20.0, "share of drag added at the edge"),
            ("d", "m", 0.1, 0.02, 0.5, "reach")), channels=("surge",)),
    effect("far_wall", "Close to the far edge the robot is slowed.", {"effort": far_edge},
           (("k", "1", 0.5, 0.0, 20.0, "share of drag added at the edge"),), channels=("surge",)),
    effect("end_walls", "Close to the tank's ends the robot is slowed.", {"effort": end_wall},
           (("k", "1", 0.5, 0.0, 20.0, "share of drag added at an end"),), channels=("surge",)),
    effect("battery_sag", "The batteries give out during a run.", {"effort": sagging},
           (("k", "1/s", 0.02, -1.0, 1.0, "share of drag per second"),), channels=("surge",)),
    effect("edge_scale", "Lengths along the edge are seen too short.", {"observe": edge_scale},
           (("k", "1", 0.05, -0.6, 0.6, "share seen too short at the edge"),), kind="measurement",
           channels=("surge",)),
    effect("lens_error", "The lens shows the tank's ends shorter than its middle.",
           {"observe": barrel}, (("k", "1", 0.03, -0.3, 0.3, "shortening at the ends"),),
           kind="measurement", channels=("surge",)),
)  # fmt: skip
STAGES = (
    Stage("effort", ("X", "w"), effort, open=True),
    Stage("rates", ("x", "y", "psi", "u"), motion),
    Stage("observe", ("x_seen", "y_seen"), seen, open=True),
)
SYSTEM = System(
    "fish_robot_pool", ("x", "y", "psi", "u"), ("L", "W"), (), COEFFICIENTS, STAGES,
    ("x_seen", "y_seen"), EFFECTS,
)  # fmt: skip
