"""Forces that are not on the list of causes."""

from __future__ import annotations

import numpy as np

from .flow import Flow, Load, pure_moment
from .law import Family, by_name
from .robots import Array


def compass(flow: Flow, size: Array, shape: float) -> Load:
    """Moment on a magnetised battery in the earth's field: sin of the heading from north."""
    scale = flow.robot.cruise_drag * flow.robot.body_length
    return pure_moment(-size * scale * np.sin(flow.theta - 2 * np.pi * shape))


def keel_compass(flow: Flow, size: Array, shape: float) -> Load:
    """Moment that aligns a soft iron keel with a field: sin of twice the heading."""
    scale = flow.robot.cruise_drag * flow.robot.body_length
    return pure_moment(-size * scale * np.sin(2 * (flow.theta - np.pi * shape)))


def tether(flow: Flow, size: Array, _: float) -> Load:
    """Elastic pull of a supply cable towards the middle of the pool."""
    length, width = flow.pool
    dx, dy = flow.x - 0.5 * length, flow.y - 0.5 * width
    return _pull(flow, -size * dx, -size * dy)


def slack_tether(flow: Flow, size: Array, shape: float) -> Load:
    """A pull beyond a slack length around the middle of the pool."""
    length, width = flow.pool
    dx, dy = flow.x - 0.5 * length, flow.y - 0.5 * width
    distance = np.hypot(dx, dy) + 1e-9
    slack = (0.1 + 0.1 * shape) * width
    taut = np.maximum(distance - slack, 0) / distance
    return _pull(flow, -1.5 * size * dx * taut, -1.5 * size * dy * taut)


def _pull(flow: Flow, dx: Array, dy: Array) -> Load:
    """Force of D0 per two body lengths of displacement, from the pool to the head frame."""
    stiff = flow.robot.cruise_drag / (2 * flow.robot.body_length)
    c, s = np.cos(flow.theta), np.sin(flow.theta)
    return Load(
        stiff * (dx * c + dy * s),
        stiff * (-dx * s + dy * c),
        np.zeros_like(dx),
    )


def hunting(flow: Flow, size: Array, shape: float) -> Load:
    """Slow swell of the thrust at constant frequency, two to three periods in a trial."""
    cycles = 2 + shape
    swell = size * flow.thrust * np.sin(2 * np.pi * cycles * flow.time / flow.setting.duration)
    return Load(swell * np.cos(flow.phi), swell * np.sin(flow.phi), np.zeros_like(swell))


def pulsing(flow: Flow, size: Array, shape: float) -> Load:
    """A leaking seal that jets forward in the middle of each trial."""
    centre = 0.4 + 0.2 * shape
    place = (flow.time / flow.setting.duration - centre) / 0.12
    force = size * flow.robot.cruise_drag * np.exp(-(place**2))
    return Load(-force, 0 * force, 0 * force)


UNLISTED_FAMILIES = (
    Family("magnetic_moment", "load", "moment over cruise drag times length", "1", 0.002, 0.2,
           by_name(compass, keel_compass), where=("yaw", "heading_rad")),
    Family("tether_pull", "load", "stiffness over cruise drag in two body lengths", "1", 0.005, 0.4,
           by_name(tether, slack_tether), where=("surge", "x_m")),
    Family("surge_in_time", "load", "force over cruise drag or thrust", "1", 0.03, 0.6,
           by_name(hunting, pulsing), where=("surge", "time_s")),
)  # fmt: skip
