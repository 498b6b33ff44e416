"""Momentum formulation of the planar robot and its implicit-midpoint integrator.

State ``y`` of shape (8, B) for B trials: x, y (m), theta (rad), P_x, P_y (kg m/s, world axes),
H (kg m^2/s, about the centre of mass), z_1, z_2 (lagged lift coefficients). With added mass A in
the head frame and relative velocity nu_r = (u, v, r), P = m V + R A nu_r and H = I r + (A nu_r)_3;
Kirchhoff's equations are P' = F and H' = M - (u p_v - v p_u) with p = A nu_r (Lamb 1932, arts.
124-126). Without added mass this is equations (1) to (8) of the paper.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .effects import Form

DENSITY = 1000.0  # kg/m^3


@dataclass(frozen=True)
class Robot:
    """Mass properties and geometry (SI) and the six coefficients of the base model."""

    mass: float
    inertia: float
    body_length: float
    head_length: float
    head_span: float
    hinge_to_com: float
    tail_length: float
    depth: float
    C_T: float  # m^2
    C_La: float
    C_D0: float
    C_Da: float
    C_Ma: float  # m
    C_Md: float  # kg m^2

    @property
    def tail_base(self) -> float:
        """Distance (m) of the caudal base behind the centre of mass."""
        return self.body_length - self.head_length - self.hinge_to_com


@dataclass(frozen=True)
class Trials:
    """Conditions of B trials, each field of shape (B,); SI units and radians."""

    power: np.ndarray
    phi: np.ndarray  # commanded head angle
    servo: np.ndarray  # servo error, rad
    head: np.ndarray  # head length, m
    f: np.ndarray  # true steady flapping frequency, Hz
    duration: np.ndarray
    x0: np.ndarray
    y0: np.ndarray
    theta0: np.ndarray

    def take(self, rows: np.ndarray) -> Trials:
        """The trials at ``rows``, repeated as given."""
        return Trials(**{k.name: getattr(self, k.name)[rows] for k in fields(self)})


@dataclass(frozen=True)
class HiddenEffect:
    """One effect in action: its form, strength (the form's unit) and constants."""

    form: Form
    strength: float
    constants: dict


@dataclass(frozen=True)
class StudyWorld:
    """Robot, pool and the hidden effects."""

    robot: Robot
    pool: tuple[float, float]
    hidden: tuple[HiddenEffect, ...] = ()

    def active(self, channel: str) -> Iterator[HiddenEffect]:
        """Effects of non-zero strength that act through ``channel``."""
        return (h for h in self.hidden if h.form.channel == channel and h.strength != 0)

    def with_strength(self, i: int, strength: float) -> StudyWorld:
        """The same world with effect ``i`` at another strength."""
        changed = replace(self.hidden[i], strength=strength)
        return replace(self, hidden=(*self.hidden[:i], changed, *self.hidden[i + 1 :]))

    def head_angle(self, t: np.ndarray, trials: Trials) -> np.ndarray:
        """Actual head angle (rad) at time ``t``: command, servo error and hidden effects."""
        phi = trials.phi + trials.servo
        for h in self.active("head_angle"):
            phi = h.form.law(phi, t, trials, h.strength, h.constants)
        return phi

    def frequency(self, t: np.ndarray, trials: Trials) -> np.ndarray:
        """Actual flapping frequency (Hz) at time ``t``."""
        f = trials.f
        for h in self.active("frequency"):
            f = h.form.law(f, t, trials, h.strength, h.constants)
        return f


@dataclass(frozen=True)
class Flow:
    """What a force law sees, each of shape (B,); complex numbers are world-axis vectors."""

    t: np.ndarray
    place: np.ndarray  # x + iy, m
    theta: np.ndarray
    phi: np.ndarray
    f: np.ndarray
    v: np.ndarray  # velocity relative to the water, m/s
    U: np.ndarray  # |v|
    r: np.ndarray  # yaw rate, rad/s
    alpha: np.ndarray
    area: np.ndarray  # head plate, m^2
    trials: Trials
    world: StudyWorld

    @property
    def head(self) -> np.ndarray:
        """Unit vector along the head plate."""
        return np.exp(1j * self.theta)

    @property
    def core(self) -> np.ndarray:
        """Unit vector along core and tail, pointing forward."""
        return np.exp(1j * (self.theta + self.phi))

    @property
    def v_hat(self) -> np.ndarray:
        """Direction of motion; zero at rest."""
        return self.v / np.maximum(self.U, 1e-9)

    def behind(self, distance: float) -> tuple[np.ndarray, np.ndarray]:
        """Forward and leftward speed (m/s, core frame) of the core axis ``distance`` m behind the
        COM.
        """
        local = self.v * np.conj(self.core) - 1j * self.r * distance
        return local.real, local.imag


def aerodynamic_arm(robot: Robot, head: np.ndarray) -> np.ndarray:
    """l(h) = h + hinge_to_com - (body_length + h - head_length)/4, in m."""
    return head + robot.hinge_to_com - (robot.body_length + head - robot.head_length) / 4


def planar_moment(lever: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moment (N m) of a planar force at ``lever`` from the centre of mass: Im(conj(lever) F)."""
    return (np.conj(lever) * force).imag


def mass_matrix(world: StudyWorld, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Total and added mass matrices (B, 3, 3) in the head frame, order surge, sway, yaw."""
    added = np.zeros((len(phi), 3, 3))
    for h in world.active("mass"):
        added += h.form.law(world.robot, phi, h.strength, h.constants)
    rigid = np.diag([world.robot.mass, world.robot.mass, world.robot.inertia])
    return rigid + added, added


def water_velocity(
    world: StudyWorld, place: np.ndarray, t: np.ndarray, trials: Trials
) -> np.ndarray:
    """Velocity (m/s, complex) of the water itself at ``place``."""
    total = np.zeros(len(place), complex)
    for h in world.active("water"):
        total = total + h.form.law(place, t, (trials, world.pool), h.strength, h.constants)
    return total


def velocities(
    world: StudyWorld, trials: Trials, t: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Solve M nu_r = (R^T P - m w, H): world velocity, nu_r (B, 3), added momentum (B, 3), phi."""
    phi = world.head_angle(t, trials)
    water = water_velocity(world, y[0] + 1j * y[1], t, trials)
    turn = np.exp(1j * y[2])
    p = (y[3] + 1j * y[4] - world.robot.mass * water) * np.conj(turn)
    if not any(world.active("mass")):
        nu = np.stack([p.real, p.imag], 1) / world.robot.mass
        nu = np.column_stack([nu, y[5] / world.robot.inertia])
        added = np.zeros_like(nu)
    else:
        total, extra = mass_matrix(world, phi)
        nu = np.linalg.solve(total, np.stack([p.real, p.imag, y[5]], 1)[..., None])[..., 0]
        added = np.einsum("bij,bj->bi", extra, nu)
    return (nu[:, 0] + 1j * nu[:, 1]) * turn + water, nu, added, phi


def head_lever(flow: Flow) -> np.ndarray:
    """Aerodynamic centre of the head plate, seen from the centre of mass (m, complex)."""
    lever = aerodynamic_arm(flow.world.robot, flow.trials.head) * flow.head
    for h in flow.world.active("mass_centre"):
        lever = lever - h.form.law(flow, h.strength, h.constants)
    return lever


def thrust(flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """T (N, complex; Eq. 1) and its moment (N m), which is zero in the base model."""
    robot = flow.world.robot
    T = robot.C_T * 0.5 * DENSITY * flow.area * flow.f**2
    for h in flow.world.active("thrust"):
        T = T * h.form.law(flow, h.strength, h.constants)
    M = np.zeros_like(T)
    for h in flow.world.active("thrust_moment"):
        M = M + T * h.form.law(flow, h.strength, h.constants)
    for h in flow.world.active("mass_centre"):
        M = M - planar_moment(h.form.law(flow, h.strength, h.constants), T * flow.core)
    return T * flow.core, M


def head_plate_load(flow: Flow, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Head-plate force (N), moment (N m; Eqs. 2-7) and the rates of the lag states ``z`` (2, B)."""
    robot, alpha = flow.world.robot, flow.alpha
    q = 0.5 * DENSITY * flow.area * flow.U**2
    C_L = robot.C_La * np.sin(2 * alpha)
    for h in flow.world.active("lift"):
        C_L = C_L * h.form.law(flow, h.strength, h.constants)
    rates = np.zeros_like(z)
    for h in flow.world.active("lag"):
        k, weight = h.form.law(flow, h.strength, h.constants)
        rates = k * (C_L - z)
        C_L = C_L + (weight * (z - C_L)).sum(0)
    C_D = robot.C_D0 + robot.C_Da * (1 - np.cos(2 * alpha))
    force = q * (1j * C_L - C_D) * flow.v_hat
    # Eq. 8: only the component of L + D normal to the plate makes a moment at the arm l.
    M = q * robot.C_Ma * np.sin(2 * alpha) - robot.C_Md * flow.r * np.abs(flow.r)
    return force, M + planar_moment(head_lever(flow), force), rates


def rates(
    world: StudyWorld, trials: Trials, t: np.ndarray, y: np.ndarray, push: np.ndarray | float = 0.0
) -> np.ndarray:
    """Rates y' (8, B); ``push`` (3, B) is the coloured acceleration by random water motion (m/s^2,
    rad/s^2).
    """
    V, nu, added, phi = velocities(world, trials, t, y)
    v = (nu[:, 0] + 1j * nu[:, 1]) * np.exp(1j * y[2])
    U = np.abs(v)
    alpha = np.where(U > 1e-9, -np.arctan2(nu[:, 1], nu[:, 0]), 0.0)
    flow = Flow(
        t, y[0] + 1j * y[1], y[2], phi, world.frequency(t, trials), v, U, nu[:, 2], alpha,
        trials.head * world.robot.head_span, trials, world,
    )  # fmt: skip
    force, M = thrust(flow)
    on_plate, plate_moment, lag = head_plate_load(flow, y[6:])
    force, M = force + on_plate, M + plate_moment
    for h in world.active("force"):
        extra, extra_moment = h.form.law(flow, h.strength, h.constants)
        force, M = force + extra, M + extra_moment
    M = M - (nu[:, 0] * added[:, 1] - nu[:, 1] * added[:, 0])
    out = np.stack([V.real, V.imag, nu[:, 2], force.real, force.imag, M, *lag])
    out[3:6] += np.array([[world.robot.mass]] * 2 + [[world.robot.inertia]]) * push
    return out


def midpoint_step(  # noqa: PLR0917
    world: StudyWorld,
    trials: Trials,
    t: np.ndarray,
    y: np.ndarray,
    dt: float,
    push: np.ndarray | float,
) -> np.ndarray:
    """Implicit midpoint: y+ = y + dt f(t + dt/2, (y + y+)/2), by three passes."""
    middle = y
    for _ in range(3):
        middle = y + 0.5 * dt * rates(world, trials, t + 0.5 * dt, middle, push)
    return 2 * middle - y


def state_at_rest(world: StudyWorld, trials: Trials) -> np.ndarray:
    """Initial state (8, B) at rest; in moving water the added mass has momentum."""
    y = np.zeros((8, len(trials.phi)))
    y[:3] = trials.x0, trials.y0, trials.theta0
    zero = np.zeros(len(trials.phi))
    if any(world.active("mass")) and any(world.active("water")):
        water = water_velocity(world, y[0] + 1j * y[1], zero, trials) * np.exp(-1j * y[2])
        _, added = mass_matrix(world, world.head_angle(zero, trials))
        p = -np.einsum("bij,bj->bi", added, np.stack([water.real, water.imag, zero], 1))
        linear = (p[:, 0] + 1j * p[:, 1]) * np.exp(1j * y[2])
        y[3], y[4], y[5] = linear.real, linear.imag, p[:, 2]
    return y


def simulate(world: StudyWorld, trials: Trials, gusts: np.ndarray, per_second: int) -> np.ndarray:
    """States (steps + 1, 8, B) ``per_second``; ``gusts`` (samples, 3, B) at 40 per s."""
    steps = int(np.ceil(trials.duration.max() * per_second)) + 1
    dt, y = 1 / per_second, state_at_rest(world, trials)
    out = np.empty((steps + 1, *y.shape))
    out[0] = y
    for k in range(steps):
        t = k * dt
        j = min(int((t + dt / 2) * 40), len(gusts) - 2)
        weight = (t + dt / 2) * 40 - j
        push = (1 - weight) * gusts[j] + weight * gusts[j + 1]
        out[k + 1] = y = midpoint_step(world, trials, np.full(y.shape[1], t), y, dt, push)
    return out


def straight_growth_rate(world: StudyWorld, f: float) -> float:
    """Largest growth rate (1/s) of sway and yaw about straight swimming at frequency ``f``."""
    robot = world.robot
    U = f * np.sqrt(robot.C_T / robot.C_D0)
    zero, n = np.zeros(7), 7
    y = np.zeros((8, n))
    y[3] = robot.mass * U
    size = np.array([1e-4, 1e-5, 1e-6])
    for j, row in enumerate((2, 4, 5)):
        y[row, 1 + 2 * j], y[row, 2 + 2 * j] = size[j], -size[j]
    full = np.full(n, robot.head_length)
    trials = Trials(zero, zero, zero, full, zero + f, zero, zero, zero, zero)
    dy = rates(world, trials, zero, y)[[2, 4, 5]]
    eigenvalues = np.linalg.eigvals((dy[:, 1::2] - dy[:, 2::2]) / (2 * size))
    return float(np.sort_complex(eigenvalues[np.argsort(np.abs(eigenvalues))[1:]]).real.max())
