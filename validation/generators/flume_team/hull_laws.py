"""Forces on the hull: each law returns surge (N), sway (N) and moment (N m) in core axes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .form import REFERENCE_SPEED, UNLISTED, Array, Form, Situation
from .robots import DENSITY

Forces = tuple[Array, Array, Array]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


def _along_path(s: Situation, size: Array) -> Forces:
    """A force against the motion through the water."""
    speed = np.maximum(s.speed, 1e-9)
    return -size * s.u / speed, -size * s.v / speed, 0 * s.r


def _strip_drag(s: Situation, strength: float, power: float, taper: float) -> Forces:
    """-rho/2 C d(x) |w|^p sign(w) V0^(2-p) integrated from the tail base to the hinge."""
    robot = s.robot
    back = robot.body_length - robot.head_length - robot.hinge_to_com
    ends = (-back, robot.hinge_to_com)
    middle, half = sum(ends) / 2, (ends[1] - ends[0]) / 2
    sway, yaw = 0 * s.r, 0 * s.r
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        x = middle + half * node
        height = robot.span * (1 - taper * (1 - node) / 2)
        w = s.v + x * s.r
        force = height * np.sign(w) * np.abs(w) ** power * REFERENCE_SPEED ** (2 - power)
        part = -0.5 * DENSITY * strength * force * weight * half
        sway, yaw = sway + part, yaw + x * part
    return 0 * s.r, sway, yaw


def crossflow_square(s: Situation, c: float) -> Forces:
    """Square law on strips of equal height (Hoerner 1965, ch. 3-11; Faltinsen 2005, ch. 10)."""
    return _strip_drag(s, c, 2.0, 0.0)


def crossflow_power(s: Situation, c: float, power: float) -> Forces:
    """Power below 2 at low Reynolds number (Hoerner 1965, ch. 3-9, falling C_D)."""
    return _strip_drag(s, c, power, 0.0)


def crossflow_tapered(s: Situation, c: float, taper: float) -> Forces:
    """Strips that narrow towards the tail (Jorgensen 1977, NASA TR R-474)."""
    return _strip_drag(s, c, 2.0, taper)


def yaw_rate_linear(s: Situation, n: float) -> Forces:
    """-N r (Fossen 2011, sec. 6.4, linear damping)."""
    return 0 * s.u, 0 * s.u, -n * s.r


def yaw_rate_power(s: Situation, n: float) -> Forces:
    """-N r |r|^(1/2): laminar boundary layer on a turning hull (Schlichting 1979, ch. 7)."""
    return 0 * s.u, 0 * s.u, -n * s.r * np.sqrt(np.abs(s.r))


def yaw_rate_times_speed(s: Situation, n: float) -> Forces:
    """-N (V/V0) r (Newman 1977, sec. 7.5: rotary derivative at forward speed)."""
    return 0 * s.u, 0 * s.u, -n * s.speed / REFERENCE_SPEED * s.r


def drag_linear(s: Situation, d: float) -> Forces:
    """Force d V/V0 against the motion (Fossen 2011, sec. 6.4)."""
    return _along_path(s, d * s.speed / REFERENCE_SPEED)


def drag_blasius(s: Situation, d: float) -> Forces:
    """Force d (V/V0)^(3/2): laminar flat plate (Blasius 1908; Schlichting 1979, ch. 7)."""
    return _along_path(s, d * (s.speed / REFERENCE_SPEED) ** 1.5)


def drag_prandtl(s: Situation, d: float) -> Forces:
    """Force d (V/V0)^(9/5): turbulent flat plate, C_f ~ Re^(-1/5) (Prandtl 1921)."""
    return _along_path(s, d * (s.speed / REFERENCE_SPEED) ** 1.8)


def wave_fourth_power(s: Situation, d: float) -> Forces:
    """Force d (V/V0)^4: wave resistance of a shallow body (Hoerner 1965, ch. 11)."""
    return _along_path(s, d * (s.speed / REFERENCE_SPEED) ** 4)


def wave_sixth_power(s: Situation, d: float) -> Forces:
    """Force d (V/V0)^6 (Newman 1977, sec. 6.20, low-speed wave resistance)."""
    return _along_path(s, d * (s.speed / REFERENCE_SPEED) ** 6)


def wave_onset(s: Situation, d: float, onset: float) -> Forces:
    """Force d exp(2 - 2 onset^2/V^2): submerged body (Havelock 1917, Proc. R. Soc. A 93)."""
    return _along_path(s, d * np.exp(2 - 2 * np.minimum((onset / (s.speed + 1e-6)) ** 2, 200)))


def friction_tanh(s: Situation, d: float, width: float) -> Forces:
    """Force d tanh(V/width): smooth dry friction (Armstrong-Helouvry et al. 1994, Automatica)."""
    return _along_path(s, d * np.tanh(s.speed / width))


def friction_stribeck(s: Situation, d: float, fall: float) -> Forces:
    """Force d (1 + exp(-(V/fall)^2)) tanh(V/0.02) (Stribeck 1902; Armstrong-Helouvry 1994)."""
    return _along_path(s, d * (1 + np.exp(-((s.speed / fall) ** 2))) * np.tanh(s.speed / 0.02))


def friction_saturating(s: Situation, d: float, half: float) -> Forces:
    """Force d V/(V + half): dragging cable or surface film (Dahl 1968, in rate form)."""
    return _along_path(s, d * s.speed / (s.speed + half))


def trim_speed_squared(s: Situation, n: float) -> Forces:
    """Moment n (V/V0)^2: hull bent to one side (Hoerner and Borst 1975, ch. 11)."""
    return 0 * s.u, 0 * s.u, n * (s.speed / REFERENCE_SPEED) ** 2


def trim_surge_squared(s: Situation, n: float) -> Forces:
    """Moment n u|u|/V0^2: vertical tab on the hull (Fossen 2011, sec. 9.5, rudder at rest)."""
    return 0 * s.u, 0 * s.u, n * s.u * np.abs(s.u) / REFERENCE_SPEED**2


def trim_with_thrust(s: Situation, arm: float) -> Forces:
    """Moment arm x thrust: tail stroke with a bias (Yu et al. 2004, IEEE Trans. SMC B 34)."""
    return 0 * s.u, 0 * s.u, arm * s.thrust


def line_sine(s: Situation, arm: float) -> Forces:
    """Moment arm x T sin phi: thrust line past the centre (Fossen 2011, sec. 9.4, a jet)."""
    return 0 * s.u, 0 * s.u, arm * s.thrust * np.sin(s.phi)


def line_angle(s: Situation, arm: float) -> Forces:
    """Moment arm x T phi: first order of the line's shift with head angle."""
    return 0 * s.u, 0 * s.u, arm * s.thrust * s.phi


