"""The flat-plate model of the paper (Eqs. 1 to 8) for many trials at once, with hidden causes.

Rows of the state (pool axes, SI): x, y, psi, their rates, then the memory states of the laws.
psi = theta + phi is the direction of the core, theta that of the head plate. With a steady head
angle both turn at the same rate; while the servo moves, the core keeps its momentum and the light
head moves. Parameters are the six coefficients, then the strengths of the causes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .form import DT, Array, Cause, Disturbance, Quantity, Situation, Trials, act
from .robots import Robot

COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
Parameters = Sequence[float] | Array


@dataclass(frozen=True)
class Setting:
    """What moves: the robot, the constants of its trials, and the causes that act on it."""

    robot: Robot
    trials: Trials
    causes: Sequence[Cause]


class Disturbances(Protocol):
    """Random disturbances at the steps of the simulation."""

    def disturbance(self, step: int, x: Array, y: Array) -> Disturbance:
        """Those of a step, at the place (m) of each trial."""


@dataclass(frozen=True)
class Motion:
    """States (steps + 1, 6 + memory, trials) on the grid t = 0, DT, ..., and their derivatives."""

    states: Array
    rates: Array

    def of_trial(self, trial: int) -> Motion:
        """The motion of one trial."""
        return Motion(self.states[:, :, trial : trial + 1], self.rates[:, :, trial : trial + 1])

    def at(self, t: Array) -> tuple[Array, Array]:
        """States and rates (6 + memory, n, trials) at motor times t (s), (n, trials).

        Hermite interpolation. Before the motor starts (t < 0) the robot lies still.
        """
        place = np.clip(t / DT, 0, len(self.states) - 1.001)
        k = place.astype(int)
        trial = np.broadcast_to(np.arange(t.shape[1]), t.shape)
        z = (place - k)[..., None]
        a, b = self.states[k, :, trial], self.states[k + 1, :, trial]
        da, db = self.rates[k, :, trial] * DT, self.rates[k + 1, :, trial] * DT
        square, cube = 3 * (b - a) - 2 * da - db, 2 * (a - b) + da + db
        states = a + z * (da + z * (square + z * cube))
        rates = (da + z * (2 * square + 3 * z * cube)) / DT
        early = t[..., None] < 0
        rates = np.where(early, 0.0, rates)
        states[..., 3:6] = np.where(early, 0.0, states[..., 3:6])
        return np.moveaxis(states, 2, 0), np.moveaxis(rates, 2, 0)


def rates(
    t: Quantity,
    state: Array,
    setting: Setting,
    parameters: Parameters,
    disturbance: Disturbance,
) -> Array:
    """Time derivative of the state, (6 + memory, trials), at the motor time t (s)."""
    return loads(t, state, setting, parameters, disturbance).rates


def loads(
    t: Quantity,
    state: Array,
    setting: Setting,
    parameters: Parameters,
    disturbance: Disturbance,
) -> Situation:
    """All forces and moments at a state, with its time derivative."""
    robot, causes, strengths = setting.robot, setting.causes, parameters[6:]
    now = Situation(t, setting.trials, robot, x=state[0], y=state[1], psi=state[2], r=state[5])
    now.velocity = state[3] + 1j * state[4]
    now.memory, now.memory_rates = state[6:], np.zeros_like(state[6:])
    now.flap = now.trials.flap * (t > -1e-9)
    act("motor", now, causes, strengths)
    now.phi = now.trials.phi + disturbance.servo
    act("servo", now, causes, strengths)
    now.axis = np.exp(1j * now.psi)
    now.head_axis = np.exp(1j * (now.psi - now.phi))
    now.water = disturbance.drift + 0j
    act("flow", now, causes, strengths)
    _relative_motion(now)
    _published_forces(now, causes, parameters)
    act("load", now, causes, strengths)
    power = (now.flap / robot.top_flap) ** 2
    push = disturbance.push
    now.force = now.force + robot.mass * power * (push[0] + 1j * push[1]) * now.axis
    now.moment = now.moment + robot.inertia * power * push[2]
    act("inertia", now, causes, strengths)
    acceleration, spin = _accelerations(now)
    motion = [state[3], state[4], state[5], acceleration.real, acceleration.imag]
    now.rates = np.concatenate([[*motion, spin + 0 * state[5]], now.memory_rates])
    return now


def _relative_motion(now: Situation) -> None:
    """Motion through the water, and the angle of attack of the head plate."""
    now.relative = now.velocity - now.water
    now.speed = np.abs(now.relative)
    now.direction = now.relative / np.maximum(now.speed, 1e-9)
    body = now.relative * np.conj(now.axis)
    now.u, now.w = body.real, body.imag
    turned = now.head_axis * np.conj(now.direction)
    now.alpha = np.where(now.speed > 1e-9, np.angle(turned), 0.0)


def _published_forces(now: Situation, causes: Sequence[Cause], parameters: Parameters) -> None:
    """Thrust, lift, drag and moments of Eqs. 1 to 8, with the laws of thrust and plate."""
    C_T, C_D0, C_Da, C_La, C_Ma, C_Md = parameters[:6]
    robot, head, r = now.robot, now.trials.head, now.r
    area = head * robot.span
    now.C_D0 = C_D0
    now.thrust = C_T * 0.5 * robot.density * area * now.flap**2
    act("thrust", now, causes, parameters[6:])
    now.q = 0.5 * robot.density * area * now.speed**2
    double = np.sin(2 * now.alpha)
    now.C_L, now.C_M = C_La * double, C_Ma * double
    now.C_D = C_D0 + C_Da * (1 - np.cos(2 * now.alpha))
    chord = 0.25 * (robot.body_length + head - robot.head_length)
    now.arm = head + robot.hinge_to_com - chord
    act("plate", now, causes, parameters[6:])
    plate = now.q * (1j * now.C_L - now.C_D) * now.direction
    normal = (plate * np.conj(1j * now.head_axis)).real
    now.force = now.thrust * now.axis + plate
    now.moment = now.q * now.C_M - C_Md * r * np.abs(r) + normal * now.arm


def _accelerations(now: Situation) -> tuple[Array, Array]:
    """Acceleration (complex, pool axes) and yaw acceleration, with the added mass if any."""
    mass, inertia, added = now.robot.mass, now.robot.inertia, now.added
    if added is None:
        return now.force / mass, now.moment / inertia
    r, u, w = now.r, now.u, now.w
    force = now.force * np.conj(now.axis)
    ground = now.velocity * np.conj(now.axis)
    water_momentum = added.sway * w + added.coupling * r
    u_rate = (force.real + mass * r * ground.imag + r * water_momentum) / (mass + added.surge)
    side = force.imag - mass * r * ground.real - r * added.surge * u
    munk = (added.sway - added.surge) * u * w + added.coupling * u * r
    moment = now.moment - added.munk * munk
    sway_mass, yaw_inertia = mass + added.sway, inertia + added.yaw
    det = sway_mass * yaw_inertia - added.coupling**2
    w_rate = (yaw_inertia * side - added.coupling * moment) / det
    r_rate = (sway_mass * moment - added.coupling * side) / det
    return (u_rate - r * ground.imag + 1j * (w_rate + r * ground.real)) * now.axis, r_rate


def three_eighths(
    rate: Callable[[Quantity, Array], Array], t: Quantity, state: Array, dt: Quantity
) -> Array:
    """One step dt (s) of Kutta's 3/8 rule; rate(t, state)."""
    k1 = rate(t, state)
    k2 = rate(t + dt / 3, state + dt / 3 * k1)
    k3 = rate(t + 2 * dt / 3, state + dt * (k2 - k1 / 3))
    k4 = rate(t + dt, state + dt * (k1 - k2 + k3))
    return state + dt / 8 * (k1 + 3 * k2 + 3 * k3 + k4)


