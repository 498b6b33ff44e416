"""A cart on a line with linear drag: a model file as `bluekoi explain` takes it."""

from bluekoi.explain import Cause, Input, Model, Observation, Parameter, Stage, State


def linear_drag(v: float, c: float) -> tuple[float]:
    """Linear drag of a unit mass (N)."""
    return (-c * v,)


def rates(v: float, push: float, F: float, w: float) -> tuple[float, float]:
    """x' = v + w, v' = push + F."""
    return v + w, push + F


def observe(x: float) -> tuple[float]:
    """The position (m)."""
    return (x,)


def quadratic_drag(v: float, k: float) -> tuple[float]:
    """F = -k v |v|."""
    return (-k * v * abs(v),)


def spring_force(x: float, k: float) -> tuple[float]:
    """F = -k x."""
    return (-k * x,)


def ground_velocity(c: float) -> tuple[float]:
    """The ground moves with c (m/s)."""
    return (c,)


MODEL = Model(
    name="cart",
    states=(State("x", "m", 0.01, observed="position"), State("v", "m/s", 0.3)),
    inputs=(Input("push", "N", held=True),),
    observations=(Observation("position", "m", 1e-3),),
    coefficients=(Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    stages=(
        Stage("force", ("F",), linear_drag, open=True),
        Stage("ground", ("w",), None, open=True),
        Stage("rates", ("x", "v"), rates),
        Stage("observe", ("position",), observe),
    ),
    causes=(
        Cause(
            "quadratic_drag",
            "Drag grows with the square of the speed.",
            {"force": quadratic_drag},
            (Parameter("k", "1/m", 0.5, 0.0, 20.0, "drag"),),
        ),
        Cause(
            "spring",
            "A spring pulls back.",
            {"force": spring_force},
            (Parameter("k", "1/s2", 0.2, -5.0, 5.0, "stiffness"),),
        ),
        Cause(
            "current",
            "The ground moves.",
            {"ground": ground_velocity},
            (Parameter("c", "m/s", 0.05, -2.0, 2.0, "velocity"),),
            site=True,
        ),
    ),
)
