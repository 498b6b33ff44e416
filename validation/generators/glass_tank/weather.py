"""What is random in the tank and in the robot: moving water, tail forces, an imperfect servo."""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import DT, Array, Disturbance
from .robots import Robot

MODES = np.array([[1, 1], [2, 1], [1, 2], [3, 1], [2, 2], [3, 2]])
"""Half waves of the stream functions along the length and the width of the pool."""


def ornstein_uhlenbeck(
    rng: np.random.Generator, shape: tuple[int, ...], n: int, dt: float, tau: float
) -> Array:
    """Stationary noise of unit variance and correlation time tau (s), n steps: (n, *shape)."""
    keep = np.exp(-dt / tau)
    out = np.empty((n, *shape))
    fresh = rng.standard_normal((n, *shape))
    out[0] = fresh[0]
    share = np.sqrt(1 - keep * keep)
    for k in range(1, n):
        out[k] = keep * out[k - 1] + share * fresh[k]
    return out


def draw_noise(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    """Standard deviations and time constants of everything random in a study."""

    def between(low: float, high: float, digits: int, unit: float = 1.0) -> float:
        return round(rng.uniform(low, high) * unit, digits)

    thrust, length = robot.top_thrust, robot.body_length
    return {
        "linear_m_s2": round(rng.uniform(0.008, 0.025) * thrust / robot.mass, 5),
        "turning_rad_s2": round(rng.uniform(0.002, 0.006) * thrust * length / robot.inertia, 4),
        "pole_rad_s": between(1.0, 5.0, 3),
        "water_m_s": between(0.002, 0.006, 5, robot.top_speed),
        "water_tau_s": between(3, 9, 2),
        "servo_deg": between(0.2, 0.6, 3),
        "servo_tau_s": 20.0,
        "white_px": between(0.3, 0.9, 3),
        "slow_px": between(0.25, 0.8, 3),
        "slow_tau_s": between(0.1, 0.5, 3),
        "corner_px": between(0.3, 1.0, 3),
        "recoil_deg": between(0.5, 2.5, 3),
        "recoil_sway_BL": between(0.002, 0.008, 5),
        "tail_beat_deg": between(12, 25, 2),
        "outlier_share": between(0.002, 0.012, 4),
        "gap_share": between(0.005, 0.04, 4),
    }


class Weather:
    """One realisation for all trials on the grid of step DT.

    Water: stream functions sin(k pi x/L) sin(l pi y/W) whose amplitudes are independent random
    processes; divergence-free, no flow through the walls, rms speed `water_m_s` in the middle.
    """

    def __init__(
        self, rng: np.random.Generator, robot: Robot, noise: dict[str, Any], steps: int
    ) -> None:
        n, trials = steps + 2, robot.trials
        linear, turning = noise["linear_m_s2"], noise["turning_rad_s2"]
        sizes = np.array([linear, linear, turning])[:, None]
        self._push = sizes * ornstein_uhlenbeck(rng, (3, trials), n, DT, 1 / noise["pole_rad_s"])
        errors = ornstein_uhlenbeck(rng, (trials,), n, DT, noise["servo_tau_s"])
        self._servo = np.radians(noise["servo_deg"]) * errors
        kx, ky = np.pi * MODES[:, 0] / robot.pool[0], np.pi * MODES[:, 1] / robot.pool[1]
        self._kx, self._ky = kx[:, None], ky[:, None]
        # one mode of amplitude 1 / |k| has mean square speed 1/4
        size = 2 * noise["water_m_s"] / np.sqrt(len(kx)) / np.hypot(kx, ky)
        modes = ornstein_uhlenbeck(rng, (len(kx), trials), n, DT, noise["water_tau_s"])
        self._modes = size[:, None] * modes

    def disturbance(self, step: int, x: Array, y: Array) -> Disturbance:
        """Disturbance of a step at the place (m) of each trial."""
        return Disturbance(self._push[step], self.drift(step, x, y), self._servo[step])

    def drift(self, step: int, x: Array, y: Array) -> Array:
        """Velocity of the water (complex, m/s) at the place (m) of each trial."""
        return self._flow(self._modes[step], x, y)

    def _flow(self, amplitudes: Array, x: Array, y: Array) -> Array:
        X, Y = self._kx * x, self._ky * y
        u = (amplitudes * self._ky * np.sin(X) * np.cos(Y)).sum(0)
        v = -(amplitudes * self._kx * np.cos(X) * np.sin(Y)).sum(0)
        return u + 1j * v

    def servo_and_drift(self, t: Array, x: Array, y: Array, trial: Array) -> tuple[Array, Array]:
        """Error of the servo (rad) and velocity of the water at times t (s) of these trials."""
        k = np.clip(np.round(t / DT).astype(int), 0, len(self._servo) - 1)
        return self._servo[k, trial], self._flow(self._modes[k, :, trial].T, x, y)

    def servo_error(self, t: Array, trial: int) -> Array:
        """Error of the servo (rad) of one trial at times t (s), linear between the steps."""
        k = np.clip(t / DT, 0, len(self._servo) - 1)
        return np.interp(k, np.arange(len(self._servo)), self._servo[:, trial])


class Calm:
    """Still water, a steady tail and a perfect servo."""

    def __init__(self, trials: int) -> None:
        still = np.zeros(trials, complex)
        self._none = Disturbance(np.zeros((3, trials)), still, np.zeros(trials))

    def disturbance(self, *_: object) -> Disturbance:
        """No disturbance."""
        return self._none

    def servo_and_drift(self, t: Array, *_: object) -> tuple[Array, Array]:
        """No error of the servo, no drift."""
        return np.zeros(np.shape(t)), np.zeros(np.shape(t), complex)

    def servo_error(self, t: Array, _: int) -> Array:
        """No error of the servo."""
        return 0 * t
