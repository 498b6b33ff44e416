"""Kirchhoff's equations of a rigid body with hidden laws, and their integration.

State, shape (9, lanes): x, y, psi, v_x, v_y, r, z_1, z_2, turned. psi is the direction of the
core, z are internal states of laws with a memory, turned is the angle swept so far.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from .robots import Array, ParallelTrials, Robot

STATE_SIZE = 9


@dataclass
class Flow:
    """What a law can see at one instant; arrays of shape (lanes,), SI units, core axes."""

    t: Any
    robot: Robot
    lanes: ParallelTrials
    psi: Array
    r: Array
    z: Array
    turned: Array
    place: Array
    f: Any = 0.0
    phi: Any = 0.0
    V: Any = 0.0
    u: Any = 0.0
    w: Any = 0.0
    alpha: Any = 0.0
    area: Any = 0.0
    T: Any = 0.0
    lift: Any = 1.0
    drag: Any = 1.0
    moment: Any = 1.0

    @property
    def q(self) -> Array:
        """Dynamic pressure times area of the head, N."""
        return 0.5 * self.robot.density * self.area * self.V**2


@dataclass(frozen=True)
class HiddenLaw:
    """A law at work: `form` from the catalogue, its strength and the numbers of its shape."""

    form: Any
    strength: float
    shape: dict[str, float]

    def __call__(self, flow: Flow) -> Any:
        """What the law gives or changes at an instant."""
        return self.form.law(flow, self.strength, self.shape)


def derivative(
    t: Any, state: Array, lanes: ParallelTrials, robot: Robot, laws: Sequence[HiddenLaw]
) -> Array:
    """Rate of the state. Reduces to the published model without laws."""

    def of(stage: str) -> list[HiddenLaw]:
        return [law for law in laws if law.form.stage == stage]

    x, y, psi, vx, vy, r, z1, z2, turned = state
    c = Flow(t, robot, lanes, psi, r, np.stack([z1, z2]), turned, x + 1j * y)
    c.f, c.phi = actual_drive(c, laws)
    axis = np.exp(1j * psi)
    water = lanes.water(t) + sum(law(c) for law in of("water"))
    v_core = (vx + 1j * vy - water) * np.conj(axis)
    c.u, c.w, c.V = v_core.real, v_core.imag, np.abs(v_core)
    # alpha = theta - arg v = -phi - arg v_core
    course = np.where(c.V > 1e-9, np.angle(v_core), -c.phi)
    c.alpha = np.angle(np.exp(-1j * (c.phi + course)))
    c.area = robot.area(lanes.head)
    c.T = robot.C_T * 0.5 * robot.density * c.area * c.f**2
    for law in of("thrust"):
        c.T = c.T * law(c)
    for law in of("head"):
        law(c)
    hydro, N = _head_plate_load(c, v_core, robot.arm(lanes.head))
    for law in of("body"):
        X, Y, more = law(c)
        hydro, N = hydro + X + 1j * Y, N + more
    for law in of("centre"):
        N = N + (np.conj(law(c)) * hydro).imag
    a_core, r_dot = _accelerations(c, hydro + c.T, N, of("inertia"))
    a = a_core * axis
    z_dot = np.zeros_like(c.z)
    for law in of("head"):
        if law.form.memory:
            z_dot = law.form.memory(c, law.strength, law.shape)
    return np.stack([vx, vy, r, a.real, a.imag, r_dot, z_dot[0], z_dot[1], np.abs(r)])


def actual_drive(c: Flow, laws: Sequence[HiddenLaw]) -> tuple[Array, Array]:
    """Flapping frequency (Hz) and head angle (rad) that motor and servo reach at c.t."""
    f = c.lanes.flap * (1 + c.lanes.wobble(c.t))
    phi = c.lanes.head_angle + c.lanes.servo_error + 0 * f
    for law in laws:
        if law.form.stage == "shaft":
            f = f * law(c)
        elif law.form.stage == "servo":
            phi = law(c) + 0 * f
    return f, phi


def _head_plate_load(c: Flow, v_core: Array, arm: Array) -> tuple[Array, Array]:
    """Force of the head in core axes and its moment: equations (2) to (7)."""
    k, one = c.robot, v_core / np.maximum(c.V, 1e-9)
    C_L = k.C_La * np.sin(2 * c.alpha) * c.lift
    C_D = (k.C_D0 + k.C_Da * (1 - np.cos(2 * c.alpha))) * c.drag
    force = c.q * (1j * C_L - C_D) * one
    normal = 1j * np.exp(-1j * c.phi)
    M = c.q * k.C_Ma * np.sin(2 * c.alpha) * c.moment - k.C_Md * c.r * np.abs(c.r)
    return force, M + (force * np.conj(normal)).real * arm


def _accelerations(c: Flow, force: Array, N: Array, inertia: Sequence[HiddenLaw]) -> Any:
    """Acceleration in core axes (complex) and of the yaw, with the added masses of the laws."""
    m, moment = c.robot.mass, c.robot.inertia
    if not inertia:
        return force / m, N / moment
    mx, my, mr, inr, munk = (sum(p) for p in zip(*(law(c) for law in inertia), strict=True))
    u, w, r = c.u, c.w, c.r
    X = force.real + (m + my) * w * r + mr * r**2
    Y = force.imag - (m + mx) * u * r
    N = N - munk * (my - mx) * u * w - mr * u * r
    u_dot = X / (m + mx)
    det = (m + my) * (moment + inr) - mr**2
    w_dot = (Y * (moment + inr) - mr * N) / det
    r_dot = ((m + my) * N - mr * Y) / det
    return (u_dot - w * r) + 1j * (w_dot + u * r), r_dot


def state_at_rest(lanes: ParallelTrials) -> Array:
    """State before a trial: at rest at the start."""
    state = np.zeros((STATE_SIZE, len(lanes.flap)))
    state[0], state[1], state[2] = lanes.start.real, lanes.start.imag, lanes.heading
    return state


def simulate_motion(
    lanes: ParallelTrials,
    robot: Robot,
    laws: Sequence[HiddenLaw],
    times: Array,
    state: Array | None = None,
) -> Array:
    """States at `times`, (times, 9, lanes), by Runge and Kutta's rule, a step between each two."""
    s = state_at_rest(lanes) if state is None else state
    out = np.empty((len(times), *s.shape))
    out[0] = s
    for k, (t, end) in enumerate(pairwise(times)):
        h = end - t
        k1 = derivative(t, s, lanes, robot, laws)
        k2 = derivative(t + h / 2, s + h / 2 * k1, lanes, robot, laws)
        k3 = derivative(t + h / 2, s + h / 2 * k2, lanes, robot, laws)
        k4 = derivative(end, s + h * k3, lanes, robot, laws)
        s = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        out[k + 1] = s
    return out


def straight_growth_rate(robot: Robot, laws: Sequence[HiddenLaw], lanes: ParallelTrials) -> float:
    """Largest real part of the eigenvalues of sway and yaw on a straight course, 1/s."""
    k = int(np.argsort(lanes.flap)[len(lanes.flap) // 2])
    one = lanes.take(np.array([k]))
    one.head_angle[:] = one.servo_error[:] = 0
    one.flow[:] = one.jitter[:] = 0
    one.head[:] = robot.head_length
    u = float(one.flap[0]) * np.sqrt(robot.C_T / robot.C_D0)

    def rates(w: float, r: float) -> Array:
        state = np.array([0, 0, 0, u, w, r, 0, 0, 0], dtype=float)[:, None]
        rate = derivative(50.0, state, one, robot, laws)
        return np.array([rate[4, 0] - u * r, rate[5, 0]])

    eps = 1e-5
    columns = [(rates(eps, 0) - rates(-eps, 0)), (rates(0, eps) - rates(0, -eps))]
    return float(np.linalg.eigvals(np.array(columns).T / (2 * eps)).real.max())
