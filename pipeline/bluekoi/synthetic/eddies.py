"""Random eddies of the pool water: slow and free of divergence."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Eddy:
    """One term of the stream function: `a sin(kx x + px) sin(ky y + py) cos(w t + pt)` (m^2/s)."""

    amplitude_m2_s: float
    wavenumber: tuple[float, float]
    phase: tuple[float, float, float]
    rate_rad_s: float


def water_velocity(eddies: tuple[Eddy, ...], time_s: float, place: complex) -> complex:
    """Water velocity (m/s) at a place (m): `u = d psi / dy`, `v = -d psi / dx`."""
    u = v = 0.0
    for eddy in eddies:
        (kx, ky), (px, py, pt) = eddy.wavenumber, eddy.phase
        now = eddy.amplitude_m2_s * math.cos(eddy.rate_rad_s * time_s + pt)
        x, y = kx * place.real + px, ky * place.imag + py
        u += now * ky * math.sin(x) * math.cos(y)
        v -= now * kx * math.cos(x) * math.sin(y)
    return complex(u, v)


def random_eddies(rng: np.random.Generator, rms_m_s: float, *, count: int = 6) -> tuple[Eddy, ...]:
    """Random eddies of 1 to 3 m wavelength and 4 to 12 s period with the given rms speed (m/s)."""
    if rms_m_s == 0:
        return ()
    eddies = []
    for _ in range(count):
        kx, ky = 2 * math.pi / rng.uniform(1.0, 3.0, 2)
        share = rms_m_s * math.sqrt(8 / (count * (kx**2 + ky**2)))
        px, py, pt = (float(p) for p in rng.uniform(0, 2 * math.pi, 3))
        rate = 2 * math.pi / rng.uniform(4.0, 12.0)
        eddies.append(Eddy(share, (float(kx), float(ky)), (px, py, pt), float(rate)))
    return tuple(eddies)
