"""Laws of the head plate and of the mass: stall, lift lag, left-right difference, shifted mass."""

from __future__ import annotations

import numpy as np

from .form import Array, Cause, Family, Look, Quantity, Shape, Situation
from .robots import Robot


def _attached_lift(attached: Array) -> Array:
    """Kirchhoff's share of the lift with the flow attached up to a share of the chord."""
    return ((1 + np.sqrt(np.clip(attached, 0, 1))) / 2) ** 2


def _lost_lift(now: Situation, cause: Cause, alpha: Array) -> Array:
    """Share of the lift lost at the angle of attack alpha (rad)."""
    onset, width = cause.shape["onset_rad"], cause.shape["width_rad"]
    separated = 1 / (1 + np.exp(-np.clip((alpha - onset) / width, -60, 60)))
    if cause.form == "leishman_beddoes":
        below = 1 - 0.3 * np.exp(np.minimum(alpha - onset, 0) / width)
        above = 0.04 + 0.66 * np.exp(np.minimum(onset - alpha, 0) / (1.5 * width))
        return 1 - _attached_lift(np.where(alpha < onset, below, above))
    if cause.form == "kirchhoff":
        return 1 - _attached_lift(1 - separated)
    if cause.form == "goman_khrabrov":
        lost = now.memory[cause.rows][0]
        rate = (separated - lost) * now.speed / (cause.shape["chords"] * now.trials.head)
        now.memory_rates[cause.rows] = [rate]
        return 1 - _attached_lift(1 - lost)
    return separated


def _stall(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Lift lost above the onset angle; strength 1 is the full loss of the form, 0 none.

    smooth_step: logistic; kirchhoff: separation point; leishman_beddoes: its exponential separation
    curve; goman_khrabrov: separation follows within the time of `chords` chords (its memory is the
    separated share); moment_stall: only the moment is lost.
    """
    alpha = np.abs(now.alpha)
    alpha = np.minimum(alpha, np.pi - alpha)
    loss = _lost_lift(now, cause, alpha)
    now.C_M = now.C_M * (1 - strength * loss)
    if cause.form != "moment_stall":
        now.C_L = now.C_L * (1 - strength * loss)
    if cause.form == "smooth_step":
        now.C_D = now.C_D + 0.5 * strength * loss * (1 - np.cos(2 * alpha))


def _draw_stall(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Onset within the angles of attack of the robot's turns."""
    typical = robot.turning_alpha
    shape = {
        "onset_rad": round(float(typical * rng.uniform(0.75, 1.1)), 4),
        "width_rad": round(float(typical * rng.uniform(0.12, 0.25)), 4),
    }
    if form == "goman_khrabrov":
        shape["chords"] = round(rng.uniform(1, 4), 2)
    return shape


def _lift_lag(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Lift follows with a delay of `strength` chords travelled.

    coefficient: dC/dt = (C_quasi-steady - C) V/(s h); circulation: the same for C V; wagner_jones:
    R. T. Jones' two exponentials of Wagner's function, stretched in time (1: Wagner).
    """
    rate = now.speed / (np.maximum(strength, 1e-3) * now.trials.head)
    rows = cause.rows
    memory = now.memory[rows]
    if cause.form == "wagner_jones":
        slow = 0.0455 * 2 * rate * (now.C_L - memory[0])
        fast = 0.3 * 2 * rate * (now.C_L - memory[1])
        now.memory_rates[rows] = [slow, fast]
        now.C_L = 0.5 * now.C_L + 0.165 * memory[0] + 0.335 * memory[1]
    elif cause.form == "circulation":
        now.memory_rates[rows] = [rate * (now.C_L * now.speed - memory[0])]
        now.C_L = memory[0] / np.maximum(now.speed, 0.02 * now.robot.top_speed)
    else:
        now.memory_rates[rows] = [rate * (now.C_L - memory[0])]
        now.C_L = memory[0]


def _asymmetry(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Lift times 1 + s g(alpha): smoothed sign, tanh, only at large angles, or drag as well."""
    alpha, scale = now.alpha, cause.shape.get("a_0", 0.009)
    side = np.tanh(alpha / scale)
    if cause.form == "large_angle":
        excess = np.clip((np.abs(alpha) - scale) / (0.15 * scale), -60, 60)
        side = np.sign(alpha) / (1 + np.exp(-excess))
    now.C_L = now.C_L * (1 + strength * side)
    if cause.form == "with_drag":
        now.C_D = now.C_D * (1 + 0.5 * strength * side)


def _draw_asymmetry(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Angle of the form, rad."""
    if form == "tanh":
        return {"a_0": round(rng.uniform(0.04, 0.12), 3)}
    if form == "large_angle":
        return {"a_0": round(float(robot.turning_alpha * rng.uniform(0.6, 0.95)), 4)}
    return {}


def _shift(form: str, strength: Quantity, phi: Array) -> Array:
    """Centre of mass less its stated place, core axes, complex, m.

    It moves sideways with the head where the mass of the head swings out.
    """
    if form == "fixed":
        return -strength + 0 * phi + 0j
    if form == "along_with_head":
        return -strength * (1 - np.cos(phi)) / 0.3 + 0j
    return -1j * strength * np.sin(phi)


def _mass_plate(now: Situation, strength: Quantity, cause: Cause) -> None:
    """The arm of the plate grows by as much as the centre of mass lies further aft."""
    now.arm = now.arm - _shift(cause.form, strength, now.phi).real


def _mass_load(now: Situation, strength: Quantity, cause: Cause) -> None:
    """A centre of mass beside the core's axis gives the thrust an arm."""
    now.moment = now.moment + now.thrust * _shift(cause.form, strength, now.phi).imag


def _mass_body(look: Look, strength: Quantity, cause: Cause) -> None:
    """All labels keep their place on the robot, hence move against the true centre of mass."""
    look.offset = look.offset - _shift(cause.form, strength, look.phi)


FAMILIES = (
    Family(
        "stall", {"plate": _stall},
        ("smooth_step", "kirchhoff", "leishman_beddoes", "goman_khrabrov", "moment_stall"),
        channels=("sway", "yaw", "surge"), variable="alpha", unit="-",
        scale="1", span=(0.08, 1.0), memory={"goman_khrabrov": 1}, draw=_draw_stall,
    ),
    Family(
        "lift_lag", {"plate": _lift_lag}, ("coefficient", "circulation", "wagner_jones"),
        channels=("sway", "yaw"), variable="history of alpha, V", unit="chords",
        scale="1", span=(0.05, 5.0),
        memory={"coefficient": 1, "circulation": 1, "wagner_jones": 2},
    ),
    Family(
        "port_starboard_asymmetry", {"plate": _asymmetry},
        ("step", "tanh", "large_angle", "with_drag"),
        channels=("sway", "yaw"), variable="sign of alpha", unit="-",
        scale="1", span=(0.01, 0.5), parity="odd", signed=True, draw=_draw_asymmetry,
    ),
    Family(
        "centre_of_mass_shift",
        {"plate": _mass_plate, "load": _mass_load, "body": _mass_body},
        ("fixed", "along_with_head", "sideways_with_head"),
        channels=("yaw", "sway"), variable="side force of the head", unit="m",
        scale="L", span=(0.004, 0.13), signed=True,
    ),
)  # fmt: skip
