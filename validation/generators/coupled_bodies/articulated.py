"""Motion of head and core, joined by a servo hinge, in moving water.

The head's own centre of mass lies at the hinge, so that the centre of mass of the pair stays on
the axis of the core. The hinge forces are internal; what remains of the equations of both bodies is

    m a = sum of forces,   d/dt (I theta' + I_core phi') = sum of moments

about the centre of mass, with I_core the inertia of the core with the head's mass at its hinge.
A state holds x, y (m), theta (rad), their momenta per mass and inertia (m/s, rad/s), and two
memories of the flow: (8, lanes). With phi constant and no law it is Eq. (8) of the published model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from . import polars, water
from .form import HiddenLaw
from .robots import RHO, ParallelTrials, Robot

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
STEP_S = 1 / 40
FLAT_PLATE_POLAR = polars.flat_plate()


@dataclass(frozen=True)
class SimulatedMotion:
    """Motion on the grid of the integration: times (s), states and rates (times, 8, lanes)."""

    times: Array
    states: Array
    rates: Array

    def at(self, times: Array) -> Array:
        """States at any times, (times, 8, lanes), by cubic Hermite interpolation; rest before 0."""
        times = np.clip(times, 0, self.times[-1])
        low = np.clip((times / STEP_S).astype(int), 0, len(self.times) - 2)
        s = ((times - self.times[low]) / STEP_S)[:, None, None]
        left, right = self.states[low], self.states[low + 1]
        a, b = self.rates[low] * STEP_S, self.rates[low + 1] * STEP_S
        value = left + s * (a + s * (3 * (right - left) - 2 * a - b + s * (
            2 * (left - right) + a + b)))  # fmt: skip
        return np.asarray(value)


def laws_of_stage(laws: Sequence[HiddenLaw], stage: str) -> list[tuple[int, HiddenLaw]]:
    """Laws of a stage with their rows in the strengths."""
    return [(i, law) for i, law in enumerate(laws) if law.form.stage == stage]


def head_angle(
    lanes: ParallelTrials, laws: Sequence[HiddenLaw], t: Array | float
) -> tuple[Array, Array]:
    """Actual head angle, rad, and its rate, rad/s, at one time or at times along a first axis."""
    zero = 0 * np.asarray(t)[..., None]
    phi, rate = lanes.angle + zero, np.zeros(lanes.count) + zero
    for i, law in laws_of_stage(laws, "servo"):
        phi, extra = law.form.law(t, phi, law.sign * lanes.size[i], law.shape)
        rate = rate + extra
    return phi, rate


def frequency(lanes: ParallelTrials, laws: Sequence[HiddenLaw], t: Array | float) -> Array:
    """Flapping frequency, Hz."""
    amp, omega, phase = lanes.wander
    wave = amp * np.cos(omega * np.asarray(t)[..., None, None] + phase)
    f = lanes.flap * (1 + wave.sum(-2))
    for i, law in laws_of_stage(laws, "drive"):
        f = f * law.form.law(t, lanes, lanes.size[i], law.shape)
    return np.asarray(f)


def shaft_revolutions(lanes: ParallelTrials, t: float) -> Array:
    """Revolutions of the motor shaft of an undisturbed drive since the start of the trial."""
    amp, omega, phase = lanes.wander
    extra = (amp / omega * (np.sin(omega * t + phase) - np.sin(phase))).sum(0)
    return np.asarray(lanes.shaft + lanes.flap * (t + extra))


def instantaneous_state(
    t: float, state: Array, lanes: ParallelTrials, robot: Robot, laws: Sequence[HiddenLaw]
) -> SimpleNamespace:
    """All quantities on which a law may depend, at one time; (lanes,) each, SI units."""
    phi, phi_rate = head_angle(lanes, laws, t)
    x, v = state[0] + 1j * state[1], state[3] + 1j * state[4]
    th, r = state[2], state[5] - robot.core_share * phi_rate
    c = SimpleNamespace(t=t, robot=robot, lanes=lanes, x=x, th=th, phi=phi, r=r, head=lanes.head,
                        memory=state[6:8])  # fmt: skip
    for i, law in laws_of_stage(laws, "water"):
        v = v - law.form.law(c, law.sign * lanes.size[i], law.shape)
    c.v = v - water.water_velocity(lanes, x, t)
    c.V = np.abs(c.v)
    c.along = c.v / (c.V + 1e-12)
    c.nose, c.axis = np.exp(1j * th), np.exp(1j * (th + phi))
    c.alpha = -np.angle(c.v * np.conj(c.nose))
    body = c.v * np.conj(c.axis)
    c.u, c.w, c.r_core = body.real, body.imag, r + phi_rate
    c.area, c.arm = lanes.head * robot.span, robot.arm(lanes.head)
    c.q = 0.5 * RHO * c.area * c.V**2
    c.f = frequency(lanes, laws, t)
    c.thrust = lanes.coef[0] * 0.5 * RHO * c.area * c.f**2
    for i, law in laws_of_stage(laws, "mass"):
        c.arm = c.arm + law.form.law(c, lanes.size[i], law.shape)
    return c


def rates(
    t: float, state: Array, lanes: ParallelTrials, robot: Robot, laws: Sequence[HiddenLaw] = ()
) -> Array:
    """Time derivative of the state, (8, lanes)."""
    c = instantaneous_state(t, state, lanes, robot, laws)
    _, C_D0, C_Da, C_La, C_Ma, C_Md = lanes.coef
    lift, drag, turning = polars.interpolate_polar(FLAT_PLATE_POLAR, c.alpha)
    plate = c.q * c.along * (1j * C_La * lift - C_D0 - C_Da * drag)
    M = c.q * C_Ma * turning - C_Md * c.r * np.abs(c.r) + head_moment(c, plate)
    T = c.thrust
    for i, law in laws_of_stage(laws, "thrust"):
        T = T * law.form.law(c, lanes.size[i], law.shape)
    force, memory = plate + T * c.axis, np.zeros((2, lanes.count))
    for i, law in laws_of_stage(laws, "force"):
        F, N = law.form.law(c, law.sign * lanes.size[i], law.shape)
        force, M = force + F, M + N
    for i, law in laws_of_stage(laws, "memory"):
        F, N, memory = law.form.law(c, lanes.size[i], law.shape)
        force, M = force + F, M + N
    for i, law in laws_of_stage(laws, "sink"):
        wet = law.form.law(t, lanes.size[i], law.shape) / robot.span
        force = force - c.q * C_D0 * wet * c.along
    a, r_dot = _accelerations(c, force, M, laws)
    return np.stack([state[3], state[4], c.r, a.real, a.imag, r_dot, *memory])


def head_moment(c: SimpleNamespace, force: Complex) -> Array:
    """Moment of a force at the aerodynamic centre, N l of Eq. (8), N m."""
    return np.asarray((force * np.conj(1j * c.nose)).real * c.arm)


def _accelerations(
    c: SimpleNamespace, force: Complex, M: Array, laws: Sequence[HiddenLaw]
) -> tuple[Complex, Array]:
    """Accelerations (world) with the added masses of Kirchhoff's equations in the core's frame.

    (m + a_x) a_u = X + (a_y - a_x) r w + b r^2,  (m + a_y) a_w + b r' = Y + (a_y - a_x) r u,
    b a_w + (I + a_r) r' = N - munk (a_y - a_x) u w   (Lamb, Hydrodynamics, sec. 124).
    """
    m, inertia = c.robot.mass, c.robot.inertia
    found = laws_of_stage(laws, "inertia")
    if not found:
        return force / m, M / inertia
    (i, law), = found  # fmt: skip
    a_x, a_y, b, a_r, munk = law.form.law(c, c.lanes.size[i], law.shape)
    F, r = force * np.conj(c.axis), c.r_core
    X = F.real + (a_y - a_x) * r * c.w + b * r**2
    Y = F.imag + (a_y - a_x) * r * c.u
    N = M - munk * (a_y - a_x) * c.u * c.w
    det = (m + a_y) * (inertia + a_r) - b**2
    a_w = (Y * (inertia + a_r) - b * N) / det
    r_dot = ((m + a_y) * N - b * Y) / det
    return (X / (m + a_x) + 1j * a_w) * c.axis, r_dot


def simulate_motion(
    lanes: ParallelTrials,
    robot: Robot,
    laws: Sequence[HiddenLaw],
    seconds: float,
    step: float = STEP_S,
) -> SimulatedMotion:
    """Motion from the lanes' starting states, by the classical Runge-Kutta rule."""
    n = int(np.ceil(seconds / step - 1e-9)) + 1
    state = np.concatenate([lanes.start, np.zeros((2, lanes.count))])
    states, slopes = np.empty((n, 8, lanes.count)), np.empty((n, 8, lanes.count))
    for i in range(n):
        t = i * step
        k1 = rates(t, state, lanes, robot, laws)
        states[i], slopes[i] = state, k1
        k2 = rates(t + step / 2, state + step / 2 * k1, lanes, robot, laws)
        k3 = rates(t + step / 2, state + step / 2 * k2, lanes, robot, laws)
        k4 = rates(t + step, state + step * k3, lanes, robot, laws)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return SimulatedMotion(np.arange(n) * step, states, slopes)


def growth_rate(lanes: ParallelTrials, robot: Robot, laws: Sequence[HiddenLaw]) -> float:
    """Fastest growth, 1/s, of a small deviation from straight swimming of the last lane.

    Eigenvalues for the angle of attack, alpha' = r - (sideways acceleration)/V, and the yaw rate.
    """
    base, jacobian = np.zeros((8, lanes.count)), np.zeros((2, 2))
    V = float(np.sqrt(lanes.coef[0] / lanes.coef[1])[-1] * lanes.flap[-1])
    base[3] = V
    for column, row in enumerate((2, 5)):
        step = np.zeros_like(base)
        step[row] = 1e-5
        ends = [rates(3.0, base + sign * step, lanes, robot, laws)[:, -1] for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / 2e-5
        jacobian[:, column] = slope[2] - slope[4] / V, slope[5]
    return float(np.linalg.eigvals(jacobian).real.max())
