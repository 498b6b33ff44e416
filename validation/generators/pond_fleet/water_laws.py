"""Water that moves as a whole, and the walls of the pool.

Forms of moving water are functions of a place and give the water's velocity in the pool (m/s);
sizes are speeds over U0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .flow import Flow, Load, Setting, along_velocity
from .law import Family, by_name
from .robots import Array, Robot

Velocity = tuple[Array, Array]


@dataclass(frozen=True)
class Place:
    """Where and when the water's velocity is wanted: x, y (m), shape (columns,); time (s)."""

    robot: Robot
    pool: tuple[float, float]
    setting: Setting
    time: Array
    x: Array
    y: Array


# --- current ---


def _directed(place: Place, speed: Array, shape: float) -> Velocity:
    angle = 2 * np.pi * shape
    speed = speed * place.robot.speed + 0 * place.x
    return speed * np.cos(angle), speed * np.sin(angle)


def constant_current(place: Place, size: Array, shape: float) -> Velocity:
    """Filter pump at steady state."""
    return _directed(place, size, shape)


def decaying_current(place: Place, size: Array, shape: float) -> Velocity:
    """A pump switched off before the session: falls to a third by its end."""
    return _directed(place, 1.5 * size * np.exp(-1.1 * place.setting.order), shape)


def sheared_current(place: Place, size: Array, shape: float) -> Velocity:
    """Along a side and stronger towards one wall (a jet along that wall)."""
    length, width = place.pool
    along_x = shape < 0.5
    share = place.y / width if along_x else place.x / length
    speed = size * place.robot.speed * (0.4 + 1.2 * share)
    still = np.zeros_like(speed)
    return (speed, still) if along_x else (still, speed)


def turning_current(place: Place, size: Array, shape: float) -> Velocity:
    """Wind over an outdoor pool that veers by 80 degrees in the session."""
    angle = 2 * np.pi * shape + np.radians(80) * (place.setting.order - 0.5)
    speed = size * place.robot.speed
    return speed * np.cos(angle), speed * np.sin(angle)


# --- eddies of the pool's size ---


def _ring(
    place: Place, size: Array, centre: tuple[float, float], swirl: Callable[[Array], Array]
) -> Velocity:
    """Round eddy; swirl(radius over the pool's half width): speed over the largest."""
    scale = 0.5 * min(place.pool)
    dx, dy = place.x - centre[0] * place.pool[0], place.y - centre[1] * place.pool[1]
    radius = np.hypot(dx, dy) + 1e-9
    speed = size * place.robot.speed * swirl(radius / scale)
    return -speed * dy / radius, speed * dx / radius


def closed_cell(place: Place, size: Array, _: float) -> Velocity:
    """Stream function sin sin: a cell that fills the pool."""
    length, width = place.pool
    px, py = np.pi * place.x / length, np.pi * place.y / width
    speed = size * place.robot.speed
    return (
        -speed * np.sin(px) * np.cos(py),
        speed * width / length * np.cos(px) * np.sin(py),
    )


def rim_jet(place: Place, size: Array, shape: float) -> Velocity:
    """Solid rotation up to a jet near the rim, at rest beyond."""
    peak = 0.6 + 0.3 * shape
    return _ring(place, size, (0.5, 0.5), lambda r: r / peak * np.exp(1 - np.maximum(r / peak, 1)))


def lamb_oseen(place: Place, size: Array, shape: float) -> Velocity:
    """Viscous vortex (Saffman 1992, ch. 13), normalised to its largest speed."""
    core = 0.35 + 0.25 * shape

    def swirl(radius: Array) -> Array:
        part = 1.2564 * (radius / core) ** 2
        return 1.398 * core / np.maximum(radius, 1e-6) * -np.expm1(-part)

    return _ring(place, size, (0.45, 0.55), swirl)


def vatistas(place: Place, size: Array, shape: float) -> Velocity:
    """Swirl r / (1 + r^4)^(1/2): Vatistas 1991 with n = 2, off the centre."""
    core = 0.4 + 0.3 * shape
    return _ring(
        place, size, (0.42, 0.5), lambda r: np.sqrt(2) * r / core / np.sqrt(1 + (r / core) ** 4)
    )


def two_cells(place: Place, size: Array, _: float) -> Velocity:
    """Two cells that turn against each other, side by side along the length."""
    length, width = place.pool
    px, py = 2 * np.pi * place.x / length, np.pi * place.y / width
    speed = size * place.robot.speed
    return -speed * np.sin(px) * np.cos(py), 2 * speed * width / length * np.cos(px) * np.sin(py)


