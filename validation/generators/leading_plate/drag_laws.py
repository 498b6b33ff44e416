"""Laws of resistance, of yaw damping and of the water that is carried along."""

from __future__ import annotations

import numpy as np

from .here import Family, Here, Law
from .robots import Array

NODES, WEIGHTS = np.polynomial.legendre.leggauss(7)


def _viscous(law: Law, here: Here) -> None:
    force, ratio = law.size * here.robot.drag, here.speed / here.robot.speed
    if law.form == "reynolds_power":  # laminar boundary layer
        here.resist(force * ratio**1.5)
    elif law.form == "along_core":  # skin friction of core and tail, in their own direction
        here.push_core(-force * here.core.real / here.robot.speed)
    else:
        here.resist(force * ratio)


def _wave(law: Law, here: Here) -> None:
    force, ratio = law.size * here.robot.drag, here.speed / here.robot.speed
    if law.form == "sixth_power":
        here.resist(force * ratio**6)
    elif law.form == "hump":  # Havelock: resistance rises steeply towards a hump
        here.resist(force * ratio**2 * np.exp(2.2 * (1 - 1 / np.maximum(ratio, 0.05) ** 2)))
    else:
        here.resist(force * ratio**4)


def _coulomb(law: Law, here: Here) -> None:
    slow = (0.03 + 0.04 * law.shape[0]) * here.robot.speed
    force = law.size * here.robot.drag
    if law.form == "stribeck":
        share = np.tanh(here.speed / slow) * (1 + 0.7 * np.exp(-((here.speed / (6 * slow)) ** 2)))
    elif law.form == "saturating":
        share = here.speed / (here.speed + 2 * slow)
    else:
        share = np.tanh(here.speed / slow)
    here.resist(force * share)


def _yaw_damping(law: Law, here: Here) -> None:
    robot = here.robot
    unit = law.size * robot.drag * robot.body_length
    rate = here.rate * robot.body_length / robot.speed
    if law.form == "power":
        damping = rate * np.sqrt(np.abs(rate) + 1e-9)
    elif law.form == "with_speed":
        damping = rate * here.speed / robot.speed
    else:
        damping = rate
    here.moment = here.moment - unit * damping


def _crossflow(law: Law, here: Here) -> None:
    robot = here.robot
    length = robot.core_length + robot.tail_length
    force = np.zeros_like(here.rate)
    moment = np.zeros_like(here.rate)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        behind = length * (1 + node) / 2
        width, across = 1.0, here.core.imag - behind * here.rate
        if law.form == "tapered":
            width = 2 * (1 - behind / length) + 0.1
        power = 0.7 if law.form == "reynolds_power" else 1.0
        flow = across * np.abs(across / robot.speed + 1e-9) ** power * robot.speed**-1
        part = -0.5 * weight * width * law.size * 8 * robot.drag * flow
        force, moment = force + part, moment - behind * part
    here.push_core(0.0, force)
    here.moment = here.moment + moment


def _added_mass(law: Law, here: Here) -> None:
    robot = here.robot
    sway_added_mass, yaw_added_inertia = law.size * robot.mass, 0.8 * law.size * robot.inertia
    surge_added_mass = 0.12 * sway_added_mass
    if law.form == "strip":  # strips of the core behind the centre of mass couple sway and yaw
        here.masses = (
            0.0,
            sway_added_mass,
            yaw_added_inertia,
            -0.25 * sway_added_mass * robot.core_length,
            1.0,
        )
    elif law.form == "reduced_munk":  # separation leaves a part of the pure moment
        here.masses = (
            surge_added_mass,
            sway_added_mass,
            yaw_added_inertia,
            0.0,
            0.3 + 0.4 * law.shape[0],
        )
    else:
        here.masses = (surge_added_mass, sway_added_mass, yaw_added_inertia, 0.0, 1.0)


