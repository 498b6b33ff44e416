"""Hidden laws of thrust and motor: loss with speed, sag, spin-up, area, line of action."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law, pick
from .typical import Typical


def thrust_loss_with_speed(rng: Generator, typical: Typical) -> Law:
    """Thrust falling with forward speed over frequency (or speed alone)."""
    form = pick(
        rng,
        "quadratic_advance",
        "exponential_advance",
        "linear_advance",
        "speed_alone",
        "strouhal_window",
    )
    typical_advance, typical_speed = typical.advance, typical.speed

    def thrust(here: Here, size: Any) -> Any:
        advance = np.maximum(here.forward, 0) / here.flap / typical_advance
        if form == "quadratic_advance":  # 1 - (U/c)^2, Lighthill (1960), J. Fluid Mech. 9, 305
            return 1 - size * advance**2
        if form == "linear_advance":  # open-water K_T(J), Carlton (2012), Marine Propellers
            return 1 - size * advance
        if form == "exponential_advance":
            return np.exp(-size * advance)
        if form == "speed_alone":  # wave making of the tail near the surface, u^2 only
            return 1 - size * (np.maximum(here.forward, 0) / typical_speed) ** 2
        # best near the design Strouhal number: Triantafyllou et al. (1993), J. Fluids Struct. 7
        return 1 - size * (np.minimum(1 / (advance + 0.05), 4.0) / 1.5 - 1) ** 2

    return Law(
        "thrust_loss_with_speed",
        form,
        "loss_at_typical_advance",
        "1",
        0.15,
        0.5,
        hooks={"thrust": thrust},
        channels=("surge",),
        extra={
            "typical_advance": (typical_advance, "m"),
            "typical_speed": (typical_speed, "m s^-1"),
        },
    )


def thrust_area(rng: Generator, typical: Typical) -> Law:
    """Thrust growing slower than the head plate's area; the size is what the area misses."""
    form = pick(rng, "power_of_area", "partial_tail_only")
    ratio = typical.trials.area / (typical.robot.head * typical.robot.span)

    def thrust(_here: Here, size: Any) -> Any:
        if form == "power_of_area":  # A^(1-a); sqrt A at 0.5: Bainbridge (1963), J. Exp. Biol. 40
            return ratio[None, :] ** (-size)
        # our variant: the tail thrusts alone, the head adds only a part of its area
        return ((1 - size) * ratio[None, :] + size) / ratio[None, :]

    return Law(
        "thrust_area",
        form,
        "missing_share",
        "1",
        0.5,
        1.0,
        hooks={"thrust": thrust},
        channels=("surge",),
    )


def battery_sag(rng: Generator, typical: Typical) -> Law:
    """Frequency falling within a trial; the size is the fall at 10 s."""
    form = pick(
        rng, "exponential_to_plateau", "hyperbolic", "rc_plus_linear", "linear", "load_dependent"
    )
    tau = float(rng.uniform(2.0, 5.0))

    def flap(here: Here, size: Any) -> Any:
        t, load = here.time, 1.0
        if form == "exponential_to_plateau":  # surface charge: Shepherd (1965), J. Electrochem.
            g = (1 - np.exp(-t / tau)) / (1 - np.exp(-10 / tau))  # Soc. 112, 657
        elif form == "hyperbolic":  # K Q/(Q - it) of the Shepherd model turned into speed
            g = (t / (t + 2 * tau)) * (10 + 2 * tau) / 10
        elif form == "rc_plus_linear":  # Thevenin cell: Chen & Rincon-Mora (2006), IEEE TEC 21
            g = 0.6 * (1 - np.exp(-t / 1.5)) + 0.04 * t
        elif form == "linear":
            g = t / 10
        else:  # drop with the current drawn, here the motor power
            g, load = t / 10, (typical.trials.power[None, :] / 100) ** 2
        return np.maximum(1 - size * g * load, 0.3)

    return Law(
        "battery_sag",
        form,
        "frequency_fall_at_10_s",
        "1",
        0.05,
        0.25,
        hooks={"flap": flap},
        extra={"time_constant": (tau, "s")},
        channels=("surge",),
    )


def motor_spin_up(rng: Generator, _typical: Typical) -> Law:
    """Frequency reached only after a while."""
    form = pick(rng, "second_order", "s_curve", "dead_time_first_order", "ramp", "first_order")

    def flap(here: Here, size: Any) -> Any:
        return np.where(np.asarray(size) < 1e-4, 1.0, share(here.time / np.maximum(size, 1e-4)))

    def share(x: Any) -> Any:
        if form == "first_order":  # DC motor: Krishnan (2001), Electric Motor Drives
            return 1 - np.exp(-np.minimum(x, 50))
        if form == "second_order":  # critically damped speed loop
            return 1 - (1 + 2 * x) * np.exp(-np.minimum(2 * x, 50))
        if form == "s_curve":  # jerk-limited soft start: Meckl & Arestides (1998), ACC
            y = np.clip(x / 2.2, 0, 1)
            return y * y * (3 - 2 * y)
        if form == "dead_time_first_order":
            return 1 - np.exp(-np.minimum(np.maximum(x - 0.4, 0) / 0.6, 50))
        return np.clip(x / 2.0, 0, 1)

    return Law(
        "motor_spin_up", form, "time", "s", 0.3, 1.5, hooks={"flap": flap}, channels=("surge",)
    )


def thrust_line_offset(rng: Generator, typical: Typical) -> Law:
    """Thrust missing the centre of mass when the head is turned."""
    form = pick(rng, "sin_phi", "linear_phi", "sin_2phi")
    sign = float(rng.choice([-1.0, 1.0]))
    # offset of the hydrodynamic thrust axis of a bent body: Weihs (1972), Proc. R. Soc. B 182, 59;
    # sin 2 phi (our variant): lever arm ~ sin phi times the part of the jet ~ cos phi

    def force(here: Here, size: Any) -> tuple[Any, Any]:
        g = {
            "sin_phi": np.sin(here.phi),
            "linear_phi": here.phi,
            "sin_2phi": 0.5 * np.sin(2 * here.phi),
        }[form]
        return 0.0, sign * size * here.thrust * g

    top = 0.5 * typical.moment / (typical.thrust * max(typical.sin_head_angle, 0.15))
    return Law(
        "thrust_line_offset",
        form,
        "offset_per_unit_angle",
        "m",
        0.2 * top,
        top,
        hooks={"force": force},
        sign=sign,
        channels=("yaw",),
    )
