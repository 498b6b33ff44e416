"""The tail: where its mean force acts, what it depends on, and whether it beats as commanded.

Sources: Wang and Tan, J. Dyn. Sys. Meas. Control 137 (2015) (averaged forces of a tail-actuated
fish); Carlton, Marine Propellers and Propulsion (2012), sec. 6.1 (thrust falling with advance);
otherwise own statements.
"""
# ruff: noqa: PLR0917 -- arguments are named after what an equation needs

from __future__ import annotations

import math

from bluekoi.explain import Cause, Parameter

Three = tuple[float, float, float]


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
    rho: float,
    A: float,
    a: float,
    f: float,
    C_T: float,
    phi: float,
    k: float,
) -> tuple[float]:
    """Thrust changes by k T phi."""
    return (k * C_T * 0.5 * rho * A * a * a * f * f * phi,)


def amplitude_thrust(
    rho: float,
    A: float,
    a: float,
    f: float,
    C_T: float,
    p: float,
) -> tuple[float]:
    """T ~ a^(2 + p), held at 20 degrees."""
    return (C_T * 0.5 * rho * A * a * a * f * f * ((a / 0.3490658503988659) ** p - 1.0),)


def advance_thrust(rho: float, A: float, a: float, f: float, uh: float, k: float) -> tuple[float]:
    """Thrust changes by -k rho A a f u: it falls with the advance of a beat."""
    return (-k * rho * A * a * f * uh,)


def beat_drive(beat_hz: float, beat_hz0: float, k: float) -> Three:
    """F = f0 + k (seen beat - f0): k = 1 where the tail beats as the recoil shows."""
    return 0.0, 0.0, k * (beat_hz - beat_hz0)


def amplitude_drive(amplitude: float, recoil: float, recoil_share: float, k: float) -> Three:
    """A = commanded + k (recoil / share - commanded): k = 1: as the recoil shows."""
    return 0.0, k * (recoil / recoil_share - amplitude), 0.0


def beating_drive(
    amplitude: float,
    recoil: float,
    recoil_share: float,
    beat_hz: float,
    beat_hz0: float,
    k: float,
) -> Three:
    """Both: amplitude and frequency as the recoil shows them, at k = 1 in full."""
    return 0.0, k * (recoil / recoil_share - amplitude), k * (beat_hz - beat_hz0)


def offset_drive(d: float) -> Three:
    """Phi = commanded + d."""
    return d, 0.0, 0.0


def reach_drive(bias: float, k: float) -> Three:
    """Phi = (1 - k) commanded, to starboard (commanded < 0) only."""
    return -k * min(bias, 0.0), 0.0, 0.0


def spin_up_drive(t: float, amplitude: float, k: float, tau: float) -> Three:
    """A = commanded (1 - k exp(-t / tau)), t since the first frame."""
    return 0.0, -amplitude * k * math.exp(-t / tau), 0.0


CAUSES = (
    Cause(
        "thrust_line_offset",
        "The thrust of the turned tail acts behind the centre of mass and turns the fish.",
        {"force": thrust_line_force},
        (Parameter("d", "m", 0.05, -0.3, 0.5, "distance of the thrust behind the centre of mass"),),
    ),
    Cause(
        "tail_side_force",
        "A turned tail pushes the fish sideways more (or less) than its share of the thrust.",
        {"force": side_force},
        (Parameter("k", "1", 0.2, -5.0, 5.0, "extra side force over T sin phi"),),
    ),
    Cause(
        "thrust_loss_with_bias",
        "A tail that beats about a turned position gives less thrust.",
        {"thrust": bias_thrust},
        (Parameter("k", "1/rad2", 0.3, -1.3, 1.3, "share of thrust lost per bias squared"),),
    ),
    Cause(
        "thrust_asymmetry",
        "The tail pushes harder when turned to one side than to the other.",
        {"thrust": sided_thrust},
        (Parameter("k", "1/rad", 0.1, -1.0, 1.0, "share of thrust gained per bias to port"),),
    ),
    Cause(
        "thrust_law",
        "Thrust does not grow with the square of the tail's amplitude.",
        {"thrust": amplitude_thrust},
        (Parameter("p", "1", 0.2, -2.0, 2.0, "power of the amplitude beyond 2"),),
    ),
    Cause(
        "thrust_loss_with_speed",
        "The faster the fish swims, the less thrust a beat gives.",
        {"thrust": advance_thrust},
        (Parameter("k", "m", 0.005, 0.0, 1.0, "loss per advance"),),
    ),
    Cause(
        "tail_beat_frequency",
        "The tail does not beat at one frequency in all trials, as "
        "commanded, but as the recoil of the body shows.",
        {"drive": beat_drive},
        (Parameter("k", "1", 0.5, -1.0, 3.0, "1: thrust follows the seen beat in full"),),
    ),
    Cause(
        "tail_amplitude",
        "The tail does not swing as far as commanded in all trials, but as the "
        "recoil of the body shows.",
        {"drive": amplitude_drive},
        (Parameter("k", "1", 0.5, -1.0, 3.0, "1: thrust follows the seen recoil in full"),),
    ),
    Cause(
        "tail_drive",
        "The tail beats neither as fast nor as far as commanded, but as the recoil "
        "of the body shows.",
        {"drive": beating_drive},
        (Parameter("k", "1", 0.5, -1.0, 3.0, "1: thrust follows seen beat and recoil in full"),),
    ),
    Cause(
        "head_angle_offset",
        "The tail does not stand at the commanded bias: a constant offset.",
        {"drive": offset_drive},
        (Parameter("d", "rad", 0.03, -0.4, 0.4, "offset, to port positive"),),
    ),
    Cause(
        "servo_reach",
        "The servo does not turn the tail as far to one side as to the other.",
        {"drive": reach_drive},
        (Parameter("k", "1", 0.1, -0.6, 0.6, "share of negative bias missing"),),
    ),
    Cause(
        "motor_spin_up",
        "The tail does not beat at full amplitude from the start.",
        {"drive": spin_up_drive},
        (
            Parameter("k", "1", 0.5, 0.0, 1.0, "share missing at the first frame"),
            Parameter("tau", "s", 0.5, 0.05, 5.0, "time constant"),
        ),
    ),
)
