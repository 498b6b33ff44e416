"""Planar motion of the rigid robot: forces, rates and a fixed-step integration of many trials.

State, shape (8, ...): x, y, core heading, world velocities, yaw rate, two states of memory laws.
Stages of hidden laws, in the order in which they act:
    angle      head angle -> head angle, rad
    frequency  factor on the flapping frequency
    water      complex velocity of the water in the pool frame, m/s
    thrust     factor on the thrust
    head       (C_L, C_D, C_M) -> (C_L, C_D, C_M)
    lag        C_L -> C_L and the rates of the two states
    arm        distance by which the centre of mass lies ahead of its stated place, m
    force      complex force in core axes, N, and moment, N m
    inertia    added masses along and across (kg), added inertia (kg m^2), share of Munk's moment
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from .fins import fin_force
from .form import Array, HiddenCause, InstantaneousState, ParallelTrials
from .robots import DENSITY, Robot

STEP_S = 1 / 60
"""Step of integration, s."""


def _causes_of_stage(hidden: Sequence[HiddenCause], stage: str) -> Iterator[HiddenCause]:
    return (h for h in hidden if h.form.stage == stage)


def head_angle(t: Array, lanes: ParallelTrials, hidden: Sequence[HiddenCause]) -> Array:
    """The head angle as it is, rad."""
    angle = lanes.angle + 0 * t
    for h in _causes_of_stage(hidden, "angle"):
        angle = h.form.law(t, angle, h.strength, h.parameters)
    return angle


def frequency(t: Array, lanes: ParallelTrials, hidden: Sequence[HiddenCause]) -> Array:
    """The flapping frequency as it is, Hz."""
    hertz = lanes.hertz + 0 * t
    for h in _causes_of_stage(hidden, "frequency"):
        hertz = hertz * h.form.law(t, lanes, h.strength, h.parameters)
    return hertz


def instantaneous_state(
    t: Array, state: Array, lanes: ParallelTrials, robot: Robot, hidden: Sequence[HiddenCause]
) -> InstantaneousState:
    """Flow, angles and thrust at one time, hidden drive and water included."""
    place, velocity = state[0] + 1j * state[1], state[3] + 1j * state[4]
    for h in _causes_of_stage(hidden, "water"):
        velocity = velocity - h.form.law(t, place, lanes, h.strength, h.parameters)
    flow = velocity * np.exp(-1j * state[2])
    angle, hertz = head_angle(t, lanes, hidden), frequency(t, lanes, hidden)
    area = robot.area(lanes.head)
    # T = C_T (1/2 rho A f^2)   (1)
    thrust = robot.coefficients.C_T * 0.5 * DENSITY * area * hertz**2
    # alpha = theta - arg v, theta = core direction - phi
    attack = np.angle(np.exp(-1j * angle) * np.conj(flow))
    m = InstantaneousState(t, place, flow, state[2], state[5], angle, attack, hertz, thrust, area,
               state[2] - lanes.heading, state[6:8], lanes)  # fmt: skip
    for h in _causes_of_stage(hidden, "thrust"):
        m = replace(m, thrust=m.thrust * h.form.law(m, h.strength, h.parameters))
    return m


def head_forces(
    m: InstantaneousState, robot: Robot, hidden: Sequence[HiddenCause], shift: Array | float
) -> tuple[Array, Array, Array]:
    """Force of the head plate (core axes, N), its moment (N m), rates of the two memory states."""
    k = robot.coefficients
    q = 0.5 * DENSITY * m.area * m.speed**2
    C_L = k.C_La * np.sin(2 * m.attack)  # (5)
    C_D = k.C_D0 + k.C_Da * (1 - np.cos(2 * m.attack))  # (6)
    C_M = k.C_Ma * np.sin(2 * m.attack)  # (7)
    memory = np.zeros_like(m.lag)
    for h in _causes_of_stage(hidden, "head"):
        C_L, C_D, C_M = h.form.law(m, (C_L, C_D, C_M), h.strength, h.parameters)
    for h in _causes_of_stage(hidden, "lag"):
        C_L, memory = h.form.law(m, C_L, h.strength, h.parameters)
    force = q * m.ahead * (1j * C_L - C_D)  # (2), (3)
    # N = Re[(L + D) conj(n)], n = i e^{i theta}; M = q C_M - C_Md r |r|   (4), (8)
    N = np.imag(force * np.exp(1j * m.angle))
    moment = q * C_M - k.C_Md * m.rate * np.abs(m.rate)
    return force, moment + N * (robot.arm(m.lanes.head) - shift), memory


def rates(
    t: Array,
    state: Array,
    lanes: ParallelTrials,
    robot: Robot,
    hidden: Sequence[HiddenCause] = (),
    *,
    push: Array | float = 0.0,
) -> Array:
    """Time derivative of the state. push: random accelerations (3, ...), surge, sway and yaw."""
    m = instantaneous_state(t, state, lanes, robot, hidden)
    shift: Array | float = 0.0
    for h in _causes_of_stage(hidden, "arm"):
        shift = shift + h.form.law(m, h.strength, h.parameters)
    force, moment, memory = head_forces(m, robot, hidden, shift)
    force = force + m.thrust
    if robot.fin is not None:
        side, turning = fin_force(m.flow, m.rate, robot.fin)
        force, moment = force + side, moment + turning - shift * side.imag
    for h in _causes_of_stage(hidden, "force"):
        extra, turning = h.form.law(m, h.strength, h.parameters)
        force, moment = force + extra, moment + turning
    masses = [h.form.law(m, h.strength, h.parameters) for h in _causes_of_stage(hidden, "inertia")]
    linear, angular = _accelerations(m, force, moment, robot, masses)
    pushes = np.broadcast_to(push, (3, *state.shape[1:]))
    linear = (linear + pushes[0] + 1j * pushes[1]) * np.exp(1j * state[2])
    return np.stack([state[3], state[4], state[5], linear.real, linear.imag,
                     angular + pushes[2], memory[0], memory[1]])  # fmt: skip


def _accelerations(
    m: InstantaneousState,
    force: Array,
    moment: Array,
    robot: Robot,
    masses: Sequence[tuple[float, float, float, float]],
) -> tuple[Array, Array]:
    """Inertial acceleration in core axes (complex) and yaw acceleration, with added masses.

    Kirchhoff's equations in the plane (Lamb 1932, art. 124): (m + m_x) du/dt = X + (m + m_y) w r,
    (m + m_y) dw/dt = Y - (m + m_x) u r, (I + J) dr/dt = N - (m_y - m_x) u w.
    """
    if not masses:
        return force / robot.mass, moment / robot.inertia
    along, across, turning, munk = np.sum(masses, axis=0)
    u, w, r = m.flow.real, m.flow.imag, m.rate
    du = (force.real + (robot.mass + across) * w * r) / (robot.mass + along)
    dw = (force.imag - (robot.mass + along) * u * r) / (robot.mass + across)
    dr = (moment - munk * (across - along) * u * w) / (robot.inertia + turning)
    return du + 1j * dw + 1j * r * m.flow, dr


def advance(
    t: Array,
    state: Array,
    lanes: ParallelTrials,
    robot: Robot,
    hidden: Sequence[HiddenCause] = (),
    *,
    push: Array | float = 0.0,
    step: float = STEP_S,
) -> Array:
    """The state a step later, by the classical Runge-Kutta method of fourth order."""
    half = t + step / 2
    a = rates(t, state, lanes, robot, hidden, push=push)
    b = rates(half, state + step / 2 * a, lanes, robot, hidden, push=push)
    c = rates(half, state + step / 2 * b, lanes, robot, hidden, push=push)
    d = rates(t + step, state + step * c, lanes, robot, hidden, push=push)
    return state + step / 6 * (a + 2 * b + 2 * c + d)


def simulate_motion(
    lanes: ParallelTrials,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    *,
    first: Array,
    pushes: Array,
) -> Array:
    """States (steps + 1, 8, trials) from the release.

    first: velocities and yaw rate at release (3, trials). pushes: (steps, 3, trials).
    """
    count = lanes.angle.size
    state = np.zeros((8, count))
    state[0], state[1], state[2] = lanes.start.real, lanes.start.imag, lanes.heading
    turned = (first[0] + 1j * first[1]) * np.exp(1j * lanes.heading)
    state[3], state[4], state[5] = turned.real, turned.imag, first[2]
    states = [state]
    for k, push in enumerate(pushes):
        state = advance(np.full(count, k * STEP_S), state, lanes, robot, hidden, push=push)
        states.append(state)
    return np.array(states)
