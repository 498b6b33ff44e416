"""Core and tail as a fin.

A low-aspect-ratio fin at distance a behind the centre of mass meets the water at the sideways
speed v_a = v - a r and gives the side force of a thin wing at small angle:

    Y = -1/2 rho S u v_a |u|/u,    N = -a Y,    S = C_La,fin x area

It vanishes without forward speed and is zero in straight swimming, which it makes stable.
Source: Newman, Marine Hydrodynamics (1977), sec. 5.15 (lifting bodies of small aspect ratio).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("sway", "yaw")
STATEMENT = (
    "Core and tail act as a fin: moving sideways or turning, they feel a side force that "
    "grows with forward speed and turns the nose back into the flow."
)
REGIME = "turning or drifting while moving forward; nothing in straight swimming"
CONFUSED_WITH = ("crossflow_drag", "linear_yaw_damping", "added_mass")
PARAMETERS = (
    Parameter("S", "m2", 0.03, 0.0, 0.1, "lift slope times area of the fin"),
    Parameter("a", "m", 0.15, 0.0, 0.4, "distance of the fin behind the centre of mass"),
)


def force(
    rho: float, uc: float, vc: float, r: float, S: float, a: float
) -> tuple[float, float, float]:
    """Surge, sway (N) and yaw (N m) of the fin."""
    Y = -0.5 * rho * S * abs(uc) * (vc - a * r)
    return 0.0, Y, -a * Y
