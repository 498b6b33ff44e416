"""What a law may depend on: the robot's motion through the water at one instant.

Frames: pool (x, y); head (x forward along the head plate, y to port); core (along the core axis,
which points along theta + phi). Every array has the shape (columns,); a column is one trial of one
variant of the model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .robots import WATER_DENSITY, Array, Robot


class Load(NamedTuple):
    """Surge and sway force in the head frame (N) and yaw moment about the design centre (N m)."""

    surge: Array
    sway: Array
    yaw: Array


@dataclass(frozen=True)
class Setting:
    """What is fixed in a trial: arrays (columns,).

    flap: frequency (Hz). phi: head angle (rad). head: head length (m). order: place of the trial
    in the session, 0 to 1. duration (s).
    """

    flap: Array
    phi: Array
    head: Array
    order: Array
    duration: Array


@dataclass(frozen=True)
class Flow:
    """Motion at time `time` (s) relative to the water, head frame.

    u, v: surge and sway (m/s). rate: yaw rate (rad/s). phi: present head angle (rad). flap:
    present frequency (Hz). thrust (N). x, y: place in the pool (m). theta: heading (rad). turned:
    angle turned so far (rad).
    """

    robot: Robot
    pool: tuple[float, float]
    setting: Setting
    time: Array
    x: Array
    y: Array
    theta: Array
    u: Array
    v: Array
    rate: Array
    phi: Array
    flap: Array
    thrust: Array
    turned: Array

    @property
    def speed(self) -> Array:
        """Speed through the water (m/s)."""
        return np.hypot(self.u, self.v)

    @property
    def relative_speed(self) -> Array:
        """Speed over the straight speed at full power."""
        return self.speed / self.robot.speed

    @property
    def alpha(self) -> Array:
        """Angle of attack of the head plate (rad)."""
        return np.arctan2(-self.v, self.u)

    @property
    def area(self) -> Array:
        """Area of the head plate (m2)."""
        return self.setting.head * self.robot.head_span

    @property
    def pressure(self) -> Array:
        """Dynamic pressure times the head's area (N)."""
        return 0.5 * WATER_DENSITY * self.area * self.speed**2

    @property
    def core(self) -> tuple[Array, Array]:
        """Velocity along the core axis and across it (m/s)."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        return self.u * c + self.v * s, -self.u * s + self.v * c


def along_velocity(flow: Flow, force: Array) -> Load:
    """A force (N) against the velocity, through the centre of mass."""
    slowest = 1e-9 * flow.robot.speed
    ratio = force / np.maximum(flow.speed, slowest)
    return Load(-ratio * flow.u, -ratio * flow.v, np.zeros_like(flow.u))


def on_core(flow: Flow, along: Array, across: Array, moment: Array) -> Load:
    """Forces along and across the core axis (N) in the head frame, with a moment (N m)."""
    c, s = np.cos(flow.phi), np.sin(flow.phi)
    return Load(c * along - s * across, s * along + c * across, moment)


def pure_moment(moment: Array) -> Load:
    """A yaw moment (N m) alone."""
    return Load(np.zeros_like(moment), np.zeros_like(moment), moment)
