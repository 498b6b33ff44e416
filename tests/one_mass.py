"""A mass on a line, pushed at random, seen with errors that last: its answers are known."""

from __future__ import annotations

from types import SimpleNamespace

from pipeline.integrate import Effect, Parameter, Stage, System


def push() -> tuple[float]:
    """No force of its own."""
    return (0.0,)


def rates(v: float, F: float, c: float) -> tuple[float, float]:
    """Derivatives of place and speed of a unit mass with linear drag c."""
    return v, F - c * v


def observe(x: float) -> tuple[float]:
    """The place is seen."""
    return (x,)


def random_force(g: float) -> tuple[float]:
    """The random force itself."""
    return (g,)


def force_fades(g: float, tau: float) -> tuple[float]:
    """g' = -g / tau."""
    return (-g / tau,)


def lasting_error(e: float) -> tuple[float]:
    """The lasting error is seen as if it were place."""
    return (e,)


def error_fades(e: float, tau: float) -> tuple[float]:
    """e' = -e / tau."""
    return (-e / tau,)


def _random(name: str, state: str, hook: dict[str, object], fades: object, channel: str) -> Effect:
    present = Parameter("present", "1", 1.0, 0.0, 1.0, "1 where it acts")
    tau = Parameter("tau", "s", 0.3, 0.01, 10.0, "memory")
    given = SimpleNamespace(states=(state,), channels=(channel,) if channel else ())
    return Effect(name=name, kind="disturbance", statement="random", parameters=(present, tau),
                  hooks=hook, module=__name__, channels=given.channels, states=given.states,
                  rates=fades)  # fmt: skip


SYSTEM = System(
    "one_mass", ("x", "v"), (), ("u",), (Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    (Stage("force", ("F",), push, open=True), Stage("rates", ("x", "v"), rates),
     Stage("observe", ("seen",), observe, open=True)),
    ("seen",),
    (_random("water", "g", {"force": random_force}, force_fades, "surge"),
     _random("tracking", "e", {"observe": lasting_error}, error_fades, "")),
)  # fmt: skip
