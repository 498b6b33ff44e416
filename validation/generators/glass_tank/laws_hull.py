"""Laws of the hull: fin, cross-flow, yaw damping, added mass, and drags along the path.

Strengths are forces in N (moments in N m) at the robot's own reference state: top speed V0 and
reference yaw rate r0. All of them except added mass only take energy out.
"""

from __future__ import annotations

import numpy as np

from .form import AddedMass, Array, Cause, Family, Quantity, Shape, Situation
from .robots import Robot

EPS = 1e-9
WATER_VISCOSITY = 1.0e-6
"""Kinematic viscosity, m2/s."""


def _side_force(now: Situation, force: Quantity, x: Quantity) -> None:
    """Add a force (N, to port) on the core's axis at x (m, ahead of the centre of mass)."""
    now.force = now.force + 1j * force * now.axis
    now.moment = now.moment + x * force


def _distributed_fin(now: Situation, strength: Quantity, x_fin: float) -> None:
    """The fin's force spread over five stations along the tail."""
    top = now.robot.top_speed
    stations, shares = np.linspace(-0.1, 1.15, 5), (0.08, 0.12, 0.2, 0.25, 0.35)
    for station, share in zip(stations, shares, strict=True):
        sideways = now.w - now.r * station * x_fin
        force = -strength * share * np.abs(now.u) * sideways / top**2
        _side_force(now, force, -station * x_fin)


def _fin_force(now: Situation, strength: Quantity, cause: Cause, w_fin: Array) -> Array:
    """Side force (N) for the sideways speed w_fin (m/s) at the fin."""
    top, ahead, shape = now.robot.top_speed, np.abs(now.u), cause.shape
    speed2 = now.u**2 + w_fin**2
    speed = np.sqrt(speed2)
    if cause.form in ("abs_u", "lighthill", "induced_drag"):
        return -strength * ahead * w_fin / top**2
    if cause.form == "speed":
        return -strength * speed * w_fin / top**2
    if cause.form == "polhamus":
        sine, cosine = w_fin / np.maximum(speed, EPS), ahead / np.maximum(speed, EPS)
        curve = sine * cosine**2 + shape["k_v"] * cosine * sine * np.abs(sine)
        return -strength * speed2 / top**2 * curve
    angle = np.arctan2(w_fin, ahead + EPS)
    return -strength * ahead * w_fin / top**2 / (1 + (angle / shape["stall_rad"]) ** 4)


