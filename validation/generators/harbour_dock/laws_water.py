"""Hidden motions of the water, walls, own wake, sinking."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law, pick
from .typical import Typical


def uniform_current(rng: Generator, typical: Typical) -> Law:
    """A current through the basin."""
    form = pick(rng, "tide_over_the_session", "sheared_across", "constant", "slow_rotation")
    direction = float(rng.uniform(-np.pi, np.pi))
    trend = np.linspace(0.4, 1.6, len(typical.trials.phi))[None, :]
    width = typical.trials.pool[1]

    def water(here: Here, size: Any) -> Any:
        ahead = np.exp(1j * direction)
        if form == "constant":
            return size * ahead
        if form == "tide_over_the_session":  # tidal stream rising through the afternoon
            return size * ahead * trend
        if form == "slow_rotation":  # inertial turning of the stream
            return size * ahead * np.exp(0.06j * here.time)
        # log-like profile away from the quay: Fischer et al. (1979), Mixing in Inland Waters
        return size * (0.6 + 0.8 * np.clip(here.y / width, 0, 1)) * np.sign(np.cos(direction))

    if form == "sheared_across":
        direction = 0.0 if np.cos(direction) > 0 else np.pi
    return Law(
        "uniform_current",
        form,
        "speed",
        "m s^-1",
        0.03 * typical.speed,
        0.35 * typical.speed,
        hooks={"water": water},
        extra={"direction": (float(np.rad2deg(direction)), "deg")},
        channels=("surge", "sway"),
    )


def pool_gyre(rng: Generator, typical: Typical) -> Law:
    """A recirculation of the basin; the size is its top speed."""
    form = pick(rng, "taylor_cell", "scully_vortex", "gaussian_vortex", "two_cells", "solid_body")
    length, width, _ = typical.trials.pool
    sign = float(rng.choice([-1.0, 1.0]))
    centre_x, centre_y = length * rng.uniform(0.35, 0.65), width * rng.uniform(0.35, 0.65)
    core_radius = 0.22 * width

    def water(here: Here, size: Any) -> Any:
        if form in ("taylor_cell", "two_cells"):  # Taylor & Green (1937), Proc. R. Soc. A 158, 499
            m = 2 if form == "two_cells" else 1
            kx, ky = m * np.pi / length, np.pi / width
            u = ky * np.sin(kx * here.x) * np.cos(ky * here.y)
            v = -kx * np.cos(kx * here.x) * np.sin(ky * here.y)
            return sign * size * (u + 1j * v) / max(kx, ky)
        away = (here.x - centre_x) + 1j * (here.y - centre_y)
        r = np.abs(away) + 1e-6
        if form == "scully_vortex":  # Scully (1975), MIT ASRL TR 178-1: r/(r^2 + rc^2)
            share = 2 * core_radius * r / (r**2 + core_radius**2)
        elif form == "gaussian_vortex":  # Lamb-Oseen, top speed at 1.12 rc
            share = 1.567 * (1 - np.exp(-((r / core_radius) ** 2))) * core_radius / r
        else:
            share = np.minimum(r / (0.5 * width), 1.0)
        return sign * size * share * 1j * away / r

    return Law(
        "pool_gyre",
        form,
        "top_speed",
        "m s^-1",
        0.04 * typical.speed,
        0.35 * typical.speed,
        sign=sign,
        hooks={"water": water},
        channels=("surge", "sway"),
        extra={
            "centre_x": (float(centre_x), "m"),
            "centre_y": (float(centre_y), "m"),
            "core_radius": (float(core_radius), "m"),
        },
    )


def wall_effect(rng: Generator, typical: Typical) -> Law:
    """Forces near the walls, the size is that at contact relative to the main force."""
    form = pick(rng, "drag_exponential", "suction_power_law", "push_gaussian", "image_suction")
    length, width, _ = typical.trials.pool
    reach = float(typical.length * rng.uniform(0.5, 0.9))

    def near(gap: Any) -> Any:
        gap = np.maximum(gap, 0.02 * reach)
        if form == "drag_exponential":
            return np.exp(-gap / reach)
        if form == "suction_power_law":  # bank suction: Norrbin (1974), 10th ONR Symp.
            return 1 / (1 + gap / (0.5 * reach)) ** 2
        if form == "push_gaussian":
            return np.exp(-((gap / (1.3 * reach)) ** 2))
        # image of a slender body, suction ~ gap^-3 softened: Newman (1969), JFM 39, 97;
        # Quinn et al. (2014), J. Fluid Mech. 742 for swimmers near ground
        return 1 / (1 + (gap / reach) ** 3)

    def force(here: Here, size: Any) -> tuple[Any, Any]:
        west, east = near(here.x), near(length - here.x)
        south, north = near(here.y), near(width - here.y)
        scale = 500.0 * typical.area * here.speed**2 * size
        if form == "drag_exponential":
            return -scale * 0.7 * (
                west + east + south + north
            ) * here.through_water / here.speed, 0.0
        pull = (east - west) + 1j * (north - south)
        if form == "push_gaussian":
            pull = -pull
        side = (scale * pull * np.exp(-1j * (here.theta + here.phi))).imag
        return 1j * side, 0.08 * typical.length * side

    return Law(
        "wall_effect",
        form,
        "coefficient_at_wall",
        "1",
        0.5,
        2.0,
        hooks={"force": force},
        extra={"reach": (reach, "m")},
        channels=("surge", "sway", "yaw"),
    )


def wake_reentry(rng: Generator, _typical: Typical) -> Law:
    """Turning robots meet their own wake once they have gone round."""
    form = pick(rng, "thrust_logistic", "drag_saturating", "thrust_wake_age", "drag_ramp")

    def met_share(here: Here) -> Any:
        turned = np.abs(here.theta - here.theta_start)
        if form == "thrust_logistic":
            return 1 / (1 + np.exp(-(turned - 5.2) / 0.5))
        if form == "drag_ramp":
            return np.clip((turned - 2.5) / 4.0, 0, 1)
        met = 1 - np.exp(-np.maximum(turned - 3.0, 0) / 2.0)
        if form == "thrust_wake_age":
            # far momentum wake decays with its age, here one round: Tennekes & Lumley (1972), ch. 4
            age = 2 * np.pi / (np.abs(here.rate) + 0.15)
            return met * np.minimum(4.0 / age, 1.5)
        return met

    # a swimmer in the wake of another (here its own): Boschitsch et al. (2014), Phys. Fluids 26
    if form.startswith("thrust"):
        hooks = {"thrust": lambda here, size: 1 - size * met_share(here)}
    else:

        def force(here: Here, size: Any) -> tuple[Any, Any]:
            return -size * here.values["C_D0"] * met_share(
                here
            ) * here.q * here.through_water / here.speed, 0.0

        hooks = {"force": force}
    return Law(
        "wake_reentry", form, "relative_change", "1", 0.12, 0.5, hooks=hooks, channels=("surge",)
    )


def sinking(rng: Generator, typical: Typical) -> Law:
    """Water coming in: the robot goes down and drags more; the size is the depth gained in 10 s."""
    form = pick(rng, "quadratic_time", "linear_time", "saturating")

    def gain(time: Any) -> Any:
        if form == "quadratic_time":  # constant buoyancy deficit at low speed
            return (time / 10) ** 2
        if form == "saturating":  # until it is in balance again (first order; ours)
            return (1 - np.exp(-time / 4.0)) / (1 - np.exp(-2.5))
        return time / 10

    wet = 1.5 * typical.length

    def coefficients(here: Here, size: Any) -> None:
        here.C_D = here.C_D + here.values["C_D0"] * np.minimum(size * gain(here.time) / wet, 0.6)

    return Law(
        "sinking",
        form,
        "depth_gained_in_10_s",
        "m",
        0.2 * typical.length,
        0.6 * typical.length,
        hooks={"coefficients": coefficients, "depth": lambda time, size: size * gain(time)},
        channels=("surge",),
        extra={"drag_rise_per_metre": (1 / wet, "m^-1")},
    )
