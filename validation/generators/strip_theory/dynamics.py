"""Equations of motion on complex velocities and a fixed-step RK4 (numba).

State: position z = x + i y of the centre of mass (m), velocity w (m/s), heading th of the head
plate
(rad), yaw rate om (rad/s) and two lag states of the lift coefficient. The head plate follows
equations (1) to (8) of the paper; forces of core and tail are summed over sections, each with the
normal velocity at the section. All compiled functions read the parameter vector P (`parameters`).
Symbols: v velocity through the water, e and c unit vectors of head plate and core, q A = 1/2 rho
A V^2.
"""
# ruff: noqa: PLR0917, E741, PLR0911  (compiled functions take no keywords; symbols of the books)

import cmath
import math

import numpy as np
from numba import njit

from validation.generators.strip_theory.parameters import KEYS
from validation.generators.strip_theory.water import wake_velocity, water_velocity

STATE_SIZE = 8  # x, y, vx, vy, heading, yaw rate, two lag states
SECTION_COUNT = 10
FIN_LIFT_SLOPE = 1.8 * math.pi  # numerator of Whicker and Fehlner's slope


@njit(cache=True)
def stall_factor(alpha, P):
    """Share of lift kept at angle of attack `alpha` (rad).

    Forms: 1 linear loss beyond STALL_A over STALL_W; 2 sigmoid blend (Beard and McLain 2012, 4.10);
    3 Kirchhoff flow ((1 + sqrt f)/2)^2 (Leishman and Beddoes 1989); 4 flat plate after Viterna and
    Corrigan (1982): lift held at the stalled value.
    """
    form, s, a0, width = P[KEYS.STALL_FORM], P[KEYS.STALL], P[KEYS.STALL_A], P[KEYS.STALL_W]
    a = abs(alpha)
    if form == 1.0:
        return 1.0 - s * min(max((a - a0) / width, 0.0), 1.0)
    blend = 1.0 / (1.0 + math.exp(-4.0 * (a - a0) / width))
    if form == 2.0:
        return 1.0 - s * blend
    if form == 3.0:
        attached = 1.0 - blend
        return 1.0 - s * (1.0 - (0.5 + 0.5 * math.sqrt(attached)) ** 2) / 0.75
    held = math.sin(2.0 * a0) / max(abs(math.sin(2.0 * a)), 0.2)
    return 1.0 - s * (1.0 - min(held, 1.0)) if a > a0 else 1.0


@njit(cache=True)
def lagged_lift(C_L, V, x1, x2, P):
    """Return the lift coefficient that acts and the rates of the two lag states.

    Forms: 1 first order in time, tau = LAG; 2 Jones's approximation of Wagner's function
    (1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s), NACA R-681), with s V/LAG-scaled semichords; here
    LAG is the time that 4 semichords take at 0.4 m/s.
    """
    tau = P[KEYS.LAG]
    if tau <= 0.0:
        return C_L, 0.0, 0.0
    if P[KEYS.LAG_FORM] == 1.0:
        return x1, (C_L - x1) / tau, 0.0
    rate = 4.0 / tau * max(V, 0.02) / 0.4
    acts = 0.5 * C_L + 0.165 * x1 + 0.335 * x2
    return acts, 0.0455 * rate * (C_L - x1), 0.3 * rate * (C_L - x2)


