"""Hidden laws of the head plate and its servo: stall, lags, offsets, asymmetry, mass place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law, pick
from .typical import Typical


def stall(rng: Generator, typical: Typical) -> Law:
    """Lift (and moment) lost beyond an angle of attack."""
    form = pick(
        rng, "kirchhoff_separation", "viterna_plateau", "smooth_step", "moment_stalls_earlier"
    )
    onset = float(typical.high_attack * rng.uniform(0.45, 0.8))
    width = 0.2 * onset + 0.01

    def coefficients(here: Here, size: Any) -> None:
        attack = np.abs(np.arctan2(here.sin_attack, here.cos_attack))
        if form == "kirchhoff_separation":
            # ((1 + sqrt f)/2)^2 with the point of separation f: Leishman & Beddoes (1989), JAHS 34
            f = 1 - np.clip(size, 0, 0.98) / (1 + np.exp(-(attack - onset) / width))
            k = ((1 + np.sqrt(f)) / 2) ** 2
            here.C_L, here.C_M = here.C_L * k, here.C_M * k
        elif form == "viterna_plateau":
            # slope reduced beyond stall: after Viterna & Corrigan (1982), NASA CP-2230
            over = np.maximum(attack - onset, 0)
            k = 1 - size * over / (attack + 1e-9)
            here.C_L, here.C_M = here.C_L * k, here.C_M * k
            here.C_D = here.C_D + 0.3 * size * over**2
        else:
            # sigmoid loss: Beard & McLain (2012), Small Unmanned Aircraft, ch. 4
            k = 1 - size / (1 + np.exp(-(attack - onset) / width))
            early = 1 - size / (1 + np.exp(-(attack - 0.75 * onset) / width))
            here.C_L = here.C_L * k
            here.C_M = here.C_M * (early if form == "moment_stalls_earlier" else k)

    return Law(
        "stall",
        form,
        "loss",
        "1",
        0.3,
        0.85,
        hooks={"coefficients": coefficients},
        extra={
            "onset": (float(np.rad2deg(onset)), "deg"),
            "width": (float(np.rad2deg(width)), "deg"),
        },
        channels=("sway", "yaw"),
        variable="angle_of_attack",
    )


def lift_lag(rng: Generator, typical: Typical) -> Law:
    """Lift following the angle of attack with a delay measured in chords travelled."""
    form = pick(rng, "wagner_jones", "finite_wing_jones_ar3", "first_order_chords")
    chord = typical.trials.head[None, :]
    # Jones (1940), NACA R-681: Phi = 1 - .165 exp(-.0455 s) - .335 exp(-.3 s); for aspect ratio 3
    # 1 - .283 exp(-.54 s); s in half chords. The size stretches the time.
    terms = {
        "wagner_jones": [(0.165, 0.0455), (0.335, 0.3)],
        "finite_wing_jones_ar3": [(0.283, 0.54)],
        "first_order_chords": [(1.0, 1.0)],
    }[form]
    slow = {"wagner_jones": 4.0, "finite_wing_jones_ar3": 16.0, "first_order_chords": 12.0}[form]

    def rate(here: Here, size: Any, b: float) -> Any:
        return np.minimum(b * 2 * here.speed / chord / np.maximum(size, 1e-3), 30.0)

    def rates(here: Here, size: Any) -> Any:
        return np.stack(
            [
                rate(here, size, b) * (here.C_L - z)
                for (_, b), z in zip(terms, here.states, strict=True)
            ]
        )

    def coefficients(here: Here, size: Any) -> None:
        lost = sum(g * (here.C_L - z) for (g, _), z in zip(terms, here.states, strict=True))
        lost = np.where(np.asarray(size) > 2e-3, lost, 0.0)
        k = here.values["C_Ma"] / here.values["C_La"]
        here.C_L, here.C_M = here.C_L - lost, here.C_M - k * lost

    return Law(
        "lift_lag",
        form,
        "stretch",
        "1",
        0.3 * slow,
        slow,
        n_states=len(terms),
        hooks={"states": rates, "coefficients": coefficients},
        channels=("sway", "yaw"),
        extra={"terms": (terms, "1, per half chord")},
    )


def servo_lag(rng: Generator, _typical: Typical) -> Law:
    """The head turning to its angle only after the start."""
    form = pick(
        rng, "second_order_underdamped", "rate_limit", "dead_time_first_order", "first_order"
    )
    zeta = 0.45

    def phi(here: Here, size: Any) -> Any:
        return np.where(np.asarray(size) < 1e-4, here.phi, turned(here, np.maximum(size, 1e-4)))

    def turned(here: Here, size: Any) -> Any:
        x = np.minimum(here.time / size, 50.0)
        if form == "first_order":  # Beard & McLain (2012), servo as first-order lag
            g = 1 - np.exp(-x)
        elif form == "second_order_underdamped":  # step response: Franklin et al.
            wd = np.sqrt(1 - zeta**2)
            g = 1 - np.exp(-zeta * x * 1.5) * (
                np.cos(1.5 * wd * x) + zeta / wd * np.sin(1.5 * wd * x)
            )
        elif form == "dead_time_first_order":
            g = 1 - np.exp(-np.maximum(x - 0.6, 0) / 0.6)
        else:  # slew limit, full 45 degrees in 2 a
            return np.sign(here.phi) * np.minimum(
                np.abs(here.phi), np.deg2rad(22.5) * here.time / size
            )
        return here.phi * g

    return Law(
        "servo_lag", form, "time", "s", 0.4, 1.6, hooks={"phi": phi}, channels=("sway", "yaw")
    )


def head_angle_offset(rng: Generator, _typical: Typical) -> Law:
    """A lasting difference between commanded and actual head angle."""
    form = pick(rng, "constant", "backlash", "gain")
    sign = float(rng.choice([-1.0, 1.0]))

    def phi(here: Here, size: Any) -> Any:
        if form == "constant":
            return here.phi + sign * size
        if form == "gain":  # horn geometry: angle too small or too large by a factor
            return here.phi * (1 + sign * size * 2)
        # gear play: the water presses the head back, Nordin & Gutman (2002), Automatica 38, 1633
        return here.phi - size * np.tanh(here.phi / np.deg2rad(3.0))

    return Law(
        "head_angle_offset",
        form,
        "gain_error" if form == "gain" else "offset",
        "1" if form == "gain" else "deg",
        np.deg2rad(1.5),
        np.deg2rad(6.0),
        hooks={"phi": phi},
        sign=1.0 if form == "backlash" else sign,
        channels=("sway", "yaw"),
        show=(lambda size: 2 * size) if form == "gain" else (lambda size: float(np.rad2deg(size))),
    )


def port_starboard_asymmetry(rng: Generator, typical: Typical) -> Law:
    """Head forces differing between port and starboard flow."""
    form = pick(rng, "tanh", "large_angles_only", "step", "drag_as_well")
    sign = float(rng.choice([-1.0, 1.0]))
    a0 = 0.35 * typical.attack

    def coefficients(here: Here, size: Any) -> None:
        attack = np.arctan2(here.sin_attack, here.cos_attack)
        # wing damaged on one side / vortex asymmetry: Ericsson & Reding (1981), JSR 18;
        # the smooth switches are ours
        if form == "large_angles_only":
            g = np.clip((np.abs(attack) - a0) / (2 * a0), 0, 1) * np.sign(attack)
        elif form == "tanh":
            g = np.tanh(attack / a0)
        else:
            g = np.tanh(attack / np.deg2rad(0.8))
        k = 1 + sign * size * g
        here.C_L, here.C_M = here.C_L * k, here.C_M * k
        if form == "drag_as_well":
            here.C_D = here.C_D * k

    return Law(
        "port_starboard_asymmetry",
        form,
        "relative_difference",
        "1",
        0.06,
        0.4,
        hooks={"coefficients": coefficients},
        sign=sign,
        channels=("sway", "yaw"),
    )


def centre_of_mass_shift(rng: Generator, typical: Typical) -> Law:
    """Mass not at `core_center`; the labels stay there, forces act about the true centre."""
    form = pick(rng, "along_core", "with_the_turned_head")
    sign = float(rng.choice([-1.0, 1.0])) if form == "along_core" else 1.0
    top = 0.08 * typical.length if form == "along_core" else 0.12 * typical.length

    def shift(here: Here, size: Any) -> Any:
        ec = here.head_axis * np.exp(1j * here.phi)
        if form == "along_core":  # ballast: Prestero (2001), MIT thesis (REMUS), ch. 2
            return sign * size * ec
        # the head's mass swings with it: multibody, Boyer et al. (2006), IEEE TRO 22, 763
        return size * (here.head_axis - ec)

    return Law(
        "centre_of_mass_shift",
        form,
        "forward" if form == "along_core" else "head_share",
        "m",
        0.3 * top,
        top,
        hooks={"shift": shift},
        sign=sign,
        channels=("yaw",),
    )
