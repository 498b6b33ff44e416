"""Hidden forces on hull, core and tail: drags, yaw damping, added mass, trim."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law, pick
from .typical import Typical


def _along(here: Here, drag: Any) -> tuple[Any, float]:
    return -drag * here.through_water / here.speed, 0.0


def viscous_drag(rng: Generator, typical: Typical) -> Law:
    """Drag growing slower than speed squared; the size is the drag at the typical speed."""
    form = pick(rng, "blasius_v1.5", "ittc57_minus_constant", "prandtl_v1.8", "stokes_v1")
    typical_speed, length = typical.speed, typical.length
    if form == "ittc57_minus_constant":
        # ITTC (1957) friction line 0.075/(log10 Re - 2)^2; what of it goes with V^2 is left to C_D0
        def shape(v: Any) -> Any:
            re = np.maximum(v * length / 1e-6, 3e3)
            cf = 0.075 / (np.log10(re) - 2) ** 2
            return np.maximum(cf, 0) * v**2

        at_typical = float(shape(typical_speed))
        hook = {"force": lambda here, size: _along(here, size * shape(here.speed) / at_typical)}
    else:
        # Blasius (1908) V^1.5; Prandtl (1927) one-fifth-power law V^1.8; Stokes part V
        # (Batchelor 1967)
        power = {"blasius_v1.5": 1.5, "prandtl_v1.8": 1.8, "stokes_v1": 1.0}[form]
        hook = {
            "force": lambda here, size: _along(here, size * (here.speed / typical_speed) ** power)
        }
    return Law(
        "viscous_drag",
        form,
        "drag_at_typical_speed",
        "N",
        0.15 * typical.thrust,
        0.5 * typical.thrust,
        hooks=hook,
        extra={"typical_speed": (typical_speed, "m s^-1")},
        channels=("surge",),
    )


def wave_drag(rng: Generator, typical: Typical) -> Law:
    """Drag growing faster than speed squared."""
    form = pick(rng, "fourth_power", "sixth_power", "havelock_hump", "onset_above_froude")
    typical_speed, length = typical.top_speed, typical.length

    def shape(v: Any) -> Any:
        froude = v / np.sqrt(9.81 * length)
        if form == "fourth_power":  # C_W ~ Fr^2: power fit below the hump, Hoerner (1965), ch. 11
            return v**4
        if form == "sixth_power":  # C_W ~ Fr^4, steeper part: Newman (1977), Marine Hydrodynamics
            return v**6
        if form == "havelock_hump":  # after Havelock (1909), Proc. R. Soc. A 82, 276; 0.25 is ours
            return v**2 * np.exp(-0.25 / (froude**2 + 1e-4))
        onset = (
            0.6 * typical_speed / np.sqrt(9.81 * length)
        )  # onset: Hoerner (1965), Fluid-Dynamic Drag, ch. 11
        return v**2 * np.maximum(froude - onset, 0) ** 2

    at_typical = float(shape(typical_speed))
    return Law(
        "wave_drag",
        form,
        "drag_at_top_speed",
        "N",
        0.15 * typical.top_thrust,
        0.5 * typical.top_thrust,
        hooks={"force": lambda here, size: _along(here, size * shape(here.speed) / at_typical)},
        extra={"top_speed": (typical_speed, "m s^-1")},
        channels=("surge",),
    )


def coulomb_friction(rng: Generator, typical: Typical) -> Law:
    """Resistance that stays at low speed."""
    form = pick(rng, "tanh", "stribeck", "saturating")
    transition = 0.12 * typical.speed

    def shape(v: Any) -> Any:
        if form == "tanh":  # Andersson et al. (2007), Tribol. Int. 40, 580
            return np.tanh(v / transition)
        if form == "stribeck":  # Armstrong-Helouvry et al. (1994), Automatica 30, 1083
            return np.tanh(4 * v / transition) * (
                0.6 + 0.4 * np.exp(-((v / (2 * transition)) ** 2))
            )
        return v / (v + transition)  # surface film: Scott (1982), J. Fluid Mech. 116, 283

    return Law(
        "coulomb_friction",
        form,
        "force",
        "N",
        0.08 * typical.thrust,
        0.5 * typical.thrust,
        hooks={"force": lambda here, size: _along(here, size * shape(here.speed))},
        extra={"transition_speed": (transition, "m s^-1")},
        channels=("surge",),
    )


def crossflow_drag(rng: Generator, typical: Typical) -> Law:
    """Sideways drag along core and tail, integrated over strips."""
    form = pick(rng, "strips_quadratic", "taylor_oblique_1.5", "tapered_strips", "reynolds_0.35")
    robot = typical.robot
    front, back = robot.hinge_to_com, robot.com_to_tail + robot.tail
    x = np.linspace(front, -back, 7)
    dx = (front + back) / 7
    tapered = form == "tapered_strips"
    height = robot.span * (1 - 0.7 * np.linspace(0, 1, 7) if tapered else np.full(7, 0.75))
    typical_across = 0.25 * typical.speed

    def force(here: Here, size: Any) -> tuple[Any, Any]:
        y, m = 0.0, 0.0
        for xi, hi in zip(x, height, strict=True):
            w = here.sideways + xi * here.rate
            aw = np.abs(w) + 1e-9
            if form == "taylor_oblique_1.5":
                # Taylor (1952), Proc. R. Soc. A 214, 158: laminar part of an oblique cylinder,
                # normal force ~ V^0.5 w^1.5
                g = w * np.sqrt(aw) * np.sqrt(here.speed)
            elif form == "reynolds_0.35":
                # section drag falling with Re: Hoerner (1965), ch. 3
                g = w * aw * (typical_across / (aw + 0.1 * typical_across)) ** 0.35
            else:
                # independent cross flow: Allen & Perkins (1951), NACA R-1048
                g = w * aw
            f = -500.0 * size * hi * dx * g
            y, m = y + f, m + xi * f
        return 1j * y, m

    return Law(
        "crossflow_drag",
        form,
        "C_dc",
        "1",
        0.4,
        2.0,
        hooks={"force": force},
        extra={"from_com_forward": (front, "m"), "to_com_aft": (back, "m")},
        channels=("sway", "yaw"),
    )


def linear_yaw_damping(rng: Generator, typical: Typical) -> Law:
    """Yaw moment growing slower than the rate squared, or with speed times rate."""
    form = pick(rng, "rate_power_1.5", "speed_times_rate", "linear_rate")
    typical_rate, typical_speed = typical.yaw_rate, typical.speed

    def force(here: Here, size: Any) -> tuple[Any, Any]:
        if form == "rate_power_1.5":  # laminar disc: von Karman (1921), ZAMM 1, 233
            g = np.sign(here.rate) * (np.abs(here.rate) / typical_rate) ** 1.5
        elif form == "speed_times_rate":  # Clarke, Gedling & Hine (1983), Trans. RINA 125, 45
            g = here.rate / typical_rate * here.speed / typical_speed
        else:  # Fossen (2011), linear skin friction N_r r
            g = here.rate / typical_rate
        return 0.0, -size * g

    return Law(
        "linear_yaw_damping",
        form,
        "moment_at_typical_rate",
        "N m",
        0.1 * typical.moment,
        0.5 * typical.moment,
        hooks={"force": force},
        extra={
            "typical_rate": (typical_rate, "rad s^-1"),
            "typical_speed": (typical_speed, "m s^-1"),
        },
        channels=("yaw",),
    )


def added_mass(rng: Generator, typical: Typical) -> Law:
    """Accelerations of the water; the size multiplies the whole theory."""
    form = pick(rng, "slender_body", "lamb_ellipsoid", "partial_munk")
    m, inertia = typical.robot.mass, typical.robot.inertia
    # slender body: Munk (1924), NACA R-184; Lighthill (1970), J. Fluid Mech. 44, 265
    # ellipsoid: Lamb (1932), Hydrodynamics, art. 114 (length/width about 4: k1 .08, k2 .86, k' .61)
    # partial Munk moment of real bodies: Hopkins (1951), NACA RM A51C14
    kx, ky, kj, munk = {
        "slender_body": (0.0, 0.7, 0.7, 1.0),
        "lamb_ellipsoid": (0.08, 0.86, 0.61, 1.0),
        "partial_munk": (0.06, 0.8, 0.6, 0.6),
    }[form]

    def added(here: Here, size: Any) -> None:
        here.surge_added, here.sway_added, here.yaw_added = (
            size * kx * m,
            size * ky * m,
            size * kj * inertia,
        )
        here.munk_share = munk

    return Law(
        "added_mass",
        form,
        "sway_added_mass",
        "kg",
        0.4,
        1.3,
        hooks={"added": added},
        extra={
            "surge": (kx / ky, "times sway"),
            "munk_factor": (munk, "1"),
            "yaw": (kj / ky * inertia / m, "kg m^2 per kg sway"),
        },
        channels=("surge", "sway", "yaw"),
        show=lambda size: size * ky * m,
    )


def trim_moment(rng: Generator, typical: Typical) -> Law:
    """A turning moment on a straight robot."""
    form = pick(rng, "speed_squared", "thrust_proportional", "constant", "forward_speed")
    typical_speed, typical_thrust = typical.speed, typical.thrust
    sign = float(rng.choice([-1.0, 1.0]))

    def force(here: Here, size: Any) -> tuple[Any, Any]:
        if form == "speed_squared":  # bent hull: Burcher & Rydill (1994), Concepts
            g = (here.speed / typical_speed) ** 2
        elif form == "forward_speed":  # rudder-like trim tab, u|u|
            g = here.forward * np.abs(here.forward) / typical_speed**2
        elif form == "thrust_proportional":  # skewed stroke: Bandyopadhyay (2005), IEEE JOE 30
            g = here.thrust / typical_thrust
        else:  # static heel, moment independent of speed
            g = np.ones_like(here.speed) * np.minimum(here.speed / (0.1 * typical_speed), 1.0)
        return 0.0, sign * size * g

    return Law(
        "trim_moment",
        form,
        "moment_at_typical_speed",
        "N m",
        0.04 * typical.moment,
        0.5 * typical.moment,
        hooks={"force": force},
        sign=sign,
        channels=("yaw",),
    )
