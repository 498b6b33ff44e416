"""Forces that no cause of the contract describes."""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .articulated import shaft_revolutions
from .form import Form

Array = NDArray[np.float64]
ShapeParameters = Any


def _dynamic_force(c: SimpleNamespace) -> Array:
    """Dynamic pressure times area, N, smooth at rest."""
    return np.asarray(c.q)


def heading_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """A compass needle: N = s q cos(n theta + phase), s in m."""
    return 0j, s * _dynamic_force(c) * np.cos(round(p["n"]) * c.th + p["phase"])


def heading_surge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """A cable or wind: force along the body s q cos(theta + phase)."""
    return s * _dynamic_force(c) * np.cos(c.th + p["phase"]) * c.axis, 0.0


def place_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = s q sin(2 pi x/length + phase): a grid on the floor."""
    return 0j, s * _dynamic_force(c) * np.sin(2 * np.pi * c.x.real / p["length_m"] + p["phase"])


def place_surge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Resistance that changes across the pool, s q sin(2 pi (x + y)/length + phase)."""
    wave = np.sin(2 * np.pi * (c.x.real + c.x.imag) / p["length_m"] + p["phase"])
    return -s * _dynamic_force(c) * wave * c.along, 0.0


def time_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = s q sin(2 pi f t) with one frequency in all trials."""
    return 0j, s * _dynamic_force(c) * np.sin(2 * np.pi * p["hertz"] * c.t)


def time_surge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """A thrust that beats slowly: s T sin(2 pi f t)."""
    return s * c.thrust * np.sin(2 * np.pi * p["hertz"] * c.t) * c.axis, 0.0


def beat_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Every n-th beat is stronger to one side: N = s T cos(2 pi beats/n), s in m."""
    return 0j, s * c.thrust * np.cos(
        2 * np.pi * shaft_revolutions(c.lanes, c.t) / round(p["beats"])
    )


def beat_surge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Thrust of every n-th beat differs, s T cos(2 pi beats/n)."""
    wave = np.cos(2 * np.pi * shaft_revolutions(c.lanes, c.t) / round(p["beats"]))
    return s * c.thrust * wave * c.axis, 0.0


def yaw_angle_surge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Force along the body s r phi, N s/rad^2."""
    return s * c.r * c.phi * np.tanh(c.V / 0.05) * c.axis, 0.0


def yaw_angle_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = -s |r| phi |phi|: mirror-symmetric, of a sign with the head angle."""
    return 0j, -s * np.abs(c.r) * c.phi * np.abs(c.phi)


def resonance_sway(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """A side force with a peak at one speed: s q exp(-((V - V_0)/0.06)^2) sign of the turn."""
    peak = np.exp(-(((c.V - p["peak_m_s"]) / 0.06) ** 2))
    return s * _dynamic_force(c) * peak * np.tanh(c.phi / 0.1) * 1j * c.axis, 0.0


def _unlisted_form(name: str, law: Any, unit: str, bounds: tuple[float, float], *, channel: str,
          variable: str, **ranges: tuple[float, float]) -> Form:  # fmt: skip
    return Form("unexplained", name, "force", law, unit, *bounds, (channel,), ranges, variable)


PHASE_RANGE = {"phase": (0.0, 2 * np.pi)}
FORMS: tuple[Form, ...] = (
    _unlisted_form(
        "heading_moment",
        heading_moment,
        "m",
        (1e-5, 0.05),
        channel="yaw",
        variable="heading_rad",
        n=(0.6, 3.4),
        **PHASE_RANGE,
    ),
    _unlisted_form(
        "heading_surge",
        heading_surge,
        "1",
        (1e-4, 0.4),
        channel="surge",
        variable="heading_rad",
        **PHASE_RANGE,
    ),
    _unlisted_form(
        "place_moment",
        place_moment,
        "m",
        (1e-5, 0.05),
        channel="yaw",
        variable="x_m",
        length_m=(0.6, 1.8),
        **PHASE_RANGE,
    ),
    _unlisted_form(
        "place_surge",
        place_surge,
        "1",
        (1e-4, 0.4),
        channel="surge",
        variable="x_m",
        length_m=(0.8, 2.2),
        **PHASE_RANGE,
    ),
    _unlisted_form(
        "time_moment",
        time_moment,
        "m",
        (1e-5, 0.05),
        channel="yaw",
        variable="time_s",
        hertz=(0.25, 0.8),
    ),
    _unlisted_form(
        "time_surge",
        time_surge,
        "1",
        (1e-4, 0.6),
        channel="surge",
        variable="time_s",
        hertz=(0.2, 0.7),
    ),
    _unlisted_form(
        "beat_moment",
        beat_moment,
        "m",
        (1e-5, 0.05),
        channel="yaw",
        variable="tail_phase_rad",
        beats=(5.6, 10.4),
    ),
    _unlisted_form(
        "beat_surge",
        beat_surge,
        "1",
        (1e-4, 0.8),
        channel="surge",
        variable="tail_phase_rad",
        beats=(5.6, 10.4),
    ),
    _unlisted_form(
        "yaw_angle_surge",
        yaw_angle_surge,
        "N s/rad^2",
        (1e-4, 0.5),
        channel="surge",
        variable="yaw_rate_rad_s x head_angle_rad",
    ),
    _unlisted_form(
        "yaw_angle_moment",
        yaw_angle_moment,
        "N m s/rad^3",
        (1e-5, 0.05),
        channel="yaw",
        variable="yaw_rate_rad_s x head_angle_rad",
    ),
    _unlisted_form(
        "resonance_sway",
        resonance_sway,
        "1",
        (1e-4, 0.5),
        channel="sway",
        variable="speed_m_s",
        peak_m_s=(0.2, 0.45),
    ),
)
