"""Thrust, frequency and head angle.

`thrust` laws take the situation and return a factor; `frequency` laws take time, lanes and return a
factor; `angle` laws take time and commanded angle and return the actual one, rad.
"""

from __future__ import annotations

import numpy as np

from .form import UNLISTED, Array, Form, Lanes, Situation


def _advance(s: Situation) -> Array:
    """Advance J = u/(f L), L the body length; no less than 0."""
    return np.maximum(s.u, 0) / (np.maximum(s.flap, 0.3) * s.robot.body_length)


def thrust_line_of_advance(s: Situation, k: float) -> Array:
    """1 - k J (Carlton 2018, ch. 6: thrust coefficient over advance)."""
    return 1 - k * _advance(s)


def thrust_parabola_of_advance(s: Situation, k: float) -> Array:
    """1 - k J^2 (Carlton 2018, ch. 6, parabola of an open-water curve)."""
    return 1 - k * _advance(s) ** 2


def thrust_exponential(s: Situation, k: float) -> Array:
    """exp(-k J), always positive (a fit to Triantafyllou et al. 1993, J. Fluids Struct. 7)."""
    return np.exp(-k * _advance(s))


def _area_factor(s: Situation, share: float, power: float) -> Array:
    ratio = s.lanes.head / s.robot.head_length
    return (1 - share) + share * ratio ** (-power)


def area_independent(s: Situation, share: float) -> Array:
    """A share of the thrust does not grow with the head (Lighthill 1960: thrust is the tail's)."""
    return _area_factor(s, share, 1.0)


def area_root(s: Situation, share: float) -> Array:
    """A share grows with the root of the head's area (scaling by length, Bainbridge 1958)."""
    return _area_factor(s, share, 0.5)


def area_falling(s: Situation, share: float) -> Array:
    """A share falls as the head grows: recoil takes the stroke (Lighthill 1970)."""
    return _area_factor(s, share, 1.6)


def sag_linear(t: Array, _: Lanes, loss: float) -> Array:
    """1 - loss t/20 s (Shepherd 1965, middle part of a discharge)."""
    return 1 - loss * np.asarray(t) / 20


def sag_exponential(t: Array, _: Lanes, loss: float, tau: float) -> Array:
    """1 - loss (1 - exp(-t/tau)): polarisation (Shepherd 1965, J. Electrochem. Soc. 112)."""
    return 1 - loss * (1 - np.exp(-np.asarray(t) / tau))


def sag_hyperbolic(t: Array, _: Lanes, loss: float, tau: float) -> Array:
    """1 - loss t/(t + tau) (Tremblay et al. 2007, IEEE VPPC)."""
    return 1 - loss * np.asarray(t) / (np.asarray(t) + tau)


def spin_first_order(t: Array, _: Lanes, tau: float) -> Array:
    """1 - exp(-t/tau) (Franklin et al. 2015, sec. 2.3, DC motor)."""
    return 1 - np.exp(-np.asarray(t) / abs(tau))


def spin_second_order(t: Array, _: Lanes, tau: float) -> Array:
    """1 - (1 + 2 t/tau) exp(-2 t/tau): motor and gear (Franklin et al. 2015, sec. 3.4)."""
    x = 2 * np.asarray(t) / abs(tau)
    return 1 - (1 + x) * np.exp(-x)


def spin_ramp(t: Array, _: Lanes, tau: float) -> Array:
    """min(t/tau, 1): speed controller with a slope limit."""
    return np.clip(np.asarray(t) / abs(tau), 0, 1)


def lag_first_order(t: Array, phi: Array, tau: float) -> Array:
    """Angle phi (1 - exp(-t/tau)) from a straight head (Franklin et al. 2015, sec. 3.3)."""
    return phi * (1 - np.exp(-np.asarray(t) / abs(tau)))


def lag_second_order(t: Array, phi: Array, tau: float) -> Array:
    """Angle phi (1 - (1 + 2 t/tau) exp(-2 t/tau)), critically damped."""
    x = 2 * np.asarray(t) / abs(tau)
    return phi * (1 - (1 + x) * np.exp(-x))


def lag_rate_limit(t: Array, phi: Array, tau: float) -> Array:
    """The head turns at a fixed rate of 30 deg in tau (data sheet of a hobby servo)."""
    gone = np.radians(30) / abs(tau) * np.asarray(t)
    return np.sign(phi) * np.minimum(np.abs(phi), gone)


def offset_constant(_: Array, phi: Array, size: float) -> Array:
    """Angle phi + size: horn of the servo mounted off zero."""
    return phi + size


def offset_backlash(_: Array, phi: Array, size: float) -> Array:
    """Angle phi - size tanh(phi/3 deg): play of a gear (Nordin and Gutman 2002, Automatica 38)."""
    return phi - size * np.tanh(phi / np.radians(3))


def offset_gain(_: Array, phi: Array, size: float) -> Array:
    """Angle phi (1 + size/30 deg): wrong gain of the servo, size at 30 degrees."""
    return phi * (1 + size / np.radians(30))


def bent_thrust(s: Situation, k: float) -> Array:
    """Unlisted. 1 - k sin^2 phi: the tail beats less while the head is turned."""
    return 1 - k * np.sin(s.phi) ** 2


def slipping_thrust(s: Situation, k: float, period: float) -> Array:
    """Unlisted. 1 + k sin(2 pi t/period): belt that slips and grips."""
    return 1 + k * np.sin(2 * np.pi * s.t / period)


_S, _SY, _Y = ("surge",), ("sway", "yaw"), ("yaw",)
FORMS: tuple[Form, ...] = (
    Form("thrust_loss_with_speed", thrust_line_of_advance, "thrust", "-", 0.4, 3.0, _S, "u/f"),
    Form("thrust_loss_with_speed", thrust_parabola_of_advance, "thrust", "-", 0.6, 8.0, _S, "u/f"),
    Form("thrust_loss_with_speed", thrust_exponential, "thrust", "-", 0.4, 4.0, _S, "u/f"),
    *(Form("thrust_area", law, "thrust", "-", 0.3, 1.0, _S, "head length")
      for law in (area_independent, area_root, area_falling)),
    Form("battery_sag", sag_linear, "frequency", "-", 0.05, 0.3, _S, "t"),
    Form("battery_sag", sag_exponential, "frequency", "-", 0.05, 0.3, _S, "t",
         shape={"tau": (4.0, 9.0)}),
    Form("battery_sag", sag_hyperbolic, "frequency", "-", 0.08, 0.35, _S, "t",
         shape={"tau": (5.0, 12.0)}),
    *(Form("motor_spin_up", law, "frequency", "s", 0.3, 3.0, _S, "t at the start")
      for law in (spin_first_order, spin_second_order, spin_ramp)),
    *(Form("servo_lag", law, "angle", "s", 0.3, 2.0, _SY, "t at the start x phi")
      for law in (lag_first_order, lag_second_order, lag_rate_limit)),
    Form("head_angle_offset", offset_constant, "angle", "rad", 0.03, 0.12, _SY, "phi", signed=True),
    Form("head_angle_offset", offset_backlash, "angle", "rad", 0.03, 0.12, _SY, "phi"),
    Form("head_angle_offset", offset_gain, "angle", "rad", 0.03, 0.12, _SY, "phi", signed=True),
    Form("unexplained", bent_thrust, "thrust", "-", 0.3, 1.5, _S, "phi", kind=UNLISTED),
    Form("unexplained", slipping_thrust, "thrust", "-", 0.1, 0.6, _S, "time", kind=UNLISTED,
         shape={"period": (3.0, 6.0)}),
)  # fmt: skip
