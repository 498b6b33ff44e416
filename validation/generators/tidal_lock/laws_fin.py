"""Side force on core and tail: the tail as a fin, and cross-flow drag.

Laws of stage `force`: force in core axes, X + iY, and moment. Sources: Polhamus (1966),
Lighthill (1971), Hoerner (1965).
"""

import numpy as np

from .form import family
from .robot import WATER_DENSITY


def _fin(s, p, side, lever=1.0, axial=0.0):
    """Side force -amp q side at `lever` times the caudal base's distance behind the centre."""
    Y = -0.5 * WATER_DENSITY * p.amp * s.b.area * side
    X = 0.5 * WATER_DENSITY * p.amp * s.b.area * axial
    return X + 1j * Y, -lever * s.b.aft * Y


def _sideways(s, lever=1.0):
    return s.v - s.r * lever * s.b.aft


def _stalled(s, p):
    w = _sideways(s)
    return _fin(s, p, np.abs(s.u) * w / (1 + (w / (p.stall_slope * s.V + 1e-9)) ** 2))


def _distributed(s, p):
    parts = [_fin(s, p, np.abs(s.u) * _sideways(s, e) / 4, e) for e in (0.4, 0.65, 0.9, 1.15)]
    return sum(part[0] for part in parts), sum(part[1] for part in parts)


def _polhamus(s, p):
    w = _sideways(s)
    return _fin(s, p, np.abs(s.u) * w + p.vortex_ratio * np.abs(w) * w)


def _lighthill(s, p):
    e = 1 + s.b.tail / s.b.aft
    w = _sideways(s, e)
    return _fin(s, p, s.u * w, e, -0.5 * w**2 * np.sign(s.u))


def _induced(s, p):
    w = _sideways(s)
    return _fin(s, p, np.abs(s.u) * w, 1.0, -p.induced * w**2 * np.sign(s.u))


_FIN = {
    "abs_u_w": lambda s, p: _fin(s, p, np.abs(s.u) * _sideways(s)),
    "speed_w": lambda s, p: _fin(s, p, s.V * _sideways(s)),
    "polhamus": (_polhamus, {"vortex_ratio": (0.5, 1.4, "1")}),
    "lighthill_trailing_edge": _lighthill,
    "stalling": (_stalled, {"stall_slope": (0.45, 0.9, "1")}),
    "distributed": _distributed,
    "induced_drag": (_induced, {"induced": (0.2, 0.5, "1")}),
}
FIN = family("tail_fin_lift", "force", ("S_k", "head areas", lambda _b: 8.0), _FIN)


def _strips(s, p, pressure, taper=0.0):
    """Cross-flow drag -1/2 rho C sum(span pressure(w)) over six stations behind the centre."""
    stations = (np.arange(6) + 0.5) / 6
    Y, N = 0.0, 0.0
    for e in stations:
        w = s.v - s.r * e * s.b.aft
        step = s.b.span * (1 - taper * e) * s.b.aft / 6
        part = -0.5 * WATER_DENSITY * p.amp * step * pressure(w)
        Y, N = Y + part, N - e * s.b.aft * part
    return 1j * Y, N


def _reynolds_pressure(s, w):
    reynolds = np.abs(w) * s.b.span / 1e-6
    return np.abs(w) * w * (0.6 + 9.0 / np.sqrt(reynolds + 50.0))


_CROSSFLOW = {
    "quadratic": lambda s, p: _strips(s, p, lambda w: np.abs(w) * w),
    "power": (
        lambda s, p: _strips(
            s,
            p,
            lambda w: (
                w
                * (np.abs(w) + 1e-9) ** (p.exponent - 1)
                * (0.3 * s.b.speed_ref) ** (2 - p.exponent)
            ),
        ),
        {"exponent": (1.5, 1.9, "1")},
    ),
    "tapered": (
        lambda s, p: _strips(s, p, lambda w: np.abs(w) * w, p.taper),
        {"taper": (0.5, 0.95, "1")},
    ),
    "reynolds": lambda s, p: _strips(s, p, lambda w: _reynolds_pressure(s, w)),
}
CROSSFLOW = family("crossflow_drag", "force", ("C_dc", "1", lambda _b: 3.0), _CROSSFLOW)
