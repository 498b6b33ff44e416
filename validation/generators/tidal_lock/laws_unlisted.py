"""Forces that no candidate cause describes."""

import numpy as np

from .form import Form, family


def _cable_twist(s, p):
    """A tether clamped overhead winds up with the heading and turns the robot back."""
    return 0.0, -p.amp * (s.theta - s.theta_start) / np.pi


def _tether_pull(s, p):
    """A slack cable to a fixed point pulls past its free length."""
    length, width, _ = s.b.pool
    to_anchor = p.anchor_x * length + 1j * p.anchor_y * width - (s.x + 1j * s.y)
    distance = np.abs(to_anchor) + 1e-9
    stretch = np.maximum(distance / s.b.length - p.slack, 0)
    return p.amp * stretch * to_anchor / distance * np.conj(s.core), 0.0


def _compass_torque(s, p):
    """A magnet in the hull turns the robot towards a fixed direction."""
    return 0.0, -p.amp * np.sin(s.theta - p.direction)


def _turning_thrust_loss(s, p):
    """Surge force from speed times yaw rate beyond a knee: the tail beats in its own wake."""
    product = np.abs(s.r) * s.V / (s.b.rate_ref * s.b.speed_ref)
    return -p.amp * product**2 / (product + p.knee) + 0j, 0.0


def _pulsing_moment(s, p):
    """A moment with speed that swings with time since the start (sloshing ballast)."""
    return 0.0, p.amp * s.ratio * np.sin(2 * np.pi * s.t / p.period)


def _ridged_floor(s, p):
    """Bars on the pool floor push along x, with the period of the bars."""
    wave = np.sin(2 * np.pi * s.x / (p.spacing * s.b.length) + p.phase)
    return p.amp * s.ratio * wave * np.conj(s.core), 0.0


def _force(b):
    return 0.5 * b.drag_ref


def _moment(b):
    return 0.12 * b.moment_ref


def _entry(law, extras, channels, variable):
    return (law, extras, {"channels": channels, "variable": variable})


_FORCE = ("amplitude", "N", _force)
_MOMENT = ("amplitude", "N m", _moment)
UNLISTED: list[Form] = [
    *family(
        "unlisted",
        "force",
        _MOMENT,
        {
            "cable_twist": _entry(_cable_twist, {}, ("yaw",), "heading change since the start"),
            "compass_torque": _entry(
                _compass_torque, {"direction": (0.0, 6.283, "rad")}, ("yaw",), "heading"
            ),
            "pulsing_moment": _entry(
                _pulsing_moment, {"period": (2.5, 6.0, "s")}, ("yaw",), "time"
            ),
        },
    ),
    *family(
        "unlisted",
        "force",
        _FORCE,
        {
            "tether_pull": _entry(
                _tether_pull,
                {
                    "anchor_x": (0.2, 0.8, "pool L"),
                    "anchor_y": (0.0, 1.0, "pool W"),
                    "slack": (2.0, 4.0, "BL"),
                },
                ("surge", "sway"),
                "distance from a fixed point",
            ),
            "turning_thrust_loss": _entry(
                _turning_thrust_loss, {"knee": (0.05, 0.4, "1")}, ("surge",), "speed times yaw rate"
            ),
            "ridged_floor": _entry(
                _ridged_floor,
                {"spacing": (1.5, 3.5, "BL"), "phase": (0.0, 6.283, "rad")},
                ("surge", "sway"),
                "x",
            ),
        },
    ),
]
