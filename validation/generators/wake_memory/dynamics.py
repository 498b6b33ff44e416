"""Equations of motion with aerodynamic memory, integrated by third-order Adams-Bashforth.

The state of a trial holds the rigid body, the shaft and the memory of the flow:
x, y, theta, x_dot, y_dot, theta_dot | shaft (cycles) | lift lags 1, 2 | attached fraction |
fin lags 1, 2 | recoil angle, rate | recoil sideways shift (m), speed | recoil ramp | lagged alpha.

Recoil is the vibration forced by the tail's zero-mean side force and moment. The flow forces act on
the mean motion, so that a quadratic damping is not rectified into a linear one: the mean is that of
equations (1) to (8). Surge pulsates at twice the tail-beat frequency around equation (1).
"""
# Compiled laws take no keywords.
# ruff: noqa: PLR0917

import numpy as np
from numba import njit

from . import effects as fx
from .catalogue import CAUSE_ROW
from .effects import BODY, C_D0, C_DA, C_LA, C_MA, C_MD, C_T, HEAD1, HINGE, INERTIA, MASS, RHO, SPAN

STATE_SIZE = 18
PHI, F, HEAD, START, ORDER, PULSE, RECOIL = range(7)
FIN, ADDED, VISCOUS, DAMPING, LOSS, CURRENT, GYRE, WALL, STALL, SERVO, SPIN, SAG = range(12)
TRIM, OFFSET, CROSS, LINE, AREA, LAG, WAVE, COULOMB, WAKE, SINK, COM, SIDES, UNLISTED = range(
    12, 25
)
assert CAUSE_ROW["battery_sag"] == SAG
assert CAUSE_ROW["unlisted"] == UNLISTED


@njit(cache=True)
def head_angle(t, trial, E):
    """Actual head angle (rad): the commanded one, its lasting error and the servo's response."""
    phi, p = trial[PHI], E[OFFSET]
    if p[0] == 1:
        phi += p[1]
    elif p[0] == 2:
        phi *= 1 + p[1] / 0.5
    elif p[0] == 3:
        phi -= p[1] * np.sign(phi)
    return phi * fx.step_response(E[SERVO, 0], E[SERVO, 1], E[SERVO, 2], t - trial[START])


@njit(cache=True)
def flapping_frequency(t, trial, E):
    """Actual flapping frequency (Hz): the steady one, spin-up and sag; 0 before the start."""
    since = t - trial[START]
    if since < 0:
        return 0.0
    form = 3 if E[SPIN, 0] == 3 else E[SPIN, 0]
    spin = fx.step_response(form, E[SPIN, 1], E[SPIN, 2], since)
    return trial[F] * spin * fx.battery_sag(E[SAG], since, trial[ORDER], trial[F])


@njit(cache=True)
def flow_state(t, s, trial, R, E, stream):
    """Kinematics of the body relative to the water; `stream`: gust and wake velocity (m/s)."""
    z = complex(s[0], s[1])
    w = complex(s[3], s[4]) - stream - fx.water_velocity(E[CURRENT], E[GYRE], t, z, trial[ORDER])
    phi, f = head_angle(t, trial, E), flapping_frequency(t, trial, E)
    e_core = np.exp(1j * (s[2] + phi))
    U = abs(w)
    along = w * np.conj(e_core)
    alpha = np.angle(np.exp(1j * s[2]) * np.conj(w)) if U > 1e-9 else 0.0
    area = trial[HEAD] * R[SPAN]
    ratio = fx.thrust_ratio(E[LOSS], E[AREA], along.real, f, trial[HEAD], R)
    pulse = 1 + trial[PULSE] * np.cos(4 * np.pi * s[6])
    thrust = R[C_T] * 0.5 * RHO * area * f * f * ratio * pulse
    q = 0.5 * RHO * area * U * U
    return fx.Flow(t, z, w, U, alpha, s[2], phi, s[5], f, trial[HEAD], along.real, along.imag,
                   e_core, q, thrust)  # fmt: skip


@njit(cache=True)
def lift_slope(k, s, E):
    """The sin(2 alpha) of the lift with its memory."""
    now = np.sin(2 * k.alpha)
    if E[LAG, 0] == 0:
        return now
    A1, A2, _, _ = fx.lift_memory(E[LAG])
    return (1 - A1 - A2) * now + s[7] + s[8]


@njit(cache=True)
def head_plate(k, s, R, E):
    """Force (N, pool axes) and moment (N m) of the head plate, equations (2) to (8)."""
    sides, way = E[SIDES], np.tanh(k.alpha / 0.03)
    lift, drag, damping = 1.0, 1.0, 1.0
    if sides[0] == 1:
        lift += sides[1] * way
    elif sides[0] == 2:
        drag += sides[1] * way
    elif sides[0] == 3:
        damping += sides[1] * np.tanh(k.rate / 0.05)
    v_hat = k.w / max(k.speed, 1e-9)
    C_L = R[C_LA] * lift_slope(k, s, E) * lift * fx.stall_ratio(E[STALL], s[9], k.alpha)
    C_D = (R[C_D0] + R[C_DA] * (1 - np.cos(2 * k.alpha))) * drag
    force = k.q * (C_L * v_hat * 1j - C_D * v_hat)
    M = k.q * R[C_MA] * np.sin(2 * k.alpha) - damping * R[C_MD] * k.rate * abs(k.rate)
    arm = k.head + R[HINGE] - (R[BODY] + k.head - R[HEAD1]) / 4
    N = (force * np.conj(1j * np.exp(1j * k.theta))).real
    return force, M + N * arm


