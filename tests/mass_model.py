"""A mass on a line, pushed at random, seen with errors that last: its answers are known."""

from __future__ import annotations

from bluekoi.integrate import Effect, Parameter, Stage, System


def no_force() -> tuple[float]:
    """No force of its own."""
    return (0.0,)


def rates(v: float, F: float, c: float) -> tuple[float, float]:
    """Derivatives of place and speed of a unit mass with linear drag c."""
    return v, F - c * v


def observe(x: float) -> tuple[float]:
    """The place is seen."""
    return (x,)


def random_force(g_1: float) -> tuple[float]:
    """The random push."""
    return (g_1,)


def random_force_decay(g_1: float, tau: float) -> tuple[float]:
    """G' = -g / tau."""
    return (-g_1 / tau,)


def coloured_error(e_1: float) -> tuple[float]:
    """An error that is seen as if it were motion."""
    return (e_1,)


def coloured_error_decay(e_1: float, tau_e: float) -> tuple[float]:
    """E' = -e / tau_e."""
    return (-e_1 / tau_e,)


def ornstein_uhlenbeck_effect(name: str, hooks: dict, channels: tuple, state: str, rates) -> Effect:
    """A random force or error with a memory of 0.3 s, 0.01 to 10 s."""
    memory = "tau" if channels else "tau_e"
    parameters = (Parameter("present", "1", 1.0, 0.0, 1.0, "1 where it acts"),
                  Parameter(memory, "s", 0.3, 0.01, 10.0, "memory"))  # fmt: skip
    return Effect(name, "disturbance", name, parameters, hooks, __name__, channels,
                  states=(state,), rates=rates)  # fmt: skip


SYSTEM = System(
    "one_mass",
    ("x", "v"),
    (),
    ("u",),
    (Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    (
        Stage("force", ("F",), no_force, open=True),
        Stage("rates", ("x", "v"), rates),
        Stage("observe", ("seen",), observe, open=True),
    ),
    ("seen",),
    (
        ornstein_uhlenbeck_effect(
            "disturbance", {"force": random_force}, ("surge",), "g_1", random_force_decay
        ),
        ornstein_uhlenbeck_effect(
            "lasting_error", {"observe": coloured_error}, (), "e_1", coloured_error_decay
        ),
    ),
)