@njit(cache=True)
def head_plate(v, e, om, x1, x2, P):
    """Force (N, complex), moment without the arm (N m) and lag rates; equations (2) to (7)."""
    V = abs(v) + 1e-12
    alpha = cmath.phase(e * v.conjugate())
    q = 0.5 * P[KEYS.RHO] * P[KEYS.AREA] * V * V
    side = 1.0 + P[KEYS.ASYM] * math.tanh(alpha / 0.05) if P[KEYS.ASYM] != 0.0 else 1.0
    form = P[KEYS.ASYM_FORM]
    C_L = P[KEYS.C_LA] * math.sin(2.0 * alpha) * (side if form == 1.0 else 1.0)
    C_D = P[KEYS.C_D0] + P[KEYS.C_DA] * (1.0 - math.cos(2.0 * alpha)) * (
        side if form == 2.0 else 1.0
    )
    C_M = P[KEYS.C_MA] * math.sin(2.0 * alpha) * (side if form == 3.0 else 1.0)
    if P[KEYS.STALL] != 0.0:
        C_L *= stall_factor(alpha, P)
    C_L, r1, r2 = lagged_lift(C_L, V, x1, x2, P)
    force = q * (1j * C_L - C_D) * v / V
    return force, q * C_M - P[KEYS.C_MD] * om * abs(om), r1, r2


@njit(cache=True)
def thrust(V, freq, P):
    """Thrust (N), equation (1), with its listed changes.

    Area, forms of thrust_area: 1 A^(1-s) A_1x^s; 2 (1-s) A + s A_1x.
    Loss with speed: 1 linear in the advance ratio J = V / (f 0.1 m); 2 quadratic in J, as the
    elongated-body mean thrust 1 - (U/c)^2 (Lighthill 1960); 3 linear in V / LOSS_V (propeller near
    bollard pull, Fossen 2011, 12.2); 4 momentum theory, 1/(1 + s V/LOSS_V) (Rankine-Froude).
    """
    if freq <= 0.0:
        return 0.0
    area, s = P[KEYS.AREA], P[KEYS.TAREA]
    if P[KEYS.TAREA_FORM] == 1.0:
        area = area ** (1.0 - s) * P[KEYS.AREA_1X] ** s
    elif P[KEYS.TAREA_FORM] == 2.0:
        area = (1.0 - s) * area + s * P[KEYS.AREA_1X]
    T = P[KEYS.C_T] * 0.5 * P[KEYS.RHO] * area * freq * freq
    form, loss = P[KEYS.LOSS_FORM], P[KEYS.LOSS]
    J, ratio = V / (freq * 0.1), V / P[KEYS.LOSS_V]
    if form == 1.0:
        T *= max(1.0 - loss * J, 0.0)
    elif form == 2.0:
        T *= max(1.0 - loss * J * J, 0.0)
    elif form == 3.0:
        T *= max(1.0 - loss * ratio, 0.0)
    elif form == 4.0:
        T /= 1.0 + loss * ratio
    return T


@njit(cache=True)
def resistance(V, P):
    """Extra drag (N) at speed V (m/s).

    Viscous: 1 linear; 2 laminar plate, V^1.5 (Blasius); 3 ITTC-1957 line 0.075/(log10 Re - 2)^2
    relative to 0.3 m/s; 4 turbulent plate V^1.8 (Prandtl). Wave: 1 V^4 (thin ship, low Froude
    number); 2 Havelock's submerged body, exp(-2/F^2)-like; 3 hump, logistic in speed. Coulomb: 1
    tanh;
    2 Stribeck (Armstrong-Helouvry 1994). VISC and WAVE are forces at 1 m/s and at WAVE_V.
    """
    D = 0.0
    if P[KEYS.VISC] != 0.0:
        form = P[KEYS.VISC_FORM]
        if form == 3.0:
            Re = max(V * 0.33 / 1.0e-6, 1.0e3)
            D += P[KEYS.VISC] * 2.0 * V * V * (2.995 / (math.log10(Re) - 2.0)) ** 2
        else:
            D += P[KEYS.VISC] * V ** (1.0 if form == 1.0 else (1.5 if form == 2.0 else 1.8))
    if P[KEYS.WAVE] != 0.0:
        r = V / P[KEYS.WAVE_V]
        form = P[KEYS.WAVE_FORM]
        if form == 1.0:
            D += P[KEYS.WAVE] * r**4
        elif form == 2.0:
            D += P[KEYS.WAVE] * r * r * math.exp(2.0 - 2.0 / max(r * r, 0.02))
        else:
            D += P[KEYS.WAVE] * r * r / (1.0 + math.exp(-10.0 * (r - 1.0)))
    if P[KEYS.COUL] != 0.0:
        D += P[KEYS.COUL] * math.tanh(V / 0.02)
        if P[KEYS.COUL_FORM] == 2.0:
            D += P[KEYS.COUL] * 0.6 * math.tanh(V / 0.02) * math.exp(-((V / P[KEYS.COUL_V]) ** 2))
    return D


