"""What the flat-plate model of the fish may have left out: one function an effect.

Each says what it is, its formula stands in the function's docstring, its parameters carry unit,
start, bounds and meaning. Sources: Fossen, Handbook of Marine Craft Hydrodynamics and Motion
Control (2011), sec. 6.3 (added mass), 6.4 (damping, cross-flow drag), 8.3 (current); Wang and Tan,
J. Dyn. Sys. Meas. Control 137 (2015) (averaged forces of a tail-actuated fish).
"""

# ruff: noqa: PLR0917 -- arguments are named after what an equation needs
from __future__ import annotations

import math

from ..effect import effect

Three = tuple[float, float, float]


def disturbance_force(g_surge: float, g_sway: float, g_yaw: float) -> Three:
    """Random forces (N, N, N m)."""
    return g_surge, g_sway, g_yaw


def disturbance_rates(g_surge: float, g_sway: float, g_yaw: float, tau: float) -> Three:
    """They forget themselves within tau."""
    return -g_surge / tau, -g_sway / tau, -g_yaw / tau


def lasting_observe(e_x: float, e_y: float, e_psi: float) -> Three:
    """Errors of place (m, m) and heading (rad)."""
    return e_x, e_y, e_psi


def lasting_rates(e_x: float, e_y: float, e_psi: float, tau_e: float) -> Three:
    """They forget themselves within tau_e."""
    return -e_x / tau_e, -e_y / tau_e, -e_psi / tau_e


def thrust_line_force(T: float, sphi: float, d: float) -> Three:
    """N = -d T sin phi: the thrust acts at the tail joint, d behind the centre of mass."""
    return 0.0, 0.0, -d * T * sphi


def side_force(T: float, sphi: float, k: float) -> Three:
    """Y = k T sin phi: a turned tail pushes sideways more than its share of the thrust."""
    return 0.0, k * T * sphi, 0.0


def bias_thrust(T: float, phi: float, k: float) -> tuple[float]:
    """Thrust changes by -k T phi^2."""
    return (-k * T * phi * phi,)


def sided_thrust(
    rho: float, A: float, a: float, f: float,
    C_T: float, phi: float, k: float,
) -> tuple[float]:  # fmt: skip
    """Thrust changes by k T phi."""
    return (k * C_T * 0.5 * rho * A * a * a * f * f * phi,)


def amplitude_thrust(
    rho: float, A: float, a: float,
    f: float, C_T: float, p: float,
) -> tuple[float]:  # fmt: skip
    """T ~ a^(2 + p), held at 20 degrees."""
    return (C_T * 0.5 * rho * A * a * a * f * f * ((a / 0.3490658503988659) ** p - 1.0),)


def advance_thrust(rho: float, A: float, a: float, f: float, uh: float, k: float) -> tuple[float]:
    """Thrust changes by -k rho A a f u: it falls with the advance of a beat."""
    return (-k * rho * A * a * f * uh,)


def beat_drive(beat_hz: float, beat_hz0: float, k: float) -> Three:
    """F = f0 + k (seen beat - f0): k = 1 where the tail beats as the recoil shows."""
    return 0.0, 0.0, k * (beat_hz - beat_hz0)


def beat_clock(beat_hz: float, beat_hz0: float, k: float) -> tuple[float]:
    """True seconds in a recorded one: 1 + k (seen beat / f0 - 1); k = 1: the clock is at fault."""
    return (k * (beat_hz / beat_hz0 - 1.0),)


def offset_drive(d: float) -> Three:
    """Phi = told + d."""
    return d, 0.0, 0.0


def reach_drive(bias: float, k: float) -> Three:
    """Phi = (1 - k) told, to starboard (told < 0) alone."""
    return -k * min(bias, 0.0), 0.0, 0.0


def spin_up_drive(t: float, amplitude: float, k: float, tau: float) -> Three:
    """A = told (1 - k exp(-t / tau)), t since the first frame."""
    return 0.0, -amplitude * k * math.exp(-t / tau), 0.0


def trim_force(rho: float, A: float, V: float, c: float) -> Three:
    """N = 1/2 rho A c V^2."""
    return 0.0, 0.0, 0.5 * rho * A * c * V * V


