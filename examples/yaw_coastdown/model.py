"""Yaw alone: I r' = -d(r) + what may have been left out; the gyro sees r.

The vessel's authors fitted d = N_r r, the bare model here. The motors are off while it spins down:
no random moment acts. With one that may last 10 s the bare model follows every trial, whatever the
law of damping.
"""

from __future__ import annotations

from bluekoi.explain import Cause, Constant, Model, Observation, Parameter, Stage, State

from .reading import read_folder

YAW_INERTIA = 5.45
"""kg m2, as the vessel's authors give it."""


def linear_moment(r: float, N_r: float) -> tuple[float]:
    """N = -N_r r."""
    return (-N_r * r,)


def quadratic_moment(r: float, N_rr: float) -> tuple[float]:
    """N = -N_rr r |r|."""
    return (-N_rr * r * abs(r),)


def dry_moment(r: float, N_c: float) -> tuple[float]:
    """N = -N_c sign r, smooth within 0.005 rad/s."""
    return (-N_c * r / (r * r + 2.5e-5) ** 0.5,)


def constant_moment(N_0: float) -> tuple[float]:
    """N = N_0: wind, or a hull that is not symmetric."""
    return (N_0,)


def acceleration(inertia: float, N: float) -> tuple[float]:
    """R' = N / I."""
    return (N / inertia,)


def gyro(r: float) -> tuple[float]:
    """The yaw rate as it is seen (rad/s)."""
    return (r,)


def offset(b: float) -> tuple[float]:
    """The gyro reads b at rest."""
    return (b,)


def scaled(r: float, k: float) -> tuple[float]:
    """The gyro reads (1 + k) r."""
    return (k * r,)


CAUSES = (
    Cause(
        "quadratic_yaw_damping",
        "The water resists turning in proportion to the yaw rate squared.",
        {"moment": quadratic_moment},
        (Parameter("N_rr", "N m s2", 1.0, 0.0, 100.0, "moment at 1 rad/s"),),
    ),
    Cause(
        "dry_friction",
        "A moment against the turning that does not depend on its rate.",
        {"moment": dry_moment},
        (Parameter("N_c", "N m", 0.05, 0.0, 5.0, "moment"),),
    ),
    Cause(
        "constant_moment",
        "A lasting moment acts on the vessel: wind, trim, a bent keel.",
        {"moment": constant_moment},
        (Parameter("N_0", "N m", 0.05, -5.0, 5.0, "moment"),),
    ),
    Cause(
        "gyro_bias",
        "The gyro does not read zero at rest.",
        {"observe": offset},
        (Parameter("b", "rad/s", 0.01, -0.2, 0.2, "reading at rest"),),
        kind="measurement",
        evidence={"compass": {"b": 1.0}},
    ),
    Cause(
        "gyro_scale",
        "The gyro reads all rates too large or too small.",
        {"observe": scaled},
        (Parameter("k", "1", 0.02, -0.3, 0.3, "share read too much"),),
        kind="measurement",
    ),
)
MODEL = Model(
    name="yaw_coastdown",
    states=(State("r", "rad/s", 0.05, observed="rate"),),
    observations=(Observation("rate", "rad/s", 0.003),),
    constants=(Constant("inertia", "kg m2", YAW_INERTIA),),
    coefficients=(Parameter("N_r", "N m s", 0.5, 0.0, 50.0, "linear damping, moment at 1 rad/s"),),
    stages=(
        Stage("moment", ("N",), linear_moment, open=True),
        Stage("rates", ("r",), acceleration),
        Stage("observe", ("rate",), gyro),
    ),
    causes=CAUSES,
    pushed=(),
    read=read_folder,
)
