"""Wave drag close to the surface.

Wave drag rises faster than the square of the speed up to the hull speed. For a body of the length
L, the hull speed is (a_g L / 2 pi)^(1/2), with the acceleration of gravity a_g.

At the speed V, the wave drag against the direction of motion v_hat is

    D = -k V_1^4 ((1 - g) (1 - o) ((1 - w) (V / V_1)^4 + w (V / V_1)^6)
                  + (1 - g) o (max(V - V_0, 0) / (V_1 - V_0))^2 + g (V / V_1)^2 R(V)) v_hat
    R = 1 / (1 + ((V - V_c) / 0.08 m/s)^2)^2,  V_1 = 0.4 m/s

- k: coefficient (N (s/m)^4). With g = 0, the drag at the speed V_1 is k V_1^4 for all w and o;
- w: weight of a drag that grows as V^6. The drag that grows as V^4 has the weight 1 - w;
- o: weight of a drag that is zero below the onset speed V_0 and grows as (V - V_0)^2 above it. The
  reason for an onset is that waves on water are not slower than 0.23 m/s;
- g: weight of a hump of the drag at the speed V_c, with the shape R. Interference of bow and stern
  waves causes it.

The share h of the wave drag acts at the head plate, at the distance l ahead of the centre of mass.
The rest acts at the centre of mass.

Source: Faltinsen, Hydrodynamics of High-Speed Marine Vehicles (2005), sec. 4.1; Hoerner (1965), ch.
11; Raphael and de Gennes, Phys. Rev. E 53 (1996), 3448 (onset of capillary-gravity waves).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("speed",)
EFFECT_DESCRIPTION = (
    "Close to the surface the robot makes waves; their drag grows faster than the square of the "
    "speed."
)
MOST_VISIBLE_WHERE = "the highest speeds: the largest power"
CONFUSED_WITH = ("thrust_loss_with_speed", "viscous_drag")
EFFECT_PARAMETERS = (
    Parameter("coefficient", "N (s/m)^4", 1.0, 0.0, 60.0, "force at 0.4 m/s over 0.4^4",
              symbol="k"),
    Parameter("sixth_power_share", "1", 0.0, 0.0, 1.0, "weight of a drag that grows as V^6",
              spread=0.5, symbol="w"),
    Parameter("head_share", "1", 0.0, 0.0, 1.0, "share of the drag that acts at the head",
              spread=0.5, symbol="h"),
    Parameter("hump_share", "1", 0.0, 0.0, 1.0, "weight of the hump", spread=0.5, symbol="g"),
    Parameter("hump_speed", "m/s", 0.35, 0.1, 1.0, "speed of the hump", spread=0.1, symbol="V_c"),
    Parameter("onset_share", "1", 0.0, 0.0, 1.0, "weight of a drag above an onset speed",
              spread=0.5, symbol="o"),
    Parameter("onset_speed", "m/s", 0.23, 0.0, 0.35, "speed from which the robot makes waves",
              spread=0.05, symbol="V_0"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "V^4": {},
    "V^6": {"sixth_power_share": 1.0},
    "hump": {"hump_share": 1.0},
    "above an onset": {"onset_share": 1.0},
    "at the head": {"head_share": 1.0},
    "hump at a low speed": {"hump_share": 1.0, "hump_speed": 0.25},
}


def force(
    l: float, uc: float, vc: float, V: float, speed_unit: float, k: float, w: float, h: float,
    g: float, V_c: float, o: float, V_0: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m)."""
    z, V_1 = (V - V_c) / (0.08 * speed_unit), 0.4 * speed_unit
    e = 1.0 + z * z
    y, x = V * V / (V_1 * V_1), max(V - V_0, 0.0) / (V_1 - V_0)
    smooth = y * y * (1.0 - w + w * y)
    D = k * V_1 * V_1 * V_1 * V_1 * ((1.0 - g) * (smooth + o * (x * x - smooth)) + g * y / (e * e))
    s = -D / max(V, 1e-9)
    return s * uc, s * vc, h * l * s * vc
