"""Water and walls: residual motion of the water, and the laws of the place in the pool."""

from __future__ import annotations

import numpy as np

from .form import HALF_DENSITY, POOL_LENGTH, POOL_WIDTH, Array, HiddenLaw, Quantity, Situation

MODE_COUNT = 8


class ResidualWater:
    """Motion of the water left in each trial: eight sine modes of the stream function.

    psi = sum a sin(kx x) sin(ky y). No flow through the walls. Every mode rotates slowly in phase
    and decays.
    """

    def __init__(self, rng: np.random.Generator, trials: int, rms: float) -> None:
        """Draw amplitudes so that the speed has the root mean square `rms` (m/s) at the start."""
        shape = (trials, MODE_COUNT)
        self._kx = rng.integers(1, 6, shape) * np.pi / POOL_LENGTH
        self._ky = rng.integers(1, 5, shape) * np.pi / POOL_WIDTH
        k = np.hypot(self._kx, self._ky)
        self._amplitude = rng.standard_normal(shape) * rms / k / 2
        self._rate = rng.normal(0, 0.25, shape)
        self._phase = rng.uniform(0, 2 * np.pi, shape)
        self._decay = rng.uniform(15, 60, (trials, 1))

    def velocity(self, x: Array, y: Array, t: Array, trial: Array) -> tuple[Array, Array]:
        """Velocity (m/s) along x and y at these places and times in these trials, each (runs,)."""
        kx, ky = self._kx[trial], self._ky[trial]
        a = self._amplitude[trial] * np.exp(-t[:, None] / self._decay[trial])
        a = a * np.cos(self._rate[trial] * t[:, None] + self._phase[trial]) * np.sqrt(2)
        sx, cx = np.sin(kx * x[:, None]), np.cos(kx * x[:, None])
        sy, cy = np.sin(ky * y[:, None]), np.cos(ky * y[:, None])
        return 2 * (a * ky * sx * cy).sum(1), -2 * (a * kx * cx * sy).sum(1)


def uniform_current(now: Situation, law: HiddenLaw) -> None:
    """Current of k m/s: steady, running down from 1.5 k in 2 to 6 s, or a jet along the pool.

    poiseuille: 1.5 k (1 - 0.8 Y^2), Y = 1 at the walls.
    """
    factor: Quantity = 1.0
    direction = 2 * np.pi * law.shape[0]
    if law.form == "running_down":
        factor = 1.5 * np.exp(-now.t / (2 + 4 * law.shape[1]))
    if law.form == "poiseuille":
        factor = 1.5 * (1 - 0.8 * (2 * now.y / POOL_WIDTH - 1) ** 2)
        direction = 0.0 if law.shape[0] < 0.5 else np.pi
    now.wx = now.wx + law.size * factor * np.cos(direction)
    now.wy = now.wy + law.size * factor * np.sin(direction)


def pool_gyre(now: Situation, law: HiddenLaw) -> None:
    """Rotation of the water with the largest speed k.

    lamb_oseen: 1.398 k (1 - exp(-1.2564 s^2)) / s. vatistas: k sqrt(2) s / sqrt(1 + s^4) (Vatistas
    1991). s is the distance from the centre over the core, 0.35 to 0.65 m.
    """
    if law.form == "shallow_basin":
        _shallow_basin_gyre(now, law.size)
        return
    x0 = POOL_LENGTH * (0.4 + 0.2 * law.shape[0])
    y0 = POOL_WIDTH * (0.42 + 0.16 * law.shape[1])
    dx, dy = now.x - x0, now.y - y0
    radius = np.hypot(dx, dy) + 1e-6
    s = radius / (0.35 + 0.3 * law.shape[2])
    if law.form == "lamb_oseen":
        speed = 1.398 * law.size * (1 - np.exp(-1.2564 * s**2)) / s
    else:
        speed = law.size * np.sqrt(2) * s / (1 + s**4) ** 0.5
    now.wx = now.wx - speed * dy / radius
    now.wy = now.wy + speed * dx / radius


def _shallow_basin_gyre(now: Situation, k: float) -> None:
    """One cell with the stream function (1 - X^2)(1 - Y^2), X and Y = 1 at the walls."""
    X = np.clip(2 * now.x / POOL_LENGTH - 1, -1, 1)
    Y = np.clip(2 * now.y / POOL_WIDTH - 1, -1, 1)
    now.wx = now.wx - k * Y * (1 - X**2)
    now.wy = now.wy + k * (POOL_WIDTH / POOL_LENGTH) * X * (1 - Y**2)


def wall_effect(now: Situation, law: HiddenLaw) -> None:
    """Resistance, attraction and moment near a wall, k q A g(gap / reach); reach 0.12 to 0.22 m.

    g = sech^2 s, or 1 / (1 + s^2.5). suction: mainly attraction.
    """
    q = HALF_DENSITY * now.area * now.speed**2
    reach = 0.12 + 0.1 * law.shape[0]
    forms = {"sech2": (1, 0.3, 0.2), "power_2.5": (1, 0.6, 0.0), "suction": (0.5, 1.0, 0.5)}
    drag, pull, turn = forms[law.form]
    gaps = ((now.x, -1), (POOL_LENGTH - now.x, 1), (now.y, -1j), (POOL_WIDTH - now.y, 1j))
    for gap, toward in gaps:
        s = np.maximum(gap, 0.02) / reach
        rational = law.form == "power_2.5"
        share = 1 / (1 + s**2.5) if rational else 1 / np.cosh(np.minimum(s, 20)) ** 2
        near = law.size * q * share
        direction = toward * np.exp(-1j * now.psi)
        now.resist(drag * near)
        now.X = now.X + pull * near * direction.real
        now.Y = now.Y + pull * near * direction.imag
        now.N = now.N + 0.1 * turn * near * direction.imag
