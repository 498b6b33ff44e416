"""Straight swimming at constant thrust: u' = a (V_0^2 - u^2), each command with a speed of its own.

State: x, y [m] of the light (x along the tank, y from the edge y = 0), course psi [rad], speed u
[m/s]. The course wanders at random; what is asked is what the speed depends on.
"""

from __future__ import annotations

import math

from bluekoi.explain import Cause, Constant, Model, Observation, Parameter, Stage, State
from bluekoi.integrate.branchless import sin_cos

from .reading import TANK_M, read_folder, start

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


CAUSES = (
    Cause(
        "wall_effect",
        "Close to the tank's edge the robot is slowed.",
        {"effort": near_edge},
        (
            Parameter("k", "1", 0.5, 0.0, 20.0, "share of drag added at the edge"),
            Parameter("d", "m", 0.1, 0.02, 0.5, "reach"),
        ),
        site=True,
    ),
    Cause(
        "far_wall",
        "Close to the far edge the robot is slowed.",
        {"effort": far_edge},
        (Parameter("k", "1", 0.5, 0.0, 20.0, "share of drag added at the edge"),),
        site=True,
    ),
    Cause(
        "end_walls",
        "Close to the tank's ends the robot is slowed.",
        {"effort": end_wall},
        (Parameter("k", "1", 0.5, 0.0, 20.0, "share of drag added at an end"),),
        site=True,
    ),
    Cause(
        "battery_sag",
        "The batteries give out during a run.",
        {"effort": sagging},
        (Parameter("k", "1/s", 0.02, -1.0, 1.0, "share of drag per second"),),
    ),
    Cause(
        "edge_scale",
        "Lengths along the edge are seen too short.",
        {"observe": edge_scale},
        (Parameter("k", "1", 0.05, -0.6, 0.6, "share seen too short at the edge"),),
        kind="measurement",
        site=True,
    ),
    Cause(
        "lens_error",
        "The lens shows the tank's ends shorter than its middle.",
        {"observe": barrel},
        (Parameter("k", "1", 0.03, -0.3, 0.3, "shortening at the ends"),),
        kind="measurement",
        site=True,
    ),
)
MODEL = Model(
    name="fish_robot_pool",
    states=(
        State("x", "m", 0.05),
        State("y", "m", 0.05),
        State("psi", "rad", 0.3),
        State("u", "m/s", 0.1),
    ),
    observations=(Observation("x_seen", "m", 0.003), Observation("y_seen", "m", 0.003)),
    constants=(Constant("L", "m", TANK_M[0]), Constant("W", "m", TANK_M[1])),
    coefficients=COEFFICIENTS,
    stages=(
        Stage("effort", ("X", "w"), effort, open=True),
        Stage("rates", ("x", "y", "psi", "u"), motion),
        Stage("observe", ("x_seen", "y_seen"), seen),
    ),
    causes=CAUSES,
    pushed=("X", "w"),
    per_group=("V_0",),
    path=("x_seen", "y_seen"),
    start=start,
    read=read_folder,
)
