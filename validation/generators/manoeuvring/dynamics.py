"""Manoeuvring equations of the robot about a point that is not its centre of mass.

Frames and symbols. World: x, y along the pool, angles counter-clockwise, radians. Body: x along
the head plate, y to port. Reference point O: the aerodynamic centre, a distance l ahead of the
core centre C along the head plate; it does not move when the head turns. State rows: x, y, psi of
O and the head plate; u, v, r (surge and sway of O over ground, yaw rate); two lift lags. Every
array has one column a trial: shape (n,) or (rows, n).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

Array = np.ndarray
COEFFICIENTS = ("C_T", "C_La", "C_D0", "C_Da", "C_Ma", "C_Md")
RHO = 1000.0  # kg/m3
POOL = (2.6, 1.6)  # m


@dataclass(frozen=True)
class Robot:
    """Mass (kg), yaw inertia (kg m2), lengths (m), the paper's six coefficients (6,) or (6, n)."""

    mass: float
    yaw_inertia: float
    body_length: float
    head_1x: float
    span: float
    hinge_to_com: float
    tail_length: float
    depth: float
    coefficients: Array

    def arm(self, head: Array) -> Array:
        """Distance l from core centre to aerodynamic centre, m: h + d - (L + h - h_1x) / 4."""
        # STUDY.md writes (body_length + h - head_length) / 4 with head_length the 1x head.
        return head + self.hinge_to_com - (self.body_length + head - self.head_1x) / 4

    @property
    def aft(self) -> float:
        """Distance from core centre back to caudal base, m."""
        return self.body_length - self.head_1x - self.hinge_to_com


@dataclass(frozen=True)
class TrialInputs:
    """What a trial is given: head angle (rad), flapping (Hz), head length (m), motor start (s).

    `vortices` (5, k, n): x, y (m), circulation (m2/s), drift along x and y (m/s).
    """

    phi: Array
    flap_hz: Array
    head: Array
    start: Array
    vortices: Array
    wake: Array  # (2, n), velocity of the robot's own unit wake, world axes
    gust: Array  # (2, n), m/s, extra uniform water motion (used by the detector)

    def take(self, columns: Array) -> TrialInputs:
        """The same drive with columns chosen or repeated."""
        return TrialInputs(**{k: np.take(v, columns, axis=-1) for k, v in vars(self).items()})


@dataclass(frozen=True)
class HiddenEffect:
    """One hidden effect: a form of a cause, its strength (scalar or (n,)) and its fixed shape."""

    name: str
    form: str
    kind: str
    hook: str
    law: Callable[..., Any]
    strength: Any
    unit: str
    shape: dict[str, float] = field(default_factory=dict)

    def __call__(self, flow: Flow) -> Any:
        """The law's value in a flow."""
        return self.law(flow, self.strength, self.form, self.shape)

    def scaled(self, strength: Any) -> HiddenEffect:
        """The same effect with another strength."""
        return replace(self, strength=strength)


@dataclass(slots=True)
class Flow:
    """What a law may look at; arrays (n,). u, v: velocity of C relative to the water, body axes."""

    robot: Robot
    head: Array
    t: Array  # s since the motor started
    x: Array
    y: Array
    psi: Array
    r: Array
    f: Array
    phi: Array
    wake: Array
    u: Any = 0.0
    v: Any = 0.0
    speed: Any = 0.0
    alpha: Any = 0.0
    thrust: Any = 0.0
    lift: Any = 0.0
    lags: Any = 0.0

    @property
    def area(self) -> Array:
        """Head plate area A, m2."""
        return self.head * self.robot.span

    def core_velocity(self) -> tuple[Array, Array]:
        """Velocity of C relative to the water along and across the core, m/s."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        return self.u * c + self.v * s, self.v * c - self.u * s

    def from_core(self, along: Any, across: Any) -> tuple[Array, Array]:
        """A core-frame force in body (head) axes, N."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        return along * c - across * s, along * s + across * c

    def from_world(self, fx: Any, fy: Any) -> tuple[Array, Array]:
        """A world-frame vector in body axes."""
        c, s = np.cos(self.psi), np.sin(self.psi)
        return fx * c + fy * s, fy * c - fx * s


