"""A driven, damped pendulum: a system for tests of the integrator."""

from __future__ import annotations

import math

import numpy as np

from bluekoi.integrate import Effect, Parameter, Stage, System


def damping_coefficient(c: float) -> tuple[float]:
    return (2.0 * c,)


def torque(angle: float, rate: float, t: float, g: float, push: float, c2: float) -> tuple[float]:
    return (-g * math.sin(angle) - c2 * rate + push + 0.3 * math.sin(5.0 * t),)


def rates(rate: float, N: float) -> tuple[float, float]:
    return rate, N


def observe(angle: float) -> tuple[float]:
    return (angle,)


def cubic_damping(rate: float, k: float) -> tuple[float]:
    return (-k * math.fabs(rate) * rate * rate * np.sign(rate),)  # functions of libraries


PENDULUM = System(
    "pendulum",
    states=("angle", "rate"),
    constants=("g",),
    inputs=("push",),
    coefficients=(Parameter("c", "1/s", 0.1, 0.0, 2.0, "damping"),),
    stages=(
        Stage("damping", ("c2",), damping_coefficient),
        Stage("torque", ("N",), torque, open=True),
        Stage("rates", ("angle", "rate"), rates),
        Stage("observe", ("seen",), observe),
    ),
    observations=("seen",),
    effects=(
        Effect(
            "cubic",
            "physics",
            "It is damped by the cube.",
            (Parameter("k", "s", 0.1, 0.0, 5.0, "strength"),),
            {"torque": cubic_damping},
            "pendulum",
        ),
    ),
)
