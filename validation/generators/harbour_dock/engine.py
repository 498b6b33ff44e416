"""The equations of MODEL.md with hooks for hidden laws; RK4 for all trials and variants at once.

Arrays have the shape (variants, trials). A variant is one set of numbers: the truth itself, the
truth without one cause, or the truth with one coefficient moved (for the derivatives). Vectors are
complex numbers: pool axes x + iy, core axes forward + i port.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from .law import Law
from .plan import KNOT, Trials
from .robots import HALF_RHO, Robot

DT = 0.02
"""Step of the integration, s."""
POSITION, RATES = slice(0, 3), slice(3, 6)
"""Rows of the state: x, y, theta and their rates; states of the laws follow."""
HOOKS = ("water", "flap", "phi", "states", "coefficients", "thrust", "shift", "force", "added")


@dataclass
class Variants:
    """Sets of numbers, to be moved one by one.

    values: coefficients, `fin_strength` (kg/m) and `fin_behind` (m), each (variants, 1); sizes: of
    the laws; head_error: rad; thrust_error: relative; start: (variants, trials, 6), as the state;
    water: complex velocity (m/s) at every `KNOT`, (variants, trials, knots).
    """

    values: dict[str, np.ndarray]
    sizes: list[np.ndarray]
    head_error: np.ndarray
    thrust_error: np.ndarray
    start: np.ndarray
    water: np.ndarray


def variant_set(robot: Robot, trials: Trials, laws: list[Law], count: int) -> Variants:
    """`count` equal variants at the true values."""
    knots = int(np.ceil(trials.simulated / KNOT)) + 2
    numbers = robot.coefficients | {
        "fin_strength": robot.fin_strength,
        "fin_behind": robot.fin_behind,
    }
    variants = Variants(
        values={name: np.full((count, 1), value) for name, value in numbers.items()},
        sizes=[np.full((count, 1), law.size) for law in laws],
        head_error=np.tile(trials.servo_error, (count, 1)),
        thrust_error=np.tile(trials.thrust_error, (count, 1)),
        start=np.tile(trials.start[None], (count, 1, 1)),
        water=np.tile(trials.water[None, :, :knots], (count, 1, 1)),
    )
    assert variants.water.shape == (count, len(trials.phi), knots)
    return variants


@dataclass
class Motion:
    """time (s): (instants,); all else (instants, variants, trials).

    m, rad and their rates in pool axes; flap: Hz; depth: gained, m; shift_x, shift_y: of the centre
    of mass away from `core_center`, m.
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    velocity_x: np.ndarray
    velocity_y: np.ndarray
    rate: np.ndarray
    phi: np.ndarray
    flap: np.ndarray
    depth: np.ndarray
    shift_x: np.ndarray
    shift_y: np.ndarray

    def every(self, stride: int) -> Motion:
        """Every `stride`-th instant."""
        return Motion(*[getattr(self, item.name)[::stride] for item in fields(self)])


class Here:
    """What laws see and change at one instant.

    Set in this order: time (s), x, y, theta, rate, head_axis (of unit length), flap (Hz), phi;
    speed through the water (m/s), cos_attack, sin_attack; forward, sideways: speed in core axes;
    C_L, C_D, C_M; states of the law; q = rho A speed^2 / 2 (N); thrust (N); surge_added,
    sway_added (kg), yaw_added (kg m^2), munk_share of Munk's moment that acts.
    """

    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    rate: np.ndarray
    head_axis: np.ndarray
    core_axis: np.ndarray
    flap: np.ndarray
    phi: np.ndarray
    flow: np.ndarray
    speed: np.ndarray
    cos_attack: np.ndarray
    sin_attack: np.ndarray
    forward: np.ndarray
    sideways: np.ndarray
    C_L: Any
    C_D: Any
    C_M: Any
    states: np.ndarray
    q: np.ndarray
    thrust: Any

    def __init__(self, robot: Robot, trials: Trials, laws: list[Law], variants: Variants) -> None:
        self.robot, self.trials, self.laws, self.variants = robot, trials, laws, variants
        self.values = variants.values
        self.theta_start = variants.start[:, :, 2]
        self.time = 0.0
        self.surge_added = self.sway_added = self.yaw_added = 0.0
        self.munk_share = 1.0
        self.first = np.cumsum([0, *[law.n_states for law in laws]])
        self._acting = {
            name: [(i, variants.sizes[i]) for i, law in enumerate(laws) if name in law.hooks]
            for name in HOOKS
        }

    @property
    def through_water(self) -> np.ndarray:
        """Velocity through the water in core axes, complex, m/s."""
        return self.forward + 1j * self.sideways

    def acting(self, name: str) -> list[tuple[Any, Any, slice]]:
        """Hooks of this name with sizes and the places of the laws' states."""
        return [
            (self.laws[i].hooks[name], size, slice(self.first[i], self.first[i + 1]))
            for i, size in self._acting[name]
        ]