def effects_of_hook(effects: Sequence[HiddenEffect], hook: str) -> list[HiddenEffect]:
    """The effects of one hook."""
    return [e for e in effects if e.hook == hook]


def vortex_water(t: Array, x: Array, y: Array, vortices: Array) -> tuple[Array, Array]:
    """Water velocity of drifting viscous point vortices, m/s: Gamma d / (2 pi (d^2 + a^2)).

    Kaufmann (1962) core of a = 0.18 m; positions advance with a constant drift.
    """
    dx = x - vortices[0] - vortices[3] * t
    dy = y - vortices[1] - vortices[4] * t
    k = vortices[2] / (2 * np.pi * (dx**2 + dy**2 + 0.18**2))
    return -(k * dy).sum(0), (k * dx).sum(0)


def apply_drive(t: Array, drive: TrialInputs, flow: Flow, effects: Sequence[HiddenEffect]) -> None:
    """Set flapping frequency (Hz) and head angle (rad) as the robot has them at time t."""
    flow.f = drive.flap_hz * (t >= drive.start - 1e-9)
    flow.phi = drive.phi + 0.0 * flow.t
    for e in effects_of_hook(effects, "frequency"):
        flow.f = e(flow)
    for e in effects_of_hook(effects, "angle"):
        flow.phi = e(flow)


def head_plate(flow: Flow, robot: Robot, effects: Sequence[HiddenEffect]) -> tuple[Array, ...]:
    """Eqs. (2) to (7) of the paper about C with lift effects: X, Y (N), N (N m), lag rates."""
    C_La, C_D0, C_Da, C_Ma, C_Md = robot.coefficients[1:]
    q = 0.5 * RHO * flow.area * flow.speed**2
    flow.lift = C_La * np.sin(2 * flow.alpha)
    for e in effects_of_hook(effects, "lift"):
        flow.lift = flow.lift * e(flow)
    lag_rates = np.zeros_like(flow.lags)
    for e in effects_of_hook(effects, "lag"):
        flow.lift, lag_rates = e(flow)
    C_D = C_D0 + C_Da * (1 - np.cos(2 * flow.alpha))
    ca, sa = np.cos(flow.alpha), -np.sin(flow.alpha)  # direction of v in body axes
    X = q * (-flow.lift * sa - C_D * ca)
    Y = q * (flow.lift * ca - C_D * sa)
    M = q * C_Ma * np.sin(2 * flow.alpha) - C_Md * flow.r * np.abs(flow.r)
    return X, Y, M + Y * robot.arm(flow.head), lag_rates


def total_forces(flow: Flow, robot: Robot, effects: Sequence[HiddenEffect]) -> tuple[Array, ...]:
    """Sum of thrust, head plate and hidden forces about C, body axes: X, Y, N, lag rates."""
    thrust = robot.coefficients[0] * 0.5 * RHO * flow.area * flow.f**2  # Eq. (1)
    flow.thrust = thrust
    for e in effects_of_hook(effects, "thrust"):
        flow.thrust = flow.thrust * e(flow)
    X, Y, N, lag_rates = head_plate(flow, robot, effects)
    tx, ty = flow.from_core(flow.thrust, 0.0)
    X, Y = X + tx, Y + ty
    for e in effects_of_hook(effects, "force"):
        dX, dY, dN = e(flow)
        X, Y, N = X + dX, Y + dY, N + dN
    return X, Y, N, lag_rates


def solve_symmetric(m: tuple[Array, ...], b: tuple[Array, ...]) -> tuple[Array, Array, Array]:
    """Solution of a symmetric 3 x 3 system by cofactors; m = (m11, m12, m13, m22, m23, m33)."""
    a, p, q, c, s, d = m
    c11, c12, c13 = c * d - s * s, q * s - p * d, p * s - c * q
    c22, c23, c33 = a * d - q * q, p * q - a * s, a * c - p * p
    det = a * c11 + p * c12 + q * c13
    return (
        (c11 * b[0] + c12 * b[1] + c13 * b[2]) / det,
        (c12 * b[0] + c22 * b[1] + c23 * b[2]) / det,
        (c13 * b[0] + c23 * b[1] + c33 * b[2]) / det,
    )


