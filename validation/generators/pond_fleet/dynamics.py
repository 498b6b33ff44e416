"""Motion of many trials at once: published model, fin and hidden laws, by Runge and Kutta.

State rows: x, y (m, centre of mass in the pool), theta (rad), surge and sway over ground in the
head frame (m/s), yaw rate (rad/s), two lag states, angle turned (rad), turns of the motor shaft.

    (M + A) d(nu)/dt = gyroscopic terms of M over ground and of A through the water + loads

Pressure gradients of the moving water are left out: its accelerations are of second order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .fins import fin_load
from .flow import Flow, Load, Setting
from .law import Law
from .robots import WATER_DENSITY, Array, Robot
from .water_laws import Place

X, Y, THETA, SURGE, SWAY, RATE, SLOW, FAST, TURNED, SHAFT = range(10)
ROWS = 10
Unrest = Callable[[Array, Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Plant:
    """Robot, pool and laws for many columns; a column is a trial of a variant.

    coefficients: (6, columns). fin_area: slope times area (m2), fin_arm (m), thrust_factor:
    (columns,). Law sizes are numbers or (columns,). unrest: time, x, y -> water velocity (m/s).
    """

    robot: Robot
    pool: tuple[float, float]
    setting: Setting
    coefficients: Array
    fin_area: Array
    fin_arm: Array
    thrust_factor: Array
    laws: Sequence[Law] = ()
    unrest: Unrest | None = None

    def of_stage(self, stage: str) -> list[Law]:
        """Laws of a stage."""
        return [law for law in self.laws if law.family.stage == stage]

    @cached_property
    def added(self) -> tuple[Array, float]:
        """Added inertia (3, 3, columns) and the share of its Munk moment."""
        total, share = np.zeros((3, 3, len(self.setting.phi))), 1.0
        for law in self.of_stage("inertia"):
            matrix, share = law(self.robot, self.setting)
            total = total + matrix
        return total, share

    @cached_property
    def inverse_inertia(self) -> Array:
        """Inverse of the whole inertia, (3, 3, columns)."""
        robot = self.robot
        rigid = np.diag([robot.mass, robot.mass, robot.inertia])[:, :, None]
        return np.moveaxis(np.linalg.inv(np.moveaxis(rigid + self.added[0], 2, 0)), 0, 2)


@dataclass(frozen=True)
class Motion:
    """States and their rates (instants, rows, columns) at `times` (instants, columns) in s."""

    times: Array
    states: Array
    rates: Array

    def column_at(self, column: int, times: Array) -> Array:
        """States of a column at other times by cubic Hermite interpolation, (rows, times)."""
        own = self.times[:, column]
        step = own[1] - own[0]
        left = np.clip((times / step).astype(int), 0, len(own) - 2)
        part = times / step - left
        y0, y1 = self.states[left, :, column].T, self.states[left + 1, :, column].T
        d0, d1 = step * self.rates[left, :, column].T, step * self.rates[left + 1, :, column].T
        return np.asarray(
            y0 * (1 + 2 * part) * (1 - part) ** 2
            + d0 * part * (1 - part) ** 2
            + y1 * part**2 * (3 - 2 * part)
            + d1 * part**2 * (part - 1)
        )


def flow_at(plant: Plant, time: Array, state: Array) -> tuple[Flow, tuple[Array, Array]]:
    """Motion through the water, and the velocity of the design centre from that of the mass."""
    robot, setting = plant.robot, plant.setting
    water = _water(plant, time, state)
    c, s = np.cos(state[THETA]), np.sin(state[THETA])
    flow = Flow(
        robot, plant.pool, setting, time, state[X], state[Y], state[THETA],
        u=state[SURGE] - (water[0] * c + water[1] * s),
        v=state[SWAY] - (-water[0] * s + water[1] * c), rate=state[RATE],
        phi=setting.phi, flap=setting.flap, thrust=np.zeros_like(setting.flap),
        turned=state[TURNED],
    )  # fmt: skip
    for law in plant.of_stage("servo"):
        flow = replace(flow, phi=law(flow))
    for law in plant.of_stage("shaft"):
        flow = replace(flow, flap=flow.flap * law(flow))
    offset = centre_offset(plant, flow)
    moved = replace(flow, u=flow.u + flow.rate * offset[1], v=flow.v - flow.rate * offset[0])
    return replace(moved, thrust=_thrust(plant, moved)), offset


def _water(plant: Plant, time: Array, state: Array) -> tuple[Array, Array]:
    total = plant.unrest(time, state[X], state[Y]) if plant.unrest else (0 * state[X],) * 2
    for law in plant.of_stage("water"):
        flow = law(Place(plant.robot, plant.pool, plant.setting, time, state[X], state[Y]))
        total = total[0] + flow[0], total[1] + flow[1]
    return total


def centre_offset(plant: Plant, flow: Flow) -> tuple[Array, Array]:
    """Centre of mass from the design centre, head frame (m)."""
    forward, port = 0 * flow.phi, 0 * flow.phi
    for law in plant.of_stage("centre"):
        found = law(flow)
        forward, port = forward + found[0], port + found[1]
    return forward, port


def _thrust(plant: Plant, flow: Flow) -> Array:
    """C_T (1/2 rho A f^2) with its factors (N)."""
    thrust = 0.5 * WATER_DENSITY * flow.area * plant.coefficients[0] * flow.flap**2
    thrust = thrust * plant.thrust_factor
    for law in plant.of_stage("thrust"):
        thrust = thrust * law(flow)
    return thrust


def published_load(plant: Plant, flow: Flow, state: Array) -> tuple[Load, Array, Array]:
    """Thrust, lift, drag and moment of MODEL.md about the design centre; rates of lag states."""
    _, lift_slope, drag_zero, drag_slope, moment_slope, damping = plant.coefficients
    alpha, pressure = flow.alpha, flow.pressure
    lift = np.sin(2 * alpha)
    slow, fast = np.zeros_like(alpha), np.zeros_like(alpha)
    for law in plant.of_stage("lag"):
        lift, slow, fast = law(flow, lift, (state[SLOW], state[FAST]))
    factors = [np.ones_like(alpha)] * 3
    for law in plant.of_stage("polar"):
        factors = [a * b for a, b in zip(factors, law(flow), strict=True)]
    lift = pressure * lift_slope * lift * factors[0]
    drag = pressure * (drag_zero + drag_slope * (1 - np.cos(2 * alpha))) * factors[1]
    c, s = np.cos(alpha), -np.sin(alpha)
    surge, sway = -drag * c - lift * s, -drag * s + lift * c
    yaw = pressure * moment_slope * np.sin(2 * alpha) * factors[2]
    yaw = yaw - damping * flow.rate * np.abs(flow.rate)
    yaw = yaw + sway * plant.robot.arm(plant.setting.head)
    forward, port = flow.thrust * np.cos(flow.phi), flow.thrust * np.sin(flow.phi)
    return Load(surge + forward, sway + port, yaw), slow, fast


def rates(plant: Plant, time: Array, state: Array) -> Array:
    """Time derivative of the state, (rows, columns)."""
    flow, offset = flow_at(plant, time, state)
    load, slow, fast = published_load(plant, flow, state)
    loads = [load] + [law(flow) for law in plant.of_stage("load")]
    if plant.robot.fin:
        loads.append(fin_load(flow, plant.robot.fin.form, plant.fin_area, plant.fin_arm))
    surge, sway, yaw = (sum(parts) for parts in zip(*loads, strict=True))
    yaw = yaw - (offset[0] * sway - offset[1] * surge)
    u, v, rate = state[SURGE], state[SWAY], state[RATE]
    mass = plant.robot.mass
    gyroscopic = np.stack([mass * v * rate + surge, -mass * u * rate + sway, yaw])
    if plant.of_stage("inertia"):
        gyroscopic = gyroscopic + _added_gyroscopic(plant, flow)
    accelerations = np.einsum("ijc,jc->ic", plant.inverse_inertia, gyroscopic)
    c, s = np.cos(state[THETA]), np.sin(state[THETA])
    return np.stack([u * c - v * s, u * s + v * c, rate, *accelerations, slow, fast,
                     np.abs(rate), flow.flap])  # fmt: skip


def _added_gyroscopic(plant: Plant, flow: Flow) -> Array:
    """Kirchhoff's terms of the water's impulse (Lamb 1932, art. 124)."""
    matrix, share = plant.added
    motion = np.stack([flow.u, flow.v, flow.rate])
    impulse = np.einsum("ijc,jc->ic", matrix, motion)
    munk = flow.u * impulse[1] - flow.v * impulse[0]
    return np.stack([flow.rate * impulse[1], -flow.rate * impulse[0], -share * munk])


def integrate(
    plant: Plant, start: Array, steps: int, keep_every: int = 1,
    part: tuple[Array | float, float] = (0.0, 1.0),
) -> Motion:  # fmt: skip
    """Motion from `start` (rows, columns) over each column's duration by classical Runge-Kutta.

    part: where it begins and how long it is, in durations; `steps` steps cover it, and every
    `keep_every`-th instant is kept.
    """
    step = part[1] * plant.setting.duration / steps
    begin = part[0] * plant.setting.duration
    times, states, slopes = [], [], []
    state = start
    for k in range(steps + 1):
        time = begin + k * step
        first = rates(plant, time, state)
        if k % keep_every == 0:
            times.append(time), states.append(state), slopes.append(first)
        second = rates(plant, time + step / 2, state + step / 2 * first)
        third = rates(plant, time + step / 2, state + step / 2 * second)
        fourth = rates(plant, time + step, state + step * third)
        state = state + step / 6 * (first + 2 * second + 2 * third + fourth)
    return Motion(np.array(times), np.array(states), np.array(slopes))
