"""Water velocity at a point: sloshing modes, slow eddies, and the listed currents (numba)."""

import cmath
import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from validation.generators.strip_theory.parameters import KEYS

GRAVITY = 9.81
SLOSH, EDDY = 0.0, 1.0


def random_modes(
    rng: np.random.Generator, pool: tuple[float, float, float], rms: float
) -> NDArray[np.float64]:
    """Return modes `(modes, 6)`: kind, kx, ky (rad/m), amplitude (m/s), frequency, phase.

    Standing waves obey omega^2 = g k tanh(k h) (Lamb, Hydrodynamics, art. 257); eddies are
    stream-function modes sin(kx x) sin(ky y) that turn slowly. `rms` (m/s) is the whole motion's.
    """
    length, width, depth = pool
    rows = []
    for m, n in ((1, 0), (0, 1), (1, 1), (2, 0)):
        kx, ky = m * math.pi / length, n * math.pi / width
        k = math.hypot(kx, ky)
        omega = math.sqrt(GRAVITY * k * math.tanh(k * depth)) * rng.uniform(0.98, 1.02)
        rows.append([SLOSH, kx, ky, rng.normal() * rms * 0.7, omega, rng.uniform(0, 2 * math.pi)])
    for m, n in ((1, 1), (2, 1), (3, 1), (3, 2), (4, 2)):
        kx, ky = m * math.pi / length, n * math.pi / width
        period = rng.uniform(8.0, 30.0)
        phase = rng.uniform(0, 2 * math.pi)
        rows.append([EDDY, kx, ky, rng.normal() * rms, 2 * math.pi / period, phase])
    return np.array(rows)


@njit(cache=True)
def mode_velocity(z, t, W):
    """Complex velocity (m/s) of all random modes at z = x + i y (m) and t (s)."""
    u = 0j
    for row in W:
        kx, ky = row[1], row[2]
        k = math.sqrt(kx * kx + ky * ky)
        a = row[3] / k * math.cos(row[4] * t + row[5])
        sx, cx = math.sin(kx * z.real), math.cos(kx * z.real)
        sy, cy = math.sin(ky * z.imag), math.cos(ky * z.imag)
        if row[0] == 0.0:  # grad of cos(kx x) cos(ky y)
            u -= a * complex(kx * sx * cy, ky * cx * sy)
        else:  # (psi_y, -psi_x) of psi = sin(kx x) sin(ky y)
            u += a * complex(ky * sx * cy, -kx * cx * sy)
    return u


@njit(cache=True)
def gyre_velocity(z, P):
    """Complex velocity (m/s) of a gyre whose largest speed is about GYRE.

    Forms: 1 Rankine vortex; 2 basin mode psi = sin sin; 3 Lamb-Oseen vortex (Saffman 1992, 13.1).
    """
    form, speed, radius = P[KEYS.GYRE_FORM], P[KEYS.GYRE], P[KEYS.GYRE_R]
    if form == 2.0:
        kx, ky = math.pi / P[KEYS.POOL_L], math.pi / P[KEYS.POOL_W]
        x, y = kx * z.real, ky * z.imag
        return speed * complex(math.sin(x) * math.cos(y), -kx / ky * math.cos(x) * math.sin(y))
    d = z - complex(P[KEYS.GYRE_X], P[KEYS.GYRE_Y])
    r = abs(d) + 1e-9
    ratio = r / radius
    if form == 1.0:
        swirl = min(ratio, 1.0 / ratio)
    else:
        swirl = 1.398 / ratio * (1.0 - math.exp(-1.2564 * ratio * ratio))
    return 1j * speed * swirl * d / r


@njit(cache=True)
def water_velocity(z, t, P, W):
    """Complex water velocity (m/s) at z without the wake, which `dynamics` adds."""
    u = mode_velocity(z, t, W)
    if P[KEYS.GYRE] != 0.0:
        u += gyre_velocity(z, P)
    if P[KEYS.CUR] != 0.0:
        u += P[KEYS.CUR] * P[KEYS.CUR_NOW] * cmath.exp(1j * P[KEYS.CUR_DIR])
    return u


@njit(cache=True)
def wake_velocity(path, now, dt, P):
    """Complex velocity (m/s) at path[now] of the water left behind along the earlier path.

    Every element of the path leaves motion across which the profile is Gaussian. Forms: 1 jet with
    exponential decay; 2 self-similar spreading jet, width^2 growing as age (Schlichting, ch. XXIV);
    3 far wake of power-law decay age^(-2/3), width as age^(1/3) (Tennekes and Lumley, 4.2),
    following the body; 4 top hat with linear decay. `path` is complex, one point every `dt` s.
    """
    form, u0, w0, tau = P[KEYS.WAKE_FORM], P[KEYS.WAKE], P[KEYS.WAKE_W], P[KEYS.WAKE_TAU]
    u = 0j
    for k in range(1, now - int(1.2 / dt)):
        step = path[k] - path[k - 1]
        age = (now - k) * dt
        distance = abs(path[now] - path[k])
        width, decay = w0, math.exp(-age / tau)
        if form == 2.0:
            width = w0 * math.sqrt(1.0 + age / tau)
            decay = (w0 / width) ** 2
        elif form == 3.0:
            width = w0 * (1.0 + age / tau) ** (1.0 / 3.0)
            decay = -((w0 / width) ** 2)
        elif form == 4.0:
            decay = max(0.0, 1.0 - age / (2.0 * tau))
        if distance < 3.0 * width:
            kernel = math.exp(-0.5 * (distance / width) ** 2) / (2.5066 * width)
            if form == 4.0:
                kernel = 0.5 / width if distance < width else 0.0
            u -= u0 * decay * kernel * step
    return u
