"""Laws that change the head plate's lift (N), drag (N), moment (N m) and memory, or the masses.

`head` laws take and return (lift, drag, moment, change), change: rates of memory (2, ..., trials).
"""

from __future__ import annotations

import numpy as np

from .form import Array, Form, Situation

Plate = tuple[Array, Array, Array, Array]


def _with_share_lost(plate: Plate, lost: Array) -> Plate:
    """Lift and moment less a share; half of the lost lift becomes drag."""
    lift, drag, moment, change = plate
    return lift * (1 - lost), drag + 0.5 * np.abs(lift) * lost, moment * (1 - lost), change


def _excess(s: Situation) -> Array:
    """Angle between plate and flow, rad, 0 to pi/2."""
    return np.abs(np.arcsin(np.clip(np.sin(s.alpha), -1, 1)))


def stall_smooth_step(s: Situation, plate: Plate, k: float, onset: float, width: float) -> Plate:
    """Share k tanh-like beyond the onset (Stevens and Lewis 2003, ch. 2)."""
    return _with_share_lost(plate, k / (1 + np.exp(-(_excess(s) - onset) / width)))


def stall_kirchhoff(s: Situation, plate: Plate, k: float, onset: float, width: float) -> Plate:
    """Lift x ((1 + sqrt f)/2)^2, f the attached share (Leishman 2006, sec. 8.5)."""
    attached = 1 / (1 + np.exp((_excess(s) - onset) / width))
    return _with_share_lost(plate, k * (1 - ((1 + np.sqrt(attached)) / 2) ** 2))


def stall_goman_khrabrov(s: Situation, plate: Plate, k: float, onset: float, tau: float) -> Plate:
    """Kirchhoff with the attached share of first order, tau chords (Goman and Khrabrov 1994)."""
    detached = 1 - 1 / (1 + np.exp((_excess(s) - onset) / 0.06))
    lift, drag, moment, change = plate
    change = change.copy()
    change[0] = (detached - s.memory[0]) * (s.speed + 0.02) / (tau * s.lanes.head)
    attached = np.clip(1 - s.memory[0], 0, 1)
    lost = k * (1 - ((1 + np.sqrt(attached)) / 2) ** 2)
    return _with_share_lost((lift, drag, moment, change), lost)


def _with_lift(plate: Plate, lift: Array, change: Array) -> Plate:
    return lift, plate[1], plate[2], change


def lag_of_coefficient(s: Situation, plate: Plate, chords: float) -> Plate:
    """C_L follows sin(2 alpha) over a number of head lengths (Leishman 2006, sec. 8.3)."""
    change = plate[3].copy()
    change[0] = (
        (np.sin(2 * s.alpha) - s.memory[0]) * (s.speed + 0.02) / (abs(chords) * s.lanes.head)
    )
    return _with_lift(plate, s.q * s.robot.coefficients.C_La * s.memory[0], change)


def lag_of_circulation(s: Situation, plate: Plate, chords: float) -> Plate:
    """V sin(2 alpha) follows its value over head lengths (Katz and Plotkin 2001, sec. 13.7)."""
    change, wanted = plate[3].copy(), s.speed * np.sin(2 * s.alpha)
    change[0] = (wanted - s.memory[0]) * (s.speed + 0.02) / (abs(chords) * s.lanes.head)
    slope = s.q * s.robot.coefficients.C_La / np.maximum(s.speed, 1e-6)
    return _with_lift(plate, slope * s.memory[0], change)


def lag_of_jones(s: Situation, plate: Plate, k: float) -> Plate:
    """Two lags of Wagner's function, weights k x (0.165, 0.335) (Jones 1940, NACA report 681)."""
    change, wanted = plate[3].copy(), np.sin(2 * s.alpha)
    pace = (s.speed + 0.02) / (s.lanes.head / 2)
    change[0] = (wanted - s.memory[0]) * 0.0455 * pace
    change[1] = (wanted - s.memory[1]) * 0.3 * pace
    late = wanted * (1 - 0.5 * k) + k * (0.165 * s.memory[0] + 0.335 * s.memory[1])
    return _with_lift(plate, s.q * s.robot.coefficients.C_La * late, change)


def _asymmetry(plate: Plate, factor: Array) -> Plate:
    lift, drag, moment, change = plate
    return lift * factor, drag, moment * factor, change


def sides_step(s: Situation, plate: Plate, k: float) -> Plate:
    """Lift and moment x (1 + k sign alpha): one face rough (Hoerner and Borst 1975, ch. 2)."""
    return _asymmetry(plate, 1 + k * np.tanh(s.alpha / 0.02))


def sides_smooth(s: Situation, plate: Plate, k: float) -> Plate:
    """Lift and moment x (1 + k tanh(alpha/0.25)): cambered plate (Abbott and von Doenhoff)."""
    return _asymmetry(plate, 1 + k * np.tanh(s.alpha / 0.25))


def sides_large_angle(s: Situation, plate: Plate, k: float, onset: float) -> Plate:
    """Sides differ beyond an angle of attack only: edges of unequal radius (Polhamus 1966)."""
    beyond = 1 / (1 + np.exp(-(np.abs(s.alpha) - onset) / 0.05))
    return _asymmetry(plate, 1 + k * np.sign(s.alpha) * beyond)