def water_velocity(
    t: Array, drive: TrialInputs, flow: Flow, effects: Sequence[HiddenEffect]
) -> tuple[Array, Array]:
    """Water velocity at C, world axes, m/s: random vortices, gust and hidden currents."""
    wx, wy = vortex_water(t, flow.x, flow.y, drive.vortices)
    wx, wy = wx + drive.gust[0], wy + drive.gust[1]
    for e in effects_of_hook(effects, "water"):
        ex, ey = e(flow)
        wx, wy = wx + ex, wy + ey
    return wx, wy


def rates(
    t: Array, S: Array, robot: Robot, drive: TrialInputs, effects: Sequence[HiddenEffect]
) -> Array:
    """Time derivative of the state, (8, n).

    Rigid body about O with the mass at (x_G, y_G) (Fossen 2011, sec. 3.3):
    m (u' - v r - x_G r^2 - y_G r') = X, m (v' + u r - y_G r^2 + x_G r') = Y,
    I_O r' + m [x_G (v' + u r) - y_G (u' - v r)] = N_O.
    """
    x, y, psi, u, v, r = S[:6]
    c, s = np.cos(psi), np.sin(psi)
    arm = robot.arm(drive.head)
    flow = Flow(
        robot, drive.head, t - drive.start, x - arm * c, y - arm * s, psi, r, r, r, drive.wake
    )
    apply_drive(t, drive, flow, effects)
    wx, wy = flow.from_world(*water_velocity(t, drive, flow, effects))
    flow.u, flow.v, flow.lags = u - wx, v - arm * r - wy, S[6:8]
    flow.speed = np.hypot(flow.u, flow.v)
    flow.alpha = -np.arctan2(flow.v, flow.u)
    X, Y, N, lag_rates = total_forces(flow, robot, effects)
    N = N - arm * Y  # about O
    m, xG, yG = robot.mass, -arm, 0.0 * arm
    for e in effects_of_hook(effects, "mass"):
        dx, dy = flow.from_core(*e(flow))
        xG, yG = xG + dx, yG + dy
    X = X + m * (v * r + xG * r**2)
    Y = Y + m * (-u * r + yG * r**2)
    N = N - m * (xG * u * r + yG * v * r)
    M = [m + 0 * r, 0 * r, -m * yG, m + 0 * r, m * xG]
    M.append(robot.yaw_inertia + m * (xG**2 + yG**2))
    for e in effects_of_hook(effects, "added_mass"):
        M, X, Y, N = add_fluid_inertia(M, (X, Y, N), flow, (wx, wy), e(flow), arm=arm)
    du, dv, dr = solve_symmetric(tuple(M), (X, Y, N))
    return np.stack([u * c - v * s, u * s + v * c, r, du, dv, dr, *lag_rates])


def add_fluid_inertia(
    M: list[Array], F: tuple, flow: Flow, water: tuple, own: tuple, *, arm: Array
) -> tuple[list[Array], Array, Array, Array]:
    """Mass matrix and forces about O with added mass (Kirchhoff; Lamb 1932, art. 124).

    `own` = (m11, m22, m66, m26) about C in core axes, kg, kg, kg m2, kg m. p = M_A nu:
    F = -r x p, N = -(u p_y - v p_x); the current's rate in turning axes is added (Fossen 2011).
    """
    k11, k22, k66, k26 = own
    c, s = np.cos(flow.phi), np.sin(flow.phi)
    a11, a22 = k11 * c * c + k22 * s * s, k11 * s * s + k22 * c * c
    a12, a16, a26 = (k11 - k22) * c * s, -k26 * s, k26 * c
    u, v, r = flow.u, flow.v, flow.r
    px, py = a11 * u + a12 * v + a16 * r, a12 * u + a22 * v + a26 * r
    gx, gy = r * water[1], -r * water[0]
    X = r * py + a11 * gx + a12 * gy
    Y = -r * px + a12 * gx + a22 * gy
    N = -(u * py - v * px) + a16 * gx + a26 * gy - arm * Y
    b16, b26 = a16 - arm * a12, a26 - arm * a22
    b66 = k66 - 2 * arm * a26 + arm**2 * a22
    M = [m + a for m, a in zip(M, (a11, a12, b16, a22, b26, b66), strict=True)]
    return M, F[0] + X, F[1] + Y, F[2] + N


