"""Water that moves: hidden currents (hook `water`, m/s, complex) and the unrest of every pool.

The unrest has three parts: eddies left by the trial before (a sum of slow cosines a trial), a
seiche (standing wave of the pool's length) and short waves; and a small random turning moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .form import Family
from .robots import Array, Robot

Pool = tuple[float, float]
GRAVITY = 9.81


def current_constant(
    _t: float, z: Array, _pool: Pool, robot: Robot, size: float, shape: float
) -> Array:
    """The same everywhere."""
    return size * robot.speed * np.exp(2j * np.pi * shape) + 0 * z


def current_pump(t: float, z: Array, _pool: Pool, robot: Robot, size: float, shape: float) -> Array:
    """A circulation pump whose flow pulses by a quarter within 11 s."""
    pulse = 1 + 0.25 * np.sin(2 * np.pi * (t / 11 + 3 * shape))
    return size * robot.speed * pulse * np.exp(2j * np.pi * shape) + 0 * z


def current_sheared(
    _t: float, z: Array, pool: Pool, robot: Robot, size: float, shape: float
) -> Array:
    """Along x or against it, 1.3 to 0.7 of size across the pool."""
    sign = 1 if shape < 0.5 else -1
    return sign * size * robot.speed * (1.3 - 0.6 * z.imag / pool[1]) + 0j


def gyre_cell(_t: float, z: Array, pool: Pool, robot: Robot, size: float, shape: float) -> Array:
    """One cell with the stream function sin(pi x/L) sin(pi y/W); G. I. Taylor, 1923."""
    a, b = np.pi * z.real / pool[0], np.pi * z.imag / pool[1]
    sign = 1 if shape < 0.5 else -1
    flow = np.sin(a) * np.cos(b) * pool[0] / pool[1] - 1j * np.cos(a) * np.sin(b)
    return -sign * size * robot.speed * flow * pool[1] / pool[0]


def gyre_vortex(_t: float, z: Array, pool: Pool, robot: Robot, size: float, shape: float) -> Array:
    """Lamb and Oseen's vortex near the centre, core radius a quarter of the width."""
    away = z - complex(pool[0] * (0.4 + 0.2 * shape), 0.5 * pool[1])
    x = np.abs(away) / (0.25 * pool[1]) + 1e-6
    sign = 1 if shape < 0.5 else -1
    return (
        sign
        * size
        * robot.speed
        * 1.567
        * 1j
        * np.exp(1j * np.angle(away))
        * (1 - np.exp(-x * x))
        / x
    )


def gyre_pair(_t: float, z: Array, pool: Pool, robot: Robot, size: float, shape: float) -> Array:
    """Two cells that turn against each other, with a jet along the middle."""
    a, b = np.pi * z.real / pool[0], 2 * np.pi * z.imag / pool[1]
    sign = 1 if shape < 0.5 else -1
    along, across = -np.sin(a) * np.cos(b), 0.5 * pool[1] / pool[0] * np.cos(a) * np.sin(b)
    return sign * size * robot.speed * (along + 1j * across)


FAMILIES = (
    Family("uniform_current", "water", "share_of_speed", "1", 0.01, 0.35,
           {"constant": current_constant, "pump": current_pump, "sheared": current_sheared}),
    Family("pool_gyre", "water", "share_of_speed", "1", 0.01, 0.45,
           {"cell": gyre_cell, "vortex": gyre_vortex, "pair": gyre_pair}),
)  # fmt: skip


@dataclass(frozen=True)
class Unrest:
    """Random water. eddies, torque: complex amplitudes (components, columns); rates: rad/s.

    seiche, chop: amplitude (m/s) and phase a column, as complex numbers.
    """

    eddies: Array
    torque: Array
    rates: Array
    seiche: Array
    chop: Array
    depth: float

    def velocity(self, t: float, z: Array, pool: Pool) -> Array:
        """Velocity of the water (m/s, complex)."""
        slow = (self.eddies * np.cos(self.rates * t + np.angle(self.eddies))).sum(0)
        k = np.pi / pool[0]
        omega = np.sqrt(GRAVITY * k * np.tanh(k * self.depth))
        seiche = np.sin(k * z.real) * (self.seiche * np.exp(1j * omega * t)).real
        k, omega = 6 * k, np.sqrt(GRAVITY * 6 * k)
        chop = 1j * np.cos(k * z.imag) * (self.chop * np.exp(1j * omega * t)).real
        return slow + seiche + chop

    def moment(self, t: float) -> Array:
        """Turning moment (N m)."""
        return (np.abs(self.torque) * np.cos(1.7 * self.rates * t + np.angle(self.torque))).sum(0)


def draw_unrest(
    rng: np.random.Generator, robot: Robot, columns: int, depth: float, level: float
) -> Unrest:
    """Unrest of `columns` trials. level: rms speed of the eddies over the robot's."""

    def normal(scale: float, *shape: int) -> Array:
        return scale * (rng.normal(size=shape) + 1j * rng.normal(size=shape))

    speed, moment = level * robot.speed, 0.04 * level * robot.drag * robot.body_length
    return Unrest(
        eddies=normal(speed / np.sqrt(6), 6, columns),
        torque=normal(moment / np.sqrt(6), 6, columns),
        rates=rng.uniform(0.1, 0.8, (6, columns)) * np.pi * robot.speed / robot.body_length,
        seiche=normal(0.5 * speed, columns), chop=normal(0.4 * speed, columns), depth=depth,
    )  # fmt: skip
