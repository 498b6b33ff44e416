"""Forces that rise and fall with the time or along the pool, without a name among the causes.

    F = s sin Wz + c cos Wz,   z = t since the start, x or y from the pool's corner

in one channel each: what comes and goes with the time (a supply that hunts about its voltage, water
that swings after the release) or with the place (a standing wave). Terms without a name like those
of `residual`, with a wave number of their own.
Source: any periodic function, to first order (Fourier).
"""

from __future__ import annotations

from collections.abc import Callable

from ..integrate import Effect, Parameter
from ..integrate.branchless import sin_cos

KIND = "residual"
Force = tuple[float, float, float]
RATES = (1.2, 1.7, 2.2, 2.7, 3.2, 3.8, 4.4, 5.1, 5.9)
"""rad/s: neighbours differ by half a cycle in the 6 s of a usual trial."""
WAVE_NUMBERS = (2.4, 3.4, 4.6, 6.2, 8.0)
"""rad/m: from one wave in the pool's length to one in half its width."""


def surge_with_time(t: float, s: float, c: float, W: float) -> Force:
    """Surge force (N)."""
    sine, cosine = sin_cos(W * t)
    return s * sine + c * cosine, 0.0, 0.0


def sway_with_time(t: float, s: float, c: float, W: float) -> Force:
    """Sway force (N)."""
    sine, cosine = sin_cos(W * t)
    return 0.0, s * sine + c * cosine, 0.0


def yaw_with_time(t: float, s: float, c: float, W: float) -> Force:
    """Yaw moment (N m)."""
    sine, cosine = sin_cos(W * t)
    return 0.0, 0.0, s * sine + c * cosine


def surge_along_x(x: float, s: float, c: float, W: float) -> Force:
    """Surge force (N)."""
    sine, cosine = sin_cos(W * x)
    return s * sine + c * cosine, 0.0, 0.0


def sway_along_x(x: float, s: float, c: float, W: float) -> Force:
    """Sway force (N)."""
    sine, cosine = sin_cos(W * x)
    return 0.0, s * sine + c * cosine, 0.0


def yaw_along_x(x: float, s: float, c: float, W: float) -> Force:
    """Yaw moment (N m)."""
    sine, cosine = sin_cos(W * x)
    return 0.0, 0.0, s * sine + c * cosine


def surge_along_y(y: float, s: float, c: float, W: float) -> Force:
    """Surge force (N)."""
    sine, cosine = sin_cos(W * y)
    return s * sine + c * cosine, 0.0, 0.0


def sway_along_y(y: float, s: float, c: float, W: float) -> Force:
    """Sway force (N)."""
    sine, cosine = sin_cos(W * y)
    return 0.0, s * sine + c * cosine, 0.0


def yaw_along_y(y: float, s: float, c: float, W: float) -> Force:
    """Yaw moment (N m)."""
    sine, cosine = sin_cos(W * y)
    return 0.0, 0.0, s * sine + c * cosine


def _effect(force: Callable[..., Force]) -> Effect:
    channel, variable = force.__name__.split("_", maxsplit=1)
    in_time = variable == "with_time"
    unit, size = ("N m", 0.001) if channel == "yaw" else ("N", 0.01)
    tries = RATES if in_time else WAVE_NUMBERS
    return Effect(
        name=force.__name__,
        kind=KIND,
        statement=f"A {channel} force rises and falls {variable.replace('_', ' ')}.",
        parameters=(
            Parameter("s", unit, size, -1.0, 1.0, "amplitude of the sine"),
            Parameter("c", unit, size, -1.0, 1.0, "amplitude of the cosine"),
            Parameter("W", "rad/s" if in_time else "rad/m", tries[len(tries) // 2],
                      0.8 * tries[0], 1.2 * tries[-1], "wave number", tries=tries),
        ),
        hooks={"force": force},
        module=__name__,
        channels=(channel,),
        variables=("time" if in_time else "place",),
        strengths=2,
    )  # fmt: skip


EFFECTS = tuple(
    _effect(force)
    for force in (
        surge_with_time, sway_with_time, yaw_with_time, surge_along_x, sway_along_x, yaw_along_x,
        surge_along_y, sway_along_y, yaw_along_y,
    )
)  # fmt: skip
