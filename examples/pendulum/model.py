"""A pendulum: a'' = -w0^2 sin(a - a0) + what was left out; angle a (rad), rate b (rad/s).

Per unit of inertia, so that every friction has the unit of an angular acceleration.
"""

from __future__ import annotations

from bluekoi.integrate import Parameter, Stage, System
from bluekoi.integrate.branchless import sin_cos

from ..effect import effect
from ..randomness import lasting_errors, pushes


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


COEFFICIENTS = (Parameter("w0", "rad/s", 1.16, 0.2, 20.0, "frequency of small swings"),)
EFFECTS = (
    pushes("Air and bearing are never quite even.", "moment", ("swing",), (0.5, 0.05, 10.0)),
    lasting_errors("The recorded angle's errors last for a while.", 2, (0.3, 0.02, 5.0)),
    effect("viscous_friction", "Friction in proportion to the rate.", {"moment": viscous},
           (("k", "1/s", 0.05, 0.0, 5.0, "over the rate"),)),
    effect("coulomb_friction", "Dry friction, the same at every rate.", {"moment": coulomb},
           (("k", "rad/s2", 0.1, 0.0, 10.0, "deceleration"),)),
    effect("quadratic_friction", "Friction in proportion to the rate squared.",
           {"moment": quadratic}, (("k", "1", 0.02, 0.0, 5.0, "over the rate squared"),)),
    effect("zero_error", "The angle's zero is not where the pendulum rests.",
           {"moment": zero_error}, (("d", "rad", 0.01, -0.5, 0.5, "angle of rest"),),
           kind="measurement"),
    effect("rate_scale", "The rate is recorded too large or too small.", {"observe": rate_scaled},
           (("k", "1", 0.01, -0.3, 0.3, "share too large"),), kind="measurement"),
)  # fmt: skip
STAGES = (
    Stage("moment", ("N",), swing, open=True),
    Stage("rates", ("a", "b"), motion),
    Stage("observe", ("angle", "rate"), seen, open=True),
)
SYSTEM = System("pendulum", ("a", "b"), (), (), COEFFICIENTS, STAGES, ("angle", "rate"), EFFECTS)
