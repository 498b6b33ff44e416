"""Drag and damping beside the published quadratic terms.

Sizes are forces over the cruise drag D0 or moments over D0 L, at the speed U0 of straight
swimming at full power.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .flow import Flow, Load, along_velocity, on_core, pure_moment
from .law import Family, by_name
from .robots import WATER_DENSITY, Array

STATIONS, WEIGHTS = np.polynomial.legendre.leggauss(6)


def _against(flow: Flow, size: Array, growth: Array) -> Load:
    return along_velocity(flow, size * flow.robot.cruise_drag * growth)


def stokes(flow: Flow, size: Array, _: float) -> Load:
    """V: creeping flow (Lamb 1932, art. 337)."""
    return _against(flow, size, flow.relative_speed)


def laminar_plate(flow: Flow, size: Array, _: float) -> Load:
    """V^1.5: laminar skin friction (Blasius 1908; Schlichting, ch. 7)."""
    return _against(flow, size, flow.relative_speed**1.5)


def laminar_and_creeping(flow: Flow, size: Array, shape: float) -> Load:
    """Skin friction with its first correction, V^1.5 and V (Kuo 1953)."""
    share = 0.3 + 0.4 * shape
    ratio = flow.relative_speed
    return _against(flow, size, (1 - share) * ratio**1.5 + share * ratio)


def transitional(flow: Flow, size: Array, shape: float) -> Load:
    """V^1.2 to V^1.45: a laminar separation bubble that shrinks with the Reynolds number."""
    return _against(flow, size, flow.relative_speed ** (1.2 + 0.25 * shape))


def skin_of_core(flow: Flow, size: Array, _: float) -> Load:
    """Linear skin friction of the core alone, along its own axis."""
    along, _across = flow.core
    force = -size * flow.robot.cruise_drag * along / flow.robot.speed
    return on_core(flow, force, np.zeros_like(force), np.zeros_like(force))


def fourth_power(flow: Flow, size: Array, _: float) -> Load:
    """V^4: wave resistance at low Froude number, practical fit (Oortmerssen 1971)."""
    return _against(flow, size, flow.relative_speed**4)


def sixth_power(flow: Flow, size: Array, _: float) -> Load:
    """V^6: thin ship theory before the last hump (Wehausen 1973)."""
    return _against(flow, size, flow.relative_speed**6)


def pressure_travelling(flow: Flow, size: Array, shape: float) -> Load:
    """V^-2 exp(-c / V^2): a deeply submerged body (Havelock 1931; Lamb 1932, art. 249)."""
    depth = 2.2 + 1.5 * shape
    ratio = np.maximum(flow.relative_speed, 0.05)
    return _against(flow, size, np.exp(-depth * (ratio**-2 - 1)) / ratio**2)


def wave_onset(flow: Flow, size: Array, shape: float) -> Load:
    """V^2 times the square of the excess over an onset at 0.35 to 0.6 U0."""
    onset = 0.35 + 0.25 * shape
    excess = np.maximum(flow.relative_speed - onset, 0) / (1 - onset)
    return _against(flow, size, flow.relative_speed**2 * excess**2)


def dry_sign(flow: Flow, size: Array, _: float) -> Load:
    """Coulomb: constant beyond 2 % of U0 (tanh for a continuous start)."""
    return _against(flow, size, np.tanh(flow.relative_speed / 0.02))


def saturating(flow: Flow, size: Array, shape: float) -> Load:
    """V / (V + c): a line that drags over the pool's rim."""
    ratio = flow.relative_speed
    return _against(flow, size, ratio / (ratio + 0.03 + 0.1 * shape))


def stribeck(flow: Flow, size: Array, shape: float) -> Load:
    """Boundary friction that falls to half as a film forms (Armstrong-Helouvry 1994)."""
    ratio = flow.relative_speed
    film = 0.5 + 0.5 * np.exp(-((ratio / (0.3 + 0.2 * shape)) ** 2))
    return _against(flow, size, film * np.tanh(ratio / 0.03))


def algebraic(flow: Flow, size: Array, shape: float) -> Load:
    """V / sqrt(V^2 + c^2): smooth dry friction."""
    ratio = flow.relative_speed
    return _against(flow, size, ratio / np.hypot(ratio, 0.04 + 0.08 * shape))


