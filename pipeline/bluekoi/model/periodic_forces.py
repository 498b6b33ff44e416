"""Forces periodic in time, along the pool or with heading: residual terms with a wave number.

    F = s sin Wz + c cos Wz,   z = t since the start, x or y from the pool's corner, psi - q phi

in one channel each, as of a supply that oscillates about its voltage, water that sloshes after the
release, a standing wave, or a magnet that meets steel. The heading is that of the core (q = 0) or
of the head plate (q = 1).
Source: any periodic function, to first order (Fourier).
"""

from __future__ import annotations

from collections.abc import Callable

from ..integrate import Effect, Parameter
from ..integrate.branchless import sin_cos

EFFECT_KIND = "residual"
SurgeSwayYaw = tuple[float, float, float]
TRIED_ANGULAR_FREQUENCIES_RAD_S = (1.2, 1.7, 2.2, 2.7, 3.2, 3.8, 4.4, 5.1, 5.9)
"""rad/s: neighbours differ by half a cycle in the 6 s of a usual trial."""
TRIED_WAVE_NUMBERS_PER_M = (2.4, 3.4, 4.6, 6.2, 8.0)
"""rad/m: from one wave in the pool's length to one in half its width."""
TRIED_HARMONICS = (1.0, 2.0, 3.0, 4.0)
"""Waves in a full turn."""


def sinusoidal_force_profile(z: float, s: float, c: float, W: float) -> float:
    """F of the equation above."""
    sine, cosine = sin_cos(W * z)
    return s * sine + c * cosine


def surge_with_time(t: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Surge force (N)."""
    return sinusoidal_force_profile(t, s, c, W), 0.0, 0.0


def sway_with_time(t: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Sway force (N)."""
    return 0.0, sinusoidal_force_profile(t, s, c, W), 0.0


def yaw_with_time(t: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, sinusoidal_force_profile(t, s, c, W)


def surge_along_x(x: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Surge force (N)."""
    return sinusoidal_force_profile(x, s, c, W), 0.0, 0.0


def sway_along_x(x: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Sway force (N)."""
    return 0.0, sinusoidal_force_profile(x, s, c, W), 0.0


def yaw_along_x(x: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, sinusoidal_force_profile(x, s, c, W)


def surge_along_y(y: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Surge force (N)."""
    return sinusoidal_force_profile(y, s, c, W), 0.0, 0.0


def sway_along_y(y: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Sway force (N)."""
    return 0.0, sinusoidal_force_profile(y, s, c, W), 0.0


def yaw_along_y(y: float, s: float, c: float, W: float) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, sinusoidal_force_profile(y, s, c, W)


def surge_with_heading(
    psi: float, phi: float, s: float, c: float, W: float, q: float
) -> SurgeSwayYaw:
    """Surge force (N)."""
    return sinusoidal_force_profile(psi - q * phi, s, c, W), 0.0, 0.0


def sway_with_heading(
    psi: float, phi: float, s: float, c: float, W: float, q: float
) -> SurgeSwayYaw:
    """Sway force (N)."""
    return 0.0, sinusoidal_force_profile(psi - q * phi, s, c, W), 0.0


def yaw_with_heading(
    psi: float, phi: float, s: float, c: float, W: float, q: float
) -> SurgeSwayYaw:
    """Yaw moment (N m)."""
    return 0.0, 0.0, sinusoidal_force_profile(psi - q * phi, s, c, W)


PERIODIC_TERM_SETTINGS_BY_NAME_SUFFIX = {
    "with_time": ("time", "rad/s", TRIED_ANGULAR_FREQUENCIES_RAD_S),
    "along_x": ("place", "rad/m", TRIED_WAVE_NUMBERS_PER_M),
    "along_y": ("place", "rad/m", TRIED_WAVE_NUMBERS_PER_M),
    "with_heading": ("heading", "1", 2 * TRIED_HARMONICS),
}
"""Ending of a term's name -> the variable of its force, unit of W, and values tried."""
TRIED_CORE_OR_HEAD_HEADING = len(TRIED_HARMONICS) * (0.0,) + len(TRIED_HARMONICS) * (1.0,)
"""The harmonics are tried with the heading of the core (0), then with that of the head (1)."""
CORE_OR_HEAD_HEADING_PARAMETER = Parameter(
    "of_head",
    "1",
    0.0,
    0.0,
    1.0,
    "heading of the core (0) or of the head (1)",
    tries=TRIED_CORE_OR_HEAD_HEADING,
    symbol="q",
)


def _residual_effect(force: Callable[..., SurgeSwayYaw]) -> Effect:
    channel, ending = force.__name__.split("_", maxsplit=1)
    variable, rate_unit, tries = PERIODIC_TERM_SETTINGS_BY_NAME_SUFFIX[ending]
    unit, size = ("N m", 0.001) if channel == "yaw" else ("N", 0.01)
    return Effect(
        name=force.__name__,
        kind=EFFECT_KIND,
        statement=f"A {channel} force rises and falls {ending.replace('_', ' ')}.",
        parameters=(
            Parameter("sine_amplitude", unit, size, -1.0, 1.0, "s above", symbol="s"),
            Parameter("cosine_amplitude", unit, size, -1.0, 1.0, "c above", symbol="c"),
            Parameter("wave_number", rate_unit, tries[len(tries) // 2], 0.8 * tries[0],
                      1.2 * tries[-1], "frequency or wave number", tries=tries, symbol="W"),
            *((CORE_OR_HEAD_HEADING_PARAMETER,) if variable == "heading" else ()),
        ),
        hooks={"force": force},
        module=__name__,
        channels=(channel,),
        variables=(variable,),
        strengths=2,
    )  # fmt: skip


RESIDUAL_FORCE_EFFECTS = tuple(
    _residual_effect(force)
    for force in (
        surge_with_time, sway_with_time, yaw_with_time, surge_along_x, sway_along_x, yaw_along_x,
        surge_along_y, sway_along_y, yaw_along_y, surge_with_heading, sway_with_heading,
        yaw_with_heading,
    )
)  # fmt: skip
"""Residual terms that are sines of time, place or heading."""
