"""Yaw laws: linear damping, trim, thrust line, and differences between port and starboard."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form, smooth_sign


@form("linear_yaw_damping", "constant_rate", "force", 0.1, 1.5)
def _(w: Any, p: dict[str, float]) -> None:
    """Moment proportional to yaw rate."""
    w.moment = w.moment - p["amp"] * w.sc.moment * w.r / w.sc.rate


@form("linear_yaw_damping", "beat_driven", "force", 0.1, 1.5, share=(0.7, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Linear in yaw rate, the factor growing with the flapping frequency."""
    gain = 1 - p["share"] + p["share"] * w.f / w.sc.frequency
    w.moment = w.moment - p["amp"] * w.sc.moment * gain * w.r / w.sc.rate


@form("linear_yaw_damping", "saturating", "force", 0.1, 1.2, knee=(0.3, 0.8))
def _(w: Any, p: dict[str, float]) -> None:
    """Linear at small yaw rate, levelling off beyond a knee."""
    s = w.r / (p["knee"] * w.sc.rate)
    w.moment = w.moment - p["amp"] * w.sc.moment * p["knee"] * s / (1 + np.abs(s))


@form("linear_yaw_damping", "speed_weighted", "force", 0.1, 1.5, power=(0.3, 0.7))
def _(w: Any, p: dict[str, float]) -> None:
    """Linear in yaw rate times a fractional power of speed."""
    gain = (w.speed / w.sc.speed) ** p["power"]
    w.moment = w.moment - p["amp"] * w.sc.moment * gain * w.r / w.sc.rate


@form("trim_moment", "constant", "force", 0.02, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Constant turning moment."""
    w.moment = w.moment + p["sign"] * p["amp"] * w.sc.moment


@form("trim_moment", "bent_body", "force", 0.02, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Moment of a cambered body, growing with the square of speed."""
    w.moment = w.moment + p["sign"] * p["amp"] * w.sc.moment * (w.speed / w.sc.speed) ** 2


@form("trim_moment", "uneven_stroke", "force", 0.02, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Moment of an uneven tail stroke, growing with the square of the frequency."""
    w.moment = w.moment + p["sign"] * p["amp"] * w.sc.moment * 2 * (w.f / w.sc.frequency) ** 2


@form("trim_moment", "trailing_lead", "force", 0.02, 0.4, sign=[-1, 1], power=(0.8, 1.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Moment of a lead on one side, about proportional to speed."""
    gain = (w.speed / w.sc.speed) ** p["power"]
    w.moment = w.moment + p["sign"] * p["amp"] * w.sc.moment * gain


def _thrust_arm(w: Any, arm: Any) -> None:
    """Moment of the thrust about the centre of mass for a given arm."""
    w.thrust_arm = w.thrust_arm + arm * w.sc.length


@form("thrust_line_offset", "sine", "force", 0.02, 0.3, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Arm as the sine of the head angle."""
    _thrust_arm(w, p["sign"] * p["amp"] * np.sin(w.phi))


@form("thrust_line_offset", "square", "force", 0.04, 0.5, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Arm as the head angle times its size."""
    _thrust_arm(w, p["sign"] * p["amp"] * w.phi * np.abs(w.phi))


@form("thrust_line_offset", "skin_stretch", "force", 0.01, 0.15, knee=(0.15, 0.35), sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Arm that is reached at small head angles and then stays."""
    _thrust_arm(w, p["sign"] * p["amp"] * np.tanh(w.phi / p["knee"]))


@form("thrust_line_offset", "linkage", "force", 0.03, 0.4, dead=(0.1, 0.25), sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Play in a linkage: no arm up to a dead angle, then in proportion."""
    excess = np.maximum(np.abs(w.phi) - p["dead"], 0) * np.sign(w.phi)
    _thrust_arm(w, p["sign"] * p["amp"] * excess)


@form("port_starboard_asymmetry", "lift", "force", 0.05, 0.6, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Lift of the head plate differs with the side of attack."""
    w.cl = w.cl * (1 + p["sign"] * p["amp"] * smooth_sign(w.alpha, 0.05))


@form("port_starboard_asymmetry", "yaw_damping", "force", 0.05, 0.6, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Yaw damping differs with the sense of turning."""
    w.cmd = w.cmd * (1 + p["sign"] * p["amp"] * smooth_sign(w.r, 0.1 * w.sc.rate))


@form("port_starboard_asymmetry", "thrust", "force", 0.03, 0.3, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Thrust differs with the side to which the head is turned."""
    w.thrust = w.thrust * (1 + p["sign"] * p["amp"] * np.sin(w.phi) / 0.5)


@form("port_starboard_asymmetry", "rough_side", "force", 0.2, 2.0, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """One rough flank: incidence drag and plate moment differ with the side of attack."""
    gain = p["sign"] * p["amp"] * smooth_sign(w.alpha, 0.05)
    w.cd = w.cd + gain * np.sin(w.alpha) ** 2
    w.cm = w.cm * (1 + 0.3 * gain)