@njit(cache=True)
def com_shift(p):
    """Centre of mass ahead and to port of the stated one (m, core axes)."""
    if p[0] == 2:
        return complex(0.0, p[1])
    return complex(p[1], 0.0) if p[0] > 0 else 0j


@njit(cache=True)
def with_added_mass(p, k, F, N, R):
    """Accelerations from force F and moment N by Kirchhoff's equations in body axes.

    1 Lamb 1932 ellipsoid (with Munk moment); 2 Lighthill 1971 slender body; 3 Korotkin 2009,
    the head plate alone, its centre ahead of the centre of mass. Strength: ratio to those values.
    """
    m, inertia = R[MASS], R[INERTIA]
    if p[0] == 0:
        return F / m, N / inertia
    e = np.exp(1j * k.theta) if p[0] == 3 else k.e_core
    m22 = 0.25 * np.pi * RHO * R[SPAN] ** 2 * R[BODY] * 0.6
    m11, m66, m26 = 0.07 * m22, 0.06 * m22 * R[BODY] ** 2, 0.0
    if p[0] == 2:
        m11 = 0.0
    elif p[0] == 3:
        m22, m11 = 0.25 * np.pi * RHO * R[SPAN] ** 2 * k.head * 0.8, 0.0
        lever = 0.5 * k.head + R[HINGE]
        m26, m66 = m22 * lever, m22 * lever**2
    m11, m22, m26, m66 = p[1] * m11, p[1] * m22, p[1] * m26, p[1] * m66
    rel, Fb = k.w * np.conj(e), F * np.conj(e)
    u, v, r = rel.real, rel.imag, k.rate
    b1 = Fb.imag - (m + m11) * u * r
    b2 = N - m26 * u * r - (m22 - m11) * u * v
    det = (m + m22) * (inertia + m66) - m26 * m26
    v_dot = (b1 * (inertia + m66) - m26 * b2) / det
    r_dot = ((m + m22) * b2 - m26 * b1) / det
    u_dot = (Fb.real + (m + m22) * v * r + m26 * r * r) / (m + m11)
    return (u_dot - v * r + 1j * (v_dot + u * r)) * e, r_dot


@njit(cache=True)
def acceleration(t, s, trial, R, E, stream, moment):
    """Acceleration (m/s^2, complex) and yaw acceleration (rad/s^2) of the centre of mass."""
    k = flow_state(t, s, trial, R, E, stream)
    F, N = head_plate(k, s, R, E)
    T = k.thrust * k.e_core
    shift = com_shift(E[COM])
    N += (np.conj(-shift * k.e_core) * (T + F)).imag
    F_fin, N_fin = fx.tail_fin_lift(E[FIN], k, k.v - E[FIN, 2] * k.rate - fin_downwash(k, s, E))
    F_cross, N_cross = fx.crossflow_drag(E[CROSS], k, R)
    F_free, N_free = fx.unlisted_force(E[UNLISTED], k)
    F += T + F_fin + F_cross + F_free + fx.wall_effect(E[WALL], k)
    F += fx.along_path_drag(E[VISCOUS], E[WAVE], E[COULOMB], k)
    N += N_fin + N_cross + N_free + moment + fx.yaw_moments(E[DAMPING], E[TRIM], E[LINE], k)
    if E[COM, 0] == 3:
        N /= 1 + R[MASS] * 3 * abs(shift) * 0.1 / R[INERTIA]
    return with_added_mass(E[ADDED], k, F, N, R)


@njit(cache=True)
def fin_downwash(k, s, E):
    """Sideways speed (m/s) at the fin that has taken effect after Wagner's lag."""
    return 0.5 * (k.v - E[FIN, 2] * k.rate) + s[10] + s[11]


@njit(cache=True)
def memory_rates(k, s, E, out):
    """Rates of the flow's memory: lift lags, separation (with alpha's lag) and fin lags."""
    A1, A2, b1, b2 = fx.lift_memory(E[LAG])
    pace = 2 * k.speed / k.head
    slower = pace / max(E[LAG, 1], 0.05)
    S = np.sin(2 * k.alpha)
    out[7] = b1 * slower * (A1 * S - s[7])
    out[8] = b2 * slower * (A2 * S - s[8])
    a = abs(k.alpha)
    out[17] = pace / 1.7 * (a - s[17])
    felt = s[17] if E[STALL, 0] == 2 else a - 2.0 * (a - s[17])
    X0 = fx.attached_fraction(E[STALL], felt) if E[STALL, 0] > 0 else 1.0
    out[9] = pace / 3.0 * (X0 - s[9])
    w = k.v - E[FIN, 2] * k.rate
    out[10] = 0.0455 * pace * (0.165 * w - s[10])
    out[11] = 0.3 * pace * (0.335 * w - s[11])


