"""Head plate, trim, centre of mass, and added inertia."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .flow import Flow, Load, Setting, pure_moment
from .law import Family, by_name
from .robots import WATER_DENSITY, Array, Robot

Factors = tuple[Array, Array, Array]

# --- stall: factors on lift, drag and moment ---


def _onset(shape: float) -> float:
    return float(np.radians(9 + 8 * shape))


def _separated(flow: Flow, shape: float, width_deg: float) -> Array:
    """Share of separated flow, 0 to 1, about an onset of 9 to 17 degrees plus a width."""
    width = np.radians(width_deg)
    return 1 / (1 + np.exp(-(np.abs(flow.alpha) - _onset(shape) - 2 * width) / width))


def smooth_stall(flow: Flow, size: Array, shape: float) -> Factors:
    """Lift and moment lose the share c beyond the onset."""
    kept = 1 - size * _separated(flow, shape, 2.0)
    return kept, np.ones_like(kept), kept


def kirchhoff_stall(flow: Flow, size: Array, shape: float) -> Factors:
    """((1 + sqrt f) / 2)^2 with f the attached chord (Leishman and Beddoes 1989)."""
    attached = np.clip(1 - size * _separated(flow, shape, 2.5), 0.0, 1.0)
    kept = ((1 + np.sqrt(attached)) / 2) ** 2
    return kept, np.ones_like(kept), kept


def drag_rise_stall(flow: Flow, size: Array, shape: float) -> Factors:
    """Lift lost turns up as pressure drag (Hoerner 1965, ch. 7)."""
    lost = size * _separated(flow, shape, 2.0)
    return 1 - lost, 1 + 0.8 * lost, 1 - lost


def leading_edge_stall(flow: Flow, size: Array, shape: float) -> Factors:
    """Abrupt loss that recovers towards the plate's normal force at large angles."""
    gone = _separated(flow, shape, 1.0)
    beyond = np.maximum(np.abs(flow.alpha) - _onset(shape), 0)
    kept = 1 - size * gone * np.exp(-beyond / np.radians(35))
    return kept, np.ones_like(kept), kept


def moment_stall(flow: Flow, size: Array, shape: float) -> Factors:
    """Centre of pressure moves aft before lift is lost; the moment changes twice as much."""
    lost = size * _separated(flow, shape, 2.0)
    return 1 - 0.35 * lost, np.ones_like(lost), 1 - 2 * lost


# --- port and starboard differ ---


def sided_lift(flow: Flow, size: Array, _: float) -> Factors:
    """Lift differs between the sides by 2 c."""
    side = 1 + size * np.tanh(flow.alpha / np.radians(1.0))
    return side, np.ones_like(side), np.ones_like(side)


def sided_lift_and_moment(flow: Flow, size: Array, _: float) -> Factors:
    """A bent plate: lift and moment differ, gradually about zero."""
    side = 1 + size * np.tanh(flow.alpha / np.radians(5.0))
    return side, np.ones_like(side), side


def sided_at_large_angles(flow: Flow, size: Array, shape: float) -> Factors:
    """One edge is rounder and separates later."""
    far = np.tanh((np.abs(flow.alpha) / np.radians(8 + 6 * shape)) ** 2)
    side = 1 + size * np.sign(flow.alpha) * far
    return side, np.ones_like(side), side


def sided_lift_and_drag(flow: Flow, size: Array, _: float) -> Factors:
    """A gap on one side: less lift and more drag."""
    side = size * np.tanh(flow.alpha / np.radians(3.0))
    return 1 + side, 1 - 0.6 * side, 1 + side


# --- lagging lift: states a, b; flow gives the quasi-steady coefficient ---


def _travel(flow: Flow, size: Array) -> Array:
    """Rate (1/s) of a lag of `size` head lengths of travel."""
    return flow.speed / (size * flow.setting.head)