def _fin(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Fin: side force -s |u| w_f / V0^2 and variants; w_f = w - r x_f the sideways speed there.

    strength: N per radian of drift at V0. Polhamus: sin a cos^2 a + k_v cos a sin^2 a, a the drift
    angle. Lighthill: momentum |u| w shed at the trailing edge. stalling: beyond stall_rad.
    Induced drag: k_i times the square of the side force over s (V/V0)^2.
    """
    top, x_fin = now.robot.top_speed, cause.shape["x_f"] * now.robot.body_length
    if cause.form == "distributed":
        _distributed_fin(now, strength, x_fin)
        return
    force = _fin_force(now, strength, cause, now.w - now.r * x_fin)
    if cause.form == "induced_drag":
        lift2 = cause.shape["k_i"] * force**2 * top**2 / np.maximum(strength, EPS)
        drag = lift2 / np.maximum(now.speed, 0.02 * top) ** 2 * now.direction
        now.force = now.force - drag
    _side_force(now, force, -x_fin)


def _draw_fin(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Position of the fin (body lengths behind the centre of mass) and shape of its curve."""
    shape = {"x_f": round(rng.uniform(0.42, 0.62), 3)}
    if form == "lighthill":
        shape["x_f"] = round(robot.tail_arm / robot.body_length, 3)
    if form == "polhamus":
        shape["k_v"] = round(rng.uniform(1.0, 2.5), 2)
    if form == "stalling":
        shape["stall_rad"] = round(rng.uniform(0.35, 0.7), 3)
    if form == "induced_drag":
        shape["k_i"] = round(rng.uniform(0.2, 0.6), 2)
    return shape


def _crossflow(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Sideways drag of sections from hinge to caudal base: -s g(w + x r); g = 1 at w = 0.3 V0.

    reynolds: the coefficient falls as Re^(-1/2) to its plateau.
    """
    reference = 0.3 * now.robot.top_speed
    places = np.linspace(now.robot.hinge_to_com, -now.robot.tail_arm, 6)
    tapered = cause.form == "tapered"
    shares = np.linspace(1.6, 0.4, 6) / 6 if tapered else np.full(6, 1 / 6)
    for x, share in zip(places, shares, strict=True):
        n = (now.w + x * now.r) / reference
        size = np.abs(n)
        if cause.form == "power":
            factor = n * size ** (cause.shape["power"] - 1)
        elif cause.form == "reynolds":
            factor = n * size * (0.6 + 0.4 / np.sqrt(size + 1e-3))
        else:
            factor = n * size
        _side_force(now, -strength * share * factor, x)


def _draw_crossflow(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Power of the speed."""
    return {"power": round(rng.uniform(1.4, 1.8), 2)} if form == "power" else {}


def _yaw_damping(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Moment -s r/r0, -s (r/r0) |r/r0|^(1/2), or -s (V/V0) (r/r0)."""
    robot = now.robot
    n = now.r / robot.reference_yaw_rate
    if cause.form == "power_1_5":
        factor = n * np.sqrt(np.abs(n))
    elif cause.form == "speed":
        factor = n * now.speed / robot.top_speed
    else:
        factor = n
    now.moment = now.moment - strength * factor


def _added_mass(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Added mass in the frame of the core; strength: sideways added mass over mass.

    slender_body: only sideways sections; ellipsoid: Lamb's ratio of the axial mass; strip: the
    centre of the sections beside the centre of mass; partial_munk: viscosity leaves part of the
    moment.
    """
    length, shape = now.robot.body_length, cause.shape
    sway = strength * now.robot.mass + 0 * now.speed
    surge = shape.get("axial", 0.0) * sway
    yaw = sway * (shape["gyration"] * length) ** 2
    coupling = sway * shape.get("centre", 0.0) * length
    now.added = AddedMass(surge, sway, yaw, coupling, shape.get("munk", 1.0))


def _draw_added_mass(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Radius of gyration of the added mass (body lengths) and the peculiarity of the form.

    The ranges of the other forms are drawn from as well, so that the draws that follow do not
    depend on the form.
    """
    shape = {"gyration": round(rng.uniform(0.17, 0.24), 3)}
    own = {
        "ellipsoid": {"axial": round(rng.uniform(0.06, 0.2), 3)},
        "strip": {"centre": round(rng.uniform(-0.08, 0.08), 3)},
        "partial_munk": {"munk": round(rng.uniform(0.2, 0.6), 2)},
    }
    return shape | own.get(form, {})


def _viscous(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Drag -s g(V/V0) along the path: powers, or the ITTC 1957 friction line.

    ITTC: V^2 0.075/(log10 Re - 2)^2. at_head: linear, at the middle of the head plate.
    """
    robot, top = now.robot, now.robot.top_speed
    n = now.speed / top
    if cause.form == "at_head":
        arm = robot.hinge_to_com * now.axis + 0.5 * now.trials.head * now.head_axis
        force = -strength * (now.relative + 1j * now.r * arm) / top
        now.force = now.force + force
        now.moment = now.moment + (np.conj(arm) * force).imag
        return
    if cause.form == "ittc":
        reynolds = top * robot.body_length / WATER_VISCOSITY
        line = (np.log10(reynolds) - 2) / (np.log10(reynolds * np.maximum(n, 0.01)) - 2)
        factor = n**2 * line**2
    else:
        factor = n ** {"linear": 1.0, "power_1_5": 1.5, "power_1_8": 1.8}[cause.form]
    now.force = now.force - strength * factor * now.direction


def _wave(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Drag -s g(V/V0) along the path: V^4, V^6, a hump on V^2 (Havelock), or an onset."""
    n, shape = now.speed / now.robot.top_speed, cause.shape
    if cause.form == "hump":
        factor = n**2 * np.exp(-(((n - shape["n_h"]) / shape["width"]) ** 2))
    elif cause.form == "onset":
        factor = (np.maximum(n - shape["n_h"], 0) / (1 - shape["n_h"])) ** 2
    else:
        factor = n ** {"power_4": 4, "power_6": 6}[cause.form]
    now.force = now.force - strength * factor * now.direction


def _draw_wave(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Speed over top speed of the hump or of the onset, and width of the hump.

    Both are drawn for every form, so that the draws that follow do not depend on it.
    """
    hump = {"n_h": round(rng.uniform(0.6, 0.9), 2), "width": round(rng.uniform(0.12, 0.25), 2)}
    onset = {"n_h": round(rng.uniform(0.35, 0.6), 2)}
    return {"hump": hump, "onset": onset}.get(form, {})


def _coulomb(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Drag -s g(V) along the path that tends to s: sign, tanh, Stribeck, or V/(V + n_c V0)."""
    n, shape = now.speed / now.robot.top_speed, cause.shape
    if cause.form == "sign":
        factor = n / np.sqrt(n**2 + 0.01**2)
    elif cause.form == "tanh":
        factor = np.tanh(n / shape["n_c"])
    elif cause.form == "stribeck":
        decay = np.exp(-((n / shape["n_c"]) ** 2))
        factor = n / np.sqrt(n**2 + 0.01**2) * (0.6 + 0.4 * decay)
    else:
        factor = n / (n + shape["n_c"])
    now.force = now.force - strength * factor * now.direction


def _draw_coulomb(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Speed over top speed at which the form changes."""
    return {"n_c": round(rng.uniform(0.06, 0.2), 3)} if form != "sign" else {}


FAMILIES = (
    Family(
        "tail_fin_lift", {"load": _fin},
        ("abs_u", "speed", "polhamus", "lighthill", "stalling", "distributed", "induced_drag"),
        channels=("sway", "yaw"), variable="w - x_f r, u", unit="N", scale="T", span=(0.05, 60.0),
        draw=_draw_fin,
    ),
    Family(
        "crossflow_drag", {"load": _crossflow}, ("quadratic", "power", "tapered", "reynolds"),
        channels=("sway", "yaw"), variable="w + x r", unit="N", scale="T", span=(0.04, 1.3),
        draw=_draw_crossflow,
    ),
    Family(
        "linear_yaw_damping", {"load": _yaw_damping}, ("linear", "power_1_5", "speed"),
        channels=("yaw",), variable="r", unit="N m", scale="TL", span=(0.005, 0.6),
    ),
    Family(
        "added_mass", {"inertia": _added_mass},
        ("slender_body", "ellipsoid", "strip", "partial_munk"),
        channels=("surge", "sway", "yaw"), variable="accelerations, w r, u r, u w",
        unit="-", scale="1", span=(0.08, 1.1), draw=_draw_added_mass,
    ),
    Family(
        "viscous_drag", {"load": _viscous},
        ("linear", "power_1_5", "power_1_8", "ittc", "at_head"),
        channels=("surge", "sway"), variable="V", unit="N", scale="T", span=(0.02, 1.0),
    ),
    Family(
        "wave_drag", {"load": _wave}, ("power_4", "power_6", "hump", "onset"),
        channels=("surge", "sway"), variable="V", unit="N", scale="T", span=(0.03, 0.9),
        draw=_draw_wave,
    ),
    Family(
        "coulomb_friction", {"load": _coulomb}, ("sign", "tanh", "stribeck", "saturating"),
        channels=("surge", "sway"), variable="V", unit="N", scale="T", span=(0.01, 0.13),
        draw=_draw_coulomb,
    ),
)  # fmt: skip