def sided_plate(
    rho: float, A: float, uh: float, vh: float,
    V: float, C_La: float, k: float,
) -> tuple[float, float]:  # fmt: skip
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
    rho: float, A: float, uh: float, vh: float,
    V: float, C_La: float, z: float, k: float,
) -> tuple[float, float]:  # fmt: skip
    """Lift that is not there yet: z follows V^2 sin 2 alpha over s body lengths."""
    L = 0.5 * rho * A * C_La * k * (z + 2.0 * uh * vh) / V
    return -L * vh, L * uh


def lag_rates(uh: float, vh: float, V: float, length: float, z: float, s: float) -> tuple[float]:
    """Z' = (V^2 sin 2 alpha - z) V / (s length)."""
    return ((-2.0 * uh * vh - z) * V / (s * length),)


def current_water(c_x: float, c_y: float) -> tuple[float, float]:
    """Velocity of the water (m/s)."""
    return c_x, c_y


def point_observe(cpsi: float, spsi: float, bx: float, by: float) -> Three:
    """The tracked point lies (bx, by) from the centre of mass, fixed to the body."""
    return bx * cpsi - by * spsi, bx * spsi + by * cpsi, 0.0


def heading_observe(d: float) -> Three:
    """The heading is read d beside the body's axis."""
    return 0.0, 0.0, d