def travelled_lag(flow: Flow, steady: Array, states: tuple[Array, Array], size: Array,
                  _: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """First order in distance travelled."""
    lagged, idle = states
    return lagged, _travel(flow, size) * (steady - lagged), 0 * idle


def jones_lag(flow: Flow, steady: Array, states: tuple[Array, Array], size: Array,
              _: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """Two-term growth of circulation (R. T. Jones 1940, NACA TR 681), stretched by the size."""
    slow, fast = states
    rate = _travel(flow, size)
    lagged = 0.5 * steady + 0.165 * slow + 0.335 * fast
    return lagged, 0.25 * rate * (steady - slow), 1.5 * rate * (steady - fast)


def timed_lag(flow: Flow, steady: Array, states: tuple[Array, Array], size: Array,
              _: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """First order in time: a soft head skin, with the size in head lengths at U0."""
    lagged, idle = states
    time = size * flow.robot.head_length / flow.robot.speed
    return lagged, (steady - lagged) / time, 0 * idle


def low_aspect_lag(flow: Flow, steady: Array, states: tuple[Array, Array], size: Array,
                   shape: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """Part of the lift at once, the rest by distance: finite span (R. T. Jones 1940)."""
    lagged, idle = states
    share = 0.15 + 0.2 * shape
    now = share * steady + (1 - share) * lagged
    return now, _travel(flow, size) * (steady - lagged), 0 * idle


def second_order_lag(flow: Flow, steady: Array, states: tuple[Array, Array], size: Array,
                     _: float) -> tuple[Array, Array, Array]:  # fmt: skip
    """Separation and shear layer in series, half the distance each (Goman and Khrabrov 1994)."""
    first, second = states
    rate = 2 * _travel(flow, size)
    return second, rate * (steady - first), rate * (first - second)


# --- trim: moment on a straight robot ---


def _trim(flow: Flow, size: Array, growth: Array) -> Load:
    return pure_moment(size * flow.robot.cruise_drag * flow.robot.body_length * growth)


def trim_by_speed(flow: Flow, size: Array, _: float) -> Load:
    """V^2: a bent keel."""
    return _trim(flow, size, flow.relative_speed**2)


def trim_by_advance(flow: Flow, size: Array, _: float) -> Load:
    """U |u| along the core: a deflected tail plate."""
    along = flow.core[0] / flow.robot.speed
    return _trim(flow, size, along * np.abs(along))


def trim_by_thrust(flow: Flow, size: Array, _: float) -> Load:
    """In proportion to the thrust: a tail that beats to one side."""
    return _trim(flow, size, flow.thrust / flow.robot.cruise_drag)


def trim_by_slipstream(flow: Flow, size: Array, shape: float) -> Load:
    """Half by thrust and half by speed: a plate in the slipstream."""
    part = 0.3 + 0.4 * shape
    thrust = flow.thrust / flow.robot.cruise_drag
    return _trim(flow, size, part * thrust + (1 - part) * flow.relative_speed**2)


# --- centre of mass from the design centre: forward and to port, head frame (m) ---


def shift_along_core(flow: Flow, size: Array, _: float) -> tuple[Array, Array]:
    """Ballast that slid along the core."""
    length = size * flow.robot.body_length
    return length * np.cos(flow.phi), length * np.sin(flow.phi)


def shift_along_head(flow: Flow, size: Array, _: float) -> tuple[Array, Array]:
    """Ballast in the head."""
    length = size * flow.robot.body_length + 0 * flow.phi
    return length, np.zeros_like(length)


def shift_with_bend(flow: Flow, size: Array, _: float) -> tuple[Array, Array]:
    """Mass of the turned head: moves forward and sideways as the head turns."""
    length = size * flow.robot.body_length
    return length * (0.6 + 0.4 * np.cos(flow.phi)), -0.5 * length * np.sin(flow.phi)


def shift_with_head_length(flow: Flow, size: Array, _: float) -> tuple[Array, Array]:
    """A shift along the core that grows with the head length."""
    length = size * flow.robot.body_length * flow.setting.head / flow.robot.head_length
    return length * np.cos(flow.phi), length * np.sin(flow.phi)


# --- added inertia: matrix (3, 3, columns) for surge, sway, yaw; share of its Munk moment ---


def _segments(robot: Robot, setting: Setting, depth_of: Callable[[int, float], float]) -> Array:
    """Strips of added mass rho pi d^2 / 4 across the head and the bent core (Lighthill 1960)."""
    matrix = np.zeros((3, 3, len(setting.phi)))
    stations, weights = np.polynomial.legendre.leggauss(8)
    lengths = (setting.head, robot.hinge_to_com + robot.aft_length + 0 * setting.head)
    for part, length in enumerate(lengths):
        for station, weight in zip((stations + 1) / 2, weights / 2, strict=True):
            depth = robot.head_span * depth_of(part, station)
            strip = WATER_DENSITY * np.pi / 4 * depth**2 * weight * length
            matrix += strip * _strip_tensor(robot, setting.phi, part, station * length)
    return matrix


def _strip_tensor(robot: Robot, phi: Array, part: int, place: Array) -> Array:
    """Outer product of the strip's normal motion in surge, sway and yaw.

    place: distance from the hinge (m), ahead for the head (part 0), behind for the core (part 1).
    """
    hinge = robot.hinge_to_com * np.stack([np.cos(phi), np.sin(phi)])
    angle = 0 * phi if part == 0 else phi
    axis = np.stack([np.cos(angle), np.sin(angle)])
    point = hinge + (place if part == 0 else -place) * axis
    normal = np.stack([-np.sin(angle), np.cos(angle)])
    motion = np.stack([normal[0], normal[1], point[0] * normal[1] - point[1] * normal[0]])
    return motion[:, None] * motion[None, :]


def even_strips(robot: Robot, setting: Setting, size: Array, _: float) -> tuple[Array, float]:
    """Plates of even depth."""
    return size * _segments(robot, setting, lambda _p, _s: 1.0), 1.0


def tapered_strips(robot: Robot, setting: Setting, size: Array, _: float) -> tuple[Array, float]:
    """Head that is pointed and core that narrows aft."""
    matrix = _segments(robot, setting, lambda p, s: 1 - 0.65 * s**2 if p == 0 else 1 - 0.6 * s)
    return 1.35 * size * matrix, 1.0


def reduced_munk(robot: Robot, setting: Setting, size: Array, shape: float) -> tuple[Array, float]:
    """Even strips; separation aft leaves part of the Munk moment (Hopkins 1951, NACA RM A51C14)."""
    return size * _segments(robot, setting, lambda _p, _s: 1.0), 0.45 + 0.35 * shape


def ellipsoid(robot: Robot, setting: Setting, size: Array, _: float) -> tuple[Array, float]:
    """Spheroid along the core with Lamb's factors (Lamb 1932, art. 115), with surge."""
    ratio = robot.body_length / (0.5 * (robot.head_span + robot.width))
    eccentric = np.sqrt(1 - ratio**-2)
    log = np.log((1 + eccentric) / (1 - eccentric))
    alpha = 2 * (1 - eccentric**2) / eccentric**3 * (0.5 * log - eccentric)
    beta = 1 / eccentric**2 - (1 - eccentric**2) / (2 * eccentric**3) * log
    surge, sway = (robot.mass * f / (2 - f) for f in (alpha, beta))
    turn = sway * robot.body_length**2 / 20
    cos, sin = np.cos(setting.phi), np.sin(setting.phi)
    matrix = np.zeros((3, 3, len(cos)))
    matrix[0, 0] = surge * cos**2 + sway * sin**2
    matrix[1, 1] = surge * sin**2 + sway * cos**2
    matrix[0, 1] = matrix[1, 0] = (surge - sway) * sin * cos
    matrix[2, 2] = turn
    return size * matrix, 1.0


HEAD_FAMILIES = (
    Family("stall", "polar", "share of lift lost", "1", 0.08, 0.85,
           by_name(smooth_stall, kirchhoff_stall, drag_rise_stall, leading_edge_stall,
                   moment_stall)),
    Family("port_starboard_asymmetry", "polar", "difference of each side from the mean", "1",
           0.01, 0.35, by_name(sided_lift, sided_lift_and_moment, sided_at_large_angles,
                               sided_lift_and_drag), odd=True),
    Family("lift_lag", "lag", "lag in head lengths", "1", 0.3, 6.0,
           by_name(travelled_lag, jones_lag, timed_lag, low_aspect_lag, second_order_lag)),
    Family("trim_moment", "load", "moment over cruise drag times length", "1", 0.001, 0.08,
           by_name(trim_by_speed, trim_by_advance, trim_by_thrust, trim_by_slipstream), odd=True),
    Family("centre_of_mass_shift", "centre", "shift over body length", "1", 0.008, 0.12,
           by_name(shift_along_core, shift_along_head, shift_with_bend, shift_with_head_length),
           odd=True),
    Family("added_mass", "inertia", "added inertia over its ideal value", "1", 0.3, 1.3,
           by_name(even_strips, tapered_strips, reduced_munk, ellipsoid)),
)  # fmt: skip
