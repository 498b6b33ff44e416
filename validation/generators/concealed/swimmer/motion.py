"""Motion of the robot from release: fixed-step Runge-Kutta, compiled.

State `(9,)`: x, y (m), psi (core, rad), u, v (core frame, m/s), r (rad/s), beat (rad), and the two
states of lagging lift (m^2/s^2).
"""

import math

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline

from bluekoi.synthetic.ground_truth_physics import Recoil
from bluekoi.synthetic.motion_simulation import TrialMotion
from validation.generators.concealed.swimmer.drive import frequency, head_angle, thrust
from validation.generators.concealed.swimmer.further_forces import (
    drag_over_speed,
    further_yaw_moment,
    tether_force,
)
from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws, TrialCommand
from validation.generators.concealed.swimmer.plates import crossflow_force, fin_force, head_plate
from validation.generators.concealed.swimmer.water import water_velocity

__all__ = ["STATES", "rates", "states", "swim"]

STATES = 9
STEP_S = 1 / 480
KEEP_EVERY_STEPS = 2


@njit(cache=True)
def _relative_velocity(
    b: BodyParameters, g: HiddenLaws, eddies: np.ndarray, t: float, s: np.ndarray, x: float
) -> tuple[float, float]:
    """Velocity (core frame) of the centre of mass against the water at station x of the core."""
    cp, sp = math.cos(s[2]), math.sin(s[2])
    wx, wy = water_velocity(b, g, eddies, t, s[0] + x * cp, s[1] + x * sp)
    return s[3] - (wx * cp + wy * sp), s[4] - (wy * cp - wx * sp)


@njit(cache=True)
def _forces(
    b: BodyParameters, g: HiddenLaws, c: TrialCommand, eddies: np.ndarray, t: float, s: np.ndarray
) -> tuple[float, float, float, float]:
    """Surge, sway (N), yaw (N m), and what the lagging lift tends to."""
    phi, f = head_angle(g, c, t), frequency(g, c, t)
    back = b.body_length_m - b.head_1x_m - b.hinge_to_com_m
    u, v = _relative_velocity(b, g, eddies, t, s, 0.0)
    uh, vh = _relative_velocity(b, g, eddies, t, s, b.hinge_to_com_m + 0.5 * c.head_length_m)
    vt = _relative_velocity(b, g, eddies, t, s, -back)[1]
    T = thrust(b, g, c, t, f, u, s[6])
    X, Y, N, aim = head_plate(b, g, c, phi, uh, vh, s[7], s[8])
    V = math.sqrt(u * u + v * v)
    k = drag_over_speed(b, g, c, t, s[0], s[1], s[2] - c.psi + c.turned, V)
    X, Y = X + T - k * u, Y - k * v + g.jet * math.sin(phi) * T
    N += further_yaw_moment(g, T, phi, u, V, s[5], c.head_length_m / b.head_1x_m)
    N -= b.C_Md * s[5] * abs(s[5])
    if g.fin_m2 != 0.0:
        dY, dN = fin_force(b, g, u, v, vt - v, s[5])
        Y, N = Y + dY, N + dN
    if g.cross != 0.0:
        dY, dN = crossflow_force(b, g, v, vt - v, s[5])
        Y, N = Y + dY, N + dN
    if g.tether_n_m != 0.0:
        px, py = tether_force(g, s[0], s[1])
        cp, sp = math.cos(s[2]), math.sin(s[2])
        X, Y = X + px * cp + py * sp, Y + py * cp - px * sp
    return X, Y, N, aim


