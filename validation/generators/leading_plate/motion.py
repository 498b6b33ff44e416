"""The two-plate robot in axes of its leading plate.

With c = u + i w the velocity through the water along the head plate and across it, sin 2 alpha is
-2 u w / |c|^2 and 1 - cos 2 alpha is 2 w^2 / |c|^2, so the loads of MODEL.md are polynomials in u
and w over |c| and need no angle. Rows of a state: place, direction of the head, velocity over
ground in head axes, yaw rate, two lagging lift terms, angle turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .drive_laws import drive_factor
from .here import Here, Law, Setting
from .registry import FAMILIES
from .robots import WATER_DENSITY, Array, Robot, fin_side_force
from .water import jolt, swirl

ROWS = 9
SMALL = 1e-5
"""Speed below which directions of flow are rounded off (m/s)."""
RELEASE_TIME = 0.02
"""Time in which thrust sets in after a delayed release (s)."""


@dataclass(frozen=True)
class Plant:
    """A robot in a pool with its hidden laws."""

    robot: Robot
    pool: tuple[float, float]
    laws: tuple[Law, ...] = ()

    def without(self, law: Law) -> Plant:
        """The same without one law."""
        return Plant(self.robot, self.pool, tuple(one for one in self.laws if one is not law))

    def beside(self, law: Law) -> Plant:
        """The same with one law more."""
        return Plant(self.robot, self.pool, (*self.laws, law))


def slopes(plant: Plant, setting: Setting, since: float, state: Array) -> Array:
    """Time derivatives of a state (ROWS, columns), `since` seconds after the start."""
    here = _surroundings(plant, setting, since, state)
    laws = [(FAMILIES[law.name], law) for law in plant.laws if law.name in FAMILIES]
    for family, law in laws:
        if family.stage == "input":
            family.action(law, here)
    ground = state[3] + 1j * state[4]
    here.flow = ground - here.water * np.exp(-1j * here.theta)
    here.core = here.flow * np.exp(-1j * here.phi)
    here.speed = np.sqrt(here.flow.real**2 + here.flow.imag**2 + SMALL**2)
    _plate_loads(here)
    _fin_loads(here)
    for family, law in laws:
        if family.stage == "load":
            family.action(law, here)
    here.push_core(here.thrust)
    pull, spin = _accelerations(here)
    change = pull - 1j * here.rate * ground
    velocity = ground * np.exp(1j * here.theta)
    sine = 2 * here.side_slip * here.flow.real / here.speed
    pace = here.speed / here.setting.head
    return np.stack([
        velocity.real, velocity.imag, here.rate, change.real, change.imag, spin,
        pace * LAG_RATES[0] * (sine - state[6]), pace * LAG_RATES[1] * (sine - state[7]),
        np.abs(here.rate),
    ])  # fmt: skip


LAG_RATES = (0.3, 1.2)
"""Lags of lift per head length swum: the slow and the fast state."""


def _surroundings(plant: Plant, setting: Setting, since: float, state: Array) -> Here:
    robot, time = plant.robot, setting.since + since
    place, empty = state[0] + 1j * state[1], np.zeros(state.shape[1])
    awake = np.maximum(time - setting.delay, 0.0)
    begun = np.where(setting.delay > 0, 0.5 + 0.5 * np.tanh(
        (time - setting.delay) / RELEASE_TIME), 1.0)  # fmt: skip
    flap = setting.flap * drive_factor(plant.laws, awake, setting)
    area = setting.head * robot.head_span
    thrust = setting.coefficients[0] * 0.5 * WATER_DENSITY * area * flap**2
    return Here(
        robot=robot, pool=plant.pool, setting=setting, time=awake, place=place, theta=state[2],
        rate=state[5], turned=state[8], lagged=state[6:8], phi=setting.phi,
        arm=robot.arm(setting.head), thrust=thrust * setting.thrust * begun,
        water=swirl(setting.swirl, time, place) + setting.push[0] + 1j * setting.push[1],
        flow=place, core=place, speed=empty, lift=place, twist=empty, force=place,
        moment=jolt(setting.jolts, time) + setting.push[2],
    )  # fmt: skip


def _plate_loads(here: Here) -> None:
    """Lift, drag and moment of the head plate and damping of yaw."""
    setting = here.setting
    _, straight, steep, slope, moment, damping = setting.coefficients
    half = 0.5 * WATER_DENSITY * setting.head * here.robot.head_span
    u, w, speed = here.flow.real, here.flow.imag, here.speed
    here.lift = -2 * half * slope * u * w * 1j * here.flow / speed
    drag = -half * here.flow * (straight * speed + 2 * steep * w**2 / speed)
    here.twist = here.lift.imag * here.arm - 2 * half * moment * u * w
    here.force = here.lift + drag
    here.moment = (here.moment + here.twist + drag.imag * here.arm
                   - damping * here.rate * np.abs(here.rate))  # fmt: skip


def _fin_loads(here: Here) -> None:
    fin = here.robot.fin
    if fin is None:
        return
    strength, arm = here.setting.fin[0], here.setting.fin[1] + here.aft
    across = here.core.imag - arm * here.rate
    side = fin_side_force(fin, strength, here.core.real, across)
    here.push_core(0.0, side)
    here.moment = here.moment - arm * side


def _accelerations(here: Here) -> tuple[Array, Array]:
    """Acceleration in head axes and angular acceleration, with added masses if there are any."""
    robot = here.robot
    if here.masses is None:
        return here.force / robot.mass, here.moment / robot.inertia
    surge_added_mass, sway_added_mass, yaw_added_inertia, sway_yaw_coupling, munk = here.masses
    turned = np.exp(1j * here.phi)
    pull = here.force / turned
    u, v, r = here.core.real, here.core.imag, here.rate
    surge = (
        pull.real + (sway_added_mass - surge_added_mass) * v * r + sway_yaw_coupling * r**2
    ) / (robot.mass + surge_added_mass)
    side = pull.imag + (sway_added_mass - surge_added_mass) * u * r
    moment = here.moment - munk * (sway_added_mass - surge_added_mass) * u * v
    m, i = robot.mass + sway_added_mass, robot.inertia + yaw_added_inertia
    determinant = m * i - sway_yaw_coupling**2
    sway = (i * side - sway_yaw_coupling * moment) / determinant
    return (surge + 1j * sway) * turned, (m * moment - sway_yaw_coupling * side) / determinant


def simulate(plant: Plant, setting: Setting, start: Array, times: Array) -> Array:
    """States (ROWS, columns, times) by an adaptive method of order eight."""

    def derivative(time: float, flat: Array) -> Array:
        return slopes(plant, setting, time, flat.reshape(ROWS, -1)).ravel()

    found = solve_ivp(
        derivative, (0.0, float(times[-1])), start.ravel(), method="DOP853", t_eval=times,
        rtol=3e-6, atol=1e-8, max_step=0.4, first_step=0.005,
    )  # fmt: skip
    if not found.success:
        raise ValueError(found.message)
    return found.y.reshape(*start.shape, -1)


def advance(plant: Plant, setting: Setting, start: Array, span: float, steps: int = 3) -> Array:
    """States (ROWS, columns) `span` later, by few fixed steps; for differences over an interval."""
    state, step = start, span / steps
    for k in range(steps):
        t = k * step
        a = slopes(plant, setting, t, state)
        b = slopes(plant, setting, t + step / 2, state + step / 2 * a)
        c = slopes(plant, setting, t + step / 2, state + step / 2 * b)
        d = slopes(plant, setting, t + step, state + step * c)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
    return state


def at_rest(places: Sequence[complex] | Array, directions: Array) -> Array:
    """Starting states."""
    state = np.zeros((ROWS, len(directions)))
    state[0], state[1], state[2] = np.real(places), np.imag(places), directions
    return state
