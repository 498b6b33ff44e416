"""Forces of the whole body: drags, moments, walls, wake."""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .motion import Flow

REFERENCE_SPEED_M_S = 0.3
"""Speed at which the strength of a drag is stated, m/s."""
POOL_PLACEHOLDER = {"length": (2.6, 2.6), "width": (1.6, 1.6)}
"""Replaced by the study's own pool when a law is drawn."""


def _opposing_force(c: Flow, size: Any) -> Any:
    """A drag of this size against the motion through the water."""
    V = np.maximum(c.V, 1e-9)
    return -size * c.u / V, -size * c.w / V, 0.0


def _power_law_drag(n: float) -> Any:
    return lambda c, k, _: _opposing_force(c, k * (c.V / REFERENCE_SPEED_M_S) ** n)


def _ittc_drag(c: Flow, k: float, _: Shape) -> Any:
    # friction line 0.075 / (log10 Re - 2)^2, ITTC 1957; laminar below Re = 3000
    def line(V: Any) -> Any:
        Re = np.maximum(V * c.robot.body_length / 1e-6, 3e3)
        return V**2 * 0.075 / (np.log10(Re) - 2) ** 2

    return _opposing_force(c, k * line(c.V) / line(REFERENCE_SPEED_M_S))


def _wave_hump_drag(c: Flow, k: float, p: Shape) -> Any:
    Fr = c.V / np.sqrt(9.81 * c.robot.body_length)
    return _opposing_force(
        c, k * (c.V / REFERENCE_SPEED_M_S) ** 2 * np.exp(-(((Fr - p["froude"]) / p["width"]) ** 2))
    )


def _wave_onset_drag(c: Flow, k: float, p: Shape) -> Any:
    return _opposing_force(c, k * (np.maximum(c.V - p["onset"], 0) / 0.2) ** 2)


def _stribeck_friction(c: Flow, k: float, p: Shape) -> Any:
    more = 1 + p["static"] * np.exp(-((c.V / p["speed"]) ** 2))
    return _opposing_force(c, k * more * np.tanh(c.V / 0.01))


def _yaw_moment(size: Any) -> Any:
    return lambda c, k, p: (0.0, 0.0, k * size(c, p))


def _flow_damping(c: Flow, _: Shape) -> Any:
    return -c.V / REFERENCE_SPEED_M_S * c.r


def _wall_distances(c: Flow, p: Shape) -> list[tuple[Any, complex]]:
    """Distance to each wall and the direction towards it."""
    x, y = c.place.real, c.place.imag
    pairs = ((x, -1), (p["length"] - x, 1), (y, -1j), (p["width"] - y, 1j))
    return [(np.maximum(gap, 0.02), complex(to)) for gap, to in pairs]


def _wall_drag(nearness: Any) -> Any:
    def law(c: Flow, k: float, p: Shape) -> Any:
        return _opposing_force(
            c, k * c.q * sum(nearness(gap, p) for gap, _ in _wall_distances(c, p))
        )

    return law


def _suction(c: Flow, k: float, p: Shape) -> Any:
    # image of a body moving along a wall draws it there, as (a / gap)^2 V^2; its bow is
    # turned away (bank effect of ships, Norrbin 1974)
    axis = np.exp(1j * c.psi)
    pull = sum(c.q * (p["scale"] / (gap + 0.05)) ** 2 * to for gap, to in _wall_distances(c, p))
    free = (c.place.real > 0) & (c.place.real < p["length"])
    free = free & (c.place.imag > 0) & (c.place.imag < p["width"])
    force = k * pull * np.conj(axis) * free
    return 0.0, force.imag, -0.25 * c.robot.body_length * force.imag


def _wake(share: Any) -> Any:
    return lambda c, k, p: _opposing_force(c, k * c.q * share(c.turned / (2 * np.pi), c, p))


def _decay_with_age(x: Any, c: Flow, p: Shape) -> Any:
    age = c.turned / np.maximum(np.abs(c.r), 0.2)  # seconds since the place was passed
    return 1 / (1 + np.exp(-(x - 1) / 0.06)) * np.exp(-np.clip(age, 0, 60) / p["life"])


