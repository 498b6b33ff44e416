"""Wave drag close to the surface.

At the speed V, the drag against the direction of motion v_hat is

    D = -k V^4 ((1 - w) + w (V / V_1)^2) (1 + g R(V)) v_hat,  V_1 = 0.4 m/s
    R = 1 / (1 + ((V - V_c) / 0.08 m/s)^2)^2

Below the hull speed, wave drag rises faster than the square of the speed: here as V^4, and the part
w as V^6. Interference of bow and stern waves causes a hump of the relative height g at the speed
V_c.

The part h of the drag acts at the head plate, at the distance l ahead of the centre of mass. The
rest acts at the centre of mass.

Source: Faltinsen, Hydrodynamics of High-Speed Marine Vehicles (2005), sec. 4.1; Hoerner (1965), ch.
11.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("speed",)
STATEMENT = (
    "Close to the surface the robot makes waves; their drag grows faster than the square of the "
    "speed."
)
REGIME = "the highest speeds: 100 % power"
CONFUSED_WITH = ("thrust_loss_with_speed", "viscous_drag")
PARAMETERS = (
    Parameter("coefficient", "N (s/m)^4", 1.0, 0.0, 60.0, "force at 0.4 m/s over 0.4^4",
              symbol="k"),
    Parameter("sixth_power_share", "1", 0.0, 0.0, 1.0, "part that grows as V^6",
              spread=0.4, tries=(0.8,), symbol="w"),
    Parameter("head_share", "1", 0.0, 0.0, 1.0, "part of it that acts at the head",
              spread=0.5, symbol="h"),
    Parameter("hump_height", "1", 0.0, -0.8, 5.0, "further drag at the hump",
              spread=0.5, symbol="g"),
    Parameter("hump_speed", "m/s", 0.4, 0.1, 1.0, "speed of the hump", spread=0.1, symbol="V_c"),
)  # fmt: skip


def force(
    l: float, uc: float, vc: float, V: float, k: float, w: float, h: float, g: float, V_c: float
) -> tuple[float, float, float]:
    """Surge and sway (N) and yaw (N m)."""
    z = (V - V_c) / 0.08
    e = 1.0 + z * z
    s = -k * V * V * V * ((1.0 - w) + 6.25 * w * V * V) * (1.0 + g / (e * e))
    return s * uc, s * vc, h * l * s * vc
