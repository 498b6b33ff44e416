"""Integration of all trials of a study, and paths on a common grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from .dynamics import commands, evaluate
from .registry import Law
from .world import World

GRID_HZ = 60.0


@dataclass
class Path:
    """States (8, K, N) on a time grid, with head angle and frequency; `end` in seconds."""

    t: np.ndarray
    state: np.ndarray
    phi: np.ndarray
    f: np.ndarray
    end: np.ndarray

    @property
    def grid(self) -> np.ndarray:
        """Times with the shape (K, N)."""
        return np.broadcast_to(self.t, self.phi.shape)

    def thin(self, step: int) -> Path:
        """Every so many samples."""
        return Path(
            self.t[::step],
            self.state[:, :, ::step],
            self.phi[:, ::step],
            self.f[:, ::step],
            self.end,
        )

    def at(self, times: np.ndarray) -> Path:
        """The path at other times (K, N), by cubic splines."""
        k = self.state.shape[1]
        pack = np.concatenate([self.state, self.phi[None], self.f[None]])
        out = np.stack([CubicSpline(self.t, pack[:, i, :], axis=1)(times[i]) for i in range(k)], 1)
        return Path(times, out[:8], out[8], out[9], self.end)


def start_state(world: World) -> np.ndarray:
    """Initial state with the lift memories at their steady values."""
    start = np.zeros((8, world.trials.count, 1))
    start[:6, :, 0] = world.trials.start
    speed = start[3] + 1j * start[4]
    alpha = np.where(
        np.abs(speed) > 1e-6, np.angle(np.exp(1j * start[2]) * np.conj(speed + 1e-12)), 0.0
    )
    start[6] = world.coef["C_La"] * np.sin(2 * alpha)
    return start


def integrate(world: World, laws: list[Law], duration: float) -> Path:
    """One pass of the integrator over all trials at once."""
    k = world.trials.count
    t = np.arange(0.0, duration + 1.0 / GRID_HZ, 1.0 / GRID_HZ)
    start = start_state(world)
    if any(law.form.label == "two_term_indicial" for law in laws):
        start[7] = start[6]

    def rate(time: float, flat: np.ndarray) -> np.ndarray:
        """Derivative of the flattened states."""
        return evaluate(world, np.float64(time), flat.reshape(8, k, 1), laws).ravel()

    scale = np.ones((8, k)) * 1e-6
    scale[:2] *= world.robot.body
    scale[3:5] *= world.scales.speed
    run = solve_ivp(
        rate,
        (0.0, float(t[-1])),
        start.ravel(),
        method="RK45",
        t_eval=t,
        rtol=2e-6,
        atol=scale.ravel(),
        max_step=0.08 * max(1.0, world.scales.time),
    )
    if run.status != 0 or not np.all(np.isfinite(run.y)):
        raise ArithmeticError("the integration failed")
    state = run.y.reshape(8, k, -1)
    phi, f = commands(world, np.broadcast_to(t, state.shape[1:]), state, laws)
    return Path(t, state, phi, f, np.full(k, duration))


def wake_of(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, places and jet directions times speed along a path, for the wake laws."""
    step = max(1, round(0.2 * GRID_HZ))
    p = path.thin(step)
    speed = np.hypot(p.state[3], p.state[4])
    return (p.t, p.state[0] + 1j * p.state[1], speed * np.exp(1j * (p.state[2] + p.phi)) + 1e-9)


def outline(world: World, path: Path) -> np.ndarray:
    """Centre of mass, nose and tail tip (3, K, N) along a path."""
    rb = world.robot
    centre = path.state[0] + 1j * path.state[1]
    core = np.exp(1j * (path.state[2] + path.phi))
    hinge = centre + rb.hinge_to_com * core
    return np.stack(
        [
            centre,
            hinge + world.trials.head * np.exp(1j * path.state[2]),
            hinge - (rb.core + rb.tail) * core,
        ]
    )


def keeps_inside(world: World, points: np.ndarray, share: float = 0.06) -> np.ndarray:
    """Whether all points (first axis) are inside the pool by a share of the body length."""
    margin = share * world.robot.body
    x, y = points.real, points.imag
    return np.all(
        (x > margin)
        & (x < world.pool.length - margin)
        & (y > margin)
        & (y < world.pool.width - margin),
        axis=0,
    )


def simulate(world: World, laws: list[Law]) -> Path:
    """Paths of a study; trials end where the body nears a wall."""
    world.wake = None
    path = integrate(world, laws, world.duration)
    if any(law.name == "wake_reentry" for law in laws):
        for _ in range(2):
            world.wake = wake_of(path)
            path = integrate(world, laws, world.duration)
    world.wake = wake_of(path)
    inside = keeps_inside(world, outline(world, path))
    first_out = np.where(inside.all(1), path.t.size - 1, np.argmin(inside, axis=1))
    path.end = np.minimum(path.t[first_out], world.duration)
    return path