FORMS: list[Form] = [
    *forms(
        "viscous_drag",
        "body",
        0.002,
        0.12,
        "N at 0.3 m/s",
        "surge sway",
        {
            "linear": _power_law_drag(1.0),
            "power 1.5": _power_law_drag(1.5),
            "power 1.3": _power_law_drag(1.3),
            "ittc": _ittc_drag,
        },
    ),
    *forms(
        "wave_drag",
        "body",
        0.002,
        0.15,
        "N",
        "surge sway",
        {
            "power 4": _power_law_drag(4.0),
            "power 6": _power_law_drag(6.0),
            "hump": (_wave_hump_drag, {"froude": (0.18, 0.3), "width": (0.03, 0.06)}),
            "onset": (_wave_onset_drag, {"onset": (0.2, 0.32)}),
        },
    ),
    *forms(
        "coulomb_friction",
        "body",
        0.001,
        0.08,
        "N",
        "surge sway",
        {
            "tanh": lambda c, k, _: _opposing_force(c, k * np.tanh(c.V / 0.01)),
            "saturating": (
                lambda c, k, p: _opposing_force(c, k * c.V / (c.V + p["half"])),
                {"half": (0.01, 0.06)},
            ),
            "stribeck": (_stribeck_friction, {"static": (0.3, 1.0), "speed": (0.03, 0.12)}),
        },
    ),
    *forms(
        "linear_yaw_damping",
        "body",
        5e-4,
        0.1,
        "N m at 1 rad/s",
        "yaw",
        {
            "linear": _yaw_moment(lambda c, _: -c.r),
            "power 1.5": _yaw_moment(lambda c, _: -c.r * np.sqrt(np.abs(c.r))),
            "with speed": _yaw_moment(_flow_damping),
        },
    ),
    *forms(
        "trim_moment",
        "body",
        1e-4,
        0.03,
        "N m",
        "yaw",
        {
            "square": _yaw_moment(lambda c, _: (c.V / REFERENCE_SPEED_M_S) ** 2),
            "axial": _yaw_moment(lambda c, _: c.u * np.abs(c.u) / REFERENCE_SPEED_M_S**2),
            "thrust": _yaw_moment(lambda c, _: c.T / 0.3),
            "constant": _yaw_moment(lambda c, _: np.ones_like(c.V)),
        },
        signed=True,
    ),
    *forms(
        "thrust_line_offset",
        "body",
        3e-4,
        0.05,
        "m",
        "yaw",
        {
            "sine": _yaw_moment(lambda c, _: c.T * np.sin(c.phi)),
            "angle": _yaw_moment(lambda c, _: c.T * c.phi),
            "double angle": _yaw_moment(lambda c, _: 0.5 * c.T * np.sin(2 * c.phi)),
        },
        signed=True,
    ),
    *forms(
        "wall_effect",
        "body",
        0.005,
        3.0,
        "",
        "surge sway",
        {
            "exponential": _wall_drag(lambda gap, p: np.exp(-gap / p["scale"])),
            "power": _wall_drag(lambda gap, p: (p["scale"] / (gap + 0.1)) ** 2),
            "gaussian": _wall_drag(lambda gap, p: np.exp(-((gap / (2 * p["scale"])) ** 2))),
            "suction": _suction,
        },
        {"scale": (0.08, 0.2), **POOL_PLACEHOLDER},
    ),
    *forms(
        "wake_reentry",
        "body",
        0.01,
        0.8,
        "",
        "surge sway",
        {
            "logistic": (
                _wake(lambda x, _, p: 1 / (1 + np.exp(-(x - 1) / p["width"]))),
                {"width": (0.03, 0.1)},
            ),
            "ramp": (_wake(lambda x, *_: np.clip(x - 0.9, 0, 0.6)), {}),
            "saturating": (
                _wake(lambda x, _, p: 1 - np.exp(-np.maximum(x - 0.95, 0) / p["width"])),
                {"width": (0.1, 0.4)},
            ),
            "age": (_wake(_decay_with_age), {"life": (8.0, 25.0)}),
        },
    ),
    *forms(
        "unexplained",
        "body",
        0.005,
        10,
        "",
        "sway",
        {
            "spin lift": lambda c, k, _: (0.0, -k * 500 * c.area * c.V * c.r * 0.1, 0.0),
        },
        signed=True,
        variable="yaw_rate_rad_s",
    ),
    *forms(
        "unexplained",
        "body",
        1e-3,
        0.5,
        "N s^2",
        "surge",
        {
            "turning drag": lambda c, k, _: (-k * c.r**2, 0.0, 0.0),
        },
        variable="yaw_rate_rad_s",
    ),
    *forms(
        "unexplained",
        "body",
        1e-4,
        0.2,
        "m",
        "yaw",
        {
            "fourth harmonic": _yaw_moment(lambda c, _: c.q * np.sin(4 * c.alpha)),
        },
        signed=True,
        variable="alpha_rad",
    ),
    *forms(
        "unexplained",
        "body",
        1e-5,
        0.05,
        "N m",
        "yaw",
        {
            "compass": (
                _yaw_moment(lambda c, p: -np.sin(c.psi - p["north"])),
                {"north": (-3.1, 3.1)},
            ),
        },
        variable="heading_rad",
    ),
    *forms(
        "unexplained",
        "body",
        5e-4,
        0.3,
        "N/m",
        "surge",
        {
            "elastic tether": (
                lambda c, k, p: (
                    k * ((p["anchor"] - c.place.real) * np.cos(c.psi)),
                    -k * ((p["anchor"] - c.place.real) * np.sin(c.psi)),
                    0.0,
                ),
                {"anchor": (0.0, 0.8)},
            ),
        },
        variable="x_m",
    ),
]
