"""Forces that are on nobody's list, for the studies in which something unknown acts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law
from .typical import Typical


def _law(*head: Any, act: Callable[[Here, Any], tuple[Any, Any]], **more: Any) -> Law:
    """An unlisted force; head: form, key, unit, size, largest."""
    return Law("unlisted", *head, hooks={"force": act}, **more)


def tether(_rng: Generator, typical: Typical) -> Law:
    """An elastic safety line to the point of release (Hooke)."""
    x0, y0 = typical.trials.start[None, :, 0], typical.trials.start[None, :, 1]
    reach = float(np.median(typical.path_length) * 0.4)

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        pull = -(here.x - x0 + 1j * (here.y - y0)) / reach
        return size * pull * np.exp(-1j * (here.theta + here.phi)), 0.0

    return _law(
        "elastic_tether",
        "force_at_reach",
        "N",
        0.08 * typical.thrust,
        0.45 * typical.thrust,
        act=act,
        channels=("surge", "sway"),
        variable="distance_from_release",
        extra={"reach": (reach, "m")},
    )


def compass(rng: Generator, typical: Typical) -> Law:
    """Torque on the robot's magnets in the stray field of a steel quay: m x B."""
    at = float(rng.uniform(-np.pi, np.pi))

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        return 0.0, -size * np.sin(here.theta + here.phi - at)

    return _law(
        "magnetic_torque",
        "torque",
        "N m",
        0.1 * typical.moment,
        0.5 * typical.moment,
        act=act,
        channels=("yaw",),
        variable="heading",
        extra={"direction": (float(np.rad2deg(at)), "deg")},
    )


def twisted_cable(_rng: Generator, typical: Typical) -> Law:
    """Torsion of a hanging supply cable, growing with the angle turned since release."""

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        return 0.0, -size * (here.theta - here.theta_start) / np.pi

    return _law(
        "cable_torsion",
        "torque_at_half_turn",
        "N m",
        0.1 * typical.moment,
        0.5 * typical.moment,
        act=act,
        channels=("yaw",),
        variable="angle_turned",
    )


def spinning_mass(rng: Generator, typical: Typical) -> Law:
    """Side force of a rotating drum under the hull (Magnus): speed times motor frequency."""
    sign = float(rng.choice([-1.0, 1.0]))
    f0, typical_speed = float(typical.trials.flap.mean()), typical.speed

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        return 1j * sign * size * here.speed * here.flap / (typical_speed * f0), 0.0

    return _law(
        "magnus_drum",
        "side_force",
        "N",
        0.1 * typical.side_force,
        0.5 * typical.side_force,
        act=act,
        channels=("sway",),
        variable="speed_times_frequency",
        sign=sign,
    )


def weeds(rng: Generator, typical: Typical) -> Law:
    """Drag growing towards one end of the basin (plants on the floor)."""
    length = typical.trials.pool[0]
    end = float(rng.integers(2))

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        s = here.x / length if end else 1 - here.x / length
        g = 1 / (1 + np.exp(-(s - 0.55) / 0.06))
        return -size * g * here.speed * here.through_water / typical.speed**2, 0.0

    return _law(
        "weed_patch",
        "extra_drag",
        "N",
        0.1 * typical.thrust,
        0.45 * typical.thrust,
        act=act,
        channels=("surge",),
        variable="position_x",
        extra={"end": (end, "1: far end")},
    )


def seiche(rng: Generator, typical: Typical) -> Law:
    """Tilting water surface of a standing wave along the basin: g times slope, oscillating."""
    period = float(rng.uniform(2.5, 5.0))
    phase = float(rng.uniform(0, 2 * np.pi))

    def act(here: Here, size: Any) -> tuple[Any, Any]:
        g = size * np.sin(2 * np.pi * here.time / period + phase) * np.ones_like(here.x)
        return g * np.exp(-1j * (here.theta + here.phi)), 0.0

    return _law(
        "surface_slope",
        "force",
        "N",
        0.1 * typical.thrust,
        0.45 * typical.thrust,
        act=act,
        channels=("surge", "sway"),
        variable="time",
        extra={"period": (period, "s")},
    )


ALL = (tether, compass, twisted_cable, spinning_mass, weeds, seiche)
