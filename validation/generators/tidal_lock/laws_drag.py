"""Drag of the whole hull against its speed: viscous, wave and dry friction.

Laws of stage `force`: force in core axes and moment. Sources: ITTC (1957), Havelock (1909),
Armstrong-Helouvry (1994).
"""

import numpy as np

from .form import Form, family
from .robot import GRAVITY


def _drag(s, p, shape):
    """Force against the motion, amp shape, shape = 1 at the reference speed."""
    return -p.amp * shape * s.hat, 0.0


def _ittc(V, b):
    reynolds = np.maximum(V * b.length / 1e-6, 2e3)
    return (V / b.speed_ref) ** 2 / (np.log10(reynolds) - 2) ** 2


def _head_viscous(s, p):
    """Linear drag at the aerodynamic centre, with the local velocity there."""
    local = s.u + 1j * s.v + 1j * s.r * s.arm * np.exp(-1j * s.phi)
    force = -p.amp * local / s.b.speed_ref
    return force, s.arm * (np.conj(np.exp(-1j * s.phi)) * force).imag


_VISCOUS = {
    "linear": lambda s, p: _drag(s, p, s.ratio),
    "power_1.5": lambda s, p: _drag(s, p, s.ratio**1.5),
    "power_1.8": lambda s, p: _drag(s, p, s.ratio**1.8),
    "ittc_1957": lambda s, p: _drag(s, p, _ittc(s.V, s.b) / _ittc(s.b.speed_ref, s.b)),
    "linear_at_head": _head_viscous,
}
VISCOUS = family(
    "viscous_drag",
    "force",
    ("F_ref", "N at the reference speed", lambda b: 0.7 * b.drag_ref),
    _VISCOUS,
)


def _froude(s):
    return s.V / np.sqrt(GRAVITY * s.b.length)


_WAVE = {
    "power_4": lambda s, p: _drag(s, p, s.ratio**4),
    "power_6": lambda s, p: _drag(s, p, s.ratio**6),
    "havelock_hump": (
        lambda s, p: _drag(s, p, s.ratio**2 * np.exp(-(((s.ratio - p.hump) / p.width) ** 2))),
        {"hump": (0.7, 1.0, "V_ref"), "width": (0.12, 0.3, "V_ref")},
    ),
    "onset": (
        lambda s, p: _drag(s, p, (np.maximum(s.ratio - p.onset, 0) / (1 - p.onset)) ** 2),
        {"onset": (0.3, 0.65, "V_ref")},
    ),
    "exponential_froude": lambda s, p: _drag(
        s, p, s.ratio**4 * np.exp(-0.12 / (_froude(s) ** 2 + 1e-3)) * 1.6
    ),
}
WAVE = family(
    "wave_drag", "force", ("F_ref", "N at the reference speed", lambda b: 0.8 * b.drag_ref), _WAVE
)


def _stribeck(s, p):
    peak = 1 + p.excess * np.exp(-((s.ratio / 0.3) ** 2))
    return _drag(s, p, np.tanh(s.ratio / 0.03) * peak)


_KNEE = {"knee": (0.05, 0.22, "V_ref")}
_COULOMB = {
    "sign": lambda s, p: _drag(s, p, np.tanh(s.ratio / 0.01)),
    "tanh": (lambda s, p: _drag(s, p, np.tanh(s.ratio / p.knee)), _KNEE),
    "stribeck": (_stribeck, {"excess": (0.3, 1.2, "1")}),
    "saturating": (lambda s, p: _drag(s, p, s.ratio / (s.ratio + p.knee)), _KNEE),
}
COULOMB = family("coulomb_friction", "force", ("F_c", "N", lambda b: 0.12 * b.drag_ref), _COULOMB)

DRAG_FORMS: list[Form] = [*VISCOUS, *WAVE, *COULOMB]
