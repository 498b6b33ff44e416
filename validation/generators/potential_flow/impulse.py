"""Motion from the momentum of the body and the Kelvin impulse of the water around it.

Momentum P (body axes) and angular momentum K of body and water together:

    dP/dt = -i r P + F          dK/dt = -(v x P_water) + N
    P = m U + P_water           P_water = A (U - W) + c r
    K = (I + J) r + c . (U - W)

U velocity of the centre of mass, W of the water, A and J added masses, c their coupling.
Kirchhoff 1869; Lamb, Hydrodynamics, sections 120 to 124. Vectors are complex numbers in the axes of
the head: ahead, and to port. Without added mass this is Newton's second law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from .craft import RHO, Robot, spheroid_added_mass
from .drive import DriveHistory, drive_history
from .eddies import WaterMotion, water_velocity
from .form import HiddenForm
from .lanes import ParallelTrials

STEP_S = 1 / 120
THRUST_PULSE_SHARE = 0.35
"""Thrust pulses twice a beat by this share around its mean."""
RIGID_STATE_ROWS = 6
"""Rows of the state before the states of the laws: x, y, theta, P, K."""


@dataclass(frozen=True)
class StudyWorld:
    """What does not change from lane to lane."""

    craft: Robot
    water: WaterMotion
    pool: tuple[float, float, float]
    laws: tuple[HiddenForm, ...]
    wander: np.ndarray
    """(steps, trials)."""


@dataclass(frozen=True)
class Motion:
    """Motion on the grid of steps, each (times, n) or (times, n) complex."""

    times: np.ndarray
    place: np.ndarray
    heading: np.ndarray
    angle: np.ndarray
    phase: np.ndarray
    speed: np.ndarray
    """Of the centre of mass over ground, complex, pool axes, m/s."""
    yaw_rate: np.ndarray
    attack: np.ndarray


def _rows(laws) -> list[slice]:
    ends = RIGID_STATE_ROWS + np.cumsum([0] + [h.form.rows for h in laws])
    return [slice(a, b) for a, b in pairwise(ends)]


def added_masses(
    world: StudyWorld, lanes: ParallelTrials, angle: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Added masses in the head's axes: surge, cross, sway, coupling (complex), yaw."""
    craft = world.craft
    ax, ay, j = (craft.background * a for a in spheroid_added_mass(craft.body_length, craft.span))
    c = 0.0
    for i, law in enumerate(world.laws):
        if law.form.stage == "mass":
            own = law(SimpleNamespace(craft=craft), lanes.strengths[i])
            ax, ay, c, j = ax + own[0], ay + own[1], c + own[2], j + own[3]
    cos, sin = np.cos(angle), np.sin(angle)
    return (ax * cos**2 + ay * sin**2, (ax - ay) * sin * cos, ax * sin**2 + ay * cos**2,
            1j * c * np.exp(1j * angle), j + 0 * angle)  # fmt: skip


def _times(tensor, vector):
    a, b, d = tensor
    return a * vector.real + b * vector.imag + 1j * (b * vector.real + d * vector.imag)


def velocities_from_momentum(craft: Robot, added, momentum, spin, water):
    """Velocity U (complex, m/s) and yaw rate r (rad/s) from P, K and the water's W."""
    a, b, d, c, j = added
    m = craft.mass
    det = (m + a) * (m + d) - b**2
    inverse = ((m + d) / det, -b / det, (m + a) / det)
    known = momentum + _times((a, b, d), water)
    reach = _times(inverse, c)
    r = (spin + (np.conj(c) * water).real - (np.conj(reach) * known).real) / (
        craft.inertia + j - (np.conj(reach) * c).real)  # fmt: skip
    return _times(inverse, known - c * r), r


def water_impulse(craft: Robot, added, velocity_, rate, water):
    """P of the water alone, P, and K."""
    a, b, d, c, j = added
    relative = velocity_ - water
    fluid = _times((a, b, d), relative) + c * rate
    return fluid, craft.mass * velocity_ + fluid, (craft.inertia + j) * rate + (
        np.conj(c) * relative).real  # fmt: skip


def instantaneous_state(
    world: StudyWorld, lanes: ParallelTrials, state, time: float, drive_row
) -> SimpleNamespace:
    """Everything the laws may use at one time; see the assignments for names, SI units."""
    flap, phase, angle = drive_row
    s = SimpleNamespace(t=time, craft=world.craft, pool=world.pool, order=lanes.trial, phi=angle,
                        flap=flap, phase=phase, head=lanes.head, power=lanes.power)  # fmt: skip
    s.place = state[0] + 1j * state[1]
    s.theta = state[2]
    s.turned = state[2] - lanes.start[2]
    turn = np.exp(1j * s.theta)
    water = water_velocity(world.water, lanes, s.place, time)
    for i, law in enumerate(world.laws):
        if law.form.stage == "water":
            water = water + law(s, lanes.strengths[i])
    s.water = water * np.conj(turn)
    s.added = added_masses(world, lanes, angle)
    s.U, s.r = velocities_from_momentum(
        world.craft, s.added, state[3] + 1j * state[4], state[5], s.water
    )
    s.turn = turn
    s.v = s.U - s.water
    s.V = np.abs(s.v)
    s.u, s.w = s.v.real, s.v.imag
    s.alpha = -np.arctan2(s.w, s.u + 1e-12)
    s.core = s.v * np.exp(-1j * angle)
    s.area, s.arm = world.craft.area(lanes.head), world.craft.arm(lanes.head)
    s.q = 0.5 * RHO * s.area
    return s


