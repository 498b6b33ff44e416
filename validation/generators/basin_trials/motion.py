"""Equations of motion in axes of the core, many runs at once, by the classical Runge-Kutta method.

State (8, runs): x, y, psi, then surge and sway over ground and yaw rate, then the state of a law
with memory, and the heading turned since the start.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from .catalogue import BODY, HEAD, INPUT, WATER
from .form import HALF_DENSITY, Array, HiddenLaw, Quantity, Runs, Situation
from .robots import Fin, Robot
from .water import ResidualWater

STATE_SIZE = 8
MAX_SPEED, MAX_YAW_RATE = 3.0, 20.0
"""Bounds (m/s and rad/s) that keep a bad trial step of a fit finite."""


def situation(
    t: Array, state: Array, runs: Runs, robot: Robot, water: ResidualWater | None
) -> Situation:
    """The moment t (runs,) before any law has acted."""
    x, y, psi, u, v, r, lag, turned = state
    wx, wy = water.velocity(x, y, t, runs.trial) if water else (0.0, 0.0)
    none = np.zeros_like(x)
    return Situation(
        t=t, robot=robot, runs=runs, x=x, y=y, psi=psi, r=r, ground=u + 1j * v, lag=lag,
        turned=turned, phi=runs.phi, f=runs.flap, head=runs.head, command=runs.phi,
        area=runs.head * robot.head_span, arm=robot.arm(runs.head), wx=wx, wy=wy,
        X=none, Y=none, N=none, lag_rate=none,
    )  # fmt: skip


def act(now: Situation, laws: Sequence[HiddenLaw], *stages: str) -> None:
    """Let the laws of these stages act, stage by stage."""
    for stage in stages:
        for law in laws:
            if law.family.stage == stage:
                law.family.act(now, law)


def _fin_stations(fin: Fin, robot: Robot, arm: Quantity) -> Iterator[tuple[Quantity, float]]:
    """Distances behind the centre of mass (m) at which a fin acts, with shares of its area.

    trailing_edge: Lighthill's wake keeps most of the momentum of the last section.
    """
    if fin.form == "trailing_edge":
        reach, rest = robot.tail_reach(), (1 - fin.shape) / 2
        yield from ((reach, fin.shape), (0.6 * reach, rest), (0.25 * reach, rest))
    else:
        yield arm, 1.0


def _fin_load(now: Situation, fin: Fin, w: Quantity) -> Quantity:
    """Side force of a fin over rho/2 area, m2/s2; w is the sideways speed there.

    whicker_fehlner: |u| w + k w |w|. saturating: V^2 k tanh(angle / k). flapping: sqrt(u^2 +
    (k f)^2) w, which damps at rest as well. trailing_edge: |u| w.
    """
    u, k = now.u, fin.shape
    if fin.form == "whicker_fehlner":
        return np.abs(u) * w + k * w * np.abs(w)
    if fin.form == "saturating":
        return (u * u + w * w) * k * np.tanh(np.arctan2(w, np.abs(u) + 1e-9) / k)
    if fin.form == "flapping":
        return np.sqrt(u * u + (k * now.f) ** 2) * w
    return np.abs(u) * w


def add_fin_force(now: Situation, fin: Fin, values: Mapping[str, Array]) -> None:
    """Add side force and moment of core and tail as a fin."""
    half = HALF_DENSITY * values["fin_area"]
    for station, share in _fin_stations(fin, now.robot, values["fin_arm"]):
        behind = station + now.shift
        load = _fin_load(now, fin, now.v - behind * now.r)
        now.Y = now.Y - half * share * load
        now.N = now.N + half * share * load * behind


def add_head_force(now: Situation, values: Mapping[str, Array]) -> None:
    """Add thrust, lift, drag and moment of Eqs. (1) to (8), along and across the core."""
    q = HALF_DENSITY * now.area * now.speed**2
    unit = (now.u + 1j * now.v) / np.maximum(now.speed, 1e-9)
    lift = q * values["C_La"] * now.lift_sine * now.lift_factor
    rise = values["C_Da"] * (1 - np.cos(2 * now.alpha)) * now.drag_factor
    force = (1j * lift - q * (values["C_D0"] + rise)) * unit
    normal = (force * np.conj(1j * np.exp(-1j * now.phi))).real
    now.thrust = values["C_T"] * HALF_DENSITY * now.area * now.f**2 * now.thrust_factor
    now.X = now.X + force.real + now.thrust
    now.Y = now.Y + force.imag
    now.N = now.N + q * values["C_Ma"] * np.sin(2 * now.alpha) * now.moment_factor
    damping = values["C_Md"] * now.r * np.abs(now.r)
    now.N = now.N - damping + normal * (now.arm - now.shift)


def rates(
    t: Array, state: Array, runs: Runs, robot: Robot,
    *, laws: Sequence[HiddenLaw] = (), water: ResidualWater | None = None,
) -> Array:  # fmt: skip
    """Derivative (8, runs) of the state."""
    now = situation(t, state, runs, robot, water)
    act(now, laws, INPUT, WATER)
    now.water = (now.wx + 1j * now.wy) * np.exp(-1j * now.psi)
    relative = now.ground - now.water
    relative = relative / np.maximum(1, np.abs(relative) / MAX_SPEED)
    now.r = np.clip(now.r, -MAX_YAW_RATE, MAX_YAW_RATE)
    now.u, now.v, now.speed = relative.real, relative.imag, np.abs(relative)
    now.alpha = np.angle(np.exp(-1j * now.phi) * np.conj(relative))
    now.lift_sine = np.sin(2 * now.alpha)
    act(now, laws, HEAD)
    add_head_force(now, runs.values)
    if robot.fin:
        add_fin_force(now, robot.fin, runs.values)
    act(now, laws, BODY)
    over_ground = now.ground * np.exp(1j * now.psi)
    return np.stack(
        [over_ground.real, over_ground.imag, now.r, *_accelerations(now), now.lag_rate, now.r]
    )


def _accelerations(now: Situation) -> tuple[Array, Array, Array]:
    """Newton and Euler in turning axes, with Kirchhoff's terms if there is added mass."""
    m, i, r, added = now.robot.mass, now.robot.inertia, now.r, now.added
    u_ground, v_ground = now.ground.real, now.ground.imag
    if added is None:
        return now.X / m + v_ground * r, now.Y / m - u_ground * r, now.N / i
    u_water, v_water = np.real(now.water), np.imag(now.water)
    a11, a22, a26 = added.surge, added.sway, added.coupling
    X = now.X + m * v_ground * r + a11 * r * v_water + (a22 * now.v + a26 * r) * r
    Y = now.Y - m * u_ground * r - a22 * r * u_water - a11 * now.u * r
    N = now.N - added.munk * (a22 - a11) * now.u * now.v - a26 * (now.u + u_water) * r
    determinant = (m + a22) * (i + added.yaw) - a26**2
    dv = ((i + added.yaw) * Y - a26 * N) / determinant
    return X / (m + a11), dv, ((m + a22) * N - a26 * Y) / determinant


def integrate(
    state: Array, runs: Runs, robot: Robot,
    *, step: float, count: int, every: int,
    laws: Sequence[HiddenLaw] = (), water: ResidualWater | None = None,
) -> Array:  # fmt: skip
    """States (count + 1, 8, runs), one for every `every` steps of `step` seconds."""

    def slope(t: Array, state: Array) -> Array:
        return rates(t, state, runs, robot, laws=laws, water=water)

    out = np.empty((count + 1, *state.shape))
    out[0] = state
    t = runs.begin.astype(float).copy()
    for k in range(count):
        for _ in range(every):
            k1 = slope(t, state)
            k2 = slope(t + step / 2, state + step / 2 * k1)
            k3 = slope(t + step / 2, state + step / 2 * k2)
            k4 = slope(t + step, state + step * k3)
            state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            t = t + step
        out[k + 1] = state
    return out
