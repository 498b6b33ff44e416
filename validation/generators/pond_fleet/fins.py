"""Core and tail as a fin: side force against the sideways velocity of the after body.

The local sideways velocity at the distance s behind the centre of mass is v_core - s r. Each form
takes its size from area and slope of the fin, so that all have the same side force at a small
angle.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .flow import Flow, Load, on_core
from .robots import WATER_DENSITY, Array, Fin, Robot

STATIONS, WEIGHTS = np.polynomial.legendre.leggauss(5)
SUCTION_SHARE = 0.9
"""Vortex lift over potential lift at 45 degrees."""
MARGINAL, STIFFEST = -0.08, -14.0
"""Growth rates per body length travelled of the least and most stable robots."""
STALL_ANGLE = np.radians(24.0)


def _at_fin(flow: Flow, arm: Array) -> tuple[Array, Array]:
    along, across = flow.core
    return along, across - arm * flow.rate


def _side(flow: Flow, arm: Array, force: Array, along: Array | float = 0.0) -> Load:
    return on_core(flow, along + 0 * force, force, -arm * force)


def resultant(flow: Flow, arm: Array, strength: Array) -> Load:
    """-strength V w, V resultant speed at the fin: Y = q S a sin(beta)."""
    forward, side = _at_fin(flow, arm)
    return _side(flow, arm, -strength * np.hypot(forward, side) * side)


def suction_analogy(flow: Flow, arm: Array, strength: Array) -> Load:
    """Potential and vortex lift of a slender fin (Polhamus 1966, NASA TN D-3767)."""
    forward, side = _at_fin(flow, arm)
    vortex = SUCTION_SHARE * np.abs(side)
    return _side(flow, arm, -strength * side * (np.abs(forward) + vortex))


def rudder_series(flow: Flow, arm: Array, strength: Array) -> Load:
    """Lift with the cross-flow term of square-tipped control surfaces, and their induced drag.

    C_L = a beta + C_Dc / AR beta |beta| (Whicker and Fehlner 1958, DTMB report 933).
    """
    forward, side = _at_fin(flow, arm)
    speed = np.hypot(forward, side)
    angle = np.arctan2(side, np.abs(forward) + 1e-12)
    lift = strength * speed**2 * (angle + 0.55 * angle * np.abs(angle))
    drag = strength * speed**2 * 0.6 * angle**2
    across = -lift * np.cos(angle) - drag * np.sin(angle)
    along = lift * np.sin(angle) - drag * np.cos(angle)
    return _side(flow, arm, across, along * np.sign(forward))


def shed_momentum(flow: Flow, arm: Array, strength: Array) -> Load:
    """Sideways momentum shed at the trailing edge, U m_a w, and its Kelvin impulse along the core.

    Lighthill 1971, Proc. R. Soc. B 179, eq. 7 and 8, for a stiff body.
    """
    forward, side = _at_fin(flow, arm)
    ahead = np.maximum(forward, 0.0)
    return _side(flow, arm, -strength * ahead * side, 0.5 * strength * side * np.abs(side))


def along_the_body(flow: Flow, arm: Array, strength: Array) -> Load:
    """Linear strips along the core from half to one and a half arms (strip theory)."""
    along, across = flow.core
    force, moment = np.zeros_like(along), np.zeros_like(along)
    for station, weight in zip(STATIONS, WEIGHTS / 2, strict=True):
        lever = arm * (1 + 0.5 * station)
        strip = -weight * strength * np.abs(along) * (across - lever * flow.rate)
        force, moment = force + strip, moment - lever * strip
    return on_core(flow, np.zeros_like(force), force, moment)


def stalling(flow: Flow, arm: Array, strength: Array) -> Load:
    """Normal force that falls to plate drag past 24 degrees (Hoerner and Borst 1975, ch. 3)."""
    forward, side = _at_fin(flow, arm)
    speed = np.hypot(forward, side)
    angle = np.arctan2(side, np.abs(forward) + 1e-12)
    stalled = 1 / (1 + np.exp((STALL_ANGLE - np.abs(angle)) / np.radians(4.0)))
    normal = np.sin(angle) * ((1 - stalled) * np.cos(angle) + 0.55 * stalled)
    return _side(flow, arm, -strength * speed**2 * normal)


FIN_FORMS: dict[str, Callable[[Flow, Array, Array], Load]] = {
    f.__name__: f
    for f in (resultant, suction_analogy, rudder_series, shed_momentum, along_the_body, stalling)
}


def fin_load(flow: Flow, form: str, area: Array, arm: Array) -> Load:
    """Load of a fin of slope-weighted area (m2) at an arm (m)."""
    return FIN_FORMS[form](flow, arm, 0.5 * WATER_DENSITY * area)


def straight_growth(robot: Robot, fin: Fin | None) -> float:
    """Largest growth rate (1/s) of sway and yaw about straight swimming at full power.

    All fin forms have the same derivatives there, except that strips damp yaw a little more.
    """
    _, lift, drag, _, moment, _ = robot.coefficients
    unit_force = 0.5 * WATER_DENSITY * robot.head_area * robot.speed
    arm = float(robot.arm(np.array(robot.head_length)))
    side = -unit_force * (2 * lift + drag)
    turn = side * arm - 2 * unit_force * moment
    stiff = 0.5 * WATER_DENSITY * robot.speed * fin.area * fin.slope if fin else 0.0
    lever = fin.arm if fin else 0.0
    spread = 1 + 0.25 / 3 if fin and fin.form == "along_the_body" else 1.0
    mass, inertia = robot.mass, robot.inertia
    matrix = np.array([
        [(side - stiff) / mass, stiff * lever / mass - robot.speed],
        [(turn + lever * stiff) / inertia, -stiff * lever**2 * spread / inertia],
    ])  # fmt: skip
    return float(np.linalg.eigvals(matrix).real.max())


def draw_fin(rng: np.random.Generator, robot: Robot) -> Fin | None:
    """A fin with which straight swimming is marginally to strongly stable; None if it is not.

    The slope-weighted area is 0.015 to 0.16 squared body lengths: from a bare caudal fin to a deep
    core with it.
    """
    aft, tail = robot.aft_length, robot.tail_length
    slope = rng.uniform(1.3, 2.8)
    area = np.exp(rng.uniform(np.log(0.015), np.log(0.16))) * robot.body_length**2 / slope
    arm = aft * rng.uniform(0.75, 1) + tail / 4
    fin = Fin(str(rng.choice(list(FIN_FORMS))), float(area), float(arm), slope, aft + tail)
    growth = straight_growth(robot, fin) * robot.body_time
    return fin if STIFFEST < growth < MARGINAL else None
