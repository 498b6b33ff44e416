# ruff: noqa: PLR0911, PLR0917, ARG001
# Compiled laws take no keywords, branch on the form and share their leading arguments.
"""Loads on the robot, one compiled pure function each.

Loads are a complex force in core axes (real part surge, imaginary part sway to port) and a yaw
moment about the centre of mass. ``p`` is one row of the strength table: ``p[0]`` is the strength,
``p[1:]`` are the shape parameters in the order of the registry (effects.py). ``k`` selects the
form; 0 is no effect. Arguments are SI throughout: ``u``, ``s`` surge and sway relative to the water
(m/s), ``r`` yaw rate (rad/s), ``f`` flapping frequency (Hz), ``phi`` head angle (rad).
"""

import math

import numpy as np
from numba import njit

jit = njit(cache=True, fastmath=False)
RHO = 1000.0
KINEMATIC_VISCOSITY = 1.0e-6
G = 9.81


@jit
def fin_force(k, p, u, s, r):
    """Lift of core and tail: 1 Polhamus (NASA TN D-3767), 2 Jones (NACA 835), 3 Helmbold
    (1942), 4 ITTC.
    """
    area, arm, aspect = p[0], p[1], p[2]
    vf = s - r * arm
    V = math.hypot(u, vf)
    if V < 1e-9:
        return 0j, 0.0
    q = 0.5 * RHO * area
    sin_a, cos_a = vf / V, abs(u) / V
    side, drag = 0.0, 0.0
    if k == 1:
        side = q * V * V * (1.6 * aspect * sin_a * cos_a**2 + math.pi * abs(sin_a) * sin_a * cos_a)
    elif k == 2:
        side = q * 0.5 * math.pi * aspect * abs(u) * vf
    elif k == 3:
        slope = 2 * math.pi * aspect / (2 + math.sqrt(aspect**2 + 4))
        CL = slope * sin_a * cos_a
        side = q * V * V * (CL * cos_a)
        drag = q * V * V * CL * CL / (math.pi * 0.8 * aspect)
    else:
        side = q * V * V * sin_a / (0.222 + 0.283 * abs(sin_a)) * aspect / (aspect + 2.25) * 2
        side *= cos_a
    sign = 1.0 if u >= 0 else -1.0
    return complex(-drag * sign, -side), arm * side


@jit
def surge_drag(k, p, u, s):
    """Viscous drag: 1 linear (Stokes), 2 Blasius U^1.5, 3 ITTC 1957 line, 4 Prandtl 1/5 power
    U^1.8.
    """
    U = math.hypot(u, s)
    if U < 1e-6:
        return 0j
    if k == 1:
        D = p[0] * U
    elif k == 2:
        D = p[0] * U**1.5
    elif k == 3:
        Re = max(U * 0.33 / KINEMATIC_VISCOSITY, 300.0)
        D = 0.5 * RHO * p[0] * U * U * 0.075 / (math.log10(Re) - 2) ** 2
    else:
        D = p[0] * U**1.8
    return -D * complex(u, s) / U


@jit
def yaw_damping(k, p, r):
    """Linear yaw damping: 1 N = -N_r r, 2 saturating as r / sqrt(1 + (r/r0)^2) (Fossen 2011,
    6.4).
    """
    return -p[0] * r if k == 1 else -p[0] * r / math.sqrt(1 + (r / p[1]) ** 2)


@jit
def thrust_loss(k, p, u, f):
    """Fraction of thrust lost at advance ratio J = u/(f 0.1 m): 1 linear (Carlton 2018, 6.1),
    2 quadratic (Wageningen B, Oosterveld 1975), 3 hyperbolic slip, 4 speed squared ram drag.
    """
    J = max(u, 0.0) / (max(f, 0.2) * 0.1)
    if k == 1:
        loss = p[0] * J
    elif k == 2:
        loss = p[0] * J * J + 0.3 * p[0] * J
    elif k == 3:
        loss = p[0] * J / (1 + p[0] * J)
    else:
        loss = p[0] * (u / 0.5) ** 2
    return min(loss, 0.9)


@jit
def current_velocity(k, p, t):
    """Uniform current: 1 steady, 2 pulsating (pump, +-30 %), both along ``p[1]`` (rad)."""
    gain = 1.0 if k == 1 else 1 + 0.3 * math.sin(2 * math.pi * t / p[2])
    return p[0] * gain * complex(math.cos(p[1]), math.sin(p[1]))


