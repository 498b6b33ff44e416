"""Data classes: robot, coefficients, trials, and the world that holds all of a study."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")


@dataclass
class Robot:
    """Dimensions of a robot, SI units."""

    mass: float
    inertia: float
    body: float
    head: float
    span: float
    hinge_to_com: float
    tail: float
    depth: float
    density: float = 1000.0

    @property
    def core(self) -> float:
        """Length from the hinge to the caudal base."""
        return self.body - self.head

    def arm(self, head: Any) -> Any:
        """Distance from the centre of mass to the aerodynamic centre for a head length."""
        return head + self.hinge_to_com - (self.body + head - self.head) / 4.0


@dataclass
class Scales:
    """Typical speed, drag, yaw rate, moment, length, convective time; full-power frequency."""

    speed: float
    drag: float
    rate: float
    moment: float
    length: float
    time: float
    frequency: float


@dataclass
class Trials:
    """Arrays over trials, mostly of shape (K, 1) so that they broadcast over time."""

    power: np.ndarray
    phi_cmd: np.ndarray
    phi_err: np.ndarray
    phi_before: np.ndarray
    f_nom: np.ndarray
    head: np.ndarray
    t_on: np.ndarray
    rest: np.ndarray
    thrust: np.ndarray
    order: np.ndarray
    z: np.ndarray
    end: np.ndarray
    start: np.ndarray
    mode_amp: np.ndarray
    mode_omega: np.ndarray
    mode_phase: np.ndarray

    @property
    def count(self) -> int:
        """Number of trials."""
        return int(self.power.shape[0])


@dataclass
class Pool:
    """Pool dimensions in metres."""

    length: float
    width: float
    depth: float


@dataclass
class World:
    """Everything true about a study, and the stated robot beside it."""

    robot: Robot
    stated_robot: Robot
    coef: dict[str, float]
    scales: Scales
    pool: Pool
    camera: Any
    trials: Trials
    noise: dict[str, float]
    fps: float
    duration: float
    index: float = 1.333
    log: bool = False
    wake: Any = None
    extra: dict[str, Any] = field(default_factory=dict)