@njit(cache=True)
def section_normal_force(form, s, U, v_n, reach, P):
    """Crossflow drag per metre (N/m) of the section at `s` (m from the centre of mass).

    -1/2 rho Cd b |v_n| v_n with b tapering to 0.6 of the span at the caudal base. Forms of Cd:
    1 constant (Hoerner 1965, 3-11); 2 end loss over the last depth of tail (Jorgensen 1977);
    3 growing along the length from the hinge as the separation develops (Faltinsen 1990, 6.5);
    4 square root of the incidence |v_n|/V (Taylor 1952, oblique cylinder: laminar layer).
    """
    share = (P[KEYS.HINGE] - s) / reach
    b = P[KEYS.SPAN] * (1.0 - 0.4 * share)
    Cd = P[KEYS.CROSS_CD]
    if form == 2.0:
        Cd *= 1.0 - 0.5 * max(0.0, 1.0 - (1.0 - share) * reach / P[KEYS.SPAN])
    elif form == 3.0:
        Cd *= 1.5 * (1.0 - math.exp(-3.0 * share))
    elif form == 4.0:
        Cd *= math.sqrt(abs(v_n) / (math.hypot(U, v_n) + 1e-9))
    return -0.5 * P[KEYS.RHO] * Cd * b * abs(v_n) * v_n


@njit(cache=True)
def fin_section(form, area, U, v_n, P):
    """Side force (N) of a fin section of `area` (m2); none in reversed flow.

    1 Whicker and Fehlner (1958): C_La = 1.8 pi AR/(1.8 + sqrt(AR^2 + 4)), linear in v_n/U;
    2 Polhamus (1966): K_p sin a cos a + K_v sin^2 a with K_v = pi; 3 Lighthill (1960): momentum
    rho pi b^2/4 v_n shed at the trailing edge; 4 Hoerner (1975, ch. 17): pi AR/2 sin a cos a
    plus crossflow 1.2 sin^2 a.
    """
    if U <= 0.0:
        return 0.0
    AR, rho = P[KEYS.FIN_ASPECT], P[KEYS.RHO]
    slope = FIN_LIFT_SLOPE * AR / (1.8 + math.sqrt(AR * AR + 4.0))
    if form == 1.0:
        return -0.5 * rho * area * slope * U * v_n
    if form == 2.0:
        return -0.5 * rho * area * (slope * U * v_n + math.pi * P[KEYS.FIN_VORTEX] * abs(v_n) * v_n)
    if form == 3.0:  # b^2 = AR S
        return -0.25 * math.pi * rho * AR * area * U * v_n
    return -0.5 * rho * area * (0.5 * math.pi * AR * U * v_n + 1.2 * abs(v_n) * v_n)


