"""Damping, trim, thrust line, walls, wake and sinking.

A law of stage `force` returns the force in core axes, X + iY, and the moment N. `s` is the flow
state of `dynamics.flow_rates`; reference values come from the robot `s.b`.
"""

import numpy as np

from .form import Form, family


def logistic(x: np.ndarray) -> np.ndarray:
    """1 / (1 + exp(-x)) without overflow."""
    return 0.5 * (1 + np.tanh(0.5 * x))


_YAW = {
    "linear": lambda s, p: (0.0, -p.amp * s.r),
    "power_1.5": lambda s, p: (0.0, -p.amp * s.r * np.sqrt(np.abs(s.r) / s.b.rate_ref)),
    "speed": lambda s, p: (0.0, -p.amp * s.r * s.V / s.b.speed_ref),
}
YAW = family("linear_yaw_damping", "force", ("N_r", "N m s", lambda b: 4.0 * b.inertia), _YAW)


_TRIM = {
    "speed_squared": lambda s, p: (0.0, p.amp * s.ratio**2),
    "u_abs_u": lambda s, p: (0.0, p.amp * s.u * np.abs(s.u) / s.b.speed_ref**2),
    "thrust": lambda s, p: (0.0, p.amp * s.T / s.b.drag_ref),
    "constant": lambda _s, p: (0.0, p.amp),
}
TRIM = family(
    "trim_moment",
    "force",
    ("N_0", "N m at full power", lambda b: 0.2 * b.moment_ref),
    _TRIM,
    signed=True,
)

_THRUST_LINE = {
    "sin_phi": lambda s, p: (0.0, s.T * p.amp * np.sin(s.phi)),
    "phi": lambda s, p: (0.0, s.T * p.amp * s.phi),
    "sin_2_phi": lambda s, p: (0.0, s.T * p.amp * np.sin(2 * s.phi)),
}
THRUST_LINE = family(
    "thrust_line_offset",
    "force",
    ("arm", "m", lambda b: 0.15 * b.length),
    _THRUST_LINE,
    signed=True,
)


def _walls(s, p, shape, push=1.0):
    """Push off each wall times speed squared, with added drag of half its size."""
    length, width, _ = s.b.pool
    gaps = [np.maximum(g, 0.1 * s.b.length) for g in (s.x, length - s.x, s.y, width - s.y)]
    near = [shape(g / s.b.length) for g in gaps]
    normal = (near[0] - near[1]) + 1j * (near[2] - near[3])
    strength = p.amp * s.ratio**2
    force = strength * (push * normal * np.conj(s.core) - 0.5 * sum(near) * s.hat)
    lateral = strength * push * (normal * np.conj(s.core)).imag
    return force, 0.15 * s.b.length * lateral


_WALL = {
    "exponential": (
        lambda s, p: _walls(s, p, lambda g: np.exp(-g / p.reach)),
        {"reach": (0.5, 1.2, "BL")},
    ),
    "power_law": (
        lambda s, p: _walls(s, p, lambda g: (0.5 / g) ** p.exponent),
        {"exponent": (1.5, 3.0, "1")},
    ),
    "gaussian": (
        lambda s, p: _walls(s, p, lambda g: np.exp(-((g / p.reach) ** 2))),
        {"reach": (0.9, 1.8, "BL")},
    ),
    "image_suction": lambda s, p: _walls(s, p, lambda g: (0.5 / g) ** 2, -1.0),
}
WALL = family(
    "wall_effect",
    "force",
    ("F_wall", "N at the reference speed", lambda b: 1.5 * b.drag_ref),
    _WALL,
)


def _wake(s, p, share):
    """Part of the plate's force taken away inside the robot's own wake."""
    return -p.amp * share * s.plate_force * np.conj(s.core), 0.0


def _revolutions(s):
    """Revolutions made since the start of the trial."""
    return np.abs(s.theta - s.theta_start) / (2 * np.pi)


_WAKE = {
    "logistic": lambda s, p: _wake(s, p, logistic((_revolutions(s) - 1) / 0.06)),
    "ramp": lambda s, p: _wake(s, p, np.clip(_revolutions(s) - 0.85, 0, 0.5) * 2),
    "saturating": lambda s, p: _wake(s, p, 1 - np.exp(-np.maximum(_revolutions(s) - 0.9, 0) / 0.3)),
    "wake_age": (
        lambda s, p: _wake(
            s,
            p,
            logistic((_revolutions(s) - 1) / 0.06)
            * np.exp(-2 * np.pi / (np.abs(s.r) + 0.05) / p.decay),
        ),
        {"decay": (6.0, 20.0, "s")},
    ),
}
WAKE = family("wake_reentry", "force", ("share", "1", lambda _b: 0.5), _WAKE)


def _sinking_drag(s, p, shape):
    """Drag of a robot that floats lower by amp shape(t)."""
    return -0.5 * p.amp * shape / s.b.span * s.b.drag_ref * s.ratio**2 * s.hat, 0.0


SINKING_SHAPES = {
    "linear": lambda t: t / 10,
    "quadratic": lambda t: (t / 10) ** 2,
    "saturating": lambda t: 1 - np.exp(-t / 3),
}
_SINKING = {
    name: (lambda s, p, shape=shape: _sinking_drag(s, p, shape(s.t)))
    for name, shape in SINKING_SHAPES.items()
}
SINKING = family("sinking", "force", ("depth_gain", "m", lambda b: 0.2 * b.pool[2]), _SINKING)

BODY_FORMS: list[Form] = [*YAW, *TRIM, *THRUST_LINE, *WALL, *WAKE, *SINKING]