@njit(cache=True)
def rates(t, s, trial, R, E, stream, moment, out):
    """Time derivative of the state, written into `out`."""
    a, r_dot = acceleration(t, s, trial, R, E, stream, moment)
    k = flow_state(t, s, trial, R, E, stream)
    out[0], out[1], out[2] = s[3], s[4], s[5]
    out[3], out[4], out[5], out[6] = a.real, a.imag, r_dot, k.f
    memory_rates(k, s, E, out)
    beat = trial[RECOIL] * s[16] * k.thrust * np.sin(2 * np.pi * s[6])
    lever = 0.75 * (R[BODY] - R[HEAD1])
    out[12], out[13] = s[13], -beat * lever / R[INERTIA] - 5.0 * s[13] - 9.0 * s[12]
    out[14], out[15] = s[15], beat / R[MASS] - 5.0 * s[15] - 9.0 * s[14]
    out[16] = (1.0 - s[16]) / 0.35 if k.f > 0 else 0.0


@njit(cache=True)
def wake_velocity(p, trail, count, t, z):
    """Water velocity (m/s) left at z by the robot's own path at least 1.2 s ago.

    `trail` rows: time, x, y, thrust direction, speed. Strength: initial speed; shape 1: width (m).
    1 Gaussian jet, decay 6 s (Schlichting 1979); 2 jet widening as sqrt t, slowing as 1/t
    (Cantwell 1986); 3 drag wake, moving with the robot (Tennekes and Lumley 1972);
    4 vortex pair pushed to the side of a turn (Drucker and Lauder 1999).
    """
    total, weight = 0j, 0.0
    for i in range(count):
        age = t - trail[i, 0]
        if age < 1.2:
            break
        width, decay = p[2], np.exp(-age / 6.0)
        if p[0] == 2:
            width, decay = p[2] * np.sqrt(age / 1.2), 1.2 / age
        d2 = (z.real - trail[i, 1]) ** 2 + (z.imag - trail[i, 2]) ** 2
        g = np.exp(-0.5 * d2 / width**2)
        way = -np.exp(1j * trail[i, 3])
        if p[0] == 3:
            way = -way
        elif p[0] == 4:
            way *= 1j
        total += g * decay * way * trail[i, 4] / 0.4
        weight += g
    return p[1] * total / max(weight, 1.0)


@njit(cache=True)
def simulate_trial(trial, R, E, start, gusts, fps, substeps):
    """States (frames, 18) and wake velocity (frames, 2) of one trial.

    Adams-Bashforth of order 3, first two steps by Heun (Hairer, Norsett, Wanner 1993, III.1).
    `start`: x, y, theta; `gusts`: (frames, 3) water velocity (m/s) and moment (N m).
    """
    n, h = gusts.shape[0], 1.0 / (fps * substeps)
    path, wakes, trail = np.zeros((n, STATE_SIZE)), np.zeros((n, 2)), np.zeros((400, 5))
    s, d0, d1, d2 = (
        np.zeros(STATE_SIZE),
        np.zeros(STATE_SIZE),
        np.zeros(STATE_SIZE),
        np.zeros(STATE_SIZE),
    )
    s[0], s[1], s[2], s[9] = start[0], start[1], start[2], 1.0
    count, wake, step = 0, 0j, 0
    for i in range(n):
        t_frame = i / fps
        if E[WAKE, 0] > 0 and t_frame >= count * 0.08 and count < 400:
            course = s[2] + head_angle(t_frame, trial, E)
            trail[count] = np.array([t_frame, s[0], s[1], course, np.hypot(s[3], s[4])])
            count += 1
        path[i], wakes[i, 0], wakes[i, 1] = s, wake.real, wake.imag
        if i == n - 1:
            break
        for j in range(substeps):
            t, b = t_frame + j * h, j / substeps
            g = (1 - b) * gusts[i] + b * gusts[i + 1]
            if E[WAKE, 0] > 0:
                wake = wake_velocity(E[WAKE], trail, count, t, complex(s[0], s[1]))
            stream = complex(g[0], g[1]) + wake
            d2[:] = d1
            d1[:] = d0
            rates(t, s, trial, R, E, stream, g[2], d0)
            if step < 2:
                probe = s + h * d0
                ahead = np.zeros(STATE_SIZE)
                rates(t + h, probe, trial, R, E, stream, g[2], ahead)
                s = s + 0.5 * h * (d0 + ahead)
            else:
                s = s + h / 12 * (23 * d0 - 16 * d1 + 5 * d2)
            step += 1
    return path, wakes
