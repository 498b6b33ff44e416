"""Laws of moving water, of walls, and of moments about the centre of mass."""

from __future__ import annotations

import numpy as np

from .here import Complex, Family, Here, Law


def _current(law: Law, here: Here) -> None:
    angle = 2 * np.pi * law.shape[0]
    speed = law.size * here.robot.speed
    if law.form == "sheared":
        offset = here.place.imag if abs(np.cos(angle)) > 0.7 else here.place.real
        width = here.pool[1] if abs(np.cos(angle)) > 0.7 else here.pool[0]
        speed = speed * (0.5 + offset / width)
    elif law.form == "drifting":
        speed = speed * (0.6 + 0.8 * here.setting.order)
    here.water = here.water + speed * np.exp(1j * angle)


def _from_centre(law: Law, here: Here) -> Complex:
    length, width = here.pool
    shift = complex(0.15 * (law.shape[0] - 0.5) * length, 0.15 * (law.shape[1] - 0.5) * width)
    return here.place - complex(length / 2, width / 2) - shift


def _gyre(law: Law, here: Here) -> None:
    length, width = here.pool
    speed = law.side * law.size * here.robot.speed
    away = _from_centre(law, here)
    if law.form == "solid_body":
        flow = 1j * away / (width / 2)
    elif law.form == "vortex":  # Lamb and Oseen
        core = 0.22 * width
        distance = np.abs(away) + 1e-6
        swirl = 1.57 * core / distance * (1 - np.exp(-((distance / core) ** 2)))
        flow = 1j * away / distance * swirl
    else:  # one cell that fills the pool
        x = np.pi * np.clip(here.place.real / length, 0, 1)
        y = np.pi * np.clip(here.place.imag / width, 0, 1)
        flow = -np.sin(x) * np.cos(y) + 1j * width / length * np.cos(x) * np.sin(y)
    here.water = here.water + speed * flow


def _walls(law: Law, here: Here) -> None:
    length, width = here.pool
    reach = (0.35 + 0.45 * law.shape[0]) * here.robot.body_length
    x, y = here.place.real, here.place.imag
    size = law.size * here.robot.drag * (here.speed / here.robot.speed) ** 2
    push, near = 0j, 0.0
    for gap, inward in ((x, 1), (length - x, -1), (y, 1j), (width - y, -1j)):
        free = np.maximum(gap, 0.05 * here.robot.body_length)
        share = (reach / (reach + free)) ** 3 * 2 if law.form == "power" else np.exp(-free / reach)
        push, near = push + share * inward, near + share
    if law.form == "drag":  # blockage: resistance grows near a wall
        here.resist(1.5 * size * near)
    else:
        attract = -1 if law.form == "power" else 1
        here.force = here.force + attract * size * push * np.exp(-1j * here.theta)


def _trim(law: Law, here: Here) -> None:
    robot = here.robot
    if law.form == "with_thrust":
        load = here.thrust
    elif law.form == "along_core":
        load = robot.drag * here.core.real * np.abs(here.core.real) / robot.speed**2
    else:
        load = robot.drag * (here.speed / robot.speed) ** 2
    here.moment = here.moment + law.side * law.size * robot.body_length * load


def _thrust_line(law: Law, here: Here) -> None:
    if law.form == "double_angle":
        lever = 0.5 * np.sin(2 * here.phi)
    elif law.form == "linear":
        lever = here.phi
    else:
        lever = np.sin(here.phi)
    lever = law.side * law.size * here.robot.body_length * lever
    here.moment = here.moment + lever * here.thrust


def mass_shift(law: Law, phi: np.ndarray) -> np.ndarray:
    """Of the centre of mass forward along the core (body lengths)."""
    if law.form == "with_head":
        return law.side * law.size * (0.4 + 0.6 * np.cos(2 * phi))
    return law.side * law.size * np.ones_like(phi)


def _mass_shift(law: Law, here: Here) -> None:
    """A shift along the core shortens the arm; positions are shifted in `sight`."""
    forward_shift = mass_shift(law, here.phi) * here.robot.body_length
    here.arm, here.aft = here.arm - forward_shift * np.cos(here.phi), forward_shift


def _sinking(law: Law, here: Here) -> None:
    """Seen through the growing depth of the labels only (`sight`)."""


WATER_FAMILIES = (
    Family("uniform_current", "input", _current, ("constant", "sheared", "drifting"),
           0.005, 0.15, "1", "speed over full speed", 0.02),
    Family("pool_gyre", "input", _gyre, ("cell", "solid_body", "vortex"),
           0.005, 0.25, "1", "speed over full speed", 0.02),
    Family("wall_effect", "load", _walls, ("exponential", "power", "drag"),
           0.02, 2.5, "1", "force over drag, at the wall", 0.1),
    Family("trim_moment", "load", _trim, ("speed_squared", "with_thrust", "along_core"),
           0.0005, 0.06, "1", "lever over body length", 0.003),
    Family("thrust_line_offset", "load", _thrust_line, ("sine", "double_angle", "linear"),
           0.002, 0.15, "1", "lever over body length", 0.01),
    Family("centre_of_mass_shift", "input", _mass_shift, ("fixed", "with_head"),
           0.004, 0.09, "1", "forward or backward shift over body length", 0.01),
    Family("sinking", "input", _sinking, ("steady", "accelerating", "saturating"),
           0.01, 0.4, "1", "depth gained in 12 s over body length", 0.05),
)  # fmt: skip
