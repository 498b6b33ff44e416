"""Head angle and mass laws: servo, angle offset, place of the mass, added mass."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form


def _turned(w: Any, p: dict[str, float], left: Any) -> None:
    """Leave a part `left` of the last step of the head angle; the step is a share `amp`."""
    w.phi = w.phi + p["amp"] * left * (w.k.phi_before - w.k.phi_cmd)


@form("servo_lag", "first_order", "command", 0.1, 1.0, tau=(0.15, 1.2))
def _(w: Any, p: dict[str, float]) -> None:
    """Exponential approach of the head angle from its former value."""
    _turned(w, p, np.exp(-w.t / (p["tau"] * w.sc.time)))


@form("servo_lag", "rate_limit", "command", 0.2, 1.0, rate=(0.05, 0.4))
def _(w: Any, p: dict[str, float]) -> None:
    """Constant turning rate of the servo: large steps take longer."""
    size = p["amp"] * np.abs(w.k.phi_before - w.k.phi_cmd) + 1e-9
    _turned(w, p, np.clip(1 - w.t * p["rate"] / (w.sc.time * size), 0, 1))


@form("servo_lag", "delayed_ease", "command", 0.1, 1.0, wait=(0.2, 0.6), span=(0.3, 2.0))
def _(w: Any, p: dict[str, float]) -> None:
    """A waiting time, then an eased movement."""
    span = p["span"] * w.sc.time
    s = np.clip((w.t - p["wait"] * span) / ((1 - p["wait"]) * span), 0, 1)
    _turned(w, p, 1 - s * s * (3 - 2 * s))


@form("servo_lag", "springy_joint", "command", 0.1, 1.0, damping=(0.3, 0.7), tau=(0.1, 0.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Second-order joint with overshoot."""
    s, z = w.t / (p["tau"] * w.sc.time), p["damping"]
    wd = np.sqrt(1 - z * z)
    _turned(w, p, np.exp(-z * s) * (np.cos(wd * s) + z / wd * np.sin(wd * s)))


@form("head_angle_offset", "constant", "command", 0.02, 0.2, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Horn mounted askew: the same error in all trials."""
    w.phi = w.phi + p["sign"] * p["amp"]


@form("head_angle_offset", "gain", "command", 0.05, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Angle too large or too small by a factor."""
    w.phi = w.phi + p["sign"] * p["amp"] * w.k.phi_cmd


@form("head_angle_offset", "backlash", "command", 0.02, 0.2, knee=(0.03, 0.1))
def _(w: Any, p: dict[str, float]) -> None:
    """Play: the head stops short on either side."""
    w.phi = w.phi - p["amp"] * np.tanh(w.k.phi_cmd / p["knee"])


@form("head_angle_offset", "yielding_joint", "command", 0.02, 0.3)
def _(w: Any, p: dict[str, float]) -> None:
    """The joint yields to the pressure on the head plate."""
    load = np.minimum((w.speed / w.sc.speed) ** 2, 4.0) * np.sin(2 * w.alpha)
    w.phi = w.phi + 2 * p["amp"] * load


@form("centre_of_mass_shift", "forward", "force", 0.02, 0.12, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """The mass lies ahead of or behind the stated place on the core axis."""
    w.com = w.com + p["sign"] * p["amp"] * w.sc.length


@form("centre_of_mass_shift", "sideways", "force", 0.004, 0.06, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """The mass lies to one side of the core axis."""
    w.com = w.com + 1j * p["sign"] * p["amp"] * w.sc.length


@form("centre_of_mass_shift", "heavy_head", "force", 0.02, 0.3)
def _(w: Any, p: dict[str, float]) -> None:
    """Part of the mass sits in the head and swings with it."""
    w.com = w.com + p["amp"] * 0.5 * w.k.head * np.exp(-1j * w.phi)


@form("centre_of_mass_shift", "taking_water", "force", 0.03, 0.15, side=(-0.4, 0.4))
def _(w: Any, p: dict[str, float]) -> None:
    """Leaking water moves the mass aft, and a little sideways, as the session goes on."""
    w.com = w.com - p["amp"] * w.sc.length * w.k.order * (1 + 0.2j * p["side"])


@form("added_mass", "spheroid", "force", 0.3, 2.5)
def _(w: Any, p: dict[str, float]) -> None:
    """Lamb's coefficients of a slender spheroid with the Munk moment."""
    m, inertia, a = w.rb.mass, w.rb.inertia, p["amp"]
    w.added = [0.08 * a * m, 0.85 * a * m, 0.0, 0.6 * a * inertia]


@form("added_mass", "entrained_wake", "force", 0.2, 2.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Water carried along in surge and, less, in sway; no rotation."""
    w.added = [p["amp"] * w.rb.mass, 0.3 * p["amp"] * w.rb.mass, 0.0, 0.0]


@form("added_mass", "head_plate", "force", 0.5, 4.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Added mass of the head plate alone, ahead of the centre of mass."""
    plate = p["amp"] * w.rb.density * np.pi / 4 * w.rb.span**2 * w.k.head
    arm = w.rb.hinge_to_com + 0.5 * w.k.head
    w.added = [0.0 * plate, plate, plate * arm, plate * (arm**2 + w.k.head**2 / 12)]


@form("added_mass", "slender_tail", "force", 0.5, 4.0, taper=(0.3, 0.8))
def _(w: Any, p: dict[str, float]) -> None:
    """Strip theory over core and tail of falling height."""
    front = w.rb.hinge_to_com
    span = w.rb.core + w.rb.tail
    sums = [0.0, 0.0, 0.0]
    for s in (np.arange(8) + 0.5) / 8:
        strip = (
            p["amp"] * w.rb.density * np.pi / 4 * (w.rb.span * (1 - p["taper"] * s)) ** 2 * span / 8
        )
        x = front - span * s
        sums = [sums[0] + strip, sums[1] + strip * x, sums[2] + strip * x * x]
    w.added = [0.0, *sums]