@njit(cache=True)
def section_forces(v, c, om, P):
    """Force (N, complex, world) and moment (N m) of the sections of core and tail."""
    U, sway = (v * c.conjugate()).real, (v * c.conjugate()).imag
    reach = P[KEYS.HINGE] + P[KEYS.AFT] + P[KEYS.TAIL]
    Y, N = 0.0, 0.0
    if P[KEYS.CROSS_CD] != 0.0:
        ds = reach / SECTION_COUNT
        for k in range(SECTION_COUNT):
            s = P[KEYS.HINGE] - (k + 0.5) * ds
            dY = ds * section_normal_force(P[KEYS.CROSS_FORM], s, U, sway + om * s, reach, P)
            Y, N = Y + dY, N + s * dY
    if P[KEYS.FIN_AREA] != 0.0:
        count = 1 if P[KEYS.FIN_FORM] == 3.0 else 5
        chord = P[KEYS.TAIL] + 0.3 * P[KEYS.AFT]
        for k in range(count):
            s = -(P[KEYS.AFT] + P[KEYS.TAIL]) + (chord * (k + 0.5) / 5.0 if count == 5 else 0.0)
            dY = fin_section(P[KEYS.FIN_FORM], P[KEYS.FIN_AREA] / count, U, sway + om * s, P)
            Y, N = Y + dY, N + s * dY
    return 1j * c * Y, N


@njit(cache=True)
def wall_force(z, v, P):
    """Force (N, complex) of the four walls, with q A and a range WALL_D (m).

    Forms: 1 cushion, away from the wall, exp(-d/D); 2 suction towards it, (D/d)^2 (Bernoulli
    between body and wall, Newman 1965); 3 drag rise exp(-d/D) (blockage).
    """
    V = abs(v) + 1e-12
    q = 0.5 * P[KEYS.RHO] * P[KEYS.AREA] * V * V * P[KEYS.WALL]
    form, D = P[KEYS.WALL_FORM], P[KEYS.WALL_D]
    total = 0j
    gaps = (z.real, P[KEYS.POOL_L] - z.real, z.imag, P[KEYS.POOL_W] - z.imag)
    inward = (1 + 0j, -1 + 0j, 1j, -1j)
    for k in range(4):
        gap = max(gaps[k], 0.05)
        if form == 1.0:
            total += q * math.exp(-gap / D) * inward[k]
        elif form == 2.0:
            total -= q * (D / gap) ** 2 * inward[k]
        else:
            total -= q * math.exp(-gap / D) * v / V
    return total


@njit(cache=True)
def unlisted_force(z, v, e, t, P):
    """Force (N, complex) and moment (N m) outside the list of causes; see `effects.UNLISTED`."""
    form, F, M, a, b = P[KEYS.U_FORM], P[KEYS.U_FORCE], P[KEYS.U_MOMENT], P[KEYS.U_A], P[KEYS.U_B]
    th = cmath.phase(e)
    x, y, V = z.real, z.imag, abs(v)
    if form == 1.0:
        return 0j, M * math.sin(3.0 * th + a)
    if form == 2.0:
        return F * math.cos(2.0 * th + a) * e, 0.0
    if form == 3.0:
        return F * math.sin(2.0 * math.pi * x / b + a) * 1j * e, 0.0
    if form == 4.0:
        return 0j, M * math.sin(2.0 * math.pi * t / b + a)
    if form == 5.0:
        return F * math.sin(2.0 * math.pi * t / b + a) * e, 0.0
    if form == 6.0:
        return 0j, M * math.exp(-(((V - a) / b) ** 2))
    if form == 7.0:
        return -F * math.exp(-(((V - a) / b) ** 2)) * e, 0.0
    if form == 8.0:
        d = z - complex(0.5 * P[KEYS.POOL_L], 0.5 * P[KEYS.POOL_W])
        return -F * max(abs(d) - a, 0.0) * d / (abs(d) + 1e-9), 0.0
    if form == 9.0:
        return 0j, M * math.cos(2.0 * math.pi * y / b + a)
    return F * math.sin(th + a) * 1j * e, 0.0


