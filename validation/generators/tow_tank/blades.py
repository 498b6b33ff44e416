"""Forces summed over blades from the hinge to the tip of the tail.

A blade at x ahead of the centre of mass meets water from the side at w + x r. Each law returns
force along the core, to port, and moment: N, N, N m.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .motion import Flow

KINEMATIC_VISCOSITY = 1.0e-6


def _blade_sum(c: Flow, per_length: Any, along: Any = 0.0) -> Any:
    x, _, ds = c.robot.stations
    return np.sum(along * ds + 0 * per_length, 0), np.sum(per_length * ds, 0), np.sum(
        x * per_length * ds, 0
    )  # fmt: skip


def _blade_side_flow(c: Flow) -> tuple[Any, Any, Any]:
    """Height of each blade, side speed there, and the height with weight on the fin."""
    x, height, _ = c.robot.stations
    aft = height * np.clip((c.robot.hinge_to_com - x) / 0.25, 0, None) ** 2
    return height, c.w + x * c.r, aft


def _fin_axial(c: Flow, k: float, _: Shape) -> Any:
    _, w, aft = _blade_side_flow(c)  # lift slope times |u| w, more of it aft
    return _blade_sum(c, -0.5 * c.robot.density * k * aft * np.abs(c.u) * w)


def _fin_speed(c: Flow, k: float, _: Shape) -> Any:
    _, w, aft = _blade_side_flow(c)
    return _blade_sum(c, -0.5 * c.robot.density * k * aft * np.hypot(c.u, w) * w)


def _fin_polhamus(c: Flow, k: float, p: Shape) -> Any:
    # C_N = K_p sin a cos a + K_v sin^2 a (Polhamus 1966), at the tail alone
    x, height, _ = c.robot.stations
    w = c.w + x[-1] * c.r
    q = 0.5 * c.robot.density * k * height[-1] * c.robot.tail_length
    Y = -q * (np.abs(c.u) * w + p["vortex"] * w * np.abs(w))
    return 0 * Y, Y, x[-1] * Y


def _fin_lighthill(c: Flow, k: float, _: Shape) -> Any:
    # momentum shed at the trailing edge: Y = -m u w, thrust reduced by m w^2 / 2 (Lighthill 1970)
    x, height, _ = c.robot.stations
    w = c.w + x[-1] * c.r
    m = k * c.robot.density * np.pi / 4 * height[-1] ** 2
    Y = -m * np.abs(c.u) * w
    return -0.5 * m * w**2, Y, x[-1] * Y


def _fin_stalling(c: Flow, k: float, p: Shape) -> Any:
    _, w, aft = _blade_side_flow(c)
    V2, a = c.u**2 + w**2, np.arctan2(w, np.maximum(np.abs(c.u), 1e-6))
    return _blade_sum(
        c, -0.5 * c.robot.density * k * aft * V2 * p["angle"] * np.tanh(a / p["angle"])
    )


def _fin_induced(c: Flow, k: float, p: Shape) -> Any:
    _, w, aft = _blade_side_flow(c)
    pressure = -0.5 * c.robot.density * k * aft
    return _blade_sum(c, pressure * np.abs(c.u) * w, pressure * p["induced"] * w**2)


def _cross_square(c: Flow, k: float, _: Shape) -> Any:
    h, w, _ = _blade_side_flow(c)
    return _blade_sum(c, -0.5 * c.robot.density * k * h * w * np.abs(w))


def _cross_power(c: Flow, k: float, p: Shape) -> Any:
    h, w, _ = _blade_side_flow(c)
    size = 0.1 ** (2 - p["power"]) * np.abs(w) ** p["power"]
    return _blade_sum(c, -0.5 * c.robot.density * k * h * np.sign(w) * size)


def _cross_tapered(c: Flow, k: float, _: Shape) -> Any:
    h, w, _ = _blade_side_flow(c)  # bluff near the hinge, thin towards the tail
    x = c.robot.stations[0]
    bluff = np.clip((x - x[-1]) / (x[0] - x[-1]), 0, 1)
    return _blade_sum(c, -c.robot.density * k * bluff * h * w * np.abs(w))


def _cross_reynolds(c: Flow, k: float, _: Shape) -> Any:
    h, w, _ = _blade_side_flow(c)  # C_d (1 + 10 Re^-2/3), as for cylinders (White 1974)
    Re = np.abs(w) * h / KINEMATIC_VISCOSITY + 1.0
    return _blade_sum(c, -0.5 * c.robot.density * k * (1 + 10 * Re ** (-2 / 3)) * h * w * np.abs(w))


FORMS: list[Form] = [
    *forms("tail_fin_lift", "body", 0.01, 60, "", "sway yaw", {
        "axial": _fin_axial, "speed": _fin_speed, "lighthill": _fin_lighthill,
        "polhamus": (_fin_polhamus, {"vortex": (0.4, 2.0)}),
        "stalling": (_fin_stalling, {"angle": (0.3, 0.7)}),
        "induced": (_fin_induced, {"induced": (0.2, 0.8)}),
    }),
    *forms("crossflow_drag", "body", 0.05, 3.0, "", "sway yaw", {
        "square": _cross_square, "tapered": _cross_tapered, "reynolds": _cross_reynolds,
        "power": (_cross_power, {"power": (1.5, 1.85)}),
    }),
]  # fmt: skip