def total_forces(
    world: StudyWorld, lanes: ParallelTrials, s: SimpleNamespace, state
) -> tuple[np.ndarray, np.ndarray]:
    """Force F (complex, N) and moment N (N m) on the body: equations 1 to 8 and the laws."""
    C_T, C_D0, C_Da, C_La, C_Ma, C_Md = lanes.coefficients
    rows, calm = _rows(world.laws), s.V**2 + 1e-12
    s.lift = s.turning = -2 * s.u * s.w / calm  # sin 2 alpha
    s.drag = C_D0 + C_Da * 2 * s.w**2 / calm  # 1 - cos 2 alpha = 2 sin^2 alpha
    s.thrust = C_T * s.q * s.flap**2 * (1 + THRUST_PULSE_SHARE * np.cos(2 * s.phase))
    shift, others, torque = 0.0, 0.0, 0.0
    for i, law in enumerate(world.laws):
        k, s.memory = lanes.strengths[i], state[rows[i]]
        match law.form.stage:
            case "head":
                s.lift, s.drag, s.turning = law(s, k)
            case "thrust":
                s.thrust = s.thrust * law(s, k)
            case "balance":
                shift = law(s, k)
    plate = s.q * s.V * s.v * (1j * C_La * s.lift - s.drag)
    M = s.q * s.V**2 * C_Ma * s.turning - C_Md * s.r * np.abs(s.r)
    for i, law in enumerate(world.laws):
        if law.form.stage == "force":
            s.memory = state[rows[i]]
            force, own = law(s, lanes.strengths[i])
            others, torque = others + force, torque + own
    total = s.thrust * np.exp(1j * s.phi) + plate + others
    return total, M + (np.conj(s.arm - shift) * plate).imag + torque


def state_derivative(
    world: StudyWorld, lanes: ParallelTrials, state, time: float, drive_row
) -> np.ndarray:
    """Rate of change of the state, (rows, n)."""
    s = instantaneous_state(world, lanes, state, time, drive_row)
    force, torque = total_forces(world, lanes, s, state)
    P = state[3] + 1j * state[4]
    fluid = water_impulse(world.craft, s.added, s.U, s.r, s.water)[0]
    over_ground = s.U * s.turn
    dP = force - 1j * s.r * P
    out = np.empty_like(state)
    out[0], out[1], out[2] = over_ground.real, over_ground.imag, s.r
    out[3], out[4], out[5] = dP.real, dP.imag, torque - (np.conj(s.v) * fluid).imag
    for rows, law in zip(_rows(world.laws), world.laws, strict=True):
        if law.form.rows:
            s.memory = state[rows]
            out[rows] = law.form.memory(s, law.parameters)
    return out


def initial_state(world: StudyWorld, lanes: ParallelTrials, drive_row) -> np.ndarray:
    """The state at the start, with momenta that belong to the velocities of `lanes.start`."""
    state = np.zeros((_rows(world.laws)[-1].stop if world.laws else RIGID_STATE_ROWS, len(lanes)))
    state[:3] = lanes.start[:3]
    s = instantaneous_state(world, lanes, state, 0.0, drive_row)
    U = (lanes.start[3] + 1j * lanes.start[4]) * np.conj(s.turn)
    _, P, K = water_impulse(world.craft, s.added, U, lanes.start[5], s.water)
    state[3], state[4], state[5] = P.real, P.imag, K
    return state


def simulate_motion(
    world: StudyWorld, lanes: ParallelTrials, seconds: float, step: float = STEP_S
) -> Motion:
    """Motion by the implicit midpoint rule, solved by two fixed-point steps from the last slope."""
    count = int(np.ceil(seconds / step))
    driven = drive_history(lanes, list(world.laws), world.wander, step * (np.arange(count) + 0.5))
    row = (driven.flap[0], 0 * driven.phase[0], driven.angle[0])
    state = initial_state(world, lanes, row)
    slope = state_derivative(world, lanes, state, 0.0, row)
    states = [state]
    for i in range(count):
        row = (driven.flap[i], driven.phase[i], driven.angle[i])
        for _ in range(2):
            slope = state_derivative(world, lanes, state + step / 2 * slope, step * (i + 0.5), row)
        state = state + step * slope
        states.append(state)
    return _motion(world, lanes, np.array(states), driven, step)


def _motion(
    world: StudyWorld, lanes: ParallelTrials, states, driven: DriveHistory, step: float
) -> Motion:
    first = np.zeros((1, len(lanes)))
    last = driven.phase[-1:] + np.pi * step * driven.flap[-1:]
    phase = np.concatenate([first, (driven.phase[1:] + driven.phase[:-1]) / 2, last])
    between = (driven.angle[1:] + driven.angle[:-1]) / 2
    angle = np.concatenate([1.5 * driven.angle[:1] - 0.5 * driven.angle[1:2], between,
                            driven.angle[-1:]])  # fmt: skip
    times = step * np.arange(len(states))
    flat = ParallelTrials(**{k: v[..., None, :] for k, v in vars(lanes).items()})
    s = instantaneous_state(
        world, flat, np.moveaxis(states, 1, 0), times[:, None], (0.0, phase, angle)
    )
    return Motion(times, s.place, s.theta, angle, phase, s.U * s.turn, s.r, s.alpha)


def with_laws(world: StudyWorld, laws) -> StudyWorld:
    """The same world with these laws."""
    return replace(world, laws=tuple(laws))


def set_strengths(lanes: ParallelTrials, strengths) -> ParallelTrials:
    """The lanes with these strengths of the laws, the same in all."""
    column = np.asarray(strengths, dtype=float).reshape(-1, 1)
    return replace(lanes, strengths=np.repeat(column, len(lanes), axis=1))