EFFECTS = (
    effect(
        "disturbance", "The water is never quite still.", {"force": disturbance_force},
        (("present", "1", 1.0, 0.0, 1.0, "1 where the forces act"),
         ("tau", "s", 0.5, 0.05, 10.0, "time within which a force is forgotten")),
        kind="disturbance", channels=("surge", "sway", "yaw"),
        states=("g_surge", "g_sway", "g_yaw"), rates=disturbance_rates),
    effect(
        "lasting_error", "Errors of the tracked place and heading last for a while, what is left "
        "of the recoil among them.", {"observe": lasting_observe},
        (("present", "1", 1.0, 0.0, 1.0, "1 where they are"),
         ("tau_e", "s", 0.2, 0.02, 2.0, "memory")),
        kind="disturbance", states=("e_x", "e_y", "e_psi"), rates=lasting_rates),
    effect(
        "thrust_line_offset", "The thrust of the turned tail acts behind the centre of mass and "
        "turns the fish.", {"force": thrust_line_force},
        (("d", "m", 0.05, -0.3, 0.5, "distance of the thrust behind the centre of mass"),),
        channels=("yaw",)),
    effect(
        "tail_side_force", "A turned tail pushes the fish sideways more (or less) than its share "
        "of the thrust.", {"force": side_force},
        (("k", "1", 0.2, -5.0, 5.0, "extra side force over T sin phi"),), channels=("sway",)),
    effect(
        "thrust_loss_with_bias", "A tail that beats about a turned position gives less thrust.",
        {"thrust": bias_thrust},
        (("k", "1/rad2", 0.3, -1.3, 1.3, "share of thrust lost per bias squared"),),
        channels=("surge",)),
    effect(
        "thrust_asymmetry", "The tail pushes harder when turned to one side than to the other.",
        {"thrust": sided_thrust},
        (("k", "1/rad", 0.1, -1.0, 1.0, "share of thrust gained per bias to port"),),
        channels=("surge",)),
    effect(
        "thrust_law", "Thrust does not grow with the square of the tail's amplitude.",
        {"thrust": amplitude_thrust},
        (("p", "1", 0.2, -2.0, 2.0, "power of the amplitude beyond 2"),), channels=("surge",)),
    effect(
        "thrust_loss_with_speed", "The faster the fish swims, the less thrust a beat gives.",
        {"thrust": advance_thrust}, (("k", "m", 0.005, 0.0, 1.0, "loss per advance"),),
        channels=("surge",)),
    effect(
        "tail_beat_frequency", "The tail does not beat at one frequency in all trials, as it was "
        "told, but as the recoil of the body shows.", {"drive": beat_drive},
        (("k", "1", 0.5, -1.0, 3.0, "1: thrust follows the seen beat in full"),),
        channels=("surge",)),
    effect(
        "clock_error", "The recordings' clocks run at different rates; a tail that beats at one "
        "rate is seen at several.", {"clock": beat_clock},
        (("k", "1", 0.5, -1.0, 2.0, "1: the whole difference of the seen beats is the clock's"),),
        kind="measurement", channels=("surge", "yaw")),
    effect(
        "head_angle_offset", "The tail does not stand at the bias it was told: a constant offset.",
        {"drive": offset_drive}, (("d", "rad", 0.03, -0.4, 0.4, "offset, to port positive"),),
        channels=("yaw", "sway")),
    effect(
        "servo_reach", "The servo does not turn the tail as far to one side as to the other.",
        {"drive": reach_drive}, (("k", "1", 0.1, -0.6, 0.6, "share of negative bias missing"),),
        channels=("yaw", "sway", "surge")),
    effect(
        "motor_spin_up", "The tail does not beat at full amplitude from the start.",
        {"drive": spin_up_drive},
        (("k", "1", 0.5, 0.0, 1.0, "share missing at the first frame"),
         ("tau", "s", 0.5, 0.05, 5.0, "time constant")), channels=("surge",)),
    effect(
        "trim_moment", "A small lasting turning moment acts even with the tail straight.",
        {"force": trim_force}, (("c", "m", 0.002, -0.2, 0.2, "moment per 1/2 rho A V^2"),),
        channels=("yaw",)),
    effect(
        "port_starboard_asymmetry", "The body's lift differs between the two sides.",
        {"plate": sided_plate}, (("k", "1", 0.05, -1.0, 1.0, "share of the lift"),),
        channels=("sway", "yaw")),
    effect(
        "linear_yaw_damping", "The water resists turning in proportion to the yaw rate.",
        {"force": yaw_damping_force}, (("N_r", "N m s", 0.001, 0.0, 0.2, "moment at 1 rad/s"),),
        channels=("yaw",)),
    effect(
        "viscous_drag", "Skin friction grows more slowly than speed squared.",
        {"force": viscous_force}, (("k", "N (s/m)^1.5", 0.1, 0.0, 20.0, "force at 1 m/s"),),
        channels=("surge", "sway")),
    effect(
        "linear_drag", "Drag grows in proportion to speed.", {"force": linear_drag_force},
        (("k", "N s/m", 0.02, 0.0, 5.0, "force at 1 m/s"),), channels=("surge", "sway")),
    effect(
        "tail_fin_lift", "The tail acts as a fin and turns the nose back into the flow.",
        {"force": fin_force},
        (("S", "m2", 0.005, 0.0, 0.2, "lift slope times area"),
         ("b", "m", 0.14, 0.0, 0.4, "distance behind the centre of mass")),
        channels=("sway", "yaw")),
    effect(
        "crossflow_drag", "The body is dragged sideways, strip by strip.",
        {"force": crossflow_force}, (("C", "1", 0.5, 0.0, 20.0, "drag coefficient of a strip"),),
        channels=("sway", "yaw")),
    effect(
        "added_mass", "The water around the fish has to be accelerated with it.",
        {"inertia": added_inertia},
        (("A11", "kg", 0.05, 0.0, 3.0, "added mass in surge"),
         ("A22", "kg", 0.1, 0.0, 5.0, "added mass in sway"),
         ("A66", "kg m2", 0.0003, 0.0, 0.05, "added inertia in yaw")),
        channels=("surge", "sway", "yaw"), strengths=3),
    effect(
        "lift_lag", "The body's lift follows changes with a delay.", {"plate": lag_plate},
        (("k", "1", 0.5, 0.0, 1.2, "share of the lift that lags"),
         ("s", "1", 1.0, 0.1, 40.0, "body lengths travelled while it builds up")),
        channels=("sway", "yaw"), states=("z",), rates=lag_rates),
    effect(
        "uniform_current", "The water itself moves, the same everywhere.",
        {"water": current_water},
        (("c_x", "m/s", 0.003, -0.2, 0.2, "along x"), ("c_y", "m/s", 0.003, -0.2, 0.2, "along y")),
        channels=("surge", "sway"), strengths=2),
    effect(
        "keypoint_bias", "The tracked point is not the centre of mass.",
        {"observe": point_observe},
        (("by", "m", 0.003, -0.1, 0.1, "to the left"), ("bx", "m", 0.003, -0.15, 0.15, "ahead")),
        kind="measurement", channels=("sway", "yaw"), strengths=2),
    effect(
        "heading_bias", "The heading is read beside the body's axis.",
        {"observe": heading_observe}, (("d", "rad", 0.02, -0.4, 0.4, "to the left"),),
        kind="measurement", channels=("yaw",)),
)  # fmt: skip
