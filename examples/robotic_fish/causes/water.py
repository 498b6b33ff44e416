"""Forces of the water on the body that the flat plate leaves out, and water that moves.

Sources: Fossen, Handbook of Marine Craft Hydrodynamics (2011), sec. 6.3 (added mass), 6.4
(damping, cross-flow drag), 8.3 (current); Leishman, Principles of Helicopter Aerodynamics
(2006), sec. 8.10 (lift that lags); otherwise own statements.
"""
# ruff: noqa: PLR0917 -- arguments are named after what an equation needs

from __future__ import annotations

import math

from bluekoi.explain import Cause, Parameter

Three = tuple[float, float, float]


def trim_force(rho: float, A: float, V: float, c: float) -> Three:
    """N = 1/2 rho A c V^2."""
    return 0.0, 0.0, 0.5 * rho * A * c * V * V


def sided_plate(
    rho: float,
    A: float,
    uh: float,
    vh: float,
    V: float,
    C_La: float,
    k: float,
) -> tuple[float, float]:
    """Lift changes by k |L| to the left of the flow."""
    L = 0.5 * rho * A * C_La * k * abs(2.0 * uh * vh) / V
    return -L * vh, L * uh


def yaw_damping_force(r: float, N_r: float) -> Three:
    """N = -N_r r."""
    return 0.0, 0.0, -N_r * r


def viscous_force(uh: float, vh: float, V: float, k: float) -> Three:
    """D = -k V^(3/2) v_hat."""
    s = -k * math.sqrt(V)
    return s * uh, s * vh, 0.0


def linear_drag_force(uh: float, vh: float, k: float) -> Three:
    """D = -k v."""
    return -k * uh, -k * vh, 0.0


def fin_force(rho: float, uh: float, vh: float, r: float, S: float, b: float) -> Three:
    """Y = -1/2 rho S |u| (v - b r), N = -b Y: tail as a fin, b behind the centre of mass."""
    Y = -0.5 * rho * S * abs(uh) * (vh - b * r)
    return 0.0, Y, -b * Y


def crossflow_force(rho: float, span: float, length: float, vh: float, r: float, C: float) -> Three:
    """Strips of Y = -1/2 rho C span (v + x r) |v + x r| dx over the body, by Simpson's rule."""
    h = 0.5 * length
    k = -0.5 * rho * C * span * length / 12.0
    wa, wb, wc = vh - h * r, vh - 0.5 * h * r, vh
    wd, we = vh + 0.5 * h * r, vh + h * r
    ya, yb, yc = wa * abs(wa), 4.0 * wb * abs(wb), 2.0 * wc * abs(wc)
    yd, ye = 4.0 * wd * abs(wd), we * abs(we)
    return 0.0, k * (ya + yb + yc + yd + ye), k * h * (ye - ya + 0.5 * (yd - yb))


def added_inertia(A11: float, A22: float, A66: float) -> Three:
    """Mass against surge and sway (kg), inertia against yaw (kg m2)."""
    return A11, A22, A66


def lag_plate(
    rho: float,
    A: float,
    uh: float,
    vh: float,
    V: float,
    C_La: float,
    z: float,
    k: float,
) -> tuple[float, float]:
    """Lift that is not there yet: z follows V^2 sin 2 alpha over s body lengths."""
    L = 0.5 * rho * A * C_La * k * (z + 2.0 * uh * vh) / V
    return -L * vh, L * uh


def lag_rates(uh: float, vh: float, V: float, length: float, z: float, s: float) -> tuple[float]:
    """Z' = (V^2 sin 2 alpha - z) V / (s length)."""
    return ((-2.0 * uh * vh - z) * V / (s * length),)


def current_water(c_x: float, c_y: float) -> tuple[float, float]:
    """Velocity of the water (m/s)."""
    return c_x, c_y


CAUSES = (
    Cause(
        "linear_yaw_damping",
        "The water resists turning in proportion to the yaw rate.",
        {"force": yaw_damping_force},
        (Parameter("N_r", "N m s", 0.001, 0.0, 0.2, "moment at 1 rad/s"),),
    ),
    Cause(
        "viscous_drag",
        "Skin friction grows more slowly than speed squared.",
        {"force": viscous_force},
        (Parameter("k", "N (s/m)^1.5", 0.1, 0.0, 20.0, "force at 1 m/s"),),
    ),
    Cause(
        "linear_drag",
        "Drag grows in proportion to speed.",
        {"force": linear_drag_force},
        (Parameter("k", "N s/m", 0.02, 0.0, 5.0, "force at 1 m/s"),),
    ),
    Cause(
        "tail_fin_lift",
        "The tail acts as a fin and turns the nose back into the flow.",
        {"force": fin_force},
        (
            Parameter("S", "m2", 0.005, 0.0, 0.2, "lift slope times area"),
            Parameter("b", "m", 0.14, 0.0, 0.4, "distance behind the centre of mass"),
        ),
    ),
    Cause(
        "crossflow_drag",
        "The body is dragged sideways, strip by strip.",
        {"force": crossflow_force},
        (Parameter("C", "1", 0.5, 0.0, 20.0, "drag coefficient of a strip"),),
    ),
    Cause(
        "added_mass",
        "The water around the fish has to be accelerated with it.",
        {"inertia": added_inertia},
        (
            Parameter("A11", "kg", 0.05, 0.0, 3.0, "added mass in surge"),
            Parameter("A22", "kg", 0.1, 0.0, 5.0, "added mass in sway"),
            Parameter("A66", "kg m2", 0.0003, 0.0, 0.05, "added inertia in yaw"),
        ),
        strengths=3,
    ),
    Cause(
        "lift_lag",
        "The body's lift follows changes with a delay.",
        {"plate": lag_plate},
        (
            Parameter("k", "1", 0.5, 0.0, 1.2, "share of the lift that lags"),
            Parameter("s", "1", 1.0, 0.1, 40.0, "body lengths travelled while it builds up"),
        ),
        states=("z",),
        rates=lag_rates,
    ),
    Cause(
        "port_starboard_asymmetry",
        "The body's lift differs between the two sides.",
        {"plate": sided_plate},
        (Parameter("k", "1", 0.05, -1.0, 1.0, "share of the lift"),),
    ),
    Cause(
        "trim_moment",
        "A small lasting turning moment acts even with the tail straight.",
        {"force": trim_force},
        (Parameter("c", "m", 0.002, -0.2, 0.2, "moment per 1/2 rho A V^2"),),
    ),
    Cause(
        "uniform_current",
        "The water itself moves, the same everywhere.",
        {"water": current_water},
        (
            Parameter("c_x", "m/s", 0.003, -0.2, 0.2, "along x"),
            Parameter("c_y", "m/s", 0.003, -0.2, 0.2, "along y"),
        ),
        strengths=2,
        site=True,
    ),
)