def _stall(law: Law, here: Here) -> None:
    onset, sine = 0.2 + 0.15 * law.shape[0], np.abs(here.side_slip)
    if law.form == "kirchhoff":  # flow attached over a share of the chord
        attached = 1 / (1 + np.exp(np.clip((sine - onset) / 0.05, -50, 50)))
        lost = 1 - 0.25 * (1 + np.sqrt(attached)) ** 2
        lost = lost / 0.75
    elif law.form == "beddoes":  # exponential loss beyond the onset
        lost = np.where(sine > onset, 1 - np.exp(-np.maximum(sine - onset, 0) / 0.12), 0.0)
    else:
        x = np.clip((sine - onset + 0.08) / 0.2, 0, 1)
        lost = x**2 * (3 - 2 * x)
    _add_lift(here, -law.size * lost)


def _add_lift(here: Here, share: Array) -> None:
    here.force = here.force + share * here.lift
    here.moment = here.moment + share * here.twist


def _lift_lag(law: Law, here: Here) -> None:
    """Lift follows its angle of attack late; `lagged` holds delayed values of sin 2 alpha."""
    slow, fast = here.lagged
    sine = 2 * here.side_slip * here.flow.real / here.speed
    if law.form == "two_lags":  # Wagner's function with two exponentials
        late = 0.4 * slow + 0.6 * fast
    elif law.form == "quick":
        late = fast
    else:
        late = slow
    missing = law.size * (late - sine)
    half = 500.0 * here.setting.head * here.robot.head_span * here.speed**2
    extra = half * here.setting.coefficients[3] * missing * 1j * here.flow / here.speed
    here.force = here.force + extra
    moment = half * here.setting.coefficients[4] * missing
    here.moment = here.moment + extra.imag * here.arm + moment


def _asymmetry(law: Law, here: Here) -> None:
    sine = here.side_slip
    if law.form == "large_angles":
        share = np.sign(sine) * np.clip((np.abs(sine) - 0.08) / 0.2, 0, 1)
    elif law.form == "lift_and_drag":
        share = np.tanh(sine / 0.1)
        here.resist(0.5 * law.side * law.size * share * np.abs(here.lift))
    else:
        share = np.tanh(sine / (0.03 + 0.05 * law.shape[0]))
    _add_lift(here, law.side * law.size * share)


DRAG_FAMILIES = (
    Family("viscous_drag", "load", _viscous, ("linear", "reynolds_power", "along_core"),
           0.02, 1.0, "1", "share of the drag at full speed", 0.1),
    Family("wave_drag", "load", _wave, ("fourth_power", "sixth_power", "hump"),
           0.02, 1.0, "1", "share of the drag at full speed", 0.1),
    Family("coulomb_friction", "load", _coulomb, ("tanh", "stribeck", "saturating"),
           0.005, 0.25, "1", "share of the drag at full speed", 0.02),
    Family("linear_yaw_damping", "load", _yaw_damping, ("linear", "power", "with_speed"),
           0.01, 1.2, "1", "moment over drag times length at one speed per length", 0.1),
    Family("crossflow_drag", "load", _crossflow, ("quadratic", "reynolds_power", "tapered"),
           0.03, 2.0, "1", "size relative to the drag", 0.2),
    Family("added_mass", "load", _added_mass, ("ellipsoid", "strip", "reduced_munk"),
           0.03, 0.9, "1", "sideways added mass over mass", 0.1),
    Family("stall", "load", _stall, ("smooth_step", "kirchhoff", "beddoes"),
           0.05, 0.9, "1", "share of lift lost", 0.2),
    Family("lift_lag", "load", _lift_lag, ("slow", "two_lags", "quick"),
           0.1, 1.3, "1", "share of lift that lags", 0.2),
    Family("port_starboard_asymmetry", "load", _asymmetry,
           ("step", "large_angles", "lift_and_drag"),
           0.01, 0.5, "1", "share of lift", 0.05),
)  # fmt: skip