# --- walls ---


def _walls(flow: Flow) -> list[tuple[Array, float, float]]:
    """Gap in body lengths and outward normal of each wall.

    Laws do not grow below a gap of 0.4 and vanish behind the wall.
    """
    length, width = flow.pool
    scale = flow.robot.body_length
    gaps = ((flow.x, -1.0, 0.0), (length - flow.x, 1.0, 0.0),
            (flow.y, 0.0, -1.0), (width - flow.y, 0.0, 1.0))  # fmt: skip
    return [
        (np.where(gap > 0, np.maximum(gap / scale, 0.4), np.inf), nx, ny) for gap, nx, ny in gaps
    ]


def _in_head_frame(flow: Flow, fx: Array, fy: Array, moment: Array) -> Load:
    c, s = np.cos(flow.theta), np.sin(flow.theta)
    return Load(fx * c + fy * s, -fx * s + fy * c, moment)


def blocking_drag(flow: Flow, size: Array, shape: float) -> Load:
    """Drag rises by exp(-gap / b) (shallow-bank resistance, Norrbin 1974)."""
    reach = 0.5 + 0.4 * shape
    near = sum(np.exp(-(gap - 0.5) / reach) for gap, _, _ in _walls(flow))
    return along_velocity(flow, size * flow.robot.cruise_drag * flow.relative_speed**2 * near)


def power_drag(flow: Flow, size: Array, _: float) -> Load:
    """Drag rises by (0.5 / gap)^2."""
    near = sum((0.5 / gap) ** 2 for gap, _, _ in _walls(flow))
    return along_velocity(flow, size * flow.robot.cruise_drag * flow.relative_speed**2 * near)


def image_suction(flow: Flow, size: Array, _: float) -> Load:
    """Attraction to a wall by the image body, U^2 / gap^3 of the motion along it (Newman 1965)."""
    fx, fy = np.zeros_like(flow.x), np.zeros_like(flow.x)
    c, s = np.cos(flow.theta), np.sin(flow.theta)
    for gap, nx, ny in _walls(flow):
        tangent = (-ny * (flow.u * c - flow.v * s) + nx * (flow.u * s + flow.v * c)) ** 2
        pull = size * flow.robot.cruise_drag * tangent / flow.robot.speed**2 * (0.5 / gap) ** 3
        fx, fy = fx + pull * nx, fy + pull * ny
    return _in_head_frame(flow, fx, fy, np.zeros_like(fx))


def bank_effect(flow: Flow, size: Array, shape: float) -> Load:
    """Suction with a bow-out moment, exponential in the gap (Norrbin 1974; Vantorre 2003)."""
    reach = 0.5 + 0.3 * shape
    fx, fy, turn = (np.zeros_like(flow.x) for _ in range(3))
    c, s = np.cos(flow.theta), np.sin(flow.theta)
    for gap, nx, ny in _walls(flow):
        near = size * flow.robot.cruise_drag * flow.relative_speed**2
        near = near * np.exp(-(gap - 0.5) / reach)
        port = ny * c - nx * s
        fx, fy = fx + near * nx * np.abs(port), fy + near * ny * np.abs(port)
        turn = turn - 0.15 * flow.robot.body_length * near * port
    return _in_head_frame(flow, fx, fy, turn)


def gaussian_drag(flow: Flow, size: Array, shape: float) -> Load:
    """Drag of a zone of weeds and return flow along the rim, exp(-(gap / b)^2)."""
    reach = 0.9 + 0.4 * shape
    near = sum(np.exp((0.25 - gap**2) / reach**2) for gap, _, _ in _walls(flow))
    return along_velocity(flow, size * flow.robot.cruise_drag * flow.relative_speed**2 * near)


WATER_FAMILIES = (
    Family("uniform_current", "water", "speed over cruising speed", "1", 0.006, 0.2,
           by_name(constant_current, decaying_current, sheared_current, turning_current)),
    Family("pool_gyre", "water", "largest speed over cruising speed", "1", 0.008, 0.25,
           by_name(closed_cell, rim_jet, lamb_oseen, vatistas, two_cells), odd=True),
    Family("wall_effect", "load", "force over cruise drag half a body length from the wall", "1",
           0.03, 1.2, by_name(blocking_drag, power_drag, image_suction, bank_effect,
                              gaussian_drag)),
)  # fmt: skip