@jit
def gyre_velocity(k, p, z):
    """Vortex: 1 Lamb-Oseen (Gaussian), 2 Scully (1975), 3 Rankine, 4 Taylor-Green cell of the
    pool.
    """
    if k == 4:
        a, b = math.pi * z.real / 2.6, math.pi * z.imag / 1.6
        vx = p[0] * math.sin(a) * math.cos(b)
        return complex(vx, -p[0] * (1.6 / 2.6) * math.cos(a) * math.sin(b))
    d = z - complex(p[1], p[2])
    R, core = max(abs(d), 1e-6), p[3]
    if k == 1:
        v = 1.567 * (core / R) * (1 - math.exp(-1.2564 * (R / core) ** 2)) / 1.118
    elif k == 2:
        v = 2 * R * core / (R * R + core * core)
    else:
        v = R / core if core > R else core / R
    return p[0] * v * 1j * d / R


@jit
def wall_force(k, p, z, U, L, W):
    """World force by the four walls: 1 exponential cushion, 2 image suction (Newman 1977, 4.19),
    3 constant exponential repulsion of a bow wave.
    """
    out = 0j
    dist = (z.real, L - z.real, z.imag, W - z.imag)
    normal = (1 + 0j, -1 + 0j, 1j, -1j)
    for i in range(4):
        d = max(dist[i], 0.03)
        if k == 1:
            out += p[0] * U * U * math.exp(-d / p[1]) * normal[i]
        elif k == 2:
            out -= p[0] * U * U * p[1] ** 2 / (d * d + 0.3 * p[1] ** 2) * normal[i]
        else:
            out += p[0] * 0.1 * math.exp(-d / p[1]) * normal[i]
    return out


@jit
def stall_lift_share(k, p, alpha):
    """Remaining fraction of lift: 1 Kirchhoff (Leishman & Beddoes 1989), 2 Viterna (1982) blend,
    3 logistic, 4 linear fall-off beyond the stall angle ``p[1]``.
    """
    a = abs(alpha)
    a = min(a, math.pi - a)
    x = (a - p[1]) / p[2]
    if k == 1:
        sep = 1 - 0.4 * math.exp(-abs(x)) if x < 0 else 0.02 + 0.58 * math.exp(-x)
        if x < 0:
            sep = 1 - 0.4 * math.exp(x)
        keep = 0.25 * (1 + math.sqrt(sep)) ** 2
    elif k == 2:
        keep = 1.0 if x < 0 else 0.45 + 0.55 * math.exp(-x)
    elif k == 3:
        keep = 0.3 + 0.7 / (1 + math.exp(min(2 * x, 50.0)))
    else:
        keep = min(1.0, max(0.2, 1 - 0.5 * x))
    return 1 - p[0] * (1 - keep)


@jit
def trim_moment(k, p, u, f):
    """Moment on a straight robot: 1 thrust offset (f^2), 2 bent plate (u |u|), 3 constant
    (tether).
    """
    if k == 1:
        return p[0] * (f / 5.0) ** 2
    return p[0] * u * abs(u) / 0.09 if k == 2 else p[0]


@jit
def crossflow_drag(k, p, s, r, arms):
    """Sideways drag of core and tail (Hoerner 1965, III): 1 uniform strips, 2 tapered strips,
    3 one plate at its centroid, 4 strips with a Reynolds-dependent coefficient.
    """
    front, back = arms
    if k == 3:
        x = 0.5 * (front + back)
        v = s + r * x
        Y = -0.5 * RHO * p[0] * p[1] * (front - back) * v * abs(v)
        return complex(0.0, Y), x * Y
    Y, N = 0.0, 0.0
    dx = (front - back) / 8
    for i in range(8):
        x = front - (i + 0.5) * dx
        v = s + r * x
        depth = p[1] * (1.0 if k != 2 else 1 - 0.08 * i)
        cd = p[0] if k != 4 else p[0] * (0.7 + 0.6 / (1 + abs(v) / 0.05))
        y = -0.5 * RHO * cd * depth * dx * v * abs(v)
        Y += y
        N += x * y
    return complex(0.0, Y), N


