"""Forces on the head plate and, strip by strip, on core and tail. Compiled.

Axes of the core: u along, v to the left, r counter-clockwise; stations x along the core from the
centre of mass, positive towards the head.
"""

import math

from numba import njit

from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws, TrialCommand

__all__ = ["aerodynamic_arm", "crossflow_force", "fin_force", "head_plate", "stall_lift_share"]

FIN_STRIPS = 5
CROSS_STRIPS = 12


@njit(cache=True)
def aerodynamic_arm(b: BodyParameters, head_m: float) -> float:
    """Distance (m) from the centre of mass to a quarter of the body's length behind the nose."""
    return head_m + b.hinge_to_com_m - 0.25 * (b.body_length_m + head_m - b.head_1x_m)


@njit(cache=True)
def stall_lift_share(g: HiddenLaws, alpha: float) -> float:
    """Share of the lift kept at an angle of attack (rad).

    stall_law 0: logistic loss about the onset; 1: loss that grows with the square of the excess
    over a range (as of a separation point that walks forward), 2: a cosine step from the onset on.
    """
    if g.stall == 0.0:
        return 1.0
    over = (abs(alpha) - g.stall_onset) / g.stall_width
    if g.stall_law == 0:
        return 1 - g.stall / (1 + math.exp(-2.5 * (over - 0.5)))
    x = min(max(over, 0.0), 1.0)
    if g.stall_law == 1:
        return 1 - g.stall * x * x
    return 1 - g.stall * 0.5 * (1 - math.cos(math.pi * x))


@njit(cache=True)
def port_starboard_factor(g: HiddenLaws, s2a: float) -> float:
    """Factor on the lift of one side: `1 + k sign`, or `1 + k tanh(4 sin 2 alpha)`."""
    if g.side == 0.0:
        return 1.0
    if g.side_law == 0:
        return 1 + math.copysign(g.side, s2a * g.side) if s2a != 0.0 else 1.0
    return 1 + g.side * math.tanh(4 * s2a)


@njit(cache=True)
def head_plate(
    b: BodyParameters,
    g: HiddenLaws,
    c: TrialCommand,
    phi: float,
    u: float,
    v: float,
    z1: float,
    z2: float,
) -> tuple[float, float, float, float]:
    """Surge, sway (N), yaw moment (N m) of the head plate, and the lift variable it tends to.

    Eqs. 2 to 8 with the lift's `V^2 sin 2 alpha` = s, lagging by its states:
    lag_law 0 `s - k (s - z1)`; 1 Jones' `s - 2k (0.165 (s - z1) + 0.335 (s - z2))`.
    """
    uh = u * math.cos(phi) - v * math.sin(phi)
    vh = u * math.sin(phi) + v * math.cos(phi)
    V = math.sqrt(uh * uh + vh * vh + 1e-14)
    s = -2.0 * uh * vh
    alpha = math.atan2(-vh, uh)
    lagged = s
    if g.lag != 0.0 and g.lag_law == 1:
        lagged = s - 2 * g.lag * (0.165 * (s - z1) + 0.335 * (s - z2))
    elif g.lag != 0.0:
        lagged = s - g.lag * (s - z1)
    k = 0.5 * b.density_kg_m3 * c.head_length_m * b.head_span_m
    L = k * b.C_La * lagged * stall_lift_share(g, alpha) * port_starboard_factor(g, s / (V * V))
    D = k * (b.C_D0 * V * V + 2.0 * b.C_Da * vh * vh)
    xh, yh = (-L * vh - D * uh) / V, (L * uh - D * vh) / V
    M = k * (b.C_Ma * s + g.moment_wave_m * V * V * math.sin(4 * alpha))
    X = xh * math.cos(phi) + yh * math.sin(phi)
    Y = yh * math.cos(phi) - xh * math.sin(phi)
    return X, Y, M + yh * aerodynamic_arm(b, c.head_length_m) - g.com_shift_m * Y, s


@njit(cache=True)
def fin_force(
    b: BodyParameters, g: HiddenLaws, u: float, v: float, dv: float, r: float
) -> tuple[float, float]:
    """Sway (N) and yaw (N m) of core and tail as a fin of several strips about its arm.

    `dv`: change of the sideways flow from the centre of mass to the tail base (m/s), linear.
    """
    back = b.body_length_m - b.head_1x_m - b.hinge_to_com_m
    Y = N = 0.0
    for i in range(FIN_STRIPS):
        x = -(g.fin_arm_m + g.com_shift_m) + g.fin_spread_m * (i - 2) * 0.7
        w = v - dv * x / back + x * r
        dY = -0.5 * b.density_kg_m3 * g.fin_m2 / FIN_STRIPS * abs(u) * w
        Y, N = Y + dY, N + x * dY
    return Y, N


@njit(cache=True)
def crossflow_force(
    b: BodyParameters, g: HiddenLaws, v: float, dv: float, r: float
) -> tuple[float, float]:
    """Sway (N) and yaw (N m) of sideways drag over the strips from hinge to tail base.

    cross_law 0: depth as the head's span all along; 1: depth that tapers to a third and widens
    again to the tail fin behind.
    """
    back = b.body_length_m - b.head_1x_m - b.hinge_to_com_m
    end = back if g.cross_law == 0 else back + b.tail_length_m
    dx = (b.hinge_to_com_m + end) / CROSS_STRIPS
    Y = N = 0.0
    for i in range(CROSS_STRIPS):
        x = b.hinge_to_com_m - (i + 0.5) * dx
        depth = b.head_span_m
        if g.cross_law == 1:
            s = (b.hinge_to_com_m - x) / (b.hinge_to_com_m + back)
            depth *= 1 - 0.67 * s if s < 1 else 0.9
        w = v - dv * x / back + x * r
        dY = -0.5 * b.density_kg_m3 * g.cross * depth * dx * w * abs(w)
        Y, N = Y + dY, N + x * dY
    return Y, N