def _meet_water(here: Here, state: np.ndarray, time: float) -> None:
    """Pose, head angle, frequency, and velocity through the water."""
    trials, variants = here.trials, here.variants
    here.time, here.x, here.y, here.theta, here.rate = time, state[0], state[1], state[2], state[5]
    here.head_axis = np.exp(1j * here.theta)
    here.flap = trials.flap[None, :] * np.ones_like(here.x)
    here.phi = trials.phi[None, :] + variants.head_error
    knot = min(int(time / KNOT), variants.water.shape[2] - 2)
    later = time / KNOT - knot
    water = variants.water[:, :, knot] * (1 - later) + variants.water[:, :, knot + 1] * later
    for act, size, _ in here.acting("water"):
        water = water + act(here, size)
    through_water = state[3] + 1j * state[4] - water
    here.speed = np.abs(through_water) + 1e-9
    here.flow = through_water / here.speed
    for act, size, _ in here.acting("flap"):
        here.flap = here.flap * act(here, size)
    for act, size, _ in here.acting("phi"):
        here.phi = act(here, size)
    here.core_axis = here.head_axis * np.exp(1j * here.phi)
    attack = here.head_axis * np.conj(here.flow)
    here.cos_attack, here.sin_attack = attack.real, attack.imag
    in_core_axes = through_water * np.conj(here.core_axis)
    here.forward, here.sideways = in_core_axes.real, in_core_axes.imag


def _coefficients(here: Here, own_states: np.ndarray) -> np.ndarray:
    """Set C_L, C_D and C_M; return the rates of the laws' own states."""
    values = here.values
    here.C_L = values["C_La"] * 2 * here.sin_attack * here.cos_attack
    here.C_D = values["C_D0"] + values["C_Da"] * 2 * here.sin_attack**2
    here.C_M = values["C_Ma"] * 2 * here.sin_attack * here.cos_attack
    rates = np.zeros_like(own_states)
    for act, size, rows in here.acting("states"):
        here.states = own_states[rows]
        rates[rows] = act(here, size)
    for act, size, rows in here.acting("coefficients"):
        here.states = own_states[rows]
        act(here, size)
    return rates


def _load(here: Here) -> tuple[np.ndarray, np.ndarray]:
    """Force in core axes (N) and moment about the centre of mass (N m), Eqs. 1 to 7."""
    trials, values = here.trials, here.values
    area = trials.area[None, :]
    here.q = HALF_RHO * area * here.speed**2
    head = here.q * here.flow * (1j * here.C_L - here.C_D)
    error = 1 + here.variants.thrust_error
    here.thrust = values["C_T"] * HALF_RHO * area * here.flap**2 * error
    for act, size, _ in here.acting("thrust"):
        here.thrust = here.thrust * act(here, size)
    thrust = here.thrust * here.core_axis
    arm = trials.arm[None, :] * here.head_axis
    moment = here.q * here.C_M - values["C_Md"] * here.rate * np.abs(here.rate)
    for act, size, _ in here.acting("shift"):
        shift = act(here, size)
        arm = arm - shift
        moment = moment - (np.conj(shift) * thrust).imag
    moment = moment + (np.conj(arm) * head).imag
    force = (head + thrust) * np.conj(here.core_axis)
    for act, size, _ in here.acting("force"):
        more_force, more_moment = act(here, size)
        force, moment = force + more_force, moment + more_moment
    return force, moment