def simulate(
    first: Array,
    steps: int,
    setting: Setting,
    parameters: Parameters,
    weather: Disturbances,
) -> Motion:
    """Motion from the first state (6 + memory, trials); the disturbance is constant over a step."""
    state = first.copy()
    out = np.empty((steps + 1, *state.shape))
    derivatives = np.empty_like(out)
    for k in range(steps + 1):
        disturbance = weather.disturbance(k, state[0], state[1])

        def rate(t: Quantity, y: Array, disturbance: Disturbance = disturbance) -> Array:
            return rates(t, y, setting, parameters, disturbance)

        out[k], derivatives[k] = state, rate(k * DT, state)
        state = three_eighths(rate, k * DT, state, DT)
    return Motion(out, derivatives)


def stability(robot: Robot, parameters: Parameters, causes: Sequence[Cause]) -> float:
    """Largest real part (1/s) of the eigenvalues of straight swimming at full power.

    Of the causes only the fin counts.
    """
    fins = [i for i, cause in enumerate(causes) if cause.family.name == "tail_fin_lift"]
    parameters = [*parameters[:6], *(parameters[6 + i] for i in fins)]
    zero = np.zeros(1)
    trials = Trials(np.array([robot.top_flap]), zero, np.array([robot.head_length]), zero, zero)
    setting = Setting(robot, trials, [causes[i] for i in fins])
    speed = robot.top_flap * np.sqrt(parameters[0] / parameters[1])
    step, calm = 1e-6, Disturbance(np.zeros(3), 0.0, 0.0)

    def lateral(w: float, r: float) -> Array:
        state = np.array([0, 0, 0, speed, w, r], float)[:, None]
        rate = rates(1.0, state, setting, parameters, calm)[:, 0]
        return np.array([rate[4] - r * speed, rate[5]])

    by_w = (lateral(step, 0) - lateral(-step, 0)) / (2 * step)
    by_r = (lateral(0, step) - lateral(0, -step)) / (2 * step)
    return float(np.linalg.eigvals(np.stack([by_w, by_r], axis=1)).real.max())