@jit
def thrust_moment(k, p, T, phi):
    """Thrust line missing the centre of mass: 1 e sin(phi), 2 e tanh(phi/0.4), 3 e sin(2 phi)."""
    if k == 1:
        return p[0] * T * math.sin(phi)
    return p[0] * T * (math.tanh(phi / 0.4) if k == 2 else math.sin(2 * phi))


@jit
def wave_drag(k, p, u, s):
    """Wave drag: 1 fourth power, 2 Havelock exp(-1/Fr^2) (1909), 3 logistic hump at ``p[1]``
    (m/s).
    """
    U = math.hypot(u, s)
    if U < 1e-3:
        return 0j
    if k == 1:
        D = p[0] * U**4
    elif k == 2:
        D = p[0] * U * U * math.exp(-G * 0.15 / (U * U) * 0.35)
    else:
        D = p[0] * U * U / (1 + math.exp(-(U - p[1]) / 0.04))
    return -D * complex(u, s) / U


@jit
def coulomb_friction(k, p, u, s):
    """Dry friction of the cable: 1 Coulomb, 2 Stribeck (Armstrong 1994), smoothed below 5 mm/s."""
    U = math.hypot(u, s)
    level = p[0] if k == 1 else p[0] * (1 + p[1] * math.exp(-((U / p[2]) ** 2)))
    return -level * math.tanh(U / 0.005) * complex(u, s) / max(U, 1e-9)


@jit
def wake_velocity(k, p, z, t, hist, n_hist):
    """Water velocity in the robot's own wake: 1 Gaussian, exponential decay, 2 Gaussian
    momentumless
    t^-2/3 (Tennekes & Lumley 1972, 4), 3 top hat, 4 spreading Gaussian jet; along the old path.
    """
    out, best = 0j, 1e9
    age_at, dir_at = 0.0, 0j
    for i in range(1, n_hist):
        age = t - hist[i, 3]
        if age < 1.5:
            break
        d = abs(z - complex(hist[i, 0], hist[i, 1]))
        if d < best:
            best, age_at = d, age
            dir_at = complex(hist[i, 0] - hist[i - 1, 0], hist[i, 1] - hist[i - 1, 1]) / 0.02
    width = p[1]
    if best > 4 * width:
        return out
    if k == 1:
        gain = math.exp(-0.5 * (best / width) ** 2 - age_at / p[2])
    elif k == 2:
        gain = math.exp(-0.5 * (best / width) ** 2) * (1 + age_at / p[2]) ** (-2 / 3)
    elif k == 3:
        gain = math.exp(-age_at / p[2]) / (1 + math.exp((best - width) / (0.15 * width)))
    else:
        b = width * math.sqrt(1 + age_at / p[2])
        gain = math.exp(-0.5 * (best / b) ** 2) * width / b
    return -p[0] * gain * dir_at


@jit
def unlisted_load(k, p, z, t, theta, u, s, r):
    """Load of no named cause, world-axes force, core-axes force, moment: 1 magnet, 2 three-fold
    heading
    moment, 3 spring to a point, 4 saddle, 5 periodic side force, 6 drag bump in speed, 7 side force
    with heading, 8 moment pulses in time, 9 moment with position.
    """
    U = math.hypot(u, s)
    if k == 1:
        return 0j, 0j, -p[0] * math.sin(theta - p[1])
    if k == 2:
        return 0j, 0j, p[0] * math.sin(3 * theta + p[1])
    if k == 3:
        return -p[0] * (z - complex(p[1], p[2])), 0j, 0.0
    if k == 4:
        d = z - complex(1.3, 0.8)
        return p[0] * complex(d.real, -d.imag), 0j, 0.0
    if k == 5:
        return 0j, complex(0.0, p[0] * math.sin(2 * math.pi * t / p[1])), 0.0
    if k == 6:
        bump = p[0] * math.exp(-0.5 * ((U - p[1]) / p[2]) ** 2)
        return 0j, -bump * complex(u, s) / max(U, 1e-3), 0.0
    if k == 7:
        return 0j, complex(0.0, p[0] * math.cos(2 * theta + p[1])), 0.0
    if k == 8:
        return 0j, 0j, p[0] * math.exp(-0.5 * (((t % p[1]) - 0.5 * p[1]) / p[2]) ** 2)
    return (
        0j,
        0j,
        p[0] * math.cos(2 * math.pi * z.real / p[1]) * math.cos(2 * math.pi * z.imag / p[1]),
    )


EMPTY_HISTORY = np.zeros((1, 4))