@njit(cache=True)
def added_mass(P):
    """Return A11, A22, A26, A66 (kg, kg m, kg m2) about the centre of mass, core axes.

    Forms: 1 elliptic sections, a = rho pi b^2/4 per metre (Lewis 1929), surge 6 % of sway;
    2 prolate spheroid of the whole body (Lamb, art. 114; slenderness 5: k1 0.059, k2 0.895, k'
    0.70).
    """
    share, rho = P[KEYS.AM_SHARE], P[KEYS.RHO]
    if P[KEYS.AM_FORM] == 2.0:
        a, b = 0.5 * P[KEYS.BODY], 0.4 * P[KEYS.SPAN]
        m = rho * 4.0 / 3.0 * math.pi * a * b * b * share
        return 0.059 * m, 0.895 * m, 0.0, 0.70 * m * (a * a + b * b) / 5.0
    front, back = P[KEYS.HINGE] + P[KEYS.HEAD], -(P[KEYS.AFT] + P[KEYS.TAIL])
    ds = (front - back) / SECTION_COUNT
    A22, A26, A66 = 0.0, 0.0, 0.0
    for k in range(SECTION_COUNT):
        s = front - (k + 0.5) * ds
        b = P[KEYS.SPAN] * (1.0 - 0.4 * (k + 0.5) / SECTION_COUNT)
        a = share * rho * 0.25 * math.pi * b * b * ds
        A22, A26, A66 = A22 + a, A26 + s * a, A66 + s * s * a
    return 0.06 * A22, A22, A26, A66


@njit(cache=True)
def accelerations(F, N, v, c, om, P):
    """Linear (complex, m/s2) and yaw (rad/s2) acceleration from force F (N) and moment N (N m).

    Kirchhoff's equations in core axes with the relative velocity (Lamb, art. 124; Fossen 6.3).
    """
    m, I = P[KEYS.MASS], P[KEYS.INERTIA]
    if P[KEYS.AM_SHARE] == 0.0:
        return F / m, N / I
    A11, A22, A26, A66 = added_mass(P)
    body, Fb = v * c.conjugate(), F * c.conjugate()
    u, s, r = body.real, body.imag, om
    p1, p2 = A11 * u, A22 * s + A26 * r
    X = Fb.real - A11 * r * s + r * p2
    Y = Fb.imag + A22 * r * u - r * p1
    N = N + A26 * r * u - (u * p2 - s * p1)
    det = (m + A22) * (I + A66) - A26 * A26
    a2 = ((I + A66) * Y - A26 * N) / det
    return complex(X / (m + A11), a2) * c, ((m + A22) * N - A26 * Y) / det


@njit(cache=True)
def further_yaw_moments(V, om, phi, T, P):
    """Moments (N m) of yaw damping, trim and thrust line.

    Damping: 1 linear; 2 Stokes layer, linear only at small rates. Trim: 1 constant; 2 with V^2;
    3 with thrust. Thrust line: 1 T d sin phi (shifted mass of the head); 2 T d phi.
    """
    N = 0.0
    if P[KEYS.YAW_LIN] != 0.0:
        N -= P[KEYS.YAW_LIN] * om / (1.0 + (abs(om) if P[KEYS.YAW_FORM] == 2.0 else 0.0))
    if P[KEYS.TRIM] != 0.0:
        form = P[KEYS.TRIM_FORM]
        N += P[KEYS.TRIM] * (1.0 if form == 1.0 else ((V / 0.3) ** 2 if form == 2.0 else T / 0.2))
    if P[KEYS.LINE] != 0.0:
        N += T * P[KEYS.LINE] * (math.sin(phi) if P[KEYS.LINE_FORM] == 1.0 else phi)
    return N