def _crossflow(flow: Flow, size: Array, depth_of: Callable[[float], float], power: float) -> Load:
    """Strips across the core from the hinge to the tail tip; size: drag coefficient."""
    robot = flow.robot
    _, across = flow.core
    start, stop = -robot.hinge_to_com, robot.aft_length + robot.tail_length
    force, moment = np.zeros_like(across), np.zeros_like(across)
    for station, weight in zip((STATIONS + 1) / 2, WEIGHTS / 2, strict=True):
        lever = start + station * (stop - start)
        side = across - lever * flow.rate
        depth = robot.head_span * depth_of(station)
        scale = robot.speed ** (2 - power)
        strip = np.sign(side) * np.abs(side) ** power * scale
        strip = -0.5 * WATER_DENSITY * size * depth * weight * (stop - start) * strip
        force, moment = force + strip, moment - lever * strip
    return on_core(flow, np.zeros_like(force), force, moment)


def even_depth(flow: Flow, size: Array, _: float) -> Load:
    """W |w| on a body of even depth (Hoerner 1965, ch. 3)."""
    return _crossflow(flow, size, lambda _s: 1.0, 2.0)


def tapered(flow: Flow, size: Array, shape: float) -> Load:
    """W |w| on a body that narrows to its peduncle."""
    return _crossflow(flow, size, lambda s: 1 - (0.5 + 0.4 * shape) * s, 2.0)


def falling_coefficient(flow: Flow, size: Array, _: float) -> Load:
    """|w|^1.7: coefficient that falls with the Reynolds number (Faltinsen 1990, ch. 6)."""
    return _crossflow(flow, size, lambda _s: 1.0, 1.7)


def caudal_plate(flow: Flow, size: Array, _: float) -> Load:
    """W |w| with a deep tail plate behind a narrow peduncle."""
    return _crossflow(flow, size, lambda s: 0.5 + 1.4 * (s > 0.8) + 0.5 * (s < 0.4), 2.0)


def _yaw_damping(flow: Flow, size: Array, growth: Array) -> Load:
    robot = flow.robot
    return pure_moment(-size * robot.cruise_drag * robot.body_length * growth)


def _turns(flow: Flow) -> Array:
    """Yaw rate over U0 / L."""
    return flow.rate * flow.robot.body_time


def linear(flow: Flow, size: Array, _: float) -> Load:
    """R."""
    return _yaw_damping(flow, size, _turns(flow))


def laminar(flow: Flow, size: Array, _: float) -> Load:
    """R |r|^0.5: laminar skin friction of the turning body."""
    turns = _turns(flow)
    return _yaw_damping(flow, size, turns * np.abs(turns) ** 0.5)


def swept_speed(flow: Flow, size: Array, _: float) -> Load:
    """V r: derivative N_r of manoeuvring theory (Fossen 2011, ch. 6)."""
    return _yaw_damping(flow, size, flow.relative_speed * _turns(flow))


def mixed_speed(flow: Flow, size: Array, _: float) -> Load:
    """R sqrt(V^2 + (r L / 4)^2): friction by the resultant speed of the ends."""
    turns = _turns(flow)
    return _yaw_damping(flow, size, turns * np.hypot(flow.relative_speed, turns / 4))


def softening(flow: Flow, size: Array, shape: float) -> Load:
    """R / (1 + |r| / r0): a cable that slips."""
    turns = _turns(flow)
    return _yaw_damping(flow, size, turns / (1 + np.abs(turns) / (0.3 + 0.4 * shape)))


DRAG_FAMILIES = (
    Family("viscous_drag", "load", "force over cruise drag", "1", 0.01, 0.8,
           by_name(stokes, laminar_plate, laminar_and_creeping, transitional, skin_of_core)),
    Family("wave_drag", "load", "force over cruise drag", "1", 0.01, 1.2,
           by_name(fourth_power, sixth_power, pressure_travelling, wave_onset)),
    Family("coulomb_friction", "load", "force over cruise drag", "1", 0.003, 0.1,
           by_name(dry_sign, saturating, stribeck, algebraic)),
    Family("crossflow_drag", "load", "drag coefficient", "1", 0.05, 2.5,
           by_name(even_depth, tapered, falling_coefficient, caudal_plate)),
    Family("linear_yaw_damping", "load", "moment over cruise drag times length", "1", 0.005, 0.6,
           by_name(linear, laminar, swept_speed, mixed_speed, softening)),
)  # fmt: skip