def rk4_step(
    t: Array,
    S: Array,
    dt: float,
    robot: Robot,
    drive: TrialInputs,
    *,
    effects: Sequence[HiddenEffect],
) -> Array:
    """State after one classical Runge-Kutta step (Kutta 1901)."""
    k1 = rates(t, S, robot, drive, effects)
    k2 = rates(t + dt / 2, S + dt / 2 * k1, robot, drive, effects)
    k3 = rates(t + dt / 2, S + dt / 2 * k2, robot, drive, effects)
    k4 = rates(t + dt, S + dt * k3, robot, drive, effects)
    return S + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@dataclass(frozen=True)
class SimulatedPath:
    """Simulated trials: time (K,), state (K, 8, n), unit wake velocity (K, 2, n)."""

    t: Array
    S: Array
    wake: Array

    def core(self, robot: Robot, head: Array) -> tuple[Array, Array, Array]:
        """Core centre x, y (m) and head direction (rad), each (K, n)."""
        arm = robot.arm(head)
        x, y, psi = self.S[:, 0], self.S[:, 1], self.S[:, 2]
        return x - arm * np.cos(psi), y - arm * np.sin(psi), psi


def simulate(
    pose: Array,
    robot: Robot,
    drive: TrialInputs,
    effects: Sequence[HiddenEffect],
    *,
    fps: float,
    frames: int,
) -> SimulatedPath:
    """Trials from rest at `pose` (3, n): x, y of C (m) and heading (rad), at the frame times."""
    n, sub = pose.shape[1], int(np.ceil(50 / fps))
    arm = robot.arm(drive.head)
    S = np.zeros((frames, 8, n))
    wake = np.zeros((frames, 2, n))
    S[0, :3] = pose + np.stack([arm * np.cos(pose[2]), arm * np.sin(pose[2]), 0 * arm])
    t = np.arange(frames) / fps
    wakes = [e for e in effects if e.name == "wake_reentry"]
    with np.errstate(all="ignore"):
        for k in range(frames - 1):
            if wakes:
                wake[k] = own_wake_velocity(t[: k + 1], S[: k + 1], drive, arm, wakes[0])
                drive = replace(drive, wake=wake[k])
            state = S[k]
            for j in range(sub):
                tj = t[k] + j / (fps * sub)
                state = rk4_step(tj, state, 1 / (fps * sub), robot, drive, effects=effects)
            S[k + 1] = np.clip(state, -50, 50)
    return SimulatedPath(t, S, wake)


def own_wake_velocity(
    t: Array, S: Array, drive: TrialInputs, arm: Array, effect: HiddenEffect
) -> Array:
    """Velocity (2, n) of the jet the robot left behind, for unit strength, where it is now.

    Gaussian jet of half width b, backward along the core, of age a > 1.5 s. Decay with age:
    exponential; similarity 1/(1+a/tau) (Schlichting 1979, XXIV); spreading, b = b0 sqrt(1+a/tau);
    top_hat, uniform inside b.
    """
    x, y = S[:, 0] - arm * np.cos(S[:, 2]), S[:, 1] - arm * np.sin(S[:, 2])
    age = np.maximum(t[-1] - t, 0)[:, None]
    tau, b = effect.shape["decay_s"], effect.shape["width_m"]
    weight = np.exp(-age / tau) if effect.form == "exponential" else 1 / (1 + age / tau)
    b = b * np.sqrt(1 + age / tau) if effect.form == "spreading" else b
    d2 = ((x - x[-1]) ** 2 + (y - y[-1]) ** 2) / b**2
    shape = 1 / (1 + d2**4) if effect.form == "top_hat" else np.exp(-d2)
    w = np.where(age > 1.5, weight * shape, 0.0)
    k, cols = w.argmax(0), np.arange(w.shape[1])
    direction = S[k, 2, cols] + drive.phi
    return -w[k, cols] * np.stack([np.cos(direction), np.sin(direction)])