def line_double_angle(s: Situation, arm: float) -> Forces:
    """Moment arm x T sin(2 phi)/2: line and direction turn (Carlton 2018, ch. 6, oblique wake)."""
    return 0 * s.u, 0 * s.u, arm * s.thrust * np.sin(2 * s.phi) / 2


def _turned(s: Situation) -> Array:
    """Turns since the start, without sign."""
    return np.abs(s.psi - s.lanes.heading) / (2 * np.pi)


def _wake_pull(s: Situation, share: Array) -> Forces:
    drag = s.q * s.robot.coefficients.C_D0
    speed = np.maximum(s.speed, 1e-9)
    return share * drag * s.u / speed, share * drag * s.v / speed, 0 * s.r


def wake_logistic(s: Situation, k: float, width: float) -> Forces:
    """Drag less a share k logistic in turns, past one turn (Liao 2007, wake of bodies)."""
    return _wake_pull(s, k / (1 + np.exp(-(_turned(s) - 1) / width)))


def wake_ramp(s: Situation, k: float) -> Forces:
    """Share of drag lost grows from 0.7 turns to k at 1.3 turns, then stays."""
    return _wake_pull(s, k * np.clip((_turned(s) - 0.7) / 0.6, 0, 1))


def wake_saturating(s: Situation, k: float, turns: float) -> Forces:
    """Share k (1 - exp(-(n-0.8)/turns)): wakes of past turns add up (Schlichting 1979, ch. 24)."""
    return _wake_pull(s, k * (1 - np.exp(-np.maximum(_turned(s) - 0.8, 0) / turns)))


def tether_pull(s: Situation, k: float, across: float, along: float) -> Forces:
    """Unlisted. Spring force k d of a cable to a point above the pool at (across, along) of it."""
    place = (across * s.lanes.pool[0] - s.x) + 1j * (along * s.lanes.pool[1] - s.y)
    pull = k * place * np.exp(-1j * s.psi)
    return pull.real, pull.imag, 0 * s.r