def _accelerations(
    s: Situation, force: Array, yaw: Array, *, surge: float, sway: float, turn: float, munk: float
) -> tuple[Array, Array]:
    """Kirchhoff's equations in core axes (Lamb 1932, art. 124; Fossen 2011, sec. 6.3).

    surge, sway: added masses, kg. turn: added inertia, kg m^2. munk: share of the Munk moment.
    """
    m = s.robot.mass
    u_dot = (force.real + (m + sway) * s.v * s.r) / (m + surge)
    v_dot = (force.imag - (m + surge) * s.u * s.r) / (m + sway)
    r_dot = (yaw - munk * (sway - surge) * s.u * s.v) / (s.robot.inertia + turn)
    return (u_dot - s.v * s.r) + 1j * (v_dot + s.u * s.r), r_dot


def _core_inertia(s: Situation, added: float) -> float:
    return added * (s.robot.body_length - s.robot.head_length) ** 2 / 12


def added_slender(s: Situation, force: Array, yaw: Array, k: float) -> tuple[Array, Array]:
    """Sway mass k m and its inertia; no surge mass, half Munk (Lighthill 1970: sharp tail)."""
    sway = k * s.robot.mass
    return _accelerations(
        s, force, yaw, surge=0.0, sway=sway, turn=_core_inertia(s, sway), munk=0.5
    )


def added_ellipsoid(
    s: Situation, force: Array, yaw: Array, k: float, ratio: float
) -> tuple[Array, Array]:
    """Sway mass k m, surge mass ratio x that, full Munk moment (Lamb 1932, art. 114)."""
    sway = k * s.robot.mass
    turn = 0.8 * _core_inertia(s, sway)
    return _accelerations(s, force, yaw, surge=ratio * sway, sway=sway, turn=turn, munk=1.0)


def added_partial_munk(
    s: Situation, force: Array, yaw: Array, k: float, munk: float
) -> tuple[Array, Array]:
    """Masses of strips with a small share of the Munk moment (Newman 1977, sec. 7.2)."""
    sway = k * s.robot.mass
    turn = 1.3 * _core_inertia(s, sway)
    return _accelerations(s, force, yaw, surge=0.05 * sway, sway=sway, turn=turn, munk=munk)


def centre_fixed(phi: Array, d: float) -> Array:
    """Centre of mass d ahead of its stated place, m (ballast put elsewhere)."""
    return d + 0j * phi


def centre_swinging(phi: Array, d: float) -> Array:
    """Centre moves d sin phi to starboard: the head's mass turns with it (rigid geometry)."""
    return -1j * d * np.sin(phi)


def centre_drawn_back(phi: Array, d: float) -> Array:
    """Centre d cos phi ahead and d sin phi to starboard: a mass in the head (rigid geometry)."""
    return d * np.exp(-1j * phi)


_SY = ("sway", "yaw")
_ON = {"onset": (0.2, 0.35), "width": (0.03, 0.08)}
FORMS: tuple[Form, ...] = (
    Form("stall", stall_smooth_step, "head", "-", 0.2, 0.8, _SY, "alpha", shape=_ON),
    Form("stall", stall_kirchhoff, "head", "-", 0.4, 1.3, _SY, "alpha", shape=_ON),
    Form("stall", stall_goman_khrabrov, "head", "-", 0.4, 1.3, _SY, "alpha",
         shape={"onset": (0.2, 0.35), "tau": (1.0, 3.0)}),
    Form("lift_lag", lag_of_coefficient, "head", "chords", 0.6, 5.0, _SY, "history of alpha"),
    Form("lift_lag", lag_of_circulation, "head", "chords", 0.6, 5.0, _SY, "history of alpha, V"),
    Form("lift_lag", lag_of_jones, "head", "-", 0.8, 1.6, _SY, "history of alpha"),
    *(Form("port_starboard_asymmetry", law, "head", "-", 0.08, 0.6, _SY, "sign of alpha",
           signed=True) for law in (sides_step, sides_smooth)),
    Form("port_starboard_asymmetry", sides_large_angle, "head", "-", 0.1, 0.6, _SY,
         "sign of alpha", signed=True, shape={"onset": (0.12, 0.25)}),
    Form("added_mass", added_slender, "mass", "-", 0.2, 1.2, ("surge", "sway", "yaw"), "v r, u v"),
    Form("added_mass", added_ellipsoid, "mass", "-", 0.2, 1.2, ("surge", "sway", "yaw"),
         "v r, u v", shape={"ratio": (0.08, 0.2)}),
    Form("added_mass", added_partial_munk, "mass", "-", 0.2, 1.2, ("surge", "sway", "yaw"),
         "v r, u v", shape={"munk": (0.0, 0.4)}),
    *(Form("centre_of_mass_shift", law, "centre", "m", 0.008, 0.04, _SY, "side force of the head",
           signed=True) for law in (centre_fixed, centre_swinging, centre_drawn_back)),
)  # fmt: skip