def slopes(here: Here, state: np.ndarray, time: float) -> np.ndarray:
    """Rates of the state, (6 + states of the laws, variants, trials)."""
    _meet_water(here, state, time)
    own_rates = _coefficients(here, state[6:])
    force, moment = _load(here)
    here.surge_added = here.sway_added = here.yaw_added = 0.0
    here.munk_share = 1.0
    for act, size, _ in here.acting("added"):
        act(here, size)
    mass, forward, sideways, rate = here.robot.mass, here.forward, here.sideways, here.rate
    surge_mass, sway_mass = mass + here.surge_added, mass + here.sway_added
    surge = (force.real + sway_mass * sideways * rate) / surge_mass
    sway = (force.imag - surge_mass * forward * rate) / sway_mass
    munk = here.munk_share * (here.sway_added - here.surge_added) * forward * sideways
    yaw = (moment - munk) / (here.robot.inertia + here.yaw_added)
    acceleration = (surge - rate * sideways) + 1j * (sway + rate * forward)
    acceleration = acceleration * here.core_axis
    found = np.empty_like(state)
    found[POSITION] = state[RATES]
    found[3], found[4], found[5] = acceleration.real, acceleration.imag, yaw
    found[6:] = own_rates
    return found


def _step(here: Here, state: np.ndarray, time: float, first: np.ndarray) -> np.ndarray:
    """The state after DT (Runge-Kutta of fourth order); first: the slopes at `time`."""
    second = slopes(here, state + DT / 2 * first, time + DT / 2)
    third = slopes(here, state + DT / 2 * second, time + DT / 2)
    fourth = slopes(here, state + DT * third, time + DT)
    return state + DT / 6 * (first + 2 * (second + third) + fourth)


def _add_depth_and_shift(here: Here, motion: Motion) -> None:
    """What `depth` and `shift` of the laws do, along the whole motion."""
    for law, size in zip(here.laws, here.variants.sizes, strict=True):
        if "depth" in law.hooks:
            for row, time in enumerate(motion.time):
                motion.depth[row] += law.hooks["depth"](time, size)
        if "shift" in law.hooks:
            here.head_axis, here.phi = np.exp(1j * motion.theta), motion.phi
            shift = law.hooks["shift"](here, size[None])
            motion.shift_x += shift.real
            motion.shift_y += shift.imag


def simulate(
    robot: Robot, trials: Trials, laws: list[Law], variants: Variants, stride: int = 1
) -> Motion:
    """Integrate the equations; every `stride`-th step is kept."""
    shape = variants.head_error.shape
    here = Here(robot, trials, laws, variants)
    state = np.zeros((6 + here.first[-1], *shape))
    state[:6] = np.moveaxis(variants.start, 2, 0)
    steps = round(trials.simulated / DT)
    kept = steps // stride + 1
    motion = Motion(
        np.arange(kept) * DT * stride,
        *[np.empty((kept, *shape)) for _ in range(8)],
        *[np.zeros((kept, *shape)) for _ in range(3)],
    )
    seen = (motion.x, motion.y, motion.theta, motion.velocity_x, motion.velocity_y, motion.rate)
    with np.errstate(over="ignore", invalid="ignore"):
        for step in range(steps + 1):
            first = slopes(here, state, step * DT)
            if step % stride == 0:
                row = step // stride
                for values, now in zip(seen, state[:6], strict=True):
                    values[row] = now
                motion.phi[row], motion.flap[row] = here.phi, here.flap
            state = _step(here, state, step * DT, first)
    _add_depth_and_shift(here, motion)
    return motion
