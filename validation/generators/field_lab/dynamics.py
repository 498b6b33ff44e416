# ruff: noqa: PLR0917
# Compiled laws take no keywords, branch on the form and share their leading arguments.
"""Planar motion of the robot: variational midpoint rule with forcing (Marsden & West 2001, 3.2.5).

The discrete Lagrangian evaluated at midpoints, with the discrete Lagrange-d'Alembert principle,
gives

    q' = q + h v_m,   M(q') v' = M(q) v + h F(q + h v_m / 2, v_m),   v_m = (v + v') / 2,

solved by two fixed-point passes. M is mass plus added mass (heading dependent), F the loads.
State row: x, y, theta, x_dot, y_dot, theta_dot, z1, z2 (two lag states of the lift coefficient).
"""

import cmath
import math
from typing import NamedTuple

import numpy as np

from . import forces as fo
from .forces import RHO, jit

STEP_S = 1e-3
EFFECT_ORDER = [
    "tail_fin_lift",
    "added_mass",
    "viscous_drag",
    "linear_yaw_damping",
    "thrust_loss_with_speed",
    "uniform_current",
    "pool_gyre",
    "wall_effect",
    "stall",
    "trim_moment",
    "crossflow_drag",
    "thrust_line_offset",
    "thrust_area",
    "lift_lag",
    "wave_drag",
    "coulomb_friction",
    "wake_reentry",
    "centre_of_mass_shift",
    "port_starboard_asymmetry",
    "unlisted",
]
EFFECT_ROW = {name: i for i, name in enumerate(EFFECT_ORDER)}
(FIN, ADDED, VISC, YAWD, TLOSS, CURR, GYRE, WALL, STALL, TRIM) = range(10)
(CROSS, TLINE, TAREA, LLAG, WAVE, COUL, WAKE, COMS, ASYM, UNLI) = range(10, 20)


class BodyParameters(NamedTuple):
    """Mass (kg), yaw inertia (kg m^2), lengths (m) and the pool (m) of one trial."""

    m: float
    I: float  # noqa: E741 - the paper's symbol
    head: float
    span: float
    l: float  # noqa: E741 - the paper's symbol
    hinge_to_com: float
    core: float
    tail: float
    head_1x: float
    L: float
    W: float


class Coefficients(NamedTuple):
    """The paper's six: C_T (m^2), C_D0, C_Da, C_La (1), C_Ma (m), C_Md (kg m^2)."""

    C_T: float
    C_D0: float
    C_Da: float
    C_La: float
    C_Ma: float
    C_Md: float


@jit
def thrust(b, c, f, k, p, u, phi):
    """Thrust (N), equation (1) times the losses in ``p``."""
    A = b.head * b.span
    T = c.C_T * 0.5 * RHO * A * f * f
    if k[TLOSS]:
        T *= 1 - fo.thrust_loss(k[TLOSS], p[TLOSS], u, f)
    if k[TAREA] == 1:
        T *= (b.head / b.head_1x) ** (-p[TAREA, 0])
    elif k[TAREA] == 2:
        T *= 1 - p[TAREA, 0] + p[TAREA, 0] * b.head_1x / b.head
    if k[ASYM] == 2:
        T *= 1 + p[ASYM, 0] * math.tanh(phi / 0.1)
    return T


@jit
def head_plate(b, c, v, theta, r, k, p, z):
    """World force (N), moment (N m) and instantaneous C_L of the head plate, equations (2) to
    (8).
    """
    U = abs(v)
    q = 0.5 * RHO * b.head * b.span * U * U
    damping = c.C_Md
    if U < 1e-9:
        return 0j, -damping * r * abs(r), 0.0
    alpha = cmath.phase(cmath.exp(1j * theta) * v.conjugate())
    C_L = c.C_La * math.sin(2 * alpha)
    C_D = c.C_D0 + c.C_Da * (1 - math.cos(2 * alpha))
    C_use = C_L
    if k[STALL]:
        C_use *= fo.stall_lift_share(k[STALL], p[STALL], alpha)
    if k[LLAG]:
        A1, A2 = p[LLAG, 0], p[LLAG, 0] * p[LLAG, 1]
        C_use += A1 * (z[0] - C_L) + A2 * (z[1] - C_L)
    if k[ASYM] == 1:
        C_use *= 1 + p[ASYM, 0] * math.tanh(alpha / 0.03)
    elif k[ASYM] == 3:
        damping *= 1 + p[ASYM, 0] * math.tanh(r / 0.05)
    F = q * v / U * (C_use * 1j - C_D)
    shift = p[COMS, 0] if k[COMS] == 1 else 0.0
    N_l = (F * (1j * cmath.exp(1j * theta)).conjugate()).real * (b.l + shift)
    return F, q * c.C_Ma * math.sin(2 * alpha) - damping * r * abs(r) + N_l, C_L


