"""Exact motions whose derivatives are known by hand, seen through recoil, noise and gaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import lfilter

from bluekoi.data import Float, Pose

FPS = 30000 / 1001


@dataclass(frozen=True)
class Motion:
    """True mean motion: position (n, 2), heading, velocity (n, 2), yaw rate."""

    time_s: Float
    xy: Float
    heading: Float
    velocity: Float
    yaw_rate: Float

    @property
    def speed(self) -> Float:
        return np.hypot(*self.velocity.T)


def frame_times(n: int = 240) -> Float:
    return np.arange(n) / FPS


def at_rest(t: Float) -> Motion:
    n = len(t)
    return Motion(t, np.full((n, 2), 0.8), np.full(n, 0.4), np.zeros((n, 2)), np.zeros(n))


def straight_line(t: Float, speed: float = 0.3, heading: float = 0.3) -> Motion:
    way = np.array([np.cos(heading), np.sin(heading)])
    xy, n = 0.3 + speed * t[:, None] * way, len(t)
    return Motion(t, xy, np.full(n, heading), np.tile(speed * way, (n, 1)), np.zeros(n))


def gaining_speed(t: Float, first: float = 0.15, last: float = 0.3, T: float = 1.2) -> Motion:
    """Straight ahead at a constant thrust against quadratic drag, v = last tanh(t / T + c)."""
    c = np.arctanh(first / last)
    zero, n = np.zeros_like(t), len(t)
    way = last * T * (np.log(np.cosh(t / T + c)) - np.log(np.cosh(c)))
    v = np.column_stack([last * np.tanh(t / T + c), zero])
    return Motion(t, np.column_stack([0.3 + way, zero + 0.8]), np.zeros(n), v, np.zeros(n))


def circle(t: Float, radius: float = 0.5, speed: float = 0.35, drift_rad: float = 0.15) -> Motion:
    """Steady turn; the core points `drift_rad` inside the path."""
    w = speed / radius
    a = w * t - 0.7
    xy = 0.9 + radius * np.column_stack([np.cos(a), np.sin(a)])
    v = speed * np.column_stack([-np.sin(a), np.cos(a)])
    return Motion(t, xy, a + np.pi / 2 + drift_rad, v, np.full(len(t), w))


def spiral(t: Float, radius: float = 0.35, growth: float = 0.04, rate: float = 0.8) -> Motion:
    """Archimedean spiral r = radius + growth t at constant angular rate."""
    r, a = radius + growth * t, rate * t
    e, n = np.column_stack([np.cos(a), np.sin(a)]), np.column_stack([-np.sin(a), np.cos(a)])
    v = growth * e + (r * rate)[:, None] * n
    heading = np.unwrap(np.arctan2(v[:, 1], v[:, 0]))
    accel = -(r * rate**2)[:, None] * e + 2 * growth * rate * n
    turn = (v[:, 0] * accel[:, 1] - v[:, 1] * accel[:, 0]) / (v**2).sum(1)
    return Motion(t, 1.0 + r[:, None] * e, heading, v, turn)


def start_from_rest(
    t: Float, final: float = 0.38, tau: float = 0.9, heading: float = 0.3
) -> Motion:
    """From rest against quadratic drag: v = v_inf tanh(t / tau)."""
    way = np.array([np.cos(heading), np.sin(heading)])
    s, v = final * tau * np.log(np.cosh(t / tau)), final * np.tanh(t / tau)
    n = len(t)
    return Motion(t, 0.3 + s[:, None] * way, np.full(n, heading), v[:, None] * way, np.zeros(n))


def start_into_circle(
    t: Float, final: float = 0.38, tau: float = 0.9, radius: float = 0.5
) -> Motion:
    """From rest into a circle: v = v_inf tanh(t / tau) along it."""
    s, v = final * tau * np.log(np.cosh(t / tau)), final * np.tanh(t / tau)
    a = s / radius - 1.1
    xy = 0.9 + radius * np.column_stack([np.cos(a), np.sin(a)])
    velocity = v[:, None] * np.column_stack([-np.sin(a), np.cos(a)])
    return Motion(t, xy, a + np.pi / 2 + 0.15, velocity, v / radius)


def random_turn(t: Float, rng: np.random.Generator, fine: int = 10) -> Motion:
    """Turn whose speed and yaw rate wander: 0.35 +- 0.05 m/s, 0.5 +- 0.3 rad/s within a second.

    Ornstein-Uhlenbeck processes, integrated by the trapezium rule on a grid `fine` times finer.
    """
    dt, n = (t[1] - t[0]) / fine, (len(t) - 1) * fine + 1
    keep = np.exp(-dt / 1.0)
    kicks = rng.normal(0, np.sqrt(1 - keep**2), (n, 2))
    kicks[0] = rng.normal(0, 1, 2)
    away = lfilter([1.0], [1.0, -keep], kicks, axis=0)
    speed, rate = (np.array([0.35, 0.5]) + away * [0.05, 0.3]).T
    course = cumulative_trapezoid(rate, dx=dt, initial=0)
    v = speed[:, None] * np.column_stack([np.cos(course), np.sin(course)])
    xy = 0.5 + cumulative_trapezoid(v, dx=dt, axis=0, initial=0)
    at = slice(None, None, fine)
    return Motion(t, xy[at], course[at] + 0.15, v[at], rate[at])


MOTIONS: dict[str, Callable[[Float], Motion]] = {
    "rest": at_rest,
    "line": straight_line,
    "circle": circle,
    "spiral": spiral,
    "startup": start_from_rest,
    "turning_start": start_into_circle,
}


@dataclass(frozen=True)
class CameraConditions:
    """What the camera makes of a motion."""

    hz: float = 2.37
    sway_m: float = 0.004
    surge_m: float = 0.0005
    yaw_rad: float = 0.05
    noise_m: float = 0.001
    noise_rad: float = 0.006
    outliers: float = 0.01
    gap_s: tuple[float, float] = (4.0, 4.5)


def observed_pose(
    motion: Motion, rng: np.random.Generator, seen: CameraConditions | None = None
) -> Pose:
    """Pose measured of a motion: recoil in body axes, white noise, outliers, one gap."""
    seen = seen or CameraConditions()
    t, n = motion.time_s, len(motion.time_s)
    beat = 2 * np.pi * seen.hz * t + rng.uniform(0, 2 * np.pi)
    along = np.column_stack([np.cos(motion.heading), np.sin(motion.heading)])
    across = np.column_stack([-along[:, 1], along[:, 0]])
    xy = motion.xy + (seen.sway_m * np.sin(beat))[:, None] * across
    xy = xy + (seen.surge_m * np.cos(beat))[:, None] * along + rng.normal(0, seen.noise_m, (n, 2))
    heading = motion.heading + seen.yaw_rad * np.sin(beat + 0.8)
    heading = heading + rng.normal(0, seen.noise_rad, n)
    wrong = rng.random(n) < seen.outliers
    xy[wrong] += rng.normal(0, 0.1, (int(wrong.sum()), 2))
    heading[wrong] += rng.normal(0, 0.5, int(wrong.sum()))
    head = 0.5 + rng.normal(0, 0.01, n)
    values = np.column_stack([xy, heading, head])
    values[(t >= seen.gap_s[0]) & (t < seen.gap_s[1])] = np.nan
    cov = np.diag([seen.noise_m**2] * 2 + [seen.noise_rad**2, 1e-4])
    return Pose(t, values, np.tile(cov, (n, 1, 1)))


def with_autocorrelated_noise(
    pose: Pose, truth: Pose, rng: np.random.Generator, keep: float
) -> Pose:
    """The pose of `truth` with errors as large as those stated in `pose`, a share `keep` of each
    still there in the next frame."""
    std = np.sqrt(np.einsum("nii->ni", pose.cov))
    fresh = rng.normal(0, 1, truth.values.shape) * np.sqrt(1 - keep**2)
    fresh[0] /= np.sqrt(1 - keep**2)
    errors = lfilter([1.0], [1.0, -keep], fresh, axis=0)
    return Pose(pose.time_s, truth.values + std * errors, pose.cov)
