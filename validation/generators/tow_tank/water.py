"""Water in motion (m/s, complex), added masses, and where the mass is (m, complex, core axes)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .motion import Flow
from .resistance import POOL_PLACEHOLDER


def _current_direction(p: Shape) -> complex:
    return complex(np.exp(1j * p["direction"]))


def _sheared_current(c: Flow, k: float, p: Shape) -> Any:
    return k * _current_direction(p) * (0.3 + 1.4 * c.place.imag / p["width"])


def _drifting_current(c: Flow, k: float, p: Shape) -> Any:
    return k * _current_direction(p) * (1 + p["drift"] * (2 * c.lanes.order - 1))


def _gyre_cell(c: Flow, k: float, p: Shape) -> Any:
    x, y = np.pi * c.place.real / p["length"], np.pi * c.place.imag / p["width"]
    ratio = p["width"] / p["length"]  # stream function sin x sin y
    return k * (np.sin(x) * np.cos(y) - 1j * ratio * np.cos(x) * np.sin(y))


def _gyre_solid_body(c: Flow, k: float, p: Shape) -> Any:
    return 1j * k * _from_centre(c, p) / 0.5


def _from_centre(c: Flow, p: Shape) -> Any:
    return c.place - (p["length"] * p["at x"] + 1j * p["width"] * p["at y"])


def _gyre_gaussian(c: Flow, k: float, p: Shape) -> Any:
    d = _from_centre(c, p)
    return 1j * k * d / p["core"] * np.exp(0.5 - 0.5 * np.abs(d / p["core"]) ** 2)


def _gyre_scully(c: Flow, k: float, p: Shape) -> Any:
    d = _from_centre(c, p)  # r / (r^2 + a^2), Scully 1975
    return 2j * k * d * p["core"] / (np.abs(d) ** 2 + p["core"] ** 2)


def _added_mass_strips(c: Flow, k: float, _: Shape) -> Any:
    x, h, ds = c.robot.stations
    m = c.robot.density * np.pi / 4 * h**2 * ds
    bow = c.robot.density * np.pi / 4 * c.robot.span**2 * c.robot.head_length
    at = c.robot.hinge_to_com + 0.5 * c.robot.head_length
    my, mr, inr = m.sum() + bow, (x * m).sum() + at * bow, (x * x * m).sum() + at**2 * bow
    return 0.05 * k * my, k * my, k * mr, k * inr, 1.0


def _added_mass_ellipsoid(c: Flow, k: float, _: Shape) -> Any:
    # Lamb's factors of a spheroid six times as long as thick: 0.045, 0.918, 0.764
    m = c.robot.mass
    inertia = m * (c.robot.body_length**2 + c.robot.span**2) / 20
    return 0.045 * k * m, 0.918 * k * m, 0.0, 0.764 * k * inertia, 1.0


def _added_mass_partial_munk(c: Flow, k: float, p: Shape) -> Any:
    mx, my, mr, inr, _ = _added_mass_strips(c, k, p)
    return mx, my, mr, inr, p["munk"]


def _added_mass_sway_alone(c: Flow, k: float, _: Shape) -> Any:
    return 0.0, k * c.robot.mass, 0.0, 0.3 * k * c.robot.inertia, 0.0


def _mass_shift_with_angle(c: Flow, k: float, _: Shape) -> Any:
    return 1j * k * np.sin(c.phi)


def _mass_shift_of_long_head(c: Flow, k: float, _: Shape) -> Any:
    return k * (1 - 2.5 * (c.lanes.head / c.robot.head_length - 1))


_GYRE_PLACE_RANGES = {
    "at x": (0.35, 0.65),
    "at y": (0.35, 0.65),
    "core": (0.2, 0.45),
    **POOL_PLACEHOLDER,
}
FORMS: list[Form] = [
    *forms(
        "uniform_current",
        "water",
        5e-4,
        0.06,
        "m/s",
        "surge sway",
        {
            "constant": lambda _, k, p: k * _current_direction(p),
            "sheared": _sheared_current,
            "drifting": (_drifting_current, {"direction": (-3.1, 3.1), "drift": (0.2, 0.7)}),
        },
        {"direction": (-3.1, 3.1), **POOL_PLACEHOLDER},
    ),
    *forms(
        "pool_gyre",
        "water",
        5e-4,
        0.08,
        "m/s",
        "surge sway",
        {
            "cell": _gyre_cell,
            "solid": _gyre_solid_body,
            "gaussian": _gyre_gaussian,
            "scully": _gyre_scully,
        },
        _GYRE_PLACE_RANGES,
        signed=True,
    ),
    *forms(
        "added_mass",
        "inertia",
        0.02,
        1.5,
        "",
        "surge sway yaw",
        {
            "strip": _added_mass_strips,
            "ellipsoid": _added_mass_ellipsoid,
            "sway alone": _added_mass_sway_alone,
            "partial munk": (_added_mass_partial_munk, {"munk": (0.2, 0.7)}),
        },
    ),
    *forms(
        "centre_of_mass_shift",
        "centre",
        3e-4,
        0.03,
        "m",
        "yaw",
        {
            "fixed": lambda _c, k, _p: complex(k),
            "swinging": _mass_shift_with_angle,
            "cap": _mass_shift_of_long_head,
        },
        signed=True,
    ),
]