@jit
def core_loads(b, T, u, s, r, f, phi, k, p):
    """Force in core axes (N) and moment (N m) of the thrust and of the effects on core and tail."""
    F, N = complex(T, 0.0), 0.0
    arms = (b.hinge_to_com, b.hinge_to_com - b.core - b.tail)
    if k[FIN]:
        dF, dN = fo.fin_force(k[FIN], p[FIN], u, s, r)
        F, N = F + dF, N + dN
    if k[VISC]:
        F += fo.surge_drag(k[VISC], p[VISC], u, s)
    if k[YAWD]:
        N += fo.yaw_damping(k[YAWD], p[YAWD], r)
    if k[TRIM]:
        N += fo.trim_moment(k[TRIM], p[TRIM], u, f)
    if k[CROSS]:
        dF, dN = fo.crossflow_drag(k[CROSS], p[CROSS], s, r, arms)
        F, N = F + dF, N + dN
    if k[TLINE]:
        N += fo.thrust_moment(k[TLINE], p[TLINE], T, phi)
    if k[COMS] == 2:
        N += T * p[COMS, 0]
    if k[WAVE]:
        F += fo.wave_drag(k[WAVE], p[WAVE], u, s)
    if k[COUL]:
        F += fo.coulomb_friction(k[COUL], p[COUL], u, s)
    return F, N


@jit
def water_velocity(z, t, w, swirl, k, p, hist, n_hist):
    """Water velocity (m/s, complex): random part, swirl of the last trial, current, gyre, wake."""
    v = w + swirl * math.exp(-t / 20.0) * 1j * (z - complex(1.3, 0.8))
    if k[CURR]:
        v += fo.current_velocity(k[CURR], p[CURR], t)
    if k[GYRE]:
        v += fo.gyre_velocity(k[GYRE], p[GYRE], z)
    if k[WAKE]:
        v += fo.wake_velocity(k[WAKE], p[WAKE], z, t, hist, n_hist)
    return v


@jit
def total_loads(b, c, q, v, r, t, f, phi, w, k, p, z_lag):
    """World force (N), moment (N m) and C_L at pose ``q`` = (position, heading) in water ``w``."""
    z, theta = q
    rel = v - w
    axis = cmath.exp(1j * (theta + phi))
    rel_core = rel * axis.conjugate()
    u, s = rel_core.real, rel_core.imag
    F, N, C_L = head_plate(b, c, rel, theta, r, k, p, z_lag)
    T = thrust(b, c, f, k, p, u, phi)
    dF, dN = core_loads(b, T, u, s, r, f, phi, k, p)
    F, N = F + dF * axis, N + dN
    if k[WALL]:
        F += fo.wall_force(k[WALL], p[WALL], z, abs(v), b.L, b.W)
    if k[UNLI]:
        dW, dC, dN = fo.unlisted_load(k[UNLI], p[UNLI], z, t, theta, u, s, r)
        F, N = F + dW + dC * axis, N + dN
    return F, N, C_L


@jit
def added_mass(k, p, theta, phi):
    """Added masses (surge, sway in kg, yaw in kg m^2) and their axis: 1 Lamb ellipsoid, 2 Lighthill
    elongated body, both in core axes, 3 plate in head axes (Newman 1977, 4.13).
    """
    if k[ADDED] == 0:
        return 0.0, 0.0, 0.0, 1 + 0j
    m = p[ADDED, 0]
    if k[ADDED] == 1:
        return 0.12 * m, m, 0.006 * m, cmath.exp(1j * (theta + phi))
    if k[ADDED] == 2:
        return 0.0, m, 0.008 * m, cmath.exp(1j * (theta + phi))
    return 0.0, m, 0.003 * m, cmath.exp(1j * theta)


@jit
def added_momentum(a, v):
    """Momentum (N s) of the added mass ``a`` at relative velocity ``v``."""
    local = v * a[3].conjugate()
    return complex(a[0] * local.real, a[1] * local.imag) * a[3]


@jit
def velocity_from_momentum(a, m, P):
    """Velocity (m/s) at total momentum ``P``: (m + M_a) v = P."""
    local = P * a[3].conjugate()
    return complex(local.real / (m + a[0]), local.imag / (m + a[1])) * a[3]


