"""The flat-plate model for a fish whose body is the plate and whose tail is turned by the bias.

The paper's equations 1 to 8 in the frame of the body (the head plate of the paper): theta is the
body's heading, phi the tail bias, thrust points along theta + phi and passes through the centre of
mass. Thrust grows with the square of tail amplitude a and tail-beat frequency f in place of f^2:

    T = 1/2 rho A C_T (a f)^2

State: x, y [m], theta [rad], surge u and sway v [m/s] in the body's frame, yaw rate r [rad/s].
"""

# ruff: noqa: E741, PLR0913, PLR0917 -- arguments are named after what an equation needs
from __future__ import annotations

import math

from bluekoi.explain import Constant, Input, Model, Observation, Parameter, Stage, State
from bluekoi.integrate.branchless import sin_cos

from . import causes
from .reading import read_folder

COEFFICIENTS = (
    Parameter("C_T", "m2", 1e-3, 1e-6, 1.0, "thrust over 1/2 rho A (a f)^2, a in rad"),
    Parameter("C_D0", "1", 0.7, 1e-3, 20.0, "profile drag"),
    Parameter("C_Da", "1", 1.8, 0.0, 60.0, "drag that comes with the angle of attack"),
    Parameter("C_La", "1", 3.8, 0.0, 60.0, "lift over sin 2 alpha"),
    Parameter("C_Ma", "m", 0.05, -2.0, 4.0, "moment over sin 2 alpha"),
    Parameter("C_Md", "kg m2", 0.005, 0.0, 1.0, "damping of the yaw rate squared"),
)
"""Drag, lift slope and damping of a body are not negative; the moment may have either sign."""
GEOMETRY = {
    "rho": (1000.0, "kg/m3"),
    "length": (0.21, "m"),
    "span": (0.08, "m"),
    "A": (0.21 * 0.08, "m2"),
    "l": (0.0525, "m"),
    "m": (0.725, "kg"),
    "I": (2.66e-3, "kg m2"),
    "x_tail": (0.105, "m"),
    "beat_hz0": (2.0, "Hz"),
    "recoil_share": (0.163, "1"),
}
"""ASSUME the size of this family of robots: body some 0.21 m long and 0.08 m deep, 0.725 kg,
2.66e-3 kg m2, tail joint 0.105 m behind the centre of mass; aerodynamic centre a quarter of the
body behind its nose. No file of the recordings states them; coefficients scale with them.
beat_hz0: the frequency at which the tail is seen to beat in straight swimming; recoil_share: mean
of the body's yaw recoil over the commanded tail amplitude."""


def clock() -> tuple[float]:
    """True seconds in a recorded one."""
    return (1.0,)


def drive(bias: float, amplitude: float, beat_hz0: float) -> tuple[float, float, float]:
    """Tail bias phi (rad), amplitude a (rad), and one frequency f (Hz) for all, as commanded."""
    return bias, amplitude, beat_hz0


def flow(psi: float, u: float, v: float, phi: float, wx: float, wy: float) -> tuple[
    float, float, float, float, float, float, float
]:  # fmt: skip
    """Cosine and sine of heading and bias, velocity along and across the body, speed (m/s)."""
    s, c = sin_cos(psi)
    sp, cp = sin_cos(phi)
    uh = u - (wx * c + wy * s)
    vh = v - (wy * c - wx * s)
    return c, s, cp, sp, uh, vh, math.sqrt(uh * uh + vh * vh + 1e-12)


def thrust(rho: float, A: float, a: float, f: float, C_T: float) -> tuple[float]:
    """Thrust along the tail (N): Eq. 1 with (a f)^2 in place of f^2."""
    return (C_T * 0.5 * rho * A * a * a * f * f,)


def force(
    rho: float, A: float, l: float, r: float, uh: float, vh: float, cphi: float, sphi: float,
    T: float, Xh: float, Yh: float, C_Ma: float, C_Md: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway force (N) and yaw moment (N m) in the body's frame (Eqs. 4, 7, 8)."""
    M = 0.5 * rho * A * C_Ma * (-2.0 * uh * vh) - C_Md * r * abs(r)
    return T * cphi + Xh, T * sphi + Yh, M + Yh * l


def plate(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float, C_D0: float, C_Da: float
) -> tuple[float, float]:  # fmt: skip
    """Lift and drag of the body (N), Eqs. 2, 3, 5, 6: V^2 sin 2 alpha = -2 u v,
    V^2 (1 - cos 2 alpha) = 2 v^2.
    """
    k = 0.5 * rho * A
    L = k * C_La * (-2.0 * uh * vh) / V
    D = k * (C_D0 * V * V + C_Da * 2.0 * vh * vh) / V
    return -L * vh - D * uh, L * uh - D * vh


def inertia(m: float, I: float) -> tuple[float, float, float]:
    """Mass against surge and sway (kg), inertia against yaw (kg m2)."""
    return m, m, I


def rates(
    u: float, v: float, r: float, cpsi: float, spsi: float,
    X: float, Y: float, N: float, mx: float, my: float, J: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Derivatives of x, y, psi, u, v, r (Eq. 8 in the body's frame).

    mx u' = X + my v r;  my v' = Y - mx u r;  J r' = N - (my - mx) u v
    """
    return (u * cpsi - v * spsi, u * spsi + v * cpsi, r, (X + my * v * r) / mx,
            (Y - mx * u * r) / my, (N - (my - mx) * u * v) / J)  # fmt: skip


def seen(x: float, y: float, psi: float) -> tuple[float, float, float]:
    """What the camera gives: centre of the body (m) and its heading (rad)."""
    return x, y, psi


MODEL = Model(
    name="robotic_fish",
    states=(
        State("x", "m", 0.005),
        State("y", "m", 0.005),
        State("psi", "rad", 0.05),
        State("u", "m/s", 0.02),
        State("v", "m/s", 0.02),
        State("r", "rad/s", 0.15),
    ),
    inputs=(
        Input("bias", "rad"),
        Input("amplitude", "rad"),
        Input("beat_hz", "Hz"),
        Input("recoil", "rad"),
    ),
    observations=(
        Observation("x_seen", "m", 5e-4),
        Observation("y_seen", "m", 5e-4),
        Observation("heading", "rad", 5e-3, angle=True),
    ),
    constants=tuple(Constant(name, unit, value) for name, (value, unit) in GEOMETRY.items()),
    coefficients=COEFFICIENTS,
    stages=(
        Stage("clock", ("clock_rate",), clock, open=True),
        Stage("drive", ("phi", "a", "f"), drive, open=True),
        Stage("water", ("wx", "wy"), None, open=True),
        Stage("flow", ("cpsi", "spsi", "cphi", "sphi", "uh", "vh", "V"), flow),
        Stage("thrust", ("T",), thrust, open=True),
        Stage("plate", ("Xh", "Yh"), plate, open=True),
        Stage("force", ("X", "Y", "N"), force, open=True),
        Stage("inertia", ("mx", "my", "J"), inertia, open=True),
        Stage("rates", ("x", "y", "psi", "u", "v", "r"), rates),
        Stage("observe", ("x_seen", "y_seen", "heading"), seen),
    ),
    causes=causes.CAUSES,
    random_force_s=(0.5, 0.05, 10.0),
    path=("x_seen", "y_seen"),
    read=read_folder,
)
