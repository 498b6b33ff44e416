"""Drag of the waves that a robot close to the surface makes.

    D = -k V^4 v_hat        (rises faster than speed squared below the hull speed)

Source: Faltinsen, Hydrodynamics of High-Speed Marine Vehicles (2005), sec. 4.1;
Hoerner (1965), ch. 11.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
STATEMENT = (
    "Close to the surface the robot makes waves, a drag that grows faster than speed squared."
)
REGIME = "the highest speeds: 100 % power"
CONFUSED_WITH = ("thrust_loss_with_speed", "viscous_drag")
PARAMETERS = (Parameter("k", "N (s/m)^4", 1.0, 0.0, 60.0, "force at 1 m/s"),)


def force(uc: float, vc: float, V: float, k: float) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    s = -k * V * V * V
    return s * uc, s * vc, 0.0