def compass_moment(s: Situation, n: float, direction: float) -> Forces:
    """Unlisted. n sin(direction - psi): magnet of the motor above a steel floor."""
    return 0 * s.u, 0 * s.u, n * np.sin(direction - s.psi)


def pulsating_moment(s: Situation, n: float, period: float) -> Forces:
    """Unlisted. n sin(2 pi t / period): trapped air that rolls from side to side."""
    return 0 * s.u, 0 * s.u, n * np.sin(2 * np.pi * s.t / period) * (s.speed / REFERENCE_SPEED)


def _force_form(cause: str, law: Callable[..., Forces], *columns: Any, **rest: Any) -> Form:
    """A form that acts on the forces; columns and rest: the further fields of `Form`."""
    return Form(cause, law, "force", *columns, **rest)


_SY, _S, _Y = ("sway", "yaw"), ("surge",), ("yaw",)
FORMS: tuple[Form, ...] = (
    _force_form("crossflow_drag", crossflow_square, "-", 0.5, 2.0, _SY, "v + x r"),
    _force_form("crossflow_drag", crossflow_power, "-", 0.5, 2.0, _SY, "v + x r",
                shape={"power": (1.4, 1.8)}),
    _force_form("crossflow_drag", crossflow_tapered, "-", 0.6, 2.4, _SY, "v + x r",
                shape={"taper": (0.4, 0.9)}),
    _force_form("linear_yaw_damping", yaw_rate_linear, "N m s", 0.01, 0.5, _Y, "r"),
    _force_form("linear_yaw_damping", yaw_rate_power, "N m s^1.5", 0.01, 0.5, _Y, "r"),
    _force_form("linear_yaw_damping", yaw_rate_times_speed, "N m s", 0.01, 0.5, _Y, "V r"),
    *(_force_form("viscous_drag", law, "N", 0.03, 1.0, _S, "V")
      for law in (drag_linear, drag_blasius, drag_prandtl)),
    *(_force_form("wave_drag", law, "N", 0.01, 1.0, _S, "V")
      for law in (wave_fourth_power, wave_sixth_power)),
    _force_form("wave_drag", wave_onset, "N", 0.02, 1.0, _S, "V", shape={"onset": (0.25, 0.4)}),
    _force_form("coulomb_friction", friction_tanh, "N", 0.02, 0.3, _S, "V",
                shape={"width": (0.01, 0.03)}),
    _force_form("coulomb_friction", friction_stribeck, "N", 0.02, 0.3, _S, "V",
                shape={"fall": (0.08, 0.2)}),
    _force_form("coulomb_friction", friction_saturating, "N", 0.02, 0.3, _S, "V",
                shape={"half": (0.02, 0.06)}),
    *(_force_form("trim_moment", law, "N m", 0.001, 0.1, _Y, "V", signed=True)
      for law in (trim_speed_squared, trim_surge_squared)),
    _force_form("trim_moment", trim_with_thrust, "m", 0.002, 0.05, _Y, "thrust", signed=True),
    *(_force_form("thrust_line_offset", law, "m", 0.004, 0.06, _Y, "thrust x phi", signed=True)
      for law in (line_sine, line_angle, line_double_angle)),
    _force_form("wake_reentry", wake_logistic, "-", 0.1, 0.6, _S, "turns",
                shape={"width": (0.05, 0.15)}),
    _force_form("wake_reentry", wake_ramp, "-", 0.1, 0.6, _S, "turns"),
    _force_form("wake_reentry", wake_saturating, "-", 0.1, 0.6, _S, "turns",
                shape={"turns": (0.4, 1.2)}),
    _force_form("unexplained", tether_pull, "N/m", 0.005, 0.2, ("surge", "sway"), "position",
                kind=UNLISTED, shape={"across": (0.4, 0.6), "along": (0.3, 0.7)}),
    _force_form("unexplained", compass_moment, "N m", 0.001, 0.1, _Y, "heading", kind=UNLISTED,
                shape={"direction": (-3.0, 3.0)}),
    _force_form("unexplained", pulsating_moment, "N m", 0.001, 0.1, _Y, "time", kind=UNLISTED,
                shape={"period": (3.0, 6.0)}),
)  # fmt: skip