@njit(cache=True)
def rates(
    b: BodyParameters,
    g: HiddenLaws,
    c: TrialCommand,
    eddies: np.ndarray,
    t: float,
    s: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the state's derivative: Kirchhoff's equations in the core's frame."""
    X, Y, N, aim = _forces(b, g, c, eddies, t, s)
    length = b.body_length_m + c.head_length_m - b.head_1x_m
    mx = b.mass_kg + g.added_surge_share * g.added_sway_kg
    my = b.mass_kg + g.added_sway_kg
    J = b.yaw_inertia_kg_m2 + g.added_yaw_share * g.added_sway_kg * length**2 / 12
    cp, sp = math.cos(s[2]), math.sin(s[2])
    out[0] = s[3] * cp - s[4] * sp
    out[1] = s[3] * sp + s[4] * cp
    out[2] = s[5]
    out[3] = (X + my * s[4] * s[5]) / mx
    out[4] = (Y - mx * s[3] * s[5]) / my
    out[5] = (N - (my - mx) * s[3] * s[4]) / J
    out[6] = 2 * math.pi * frequency(g, c, t)
    V = math.sqrt(s[3] * s[3] + s[4] * s[4])
    if g.lag_law == 1:
        out[7] = (aim - s[7]) * 0.0455 * 2 * V / c.head_length_m
        out[8] = (aim - s[8]) * 0.3 * 2 * V / c.head_length_m
    else:
        pace = V / (g.lag_lengths * c.head_length_m) if g.lag_law == 0 else 0.4 / g.lag_lengths
        out[7] = (aim - s[7]) * pace
        out[8] = 0.0


@njit(cache=True)
def states(
    b: BodyParameters,
    g: HiddenLaws,
    c: TrialCommand,
    eddies: np.ndarray,
    steps: int,
    step_s: float,
    keep: int,
) -> np.ndarray:
    """States `(steps // keep + 1, 9)` from the start, every `keep`-th step of `step_s` (RK4).

    Lagging lift starts where it tends to.
    """
    s = np.zeros(STATES)
    s[0], s[1], s[2], s[3], s[4], s[5], s[6] = c.x, c.y, c.psi, c.u, c.v, c.r, c.beat
    phi = head_angle(g, c, c.time_s)
    s[7] = head_plate(b, g, c, phi, s[3], s[4], 0.0, 0.0)[3]
    s[8] = s[7]
    out = np.zeros((steps // keep + 1, STATES))
    out[0] = s
    k1, k2, k3, k4 = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    for i in range(steps):
        t = c.time_s + i * step_s
        rates(b, g, c, eddies, t, s, k1)
        rates(b, g, c, eddies, t + 0.5 * step_s, s + 0.5 * step_s * k1, k2)
        rates(b, g, c, eddies, t + 0.5 * step_s, s + 0.5 * step_s * k2, k3)
        rates(b, g, c, eddies, t + step_s, s + step_s * k3, k4)
        s = s + step_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if (i + 1) % keep == 0:
            out[(i + 1) // keep] = s
    return out


def swim(
    body: BodyParameters,
    laws: HiddenLaws,
    command: TrialCommand,
    duration_s: float,
    *,
    eddies: np.ndarray,
    recoil: Recoil | None,
) -> TrialMotion:
    """The trial from release as a `TrialMotion`: place of the core's keypoint, velocity of the
    centre of mass in the pool frame.
    """
    steps = math.ceil(duration_s / STEP_S / KEEP_EVERY_STEPS) * KEEP_EVERY_STEPS + KEEP_EVERY_STEPS
    found = states(body, laws, command, eddies, steps, STEP_S, KEEP_EVERY_STEPS)
    time_s = np.arange(len(found)) * (STEP_S * KEEP_EVERY_STEPS)
    velocity = (found[:, 3] + 1j * found[:, 4]) * np.exp(1j * found[:, 2])
    place = found[:, :2] - laws.com_shift_m * np.column_stack(
        [np.cos(found[:, 2]), np.sin(found[:, 2])]
    )
    rest = [found[:, 2], velocity.real, velocity.imag, found[:, 5], found[:, 6]]
    spline = CubicSpline(time_s, np.column_stack([place, *rest]))

    def angle(at_s: np.ndarray) -> np.ndarray:
        clipped = np.clip(np.atleast_1d(at_s), 0.0, duration_s)
        return np.array([head_angle(laws, command, float(t)) for t in clipped])

    return TrialMotion(duration_s, lambda t: spline(t).T, angle, recoil)
