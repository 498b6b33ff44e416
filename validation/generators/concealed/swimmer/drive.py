"""What motor and servo really do at a time, and what the tail makes of it. Compiled."""

import math

from numba import njit

from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws, TrialCommand

__all__ = ["frequency", "head_angle", "thrust"]

FIRST_ORDER, CRITICAL, RATE = 0, 1, 2


@njit(cache=True)
def head_angle(g: HiddenLaws, c: TrialCommand, t: float) -> float:
    """Head angle (rad): offset, and the servo's way there.

    FIRST_ORDER `1 - exp(-t/T)`; CRITICAL `1 - (1 + 2t/T) exp(-2t/T)`; RATE: 45 deg in `2 T`.
    """
    aim = c.head_angle + g.head_offset
    if g.servo_s <= 0.0:
        return aim
    x = max(t, 0.0) / g.servo_s
    if g.servo_law == FIRST_ORDER:
        return aim * (1 - math.exp(-x))
    if g.servo_law == CRITICAL:
        return aim * (1 - (1 + 2 * x) * math.exp(-2 * x))
    way = 0.5 * x * (0.25 * math.pi)
    return math.copysign(min(way, abs(aim)), aim)


@njit(cache=True)
def frequency(g: HiddenLaws, c: TrialCommand, t: float) -> float:
    """Beat frequency (Hz): `1 - exp(-t/T)`, `tanh(t/T)` or a ramp over `2 T`."""
    if g.spin_s <= 0.0:
        return c.flap_hz
    x = max(t, 0.0) / g.spin_s
    if g.spin_law == 0:
        return c.flap_hz * (1 - math.exp(-x))
    if g.spin_law == 1:
        return c.flap_hz * math.tanh(x)
    return c.flap_hz * min(0.5 * x, 1.0)


@njit(cache=True)
def battery_factor(g: HiddenLaws, t: float) -> float:
    """Factor on the thrust of a sagging pack: `1 - kt`, `1/(1 + kt)` or `exp(-kt)`."""
    x = g.sag_per_s * max(t, 0.0)
    if g.sag_law == 0:
        return 1 - x
    return 1 / (1 + x) if g.sag_law == 1 else math.exp(-x)


@njit(cache=True)
def advance_factor(g: HiddenLaws, f: float, u: float) -> float:
    """Factor on the thrust with the advance `J = u/f` (m): `1 - kJ`, `exp(-kJ)`, `1 - (kJ)^2`."""
    if g.slip_per_m <= 0.0:
        return 1.0
    x = g.slip_per_m * max(u, 0.0) / max(f, 0.05)
    if g.slip_law == 0:
        return max(1 - x, -0.5)
    return math.exp(-x) if g.slip_law == 1 else max(1 - x * x, -0.5)


@njit(cache=True)
def thrust(
    b: BodyParameters, g: HiddenLaws, c: TrialCommand, t: float, f: float, u: float, beat: float
) -> float:
    """Thrust (N) along the core: eq. 1 with its pulse twice a beat and what takes from it."""
    area = c.head_length_m * b.head_span_m
    lost = g.thrust_area * (c.head_length_m - b.head_1x_m) * b.head_span_m
    size = 0.5 * b.density_kg_m3 * b.C_T * f * f * (area - lost)
    return (
        size * (1 + b.pulse * math.cos(2 * beat)) * battery_factor(g, t) * advance_factor(g, f, u)
    )