@jit
def step(b, c, state, t, h, inp, swirl, k, p, hist, n_hist):
    """Advance ``state`` (8) in place by ``h`` (s); ``inp`` = (f, phi now, phi next, water)."""
    f, phi0, phi1, w0 = inp
    z, v = complex(state[0], state[1]), complex(state[3], state[4])
    theta, r = state[2], state[5]
    w = water_velocity(z, t, w0, swirl, k, p, hist, n_hist)
    a0 = added_mass(k, p, theta, phi0)
    P0 = b.m * v + added_momentum(a0, v - w)
    v1, r1, C_L = v, r, 0.0
    for _ in range(2):
        vm, rm = 0.5 * (v + v1), 0.5 * (r + r1)
        q = (z + 0.5 * h * vm, theta + 0.5 * h * rm)
        F, N, C_L = total_loads(
            b, c, q, vm, rm, t + 0.5 * h, f, 0.5 * (phi0 + phi1), w, k, p, state[6:8]
        )
        a1 = added_mass(k, p, theta + h * rm, phi1)
        v1 = velocity_from_momentum(a1, b.m, P0 + h * F + added_momentum(a1, w))
        Pa = added_momentum(added_mass(k, p, q[1], phi1), vm - w)
        munk = (vm - w).real * Pa.imag - (vm - w).imag * Pa.real
        r1 = r + h * (N - munk) / (b.I + a0[2])
    state[0] += h * 0.5 * (v + v1).real
    state[1] += h * 0.5 * (v + v1).imag
    state[2] += h * 0.5 * (r + r1)
    state[3], state[4], state[5] = v1.real, v1.imag, r1
    relax_lag_states(k, p, state, C_L, abs(v1 - w), b.head, h)


@jit
def relax_lag_states(k, p, state, C_L, U, chord, h):
    """Relax the lag states to C_L: rates U/(tau chord/2) (forms 1, 2) or 1/tau (forms 3, 4)."""
    if k[LLAG]:
        scale = U / (0.5 * chord) if k[LLAG] <= 2 else 1.0
        state[6] += (C_L - state[6]) * (1 - math.exp(-h * scale * p[LLAG, 2]))
        state[7] += (C_L - state[7]) * (1 - math.exp(-h * scale * p[LLAG, 3]))


@jit
def simulate(b, c, start, f, phi, w, swirl, k, p):
    """States (steps + 1, 8) from ``start`` under inputs per millisecond ``f``, ``phi``, ``w``."""
    n = len(f) - 1
    out = np.zeros((n + 1, 8))
    out[0] = start
    hist = np.zeros((n // 20 + 2, 4))
    state = start.copy()
    for i in range(n):
        if i % 20 == 0:
            j = i // 20
            hist[j, 0], hist[j, 1], hist[j, 3] = state[0], state[1], i * STEP_S
        step(
            b,
            c,
            state,
            i * STEP_S,
            STEP_S,
            (f[i], phi[i], phi[i + 1], w[i]),
            swirl,
            k,
            p,
            hist,
            i // 20,
        )
        out[i + 1] = state
    return out


@jit
def advance_state(b, c, start, i0, n, f, phi, w, swirl, k, p, hist):
    """State after ``n`` milliseconds from ``start`` at step ``i0``; 2 ms steps, known wake
    ``hist``.
    """
    state = start.copy()
    for j in range(0, n, 2):
        i = i0 + j
        step(
            b, c, state, i * STEP_S, 2 * STEP_S, (f[i], phi[i], phi[i + 2], w[i]), swirl, k, p,
            hist, i // 20,
        )  # fmt: skip
    return state


def straight_growth_rate_per_s(
    b: BodyParameters, c: Coefficients, f: float, k: np.ndarray, p: np.ndarray
) -> float:
    """Largest real eigenvalue (1/s) of straight swimming in (sway, yaw rate), body axes."""
    u = f * math.sqrt(c.C_T / c.C_D0)
    for _ in range(60):
        F = total_loads(b, c, (0j, 0.0), complex(u, 0), 0.0, 0.0, f, 0.0, 0j, k, p, np.zeros(2))[0]
        u = max(u + 0.3 * F.real / b.m, 0.01)
    J = np.zeros((2, 2))
    for j, eps in enumerate((1e-4, 1e-3)):
        d = np.zeros(2)
        d[j] = eps
        rest = np.zeros(2)
        F, N, _ = total_loads(b, c, (0j, 0.0), complex(u, d[0]), d[1], 0.0, f, 0.0, 0j, k, p, rest)
        J[0, j], J[1, j] = F.imag / b.m / eps - u * j, N / b.I / eps
    return float(np.linalg.eigvals(J).real.max())
