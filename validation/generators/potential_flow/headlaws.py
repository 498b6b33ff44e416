"""Laws of the head plate: they return lift term, drag coefficient and moment term.

The published plate has sin 2 alpha in lift and moment, and C_D; `s.lift`, `s.drag`, `s.turning`
hold them before the law.
"""

from __future__ import annotations

import numpy as np


def _logistic(x):
    return 0.5 * (1 + np.tanh(x / 2))


def _attached_share(s, p):
    """1 where the flow is attached, 0 beyond the onset of separation."""
    return _logistic((p["onset"] - np.abs(s.alpha)) / p["width"])


def stall_step(s, k, p):
    """Lift falls by the share k beyond the onset, smoothly."""
    return s.lift * (1 - k * (1 - _attached_share(s, p))), s.drag, s.turning


def stall_kirchhoff(s, k, p):
    """Lift times ((1 + sqrt f)/2)^2, f = 1 - k (1 - attached): Kirchhoff's separated plate."""
    f = np.maximum(1 - k * (1 - _attached_share(s, p)), 0)
    factor = ((1 + np.sqrt(f)) / 2) ** 2
    return s.lift * factor, s.drag, s.turning * factor


def stall_goman_khrabrov(s, k, _):
    """Kirchhoff with a separation point that lags: tau dX/dt = X_0(alpha) - X (1994)."""
    X = np.maximum(1 - k * s.memory[0], 0)
    return s.lift * ((1 + np.sqrt(X)) / 2) ** 2, s.drag, s.turning


def separation_rate(s, p):
    """Rate of the separated share; time constant of `lag` head lengths of travel."""
    return ((1 - _attached_share(s, p) - s.memory[0]) * (s.V + 0.02) / (p["lag"] * s.head))[None]


def stall_both(s, k, p):
    """Lift and moment fall by the share k, drag rises by k/2 of itself."""
    lost = k * (1 - _attached_share(s, p))
    return s.lift * (1 - lost), s.drag * (1 + lost / 2), s.turning * (1 - lost)


def lag_coefficient(s, k, _):
    """The share k of the lift coefficient comes late (first order)."""
    return s.lift + k * (s.memory[0] - s.lift), s.drag, s.turning


def lag_coefficient_state(s, p):
    """Rate of the late lift coefficient: `chords` head lengths of travel."""
    return ((-2 * s.u * s.w / (s.V**2 + 1e-12) - s.memory[0]) * (s.V + 0.01)
            / (p["chords"] * s.head))[None]  # fmt: skip


def lag_circulation(s, k, _):
    """The share k of the circulation V sin 2 alpha comes late; lift is V times circulation."""
    return s.lift + k * (s.memory[0] / (s.V + 0.01) - s.lift), s.drag, s.turning


def lag_circulation_state(s, p):
    """Rate of the late circulation, per chord."""
    gamma = -2 * s.u * s.w / (s.V + 1e-6)
    return ((gamma - s.memory[0]) * (s.V + 0.01) / (p["chords"] * s.head))[None]


def lag_wagner(s, k, _):
    """Twice k of Wagner's deficit 0.165 and 0.335 (R. T. Jones 1940), of the coefficient."""
    late = 0.33 * (s.memory[0] - s.lift) + 0.67 * (s.memory[1] - s.lift)
    return s.lift + k * late, s.drag, s.turning


def lag_wagner_state(s, p):
    """Rates 0.0455 and 0.3 per half chord of travel (R. T. Jones 1940)."""
    half = p["stretch"] * s.head / 2
    lift = -2 * s.u * s.w / (s.V**2 + 1e-12)
    rate = (s.V + 0.01) / half
    return np.array([0.0455 * rate * (lift - s.memory[0]), 0.3 * rate * (lift - s.memory[1])])


def asymmetry_step(s, k, _):
    """Lift and moment (1 + k) times on one side, (1 - k) times on the other."""
    factor = 1 + k * np.tanh(s.alpha / 0.02)
    return s.lift * factor, s.drag, s.turning * factor


def asymmetry_tanh(s, k, p):
    """The same, growing with the angle of attack over `width`."""
    factor = 1 + k * np.tanh(s.alpha / p["width"])
    return s.lift * factor, s.drag, s.turning * factor


def asymmetry_beyond_onset(s, k, p):
    """Only beyond `onset` of angle of attack."""
    factor = 1 + k * np.sign(s.alpha) * _logistic((np.abs(s.alpha) - p["onset"]) / 0.03)
    return s.lift * factor, s.drag, s.turning * factor


def asymmetry_with_drag(s, k, _):
    """Lift, moment and drag."""
    factor = 1 + k * np.tanh(s.alpha / 0.03)
    return s.lift * factor, s.drag * factor, s.turning * factor
