"""Drag laws: viscous drag, wave drag, dry friction, cross-flow drag.

Sources: flat-plate boundary layers, the ITTC 1957 line, ship resistance humps, Stribeck curves,
strip theory of cross-flow drag.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form, smooth_sign


@form("viscous_drag", "stokes_linear", "force", 0.15, 1.2)
def _(w: Any, p: dict[str, float]) -> None:
    """Resistance proportional to speed."""
    w.drag_along(p["amp"] * w.sc.drag * w.speed / w.sc.speed)


@form("viscous_drag", "laminar_plate", "force", 0.2, 1.5, exponent=(1.4, 1.6))
def _(w: Any, p: dict[str, float]) -> None:
    """Laminar boundary layer: resistance as speed to about three halves."""
    w.drag_along(p["amp"] * w.sc.drag * (w.speed / w.sc.speed) ** p["exponent"])


@form("viscous_drag", "friction_line", "force", 0.4, 3.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Friction coefficient falling with the logarithm of the Reynolds number."""
    re = w.speed * w.sc.length / 1.0e-6 + 3000.0
    re0 = w.sc.speed * w.sc.length / 1.0e-6 + 3000.0
    ratio = ((np.log10(re0) - 2) / (np.log10(re) - 2)) ** 2
    w.drag_along(p["amp"] * w.sc.drag * ratio * (w.speed / w.sc.speed) ** 2)


@form("viscous_drag", "separation_crisis", "force", 0.2, 1.0, centre=(0.6, 1.0), width=(0.1, 0.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Wake narrowing at a critical Reynolds number: the coefficient drops over a speed band."""
    s = w.speed / w.sc.speed
    drop = 0.5 * (1 - np.tanh((s - p["centre"]) / p["width"]))
    w.drag_along(p["amp"] * w.sc.drag * drop * s**2)


@form("wave_drag", "fourth_power", "force", 0.1, 1.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Thin-ship growth with the fourth power of speed."""
    w.drag_along(p["amp"] * w.sc.drag * (w.speed / w.sc.speed) ** 4)


@form("wave_drag", "exponential_onset", "force", 0.2, 3.0, onset=(0.7, 1.4))
def _(w: Any, p: dict[str, float]) -> None:
    """Deep-water source attenuation exp(-b/Fr^2) times dynamic pressure."""
    s = w.speed / w.sc.speed + 1e-6
    w.drag_along(p["amp"] * w.sc.drag * s**2 * np.exp(-p["onset"] / s**2 + p["onset"]))


@form("wave_drag", "havelock_hump", "force", 0.2, 1.5, centre=(1.15, 1.5), width=(0.15, 0.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Interference hump of bow and stern waves around one Froude number."""
    s = w.speed / w.sc.speed
    hump = np.exp(-0.5 * ((s - p["centre"]) / p["width"]) ** 2)
    w.drag_along(p["amp"] * w.sc.drag * s**2 * hump)


@form("wave_drag", "critical_depth_speed", "force", 0.2, 2.0, onset=(0.6, 0.9))
def _(w: Any, p: dict[str, float]) -> None:
    """Shallow-water rise: nothing below a speed, then as the excess to the power 1.5."""
    s = w.speed / w.sc.speed
    w.drag_along(p["amp"] * w.sc.drag * s * np.maximum(s - p["onset"], 0.0) ** 1.5)


@form("coulomb_friction", "constant", "force", 0.05, 0.5)
def _(w: Any, p: dict[str, float]) -> None:
    """Constant force against the motion over the ground."""
    u = w.velocity / w.sc.speed
    size = np.abs(u) + 1e-9
    w.force = w.force - p["amp"] * w.sc.drag * np.tanh(size / 0.03) * u / size


@form("coulomb_friction", "stribeck", "force", 0.08, 0.7, fall=(0.15, 0.5), rest=(0.2, 0.6))
def _(w: Any, p: dict[str, float]) -> None:
    """Friction that falls from a static to a kinetic value as the speed rises."""
    u = w.velocity / w.sc.speed
    size = np.abs(u) + 1e-9
    mu = p["rest"] + (1 - p["rest"]) * np.exp(-((size / p["fall"]) ** 2))
    w.force = w.force - p["amp"] * w.sc.drag * mu * np.tanh(size / 0.03) * u / size


@form("coulomb_friction", "pivot", "force", 0.05, 0.6)
def _(w: Any, p: dict[str, float]) -> None:
    """Constant moment against the yaw rate, as of a guide pin."""
    w.moment = w.moment - p["amp"] * w.sc.moment * smooth_sign(w.r, 0.05 * w.sc.rate)


@form("coulomb_friction", "dragging_line", "force", 0.05, 0.5, aft=(0.2, 0.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Constant friction at a point aft of the mass, against the motion of that point."""
    arm = -p["aft"] * w.sc.length
    point = (w.velocity + 1j * w.r * arm * w.core) / w.sc.speed
    size = np.abs(point) + 1e-9
    pull = -p["amp"] * w.sc.drag * np.tanh(size / 0.03) * point / size
    w.force = w.force + pull
    w.moment = w.moment + arm * (np.conj(w.core) * pull).imag


def _strips(w: Any, height: Any, power: float, amp: float) -> None:
    """Sum of sideways drag over strips from the hinge to the tail tip."""
    front, back = w.rb.hinge_to_com, w.rb.hinge_to_com - w.rb.core - w.rb.tail
    nodes = (np.arange(6) + 0.5) / 6
    for share in nodes:
        s = front + (back - front) * share
        local = (w.v + w.r * s) / w.sc.speed
        size = np.abs(local) + 1e-6
        load = 0.5 * w.rb.density * w.rb.span * w.sc.speed**2 * (front - back) / 6
        w.side_at(-amp * load * height(share) * local * size ** (power - 1), s)


@form("crossflow_drag", "uniform_strips", "force", 0.3, 3.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Square of the local sideways speed over core and tail of even height."""
    _strips(w, lambda _s: 1.0, 2.0, p["amp"])


@form("crossflow_drag", "tapered_strips", "force", 0.4, 4.0, taper=(0.6, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Height falling from the hinge towards the tail."""
    _strips(w, lambda s: 1.0 - p["taper"] * s, 2.0, p["amp"])


@form("crossflow_drag", "caudal_disc", "force", 0.4, 4.0, where=(0.8, 0.95))
def _(w: Any, p: dict[str, float]) -> None:
    """Sideways drag gathered on the caudal fin."""
    _strips(w, lambda s: 2.5 * np.exp(-(((s - p["where"]) / 0.15) ** 2)), 2.0, p["amp"])


@form("crossflow_drag", "inclined_cylinder", "force", 0.3, 3.0, exponent=(1.3, 1.7))
def _(w: Any, p: dict[str, float]) -> None:
    """Local sideways speed to a power below two, as on smooth cylinders at incidence."""
    _strips(w, lambda _s: 1.0, p["exponent"], p["amp"])
