"""Laws of the pool: currents, gyres, walls, the robot's own wake, and sinking."""

from __future__ import annotations

import numpy as np

from .form import Array, Cause, Family, Look, Quantity, Shape, Situation
from .robots import Robot


def _current(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Current of speed `strength` (m/s): constant, turning over the session, or sheared in y."""
    to = cause.shape["to_rad"]
    if cause.form == "drifting":
        to = to + cause.shape["turn_rad"] * now.trials.session
    sheared = cause.form == "sheared"
    factor = 0.3 + 0.7 * now.y / now.robot.pool[1] if sheared else 1.0
    now.water = now.water + strength * factor * np.exp(1j * to)


def _draw_current(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Direction of the current, along the pool if sheared, and its turn over the session."""
    if form == "sheared":
        return {"to_rad": round(rng.choice([0, np.pi]) + rng.uniform(-0.3, 0.3), 3)}
    shape = {"to_rad": round(rng.uniform(-np.pi, np.pi), 3)}
    if form == "drifting":
        shape["turn_rad"] = round(rng.uniform(0.7, 1.8), 2)
    return shape


def _cell_flow(now: Situation, cells: int) -> Array:
    """Flow of cells side by side along the pool, largest speed 1; u = d/dy, v = -d/dx of psi."""
    length, width = now.robot.pool
    X, Y = np.pi * now.x / length, np.pi * now.y / width
    top = max(1 / width, cells / length)
    across = 1j * cells * np.cos(cells * X) * np.sin(Y) / length / top
    return np.sin(cells * X) * np.cos(Y) / width / top - across


def _gyre(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Standing circulation with the largest speed `strength` (m/s).

    One or two cells, solid body, Gaussian or Scully vortex.
    """
    length, width = now.robot.pool
    if cause.form in ("cell", "two_cells"):
        flow = _cell_flow(now, 2 if cause.form == "two_cells" else 1)
    else:
        shape = cause.shape
        away = now.x + 1j * now.y - complex(shape["x_c"] * length, shape["y_c"] * width)
        core = shape["core"] * width
        n = np.abs(away) / core
        if cause.form == "solid_body":
            factor = np.where(n < 1, 1.0, np.exp(-((n - 1) ** 2)))
        elif cause.form == "gaussian":
            factor = np.exp(0.5 - n**2 / 2)
        else:
            factor = 2 / (1 + n**2)
        flow = 1j * away / core * factor
    now.water = now.water + strength * flow


def _draw_gyre(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Centre of a vortex, in shares of length and width, and its core, in widths."""
    if "cell" in form:
        return {}
    return {
        "x_c": round(rng.uniform(0.4, 0.6), 2),
        "y_c": round(rng.uniform(0.4, 0.6), 2),
        "core": round(rng.uniform(0.2, 0.45), 2),
    }


def _pull(form: str, gap: Array, reach: float) -> Array:
    """Decay of the pull with the gap (m) to the wall."""
    if form == "exponential":
        return np.exp(-gap / reach)
    if form == "gaussian":
        return np.exp(-((gap / reach) ** 2))
    return (reach / gap) ** 2


def _wall(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Pull s (V/V0)^2 g(gap) to each wall a quarter body length ahead; half of it as drag.

    g: exp(-gap/d), (d/gap)^2, Gaussian; image_suction is (d/gap)^2 without drag and at the centre.
    """
    robot, (length, width) = now.robot, now.robot.pool
    reach, speed2 = cause.shape["reach"] * robot.body_length, (now.speed / robot.top_speed) ** 2
    pull: Quantity = 0j
    near: Quantity = 0.0
    inside = (now.x > 0) & (now.x < length) & (now.y > 0) & (now.y < width)
    speed2 = speed2 * inside
    walls = ((now.x, -1), (length - now.x, 1), (now.y, -1j), (width - now.y, 1j))
    for distance, to in walls:
        factor = _pull(cause.form, np.maximum(distance, 0.2 * robot.body_length), reach)
        pull, near = pull + to * factor, near + factor
    force = strength * speed2 * pull
    if cause.form != "image_suction":
        arm = 0.25 * robot.body_length * now.axis
        now.moment = now.moment + (np.conj(arm) * force).imag
        force = force - 0.5 * strength * speed2 * near * now.direction
    now.force = now.force + force


def _draw_wall(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Reach of the wall, body lengths."""
    low, high = (0.5, 0.9) if form in ("exponential", "gaussian") else (0.3, 0.5)
    return {"reach": round(rng.uniform(low, high), 3)}


def _wake(now: Situation, strength: Quantity, cause: Cause) -> None:
    """After a full circle the water moves with the share s g(turns) of the robot's velocity.

    logistic at one turn, ramp, saturating, or fading with the age of the wake.
    """
    turns = np.abs(now.psi - now.trials.heading) / (2 * np.pi)
    logistic = 1 + np.exp(-np.clip((turns - 1) / 0.08, -60, 60))
    if cause.form == "logistic":
        factor = 1 / logistic
    elif cause.form == "ramp":
        factor = np.clip((turns - 0.8) / 1.2, 0, 1)
    elif cause.form == "saturating":
        factor = 1 - np.exp(-np.maximum(turns - 0.85, 0) / 0.4)
    else:
        age = 2 * np.pi / np.maximum(np.abs(now.r), 0.05)
        factor = np.exp(-age / cause.shape["life_s"]) / logistic
    now.water = now.water + strength * factor * now.velocity


def _draw_wake(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Time constant of the wake."""
    return {"life_s": round(rng.uniform(10, 25), 1)} if form == "age" else {}


def _sunk(strength: Quantity, cause: Cause, t: Array) -> Array:
    """Depth gained (m) at time t (s) for the sinking speed `strength` (m/s)."""
    t = np.maximum(t, 0)
    if cause.form == "saturating":
        tau = cause.shape["tau_s"]
        return strength * (tau * (1 - np.exp(-t / tau)))
    return strength * (t if cause.form == "linear" else t * t / 12)


def _sink_plate(now: Situation, strength: Quantity, cause: Cause) -> None:
    """The deeper the hull, the larger its wetted part: C_D0 grows by kappa a span of depth."""
    growth = now.C_D0 * cause.shape["kappa"]
    now.C_D = now.C_D + growth * _sunk(strength, cause, now.t) / now.robot.span


def _sink_depth(look: Look, strength: Quantity, cause: Cause) -> None:
    """The labels lie deeper and look smaller."""
    look.depth = look.depth + _sunk(strength, cause, look.clock.t)


def _draw_sinking(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Growth of the drag, and time constant of the saturating form."""
    shape = {"kappa": round(rng.uniform(0.15, 0.6), 2)}
    if form == "saturating":
        shape["tau_s"] = round(rng.uniform(3, 8), 1)
    return shape


FAMILIES = (
    Family(
        "uniform_current", {"flow": _current}, ("constant", "drifting", "sheared"),
        channels=("surge", "sway", "yaw"), variable="pool axes", unit="m/s",
        scale="V", span=(0.003, 0.15), parity="pool", draw=_draw_current,
    ),
    Family(
        "pool_gyre", {"flow": _gyre}, ("cell", "solid_body", "gaussian", "scully", "two_cells"),
        channels=("surge", "sway", "yaw"), variable="x, y", unit="m/s",
        scale="V", span=(0.005, 0.15), parity="pool", signed=True, draw=_draw_gyre,
    ),
    Family(
        "wall_effect", {"load": _wall}, ("exponential", "power", "gaussian", "image_suction"),
        channels=("surge", "sway", "yaw"), variable="gap", unit="N",
        scale="T", span=(0.03, 1.2), parity="pool", draw=_draw_wall,
    ),
    Family(
        "wake_reentry", {"flow": _wake}, ("logistic", "ramp", "saturating", "age"),
        channels=("surge", "sway"), variable="turns", unit="-",
        scale="1", span=(0.01, 0.35), draw=_draw_wake,
    ),
    Family(
        "sinking", {"plate": _sink_plate, "depth": _sink_depth},
        ("linear", "quadratic", "saturating"),
        channels=("surge",), variable="t", unit="m/s",
        scale="Z", span=(0.001, 0.025), draw=_draw_sinking,
    ),
)  # fmt: skip