@njit(cache=True)
def derivative(z, w, th, om, x1, x2, t, phi, freq, extra, P, W):
    """Rates of the state at time t (s); `extra` is the wake's velocity (m/s, complex)."""
    e = cmath.exp(1j * th)
    c = cmath.exp(1j * (th + phi))
    v = w - water_velocity(z, t, P, W) - extra
    V = abs(v) + 1e-12
    T = thrust(V, freq, P)
    F, N, r1, r2 = head_plate(v, e, om, x1, x2, P)
    # centre of mass forward (form 1) or to port (form 2) of core_center by COM_SHIFT
    ahead = P[KEYS.COM_SHIFT] if P[KEYS.COM_FORM] == 1.0 else 0.0
    port = P[KEYS.COM_SHIFT] if P[KEYS.COM_FORM] == 2.0 else 0.0
    arm = P[KEYS.ARM] * e - (ahead + 1j * port) * c
    N += (arm.conjugate() * F).imag + T * port
    N += further_yaw_moments(V, om, phi, T, P)
    Fs, Ns = section_forces(v, c, om, P)
    F += T * c + Fs - resistance(V, P) * v / V
    N += Ns
    if P[KEYS.WALL] != 0.0:
        F += wall_force(z, v, P)
    if P[KEYS.U_FORM] != 0.0:
        Fu, Nu = unlisted_force(z, v, e, t, P)
        F, N = F + Fu, N + Nu
    a, om_dot = accelerations(F, N, v, c, om, P)
    return w, a, om, om_dot, r1, r2


@njit(cache=True)
def rk4_step(y, j, dt, phi, freq, extra, P, W):
    """Advance the state `y` by step number `j`; series hold two samples a step."""
    z0, w0, th0, om0, a0, b0 = complex(y[0], y[1]), complex(y[2], y[3]), y[4], y[5], y[6], y[7]
    z, w, th, om, a, b = z0, w0, th0, om0, a0, b0
    dz, dw, dth, dom, da, db = 0j, 0j, 0.0, 0.0, 0.0, 0.0
    for stage in range(4):
        k = 2 * j + (0 if stage == 0 else (1 if stage < 3 else 2))
        t = 0.5 * k * dt
        g = derivative(z, w, th, om, a, b, t, phi[k], freq[k], extra[k], P, W)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        dz, dw, dth = dz + weight * g[0], dw + weight * g[1], dth + weight * g[2]
        dom, da, db = dom + weight * g[3], da + weight * g[4], db + weight * g[5]
        h = 0.5 * dt if stage < 2 else dt
        z, w, th = z0 + h * g[0], w0 + h * g[1], th0 + h * g[2]
        om, a, b = om0 + h * g[3], a0 + h * g[4], b0 + h * g[5]
    z, w = z0 + dt * dz, w0 + dt * dw
    out = np.empty(8)
    out[0], out[1], out[2], out[3] = z.real, z.imag, w.real, w.imag
    out[4], out[5] = th0 + dt * dth, om0 + dt * dom
    out[6], out[7] = a0 + dt * da, b0 + dt * db
    return out


@njit(cache=True)
def simulate(y0, dt, sub, phi, freq, P, W):
    """Integrate from `y0`; return states `(frames, 8)` and the wake's velocity series (complex).

    `phi` and `freq` hold 2 * sub * (frames - 1) + 1 samples; a frame has `sub` steps of `dt` s.
    """
    frames = (len(phi) - 1) // (2 * sub) + 1
    extra = np.zeros(len(phi), np.complex128)
    out = np.zeros((frames, 8))
    path = np.zeros(frames, np.complex128)
    out[0] = y0
    for n in range(frames):
        path[n] = complex(out[n, 0], out[n, 1])
        if n == frames - 1:
            break
        if P[KEYS.WAKE] != 0.0:
            extra[2 * n * sub : 2 * (n + 1) * sub + 1] = wake_velocity(path, n, dt * sub, P)
        y = out[n].copy()
        for j in range(n * sub, (n + 1) * sub):
            y = rk4_step(y, j, dt, phi, freq, extra, P, W)
        out[n + 1] = y
    return out, extra


@njit(cache=True)
def block_ends(Y, stride, dt, sub, phi, freq, extra, P, W):
    """End state of every block of `stride` frames, each restarted from a row of Y (blocks, 8)."""
    out = np.empty_like(Y)
    steps = stride * sub
    for k in range(len(Y)):
        y = Y[k].copy()
        for j in range(k * steps, (k + 1) * steps):
            y = rk4_step(y, j, dt, phi, freq, extra, P, W)
        out[k] = y
    return out
