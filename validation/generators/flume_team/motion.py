"""Equations of motion (MODEL.md, with hidden causes added) and their integration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import fin_laws
from .form import Array, HiddenCause, Lanes, Situation
from .robots import DENSITY, Robot

STEPS_PER_FRAME = 4
DRAG_LOST_BY_DEPTH = 0.6
"""Share of C_D0 lost one body length deeper (Hoerner 1965, ch. 11: drag near a surface)."""


def acting(hidden: Sequence[HiddenCause], place: str) -> list[HiddenCause]:
    """The causes that act on a place of the equations."""
    return [h for h in hidden if h.form.acts_on == place]


def head_angle(t: Array, lanes: Lanes, hidden: Sequence[HiddenCause]) -> Array:
    """Actual head angle at a time, rad, (..., trials)."""
    phi = lanes.phi + 0 * t
    for h in acting(hidden, "angle"):
        phi = h.form.law(t, phi, h.strength, **h.parameters)
    return phi


def frequency(t: Array, lanes: Lanes, hidden: Sequence[HiddenCause]) -> Array:
    """Flapping frequency at a time, Hz, (..., trials)."""
    flap = lanes.flap + 0 * t
    for h in acting(hidden, "frequency"):
        flap = flap * h.form.law(t, lanes, h.strength, **h.parameters)
    return flap


def centre_offset(phi: Array, hidden: Sequence[HiddenCause]) -> Array:
    """Centre of mass less its stated place, core axes, complex, m."""
    offset = 0j * phi
    for h in acting(hidden, "centre"):
        offset = offset + h.form.law(phi, h.strength, **h.parameters)
    return offset


def _situation(
    state: Array, t: Array, lanes: Lanes, robot: Robot, hidden: Sequence[HiddenCause]
) -> Situation:
    x, y, psi, vx, vy, r = state[:6]
    velocity = vx + 1j * vy
    for h in acting(hidden, "water"):
        velocity = velocity - h.form.law(t, x, y, lanes.pool, h.strength, **h.parameters)
    body = velocity * np.exp(-1j * psi)
    phi, flap = head_angle(t, lanes, hidden), frequency(t, lanes, hidden)
    speed = np.abs(velocity)
    alpha = np.angle(np.exp(-1j * phi) * np.conj(body))
    area = robot.area(lanes.head)
    thrust = robot.coefficients.C_T * 0.5 * DENSITY * area * flap**2
    q = 0.5 * DENSITY * area * speed**2
    return Situation(t, x, y, psi, body.real, body.imag, r, speed, alpha, phi, flap, thrust, q,
                     state[6:], lanes, robot)  # fmt: skip


def _head_forces(s: Situation, hidden: Sequence[HiddenCause]) -> tuple[Array, Array, Array, Array]:
    """Force in core axes (complex, N), moment (N m), rates of memory, plate's normal force (N).

    The rates of memory are (2, ..., trials).
    """
    c, change = s.robot.coefficients, np.zeros_like(s.memory)
    double = np.sin(2 * s.alpha)
    lift, moment = s.q * c.C_La * double, s.q * c.C_Ma * double
    drag = s.q * (c.C_D0 + c.C_Da * (1 - np.cos(2 * s.alpha)))
    for h in acting(hidden, "head"):
        lift, drag, moment, change = h.form.law(
            s, (lift, drag, moment, change), h.strength, **h.parameters
        )
    for h in acting(hidden, "depth"):
        lost = h.form.law(s.t, h.strength, **h.parameters) / s.robot.body_length
        drag = drag - s.q * c.C_D0 * DRAG_LOST_BY_DEPTH * np.clip(lost, 0, 1)
    direction = (s.u + 1j * s.v) / np.maximum(s.speed, 1e-12)
    force = (1j * lift - drag) * direction
    normal = np.real(force * np.conj(1j * np.exp(-1j * s.phi)))
    arm = s.robot.arm(s.lanes.head)
    return force, moment - c.C_Md * s.r * np.abs(s.r) + normal * arm, change, normal


def fin_force(s: Situation) -> tuple[Array, Array]:
    """Side force (N) and moment (N m) of the fin; zeros without one."""
    fin = s.robot.fin
    if fin is None:
        return 0 * s.u, 0 * s.u
    side = fin_laws.LAWS[fin.law](s.u, s.v - fin.arm * s.r, fin.area, fin.onset)
    return side, -fin.arm * side


def rates(
    state: Array,
    t: Array,
    lanes: Lanes,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    *,
    gust: Array | None = None,
) -> Array:
    """Time derivative of the state, (8, ..., trials).

    state: x, y, core direction, velocity in pool axes, yaw rate, two memories of laws.
    gust: accelerations (3, ..., trials) in axes turned to the first heading.
    """
    s = _situation(state, t, lanes, robot, hidden)
    for h in acting(hidden, "thrust"):
        s.thrust = s.thrust * h.form.law(s, h.strength, **h.parameters)
    force, yaw, memory, _ = _head_forces(s, hidden)
    side, turning = fin_force(s)
    force, yaw = force + s.thrust + 1j * side, yaw + turning
    for h in acting(hidden, "force"):
        surge, sway, moment = h.form.law(s, h.strength, **h.parameters)
        force, yaw = force + surge + 1j * sway, yaw + moment
    if acting(hidden, "centre"):
        yaw = yaw - np.imag(np.conj(centre_offset(s.phi, hidden)) * force)
    acceleration, turn = force / robot.mass, yaw / robot.inertia
    for h in acting(hidden, "mass"):
        acceleration, turn = h.form.law(s, force, yaw, h.strength, **h.parameters)
    world = acceleration * np.exp(1j * s.psi)
    if gust is not None:
        world = world + (gust[0] + 1j * gust[1]) * np.exp(1j * lanes.heading)
        turn = turn + gust[2]
    return np.stack([state[3], state[4], state[5], world.real, world.imag, turn, *memory])


def main_forces(state: Array, t: Array, lanes: Lanes, robot: Robot) -> dict[str, Array]:
    """Thrust, side force and moment of the published model with the fin, by channel, N and N m."""
    s = _situation(state, t, lanes, robot, ())
    _, yaw, _, normal = _head_forces(s, ())
    side, turning = fin_force(s)
    return {"surge": s.thrust + 0 * s.u, "sway": np.abs(normal) + np.abs(side),
            "yaw": np.abs(yaw) + np.abs(turning)}  # fmt: skip


def first_states(positions: Array, lanes: Lanes) -> Array:
    """Rest at the positions (complex, (trials,)), headed along `lanes.heading`, (8, trials)."""
    state = np.zeros((8, positions.size))
    state[0], state[1], state[2] = positions.real, positions.imag, lanes.heading
    return state


def simulate(
    first: Array,
    lanes: Lanes,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    *,
    gusts: Array,
    dt: float,
) -> Array:
    """States (steps, 8, trials) by the classical Runge-Kutta rule.

    gusts: (2 steps + 1, 3, trials) at intervals dt / 2; dt: s.
    """
    steps = (len(gusts) - 1) // 2
    states = np.empty((steps + 1, *first.shape))
    states[0] = y = first
    for n in range(steps):
        t = n * dt
        g0, g1, g2 = gusts[2 * n : 2 * n + 3]
        k1 = rates(y, t, lanes, robot, hidden, gust=g0)
        k2 = rates(y + dt / 2 * k1, t + dt / 2, lanes, robot, hidden, gust=g1)
        k3 = rates(y + dt / 2 * k2, t + dt / 2, lanes, robot, hidden, gust=g1)
        k4 = rates(y + dt * k3, t + dt, lanes, robot, hidden, gust=g2)
        y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states[n + 1] = y
    return states
