"""A pendulum: a'' = -w0^2 sin(a - a0) + what was left out; angle a (rad), rate b (rad/s).

Per unit of inertia, so that every friction has the unit of an angular acceleration.
"""

from __future__ import annotations

from bluekoi.explain import Cause, Model, Observation, Parameter, Stage, State
from bluekoi.integrate.branchless import sin_cos

from .reading import read_folder


def swing(a: float, w0: float) -> tuple[float]:
    """N = -w0^2 sin a (rad/s2)."""
    s, _ = sin_cos(a)
    return (-w0 * w0 * s,)


def motion(b: float, N: float) -> tuple[float, float]:
    """A' = b, b' = N."""
    return b, N


def seen(a: float, b: float) -> tuple[float, float]:
    """Angle and rate as recorded."""
    return a, b


def viscous(b: float, k: float) -> tuple[float]:
    """N = -k b."""
    return (-k * b,)


def coulomb(b: float, k: float) -> tuple[float]:
    """N = -k sign b, smooth within 0.02 rad/s."""
    return (-k * b / (b * b + 4e-4) ** 0.5,)


def quadratic(b: float, k: float) -> tuple[float]:
    """N = -k b |b|."""
    return (-k * b * abs(b),)


def zero_error(a: float, w0: float, d: float) -> tuple[float]:
    """The angle's zero is not the rest: gravity acts on a - d (first order in d)."""
    _, c = sin_cos(a)
    return (w0 * w0 * c * d,)


def rate_scaled(b: float, k: float) -> tuple[float, float]:
    """The rate is recorded (1 + k) times too large."""
    return 0.0, k * b


CAUSES = (
    Cause("viscous_friction", "Friction in proportion to the rate.", {"moment": viscous},
           (Parameter("k", "1/s", 0.05, 0.0, 5.0, "over the rate"),)),
    Cause("coulomb_friction", "Dry friction, the same at every rate.", {"moment": coulomb},
           (Parameter("k", "rad/s2", 0.1, 0.0, 10.0, "deceleration"),)),
    Cause("quadratic_friction", "Friction in proportion to the rate squared.",
           {"moment": quadratic}, (Parameter("k", "1", 0.02, 0.0, 5.0, "over the rate squared"),)),
    Cause("zero_error", "The angle's zero is not where the pendulum rests.",
           {"moment": zero_error}, (Parameter("d", "rad", 0.01, -0.5, 0.5, "angle of rest"),),
           kind="measurement"),
    Cause("rate_scale", "The rate is recorded too large or too small.", {"observe": rate_scaled},
           (Parameter("k", "1", 0.01, -0.3, 0.3, "share too large"),), kind="measurement"),
)  # fmt: skip
MODEL = Model(
    name="pendulum",
    states=(State("a", "rad", 0.05, observed="angle"), State("b", "rad/s", 0.05, observed="rate")),
    observations=(Observation("angle", "rad", 0.002), Observation("rate", "rad/s", 0.002)),
    coefficients=(Parameter("w0", "rad/s", 1.16, 0.2, 20.0, "frequency of small swings"),),
    stages=(
        Stage("moment", ("N",), swing, open=True),
        Stage("rates", ("a", "b"), motion),
        Stage("observe", ("angle", "rate"), seen),
    ),
    causes=CAUSES,
    pushed=(),
    read=read_folder,
)
"""Nothing pushes a pendulum in still air."""
