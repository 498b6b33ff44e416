"""Robots: geometry, inertia and the six coefficients of the flat-plate model."""

from dataclasses import dataclass, replace

import numpy as np

PUBLISHED_LENGTH = 0.331  # m
WATER_DENSITY = 1000.0  # kg/m^3
GRAVITY = 9.81  # m/s^2
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")


@dataclass(frozen=True)
class Robot:
    """Robot and pool in SI units; `flap` is the frequency at 100 % power."""

    mass: float
    inertia: float
    length: float
    head: float
    span: float
    hinge_to_com: float
    tail: float
    depth: float
    flap: float
    coefficients: dict[str, float]
    pool: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def area(self) -> float:
        """Area of the head plate with the 1x head, m^2."""
        return self.head * self.span

    @property
    def aft(self) -> float:
        """Distance from the centre of mass to the caudal base, m."""
        return self.length - self.head - self.hinge_to_com

    @property
    def speed_ref(self) -> float:
        """Terminal speed at full power with a straight head, m/s."""
        return self.flap * np.sqrt(self.coefficients["C_T"] / self.coefficients["C_D0"])

    @property
    def drag_ref(self) -> float:
        """Drag at `speed_ref`, N."""
        pressure = 0.5 * WATER_DENSITY * self.area * self.speed_ref**2
        return pressure * self.coefficients["C_D0"]

    @property
    def moment_ref(self) -> float:
        """Drag times body length, N m."""
        return self.drag_ref * self.length

    @property
    def rate_ref(self) -> float:
        """Yaw rate of a turn of two body lengths' radius at `speed_ref`, rad/s."""
        return self.speed_ref / (2 * self.length)

    @property
    def slender_mass(self) -> float:
        """Added mass of the section, rho pi span^2 / 4, kg/m."""
        return WATER_DENSITY * np.pi * self.span**2 / 4

    def arm(self, head: np.ndarray | float) -> np.ndarray | float:
        """Distance from the centre of mass to the aerodynamic centre, m."""
        return head + self.hinge_to_com - (self.length + head - self.head) / 4


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot of 0.15 to 0.9 m: the published one scaled, each number varied by itself."""
    length = float(np.exp(rng.uniform(np.log(0.15), np.log(0.9))))
    scale = length / PUBLISHED_LENGTH
    coefficients = {
        "C_T": 4.5e-3 * scale**2 * rng.uniform(0.4, 0.85),
        "C_D0": 0.5 * rng.uniform(0.7, 1.4),
        "C_Da": rng.uniform(0.4, 3.8),
        "C_La": 3.14 * rng.uniform(0.7, 1.1),
        "C_Ma": 0.1 * scale * rng.uniform(0.4, 1.3),
        "C_Md": 0.125 * scale**5 * rng.uniform(0.7, 1.4),
    }
    return Robot(
        mass=0.68 * scale**3 * rng.uniform(0.8, 1.25),
        inertia=0.0095 * scale**5 * rng.uniform(0.75, 1.25),
        length=length,
        head=0.12 * scale * rng.uniform(0.9, 1.1),
        span=0.069 * scale * rng.uniform(0.85, 1.2),
        hinge_to_com=0.04 * scale * rng.uniform(0.7, 1.3),
        tail=0.066 * scale * rng.uniform(0.8, 1.2),
        depth=float(np.clip(0.12 * length * rng.uniform(0.7, 2.5), 0.02, 0.2)),
        flap=float(np.clip(5.82 * scale**-0.5 * rng.uniform(0.75, 1.15), 1.8, 8.0)),
        coefficients=coefficients,
    )


def in_pool(rng: np.random.Generator, robot: Robot) -> Robot:
    """The robot in a pool in which it has room; one in four swims deep in a deep pool."""
    length = robot.length * rng.uniform(11, 17)
    width = length * rng.uniform(0.58, 0.78)
    if rng.random() < 0.25:
        deep = robot.length * rng.uniform(2.0, 4.0)
        return replace(robot, pool=(length, width, deep), depth=deep * rng.uniform(0.4, 0.7))
    return replace(robot, pool=(length, width, max(0.2, robot.length * rng.uniform(0.8, 1.6))))
