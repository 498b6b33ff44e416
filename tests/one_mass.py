"""A mass on a line, pushed at random, seen with errors that last: its answers are known."""

from __future__ import annotations

from bluekoi.integrate import Effect, Parameter, Stage, System


def push() -> tuple[float]:
    """No force of its own."""
    return (0.0,)


def rates(v: float, F: float, c: float) -> tuple[float, float]:
    """Derivatives of place and speed of a unit mass with linear drag c."""
    return v, F - c * v


def observe(x: float) -> tuple[float]:
    """The place is seen."""
    return (x,)


def push_1(g_1: float) -> tuple[float]:
    """The random push."""
    return (g_1,)


def push_fades(g_1: float, tau: float) -> tuple[float]:
    """G' = -g / tau."""
    return (-g_1 / tau,)


def error_1(e_1: float) -> tuple[float]:
    """An error that is seen as if it were motion."""
    return (e_1,)


def error_fades(e_1: float, tau_e: float) -> tuple[float]:
    """E' = -e / tau_e."""
    return (-e_1 / tau_e,)


def random_part(name: str, hooks: dict, channels: tuple, state: str, rates) -> Effect:
    """A random force or error with a memory of 0.3 s, 0.01 to 10 s."""
    memory = "tau" if channels else "tau_e"
    parameters = (Parameter("present", "1", 1.0, 0.0, 1.0, "1 where it acts"),
                  Parameter(memory, "s", 0.3, 0.01, 10.0, "memory"))  # fmt: skip
    return Effect(name, "disturbance", name, parameters, hooks, __name__, channels,
                  states=(state,), rates=rates)  # fmt: skip


SYSTEM = System(
    "one_mass", ("x", "v"), (), ("u",), (Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    (Stage("force", ("F",), push, open=True), Stage("rates", ("x", "v"), rates),
     Stage("observe", ("seen",), observe, open=True)),
    ("seen",),
    (random_part("disturbance", {"force": push_1}, ("surge",), "g_1", push_fades),
     random_part("lasting_error", {"observe": error_1}, (), "e_1", error_fades)),
)  # fmt: skip
