"""Resistance and thrust: drags of the whole body, losses of thrust, wakes."""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .form import Form, form_maker

Array = NDArray[np.float64]
ShapeParameters = Any
KINEMATIC_VISCOSITY_M2_S = 1e-6
GRAVITY = 9.81


def _opposing_force(c: SimpleNamespace, size: Array) -> tuple[Any, float]:
    """A resistance, N, against the velocity through the water."""
    return -size * c.along, 0.0


def viscous_linear(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Stokes-like resistance s V, s in N at 0.3 m/s as for all laws here."""
    return _opposing_force(c, s * c.V / 0.3)


def viscous_laminar(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """V^1.5: Blasius friction, C_f ~ Re^(-1/2) (Schlichting, ch. 6)."""
    return _opposing_force(c, s * (c.V / 0.3) ** 1.5)


def viscous_turbulent(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """V^1.8: Prandtl's C_f ~ Re^(-1/5)."""
    return _opposing_force(c, s * (c.V / 0.3) ** 1.8)


def viscous_ittc(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """ITTC 1957 line, C_f = 0.075/(log10 Re - 2)^2, on the length of the body; Re above 3000."""
    length = c.robot.body_length

    def line(V: Array) -> Array:
        log = np.log10(np.maximum(V * length / KINEMATIC_VISCOSITY_M2_S, 3000)) - 2
        return V**2 / log**2

    return _opposing_force(c, s * line(c.V) / line(np.float64(0.3)))


def wave_fourth(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """V^4, s in N at 0.5 m/s as for all laws here (Michell's low-speed order)."""
    return _opposing_force(c, s * (c.V / 0.5) ** 4)


def wave_sixth(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """V^6: slender hull below its hump (Newman 1977, sec. 6.20)."""
    return _opposing_force(c, s * (c.V / 0.5) ** 6)


def wave_hump(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """R = A exp(-2 k_0 d), k_0 = g/V^2, of a submerged source (Havelock 1928), depth d."""

    def rise(V: Array) -> Array:
        return np.exp(-2 * GRAVITY * p["depth_m"] / np.maximum(V, 0.03) ** 2)

    return _opposing_force(c, s * rise(c.V) / rise(np.float64(0.5)) * (c.V / 0.5) ** 2)


def wave_onset(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """(V^2 - V_0^2)^2 above the least speed of waves, V_0 = 0.23 m/s (Lamb, sec. 267)."""
    over = np.maximum(c.V**2 - p["onset_m_s"] ** 2, 0)
    return _opposing_force(c, s * over**2 / (0.25 - p["onset_m_s"] ** 2) ** 2)


def coulomb_tanh(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """A constant force, rounded below the speed V_0."""
    return _opposing_force(c, s * np.tanh(c.V / p["round_m_s"]))


def coulomb_saturating(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """S V/(V + V_0)."""
    return _opposing_force(c, s * c.V / (c.V + p["round_m_s"]))


def coulomb_stribeck(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """1 + k exp(-(V/V_s)^2), rounded at rest (Armstrong-Helouvry 1994, Automatica 30, 1083)."""
    more = 1 + p["extra"] * np.exp(-((c.V / 0.15) ** 2))
    return _opposing_force(c, s * more * np.tanh(c.V / 0.02))


def advance_ratio(c: SimpleNamespace) -> Array:
    """Advance ratio u/(f L), L the body length, not negative."""
    return np.maximum(c.u, 0) / (np.maximum(c.f, 0.1) * c.robot.body_length)


def thrust_loss_linear(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """1 - s J: a propeller's K_T (Carlton, Marine Propellers, sec. 6.1)."""
    return 1 - s * advance_ratio(c)


def thrust_loss_quadratic(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """1 - s (J/0.3)^2/3: Lighthill's balance of reactive thrust and speed."""
    return 1 - s / 3 * (advance_ratio(c) / 0.3) ** 2


def thrust_loss_exponential(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """exp(-s J)."""
    return np.exp(-s * advance_ratio(c))


def thrust_loss_strouhal(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """A window of Strouhal numbers: 1 - s (1 - exp(-(ln(St/0.3))^2/2)) (Triantafyllou 1993)."""
    strouhal = p["amplitude"] / np.maximum(advance_ratio(c), 0.05)
    return 1 - s * (1 - np.exp(-(np.log(strouhal / 0.3) ** 2) / 2))


def _area_ratio(c: SimpleNamespace) -> Array:
    return c.robot.head_length / c.head


def thrust_area_independent_share(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """A share s of the thrust does not grow with the head's area."""
    return 1 - s + s * _area_ratio(c)


def thrust_area_square_root(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """A share s of the thrust grows as the square root of the area."""
    return 1 - s + s * np.sqrt(_area_ratio(c))


def thrust_area_wake_fraction(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """A^(-s): the wake of a longer head covers the tail (wake fraction)."""
    return _area_ratio(c) ** s


def thrust_area_recoil(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """Thrust over 1 + 2 s (h/h_0 - 1): a longer head recoils less and holds the tail stiffer."""
    return 1 / (1 + 2 * s * (1 / _area_ratio(c) - 1))


def turned_revolutions(c: SimpleNamespace) -> Array:
    """Angle turned since the start, revolutions."""
    return np.abs(c.th - c.lanes.start[2]) / (2 * np.pi)


def wake_logistic(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Drag s C_D0 q after a turn of about `half` revolutions: flow left by the first pass."""
    share = 1 / (1 + np.exp(-(turned_revolutions(c) - p["half"]) / 0.06))
    return _opposing_force(c, s * c.lanes.coef[1] * c.q * share)


def wake_ramp(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Drag that grows with the angle turned beyond `onset` revolutions."""
    return _opposing_force(
        c, s * c.lanes.coef[1] * c.q * 2 * np.maximum(turned_revolutions(c) - p["onset"], 0)
    )


def wake_saturating(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """1 - exp(-(turned/scale)^2)."""
    share = 1 - np.exp(-((turned_revolutions(c) / p["scale"]) ** 2))
    return _opposing_force(c, s * c.lanes.coef[1] * c.q * share)


def wake_decay_with_age(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, float]:
    """Wake met again after the time of a revolution t: share t_d/(t_d + t) (decay as 1/t)."""
    share = 1 / (1 + np.exp(-(turned_revolutions(c) - 0.5) / 0.08))
    age = 2 * np.pi / (np.abs(c.r) + 0.2)
    return _opposing_force(
        c, 3 * s * c.lanes.coef[1] * c.q * share * p["decay_s"] / (p["decay_s"] + age)
    )


_viscous = form_maker("viscous_drag", "force", "N", ("surge", "sway"))
_wave = form_maker("wave_drag", "force", "N", ("surge", "sway"))
_dry = form_maker("coulomb_friction", "force", "N", ("surge", "sway"))
_loss = form_maker("thrust_loss_with_speed", "thrust", "1")
_area = form_maker("thrust_area", "thrust", "1")
_wake = form_maker("wake_reentry", "force", "1", ("surge", "sway"))
FORMS: tuple[Form, ...] = (
    _viscous("linear", viscous_linear, 1e-3, 1),
    _viscous("laminar", viscous_laminar, 1e-3, 1),
    _viscous("turbulent", viscous_turbulent, 1e-3, 2),
    _viscous("ittc", viscous_ittc, 1e-3, 2),
    _wave("fourth", wave_fourth, 1e-3, 3),
    _wave("sixth", wave_sixth, 1e-3, 3),
    _wave("hump", wave_hump, 1e-3, 3, depth_m=(0.02, 0.05)),
    _wave("onset", wave_onset, 1e-3, 3, onset_m_s=(0.2, 0.27)),
    _dry("tanh", coulomb_tanh, 5e-4, 0.5, round_m_s=(0.01, 0.04)),
    _dry("ratio", coulomb_saturating, 5e-4, 0.5, round_m_s=(0.02, 0.05)),
    _dry("stribeck", coulomb_stribeck, 5e-4, 0.5, extra=(0.3, 1.0)),
    _loss("linear", thrust_loss_linear, 0.02, 2.6),
    _loss("square", thrust_loss_quadratic, 0.02, 2.6),
    _loss("exponential", thrust_loss_exponential, 0.02, 4),
    _loss("strouhal", thrust_loss_strouhal, 0.02, 0.95, amplitude=(0.08, 0.14)),
    _area("none", thrust_area_independent_share, 0.01, 1),
    _area("root", thrust_area_square_root, 0.01, 1),
    _area("blocked", thrust_area_wake_fraction, 0.01, 1.3),
    _area("recoil", thrust_area_recoil, 0.01, 1),
    _wake("logistic", wake_logistic, 0.01, 2, half=(0.25, 0.5)),
    _wake("ramp", wake_ramp, 0.01, 4, onset=(0.0, 0.25)),
    _wake("saturating", wake_saturating, 0.01, 2, scale=(0.3, 0.6)),
    _wake("age", wake_decay_with_age, 0.01, 4, decay_s=(2.0, 8.0)),
)
