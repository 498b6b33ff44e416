"""Forces in no list: inventions of this pool.

Hook `force` as in `body_laws`; hook `slosh` has two states (displacement, speed) of an inner mass.
"""

from __future__ import annotations

import numpy as np

from .form import Family, Flow, reference
from .robots import Array, Robot

Loads = tuple[Array, Array | float]


def tether(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """A rubber line from the middle of a long side, slack up to 0.3 of the pool's width."""
    anchor = complex(flow.pool[0] * (0.3 + 0.4 * shape), 0.0)
    away = flow.z - anchor
    stretch = np.maximum(np.abs(away) - 0.3 * flow.pool[1], 0) / flow.pool[1]
    pull = -size * robot.drag * stretch * away / (np.abs(away) + 1e-9)
    return pull * np.exp(-1j * flow.psi), 0.0


def magnetic_floor(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Steel in the floor turns the robot's magnet to one direction of the pool."""
    turn = -0.2 * size * robot.drag * robot.body_length * np.sin(flow.psi - 2 * np.pi * shape)
    return 0j * flow.v, turn


def bubble_curtain(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """A curtain of bubbles across the pool pushes to both sides of its line."""
    x = (flow.z.real / flow.pool[0] - 0.4 - 0.2 * shape) / 0.15
    push = size * robot.drag * x * np.exp(0.5 - 0.5 * x * x)
    return push * np.exp(-1j * flow.psi), 0.0


def weed(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """A bed of weed brakes within a third of the pool's width."""
    away = flow.z - complex(flow.pool[0] * (0.35 + 0.3 * shape), 0.5 * flow.pool[1])
    bed = np.exp(-((np.abs(away) / (0.33 * flow.pool[1])) ** 2))
    return size * robot.drag * reference(flow, robot) ** 2 * bed * flow.backward, 0.0


def slosh(displacement: Array, speed: Array, robot: Robot, size: float, shape: float) -> Array:
    """Force (N) of water sloshing along the hull on the robot; natural frequency by body length."""
    omega = (1.5 + 1.5 * shape) * robot.speed / robot.body_length
    return size * robot.mass * (omega**2 * displacement + 0.3 * omega * speed)


FAMILIES = (
    Family("tether", "force", "share_of_drag", "1", 0.05, 3.0, {"rubber": tether},
           where=("surge", "y_m")),
    Family("magnetic_floor", "force", "share_of_moment", "1", 0.02, 2.0, {"sine": magnetic_floor},
           where=("yaw", "heading_rad")),
    Family("bubble_curtain", "force", "share_of_drag", "1", 0.03, 1.0, {"gaussian": bubble_curtain},
           where=("surge", "x_m")),
    Family("weed", "force", "share_of_drag", "1", 0.1, 5.0, {"bed": weed}, where=("surge", "x_m")),
    Family("slosh", "slosh", "share_of_mass", "1", 0.05, 1.5, {"hull": slosh},
           where=("surge", "time_s")),
)  # fmt: skip
