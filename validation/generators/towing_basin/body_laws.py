"""Hidden laws of the body: drag, damping, inertia, moments, and the head's lift.

Force laws return a complex force in core axes (N) and a moment (N m).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .form import Array, Form, InstantaneousState

ShapeParameters = Mapping[str, float]
ForceAndMoment = tuple[Array, Array | float]
Polar = tuple[Array, Array, Array]
STATIONS_M = np.linspace(-0.19, 0.04, 9)
"""Stations along the core ahead of the centre of mass for strip integrals, m."""


def _strip_sum(
    m: InstantaneousState, s: float, sectional: object, taper: float = 0.0
) -> ForceAndMoment:
    """Sum over strips of -s g(w) dx, with height falling towards the tail by `taper`."""
    force, moment = np.zeros_like(m.rate), np.zeros_like(m.rate)
    for x in STATIONS_M:
        height = 1 - taper * (STATIONS_M[-1] - x) / (STATIONS_M[-1] - STATIONS_M[0])
        pull = -s * height * sectional(m.flow.imag + x * m.rate) / len(STATIONS_M)  # type: ignore[operator]
        force, moment = force + pull, moment + x * pull
    return 1j * force, moment


def cross_square(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """Strips of |w| w: Taylor 1952, Proc. R. Soc. A 214, large Reynolds number."""
    return _strip_sum(m, s, lambda w: np.abs(w) * w)


def cross_power(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Strips of |w|^(n-1) w with n from 1.5 to 1.8 (Taylor 1952: skin friction across, n = 1.5)."""
    return _strip_sum(m, s, lambda w: np.sign(w) * np.abs(w) ** p["power"])


def cross_tapered(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Strips of |w| w on a body that narrows towards the tail (Hoerner 1965, ch. 3)."""
    return _strip_sum(m, s, lambda w: np.abs(w) * w, p["taper"])


def cross_reynolds(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Strips with C_c = 1 + (w_0/|w|)^(1/2): section drag at Re of 10^3 (White 2006, ch. 3)."""
    return _strip_sum(m, s, lambda w: np.abs(w) * w * (1 + np.sqrt(p["w0"] / (np.abs(w) + 1e-4))))


def yaw_damping_linear(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = -s r (Fossen 2011, sect. 6.4, linear damping)."""
    return 0 * m.flow, -s * m.rate


def yaw_damping_power(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = -s r |r|^(1/2): boundary layer of a turning body."""
    return 0 * m.flow, -s * m.rate * np.sqrt(np.abs(m.rate))


def yaw_damping_with_speed(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = -s V r (Clarke, Gedling and Hine 1983, N_r)."""
    return 0 * m.flow, -s * m.speed * m.rate


def viscous_linear(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s V (Stokes)."""
    return -s * m.flow, 0.0


def viscous_blasius(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s V^1.5: laminar boundary layer (Blasius 1908)."""
    return -s * m.flow * m.speed**0.5, 0.0


def viscous_turbulent(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s V^1.8: turbulent boundary layer, one-fifth power law (Schlichting 1979, ch. XXI)."""
    return -s * m.flow * m.speed**0.8, 0.0


def viscous_ittc(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-1/2 rho s C_F V^2, C_F = 0.075 / (log10 Re - 2)^2 (ITTC 1957), length 0.33 m."""
    reynolds = np.maximum(m.speed * 0.33 / 1e-6, 2e3)
    return -500 * s * 0.075 / (np.log10(reynolds) - 2) ** 2 * m.speed * m.flow, 0.0


def wave_fourth(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s V^4."""
    return -s * m.speed**4 * m.ahead, 0.0


def wave_sixth(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s V^6: low-Froude growth of wave resistance (Newman 1977, sect. 6.13)."""
    return -s * m.speed**6 * m.ahead, 0.0


def wave_hump(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """-s V^2 exp(-((V - V_h)/0.08)^2): a hump as in Havelock's integral."""
    return -s * m.speed**2 * np.exp(-(((m.speed - p["hump"]) / 0.08) ** 2)) * m.ahead, 0.0


def wave_onset(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """-s max(V - V_0, 0)^2: waves are made only beyond the least phase speed, 0.23 m/s."""
    return -s * np.maximum(m.speed - p["onset"], 0) ** 2 * m.ahead, 0.0


def coulomb_sign(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """-s sign V, rounded below 4 mm/s."""
    return -s * np.tanh(m.speed / 0.004) * m.ahead, 0.0


def coulomb_tanh(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """-s tanh(V / v_0)."""
    return -s * np.tanh(m.speed / p["v0"]) * m.ahead, 0.0


def coulomb_stribeck(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """-s (1 + 0.6 exp(-(V/v_s)^2)) sign V (Armstrong-Helouvry 1994, Automatica 30)."""
    fall = 1 + 0.6 * np.exp(-((m.speed / p["v0"]) ** 2))
    return -s * np.tanh(m.speed / 0.004) * fall * m.ahead, 0.0


def coulomb_saturating(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """-s V / (V + c)."""
    return -s * m.speed / (m.speed + p["v0"]) * m.ahead, 0.0


def added_mass_ellipsoid(
    _: InstantaneousState, s: float, __: ShapeParameters
) -> tuple[float, float, float, float]:
    """S times (0.05, 0.9) of 0.68 kg and 0.6 of I (Lamb 1932, art. 114, prolate ellipsoid)."""
    return 0.034 * s, 0.61 * s, 0.0057 * s, 1.0


def added_mass_slender(
    _: InstantaneousState, s: float, __: ShapeParameters
) -> tuple[float, float, float, float]:
    """Across and turning only (Lighthill 1960, J. Fluid Mech. 9, slender body)."""
    return 0.0, 0.7 * s, 0.008 * s, 1.0


def added_mass_partial_munk(
    _: InstantaneousState, s: float, p: ShapeParameters
) -> tuple[float, float, float, float]:
    """Munk's moment reduced by viscous separation at the tail (Munk 1924; Newman 1977, ch. 4)."""
    return 0.06 * s, 0.65 * s, 0.004 * s, p["munk"]


def trim_speed(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s V^2: a bent body."""
    return 0 * m.flow, s * m.speed**2


def trim_forward(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s u |u|: a bent tail, forward flow only."""
    return 0 * m.flow, s * m.flow.real * np.abs(m.flow.real)


def trim_thrust(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s T: the beat is not symmetric."""
    return 0 * m.flow, s * m.thrust


def trim_constant(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s, growing over the first half second of a trial: a stiff tether or cable."""
    return 0 * m.flow, s * (1 - np.exp(-m.t / 0.5))


def thrust_line_sine(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s T sin phi: the thrust passes beside the centre of mass when the head is turned."""
    return 0 * m.flow, s * m.thrust * np.sin(m.angle)


def thrust_line_linear(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s T phi."""
    return 0 * m.flow, s * m.thrust * m.angle


def thrust_line_double_angle(m: InstantaneousState, s: float, _: ShapeParameters) -> ForceAndMoment:
    """N = s T sin 2 phi."""
    return 0 * m.flow, s * m.thrust * np.sin(2 * m.angle)


def mass_shift_fixed(_: InstantaneousState, s: float, __: ShapeParameters) -> float:
    """The centre of mass lies s ahead of its stated place."""
    return s


def mass_shift_with_angle(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """S |sin phi| / sin 45 deg: the mass of the head moves with it."""
    return s * np.abs(np.sin(m.angle)) / np.sin(np.pi / 4)


def mass_shift_mixed(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """S (1 + cos phi) / 2: battery in the head."""
    return 0.5 * s * (1 + np.cos(m.angle))


def _smooth_onset(m: InstantaneousState, p: ShapeParameters) -> Array:
    return 0.5 * (1 + np.tanh((np.abs(np.sin(m.attack)) - p["onset"]) / p["width"]))


def stall_step(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """Lift falls by the share s beyond an onset; its moment as well."""
    keep = 1 - s * _smooth_onset(m, p)
    return polar[0] * keep, polar[1], polar[2] * keep


def stall_kirchhoff(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """C_L ((1 + sqrt f)/2)^2, f = 1 - s step (Leishman and Beddoes 1989, J. AHS 34)."""
    keep = ((1 + np.sqrt(np.maximum(1 - s * _smooth_onset(m, p), 0))) / 2) ** 2
    return polar[0] * keep, polar[1], polar[2] * keep


def stall_moment(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """Stalled lift moves aft: the free moment falls twice as fast as the lift."""
    step = _smooth_onset(m, p)
    return polar[0] * (1 - s * step), polar[1], polar[2] * (1 - 2 * s * step)


def stall_drag(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """Lost lift is in part found as drag (Hoerner and Borst 1975, ch. 4)."""
    step = _smooth_onset(m, p)
    lost = s * step * np.abs(polar[0])
    return polar[0] * (1 - s * step), polar[1] + 0.5 * lost, polar[2]


def asymmetry_step(m: InstantaneousState, polar: Polar, s: float, _: ShapeParameters) -> Polar:
    """C_L (1 + s sign alpha): one side of the head is rough."""
    side = 1 + s * np.tanh(np.sin(m.attack) / 0.01)
    return polar[0] * side, polar[1], polar[2] * side


def asymmetry_tanh(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """C_L (1 + s tanh(sin alpha / w))."""
    side = 1 + s * np.tanh(np.sin(m.attack) / p["width"])
    return polar[0] * side, polar[1], polar[2] * side


def asymmetry_beyond_onset(
    m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters
) -> Polar:
    """Only beyond an onset: separation on one side."""
    side = 1 + s * np.sign(m.attack) * _smooth_onset(m, {**p, "width": 0.05})
    return polar[0] * side, polar[1], polar[2] * side


def asymmetry_with_drag(m: InstantaneousState, polar: Polar, s: float, p: ShapeParameters) -> Polar:
    """Lift and drag of one side differ."""
    side = s * np.tanh(np.sin(m.attack) / p["width"])
    return polar[0] * (1 + side), polar[1] * (1 - 0.5 * side), polar[2]


def lag_first(
    m: InstantaneousState, C_L: Array, s: float, _: ShapeParameters
) -> tuple[Array, Array]:
    """First order in time: dC/dt = (C_L - C) / s."""
    return m.lag[0], np.stack([(C_L - m.lag[0]) / s, 0 * C_L])


def lag_wagner(
    m: InstantaneousState, C_L: Array, s: float, _: ShapeParameters
) -> tuple[Array, Array]:
    """Wagner's function after Jones 1940 (NACA Report 681): 1 - 0.165 e^-0.0455x - 0.335 e^-0.3x.

    x: distance in half chords; s scales the chord, m.
    """
    pace = 2 * m.speed / s
    memory = np.stack([0.0455 * pace * (C_L - m.lag[0]), 0.3 * pace * (C_L - m.lag[1])])
    return 0.5 * C_L + 0.165 * m.lag[0] + 0.335 * m.lag[1], memory


def lag_distance(
    m: InstantaneousState, C_L: Array, s: float, _: ShapeParameters
) -> tuple[Array, Array]:
    """First order in distance swum: dC/dt = (C_L - C) V / s (Kuessner-like)."""
    return m.lag[0], np.stack([(C_L - m.lag[0]) * m.speed / s, 0 * C_L])


def lag_circulation(
    m: InstantaneousState, C_L: Array, s: float, _: ShapeParameters
) -> tuple[Array, Array]:
    """The circulation V C_L lags by s seconds, not the coefficient."""
    lagging = m.lag[0] / np.maximum(m.speed, 0.02)
    return lagging, np.stack([(C_L * m.speed - m.lag[0]) / s, 0 * C_L])


BOTH, YAW, SURGE = ("sway", "yaw"), ("yaw",), ("surge",)
ONSET_RANGES = {"onset": (0.2, 0.4), "width": (0.05, 0.12)}


def _force(cause: str, name: str, law: object, channels: tuple[str, ...], variable: str,
           *size: object, odd: bool = False, **shape: tuple[float, float]) -> Form:  # fmt: skip
    unit, start, limit = size
    return Form(cause, name, "force", law, channels, variable, unit, start, limit, shape, odd=odd)


def _cross(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return _force("crossflow_drag", name, law, BOTH, "sway_velocity_m_s", "N (s/m)^n", 2.0, 40.0,
                  **shape)  # fmt: skip


def _damping(name: str, law: object, unit: str) -> Form:
    return _force("linear_yaw_damping", name, law, YAW, "yaw_rate_rad_s", unit, 0.005, 0.3)


def _viscous(name: str, law: object, *size: object) -> Form:
    return _force("viscous_drag", name, law, ("surge", "sway"), "speed_m_s", *size)


def _wave(name: str, law: object, *size: object, **shape: tuple[float, float]) -> Form:
    return _force("wave_drag", name, law, SURGE, "speed_m_s", *size, **shape)


def _coulomb(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return _force("coulomb_friction", name, law, SURGE, "speed_m_s", "N", 0.01, 0.1, **shape)


def _added(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return Form("added_mass", name, "inertia", law, ("surge", "sway", "yaw"), "acceleration_m_s2",
                "1", 0.3, 2.5, shape)  # fmt: skip


def _trim(name: str, law: object, unit: str, start: float, limit: float) -> Form:
    return _force("trim_moment", name, law, YAW, "speed_m_s", unit, start, limit, odd=True)


def _line(name: str, law: object) -> Form:
    return _force("thrust_line_offset", name, law, YAW, "head_angle_rad", "m", 0.005, 0.08)


def _mass(name: str, law: object) -> Form:
    return Form("centre_of_mass_shift", name, "arm", law, YAW, "sway_force_N", "m", 0.005, 0.05)


def _stall(name: str, law: object) -> Form:
    return Form("stall", name, "head", law, ("surge", "sway", "yaw"), "angle_of_attack_rad", "1",
                0.3, 0.95, ONSET_RANGES)  # fmt: skip


def _port(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return Form("port_starboard_asymmetry", name, "head", law, BOTH, "angle_of_attack_rad", "1",
                0.1, 0.5, shape, odd=True)  # fmt: skip


def _lag(name: str, law: object, unit: str, start: float, limit: float) -> Form:
    return Form("lift_lag", name, "lag", law, BOTH, "time_s", unit, start, limit)


FORMS = (
    _cross("square", cross_square),
    _cross("power", cross_power, power=(1.5, 1.8)),
    _cross("tapered", cross_tapered, taper=(0.3, 0.8)),
    _cross("reynolds", cross_reynolds, w0=(0.02, 0.1)),
    _damping("linear", yaw_damping_linear, "N m s"),
    _damping("power", yaw_damping_power, "N m s^1.5"),
    _damping("speed", yaw_damping_with_speed, "N s^2"),
    _viscous("linear", viscous_linear, "N s/m", 0.1, 1.5),
    _viscous("blasius", viscous_blasius, "N (s/m)^1.5", 0.2, 3.0),
    _viscous("turbulent", viscous_turbulent, "N (s/m)^1.8", 0.3, 5.0),
    _viscous("ittc", viscous_ittc, "m^2", 0.1, 2.0),
    _wave("fourth", wave_fourth, "N (s/m)^4", 0.5, 20.0),
    _wave("sixth", wave_sixth, "N (s/m)^6", 2.0, 100.0),
    _wave("hump", wave_hump, "N (s/m)^2", 0.2, 4.0, hump=(0.28, 0.45)),
    _wave("onset", wave_onset, "N (s/m)^2", 0.5, 12.0, onset=(0.15, 0.27)),
    _coulomb("sign", coulomb_sign),
    _coulomb("tanh", coulomb_tanh, v0=(0.02, 0.06)),
    _coulomb("stribeck", coulomb_stribeck, v0=(0.03, 0.1)),
    _coulomb("saturating", coulomb_saturating, v0=(0.02, 0.06)),
    _added("ellipsoid", added_mass_ellipsoid),
    _added("slender", added_mass_slender),
    _added("partial_munk", added_mass_partial_munk, munk=(0.2, 0.7)),
    _trim("speed", trim_speed, "N s^2/m", 0.001, 0.05),
    _trim("forward", trim_forward, "N s^2/m", 0.001, 0.05),
    _trim("thrust", trim_thrust, "m", 0.001, 0.03),
    _trim("constant", trim_constant, "N m", 2e-4, 0.005),
    _line("sine", thrust_line_sine),
    _line("angle", thrust_line_linear),
    _line("double", thrust_line_double_angle),
    _mass("fixed", mass_shift_fixed),
    _mass("moving", mass_shift_with_angle),
    _mass("mixed", mass_shift_mixed),
    _stall("step", stall_step),
    _stall("kirchhoff", stall_kirchhoff),
    _stall("moment", stall_moment),
    _stall("drag", stall_drag),
    _port("step", asymmetry_step),
    _port("tanh", asymmetry_tanh, width=(0.1, 0.3)),
    _port("large", asymmetry_beyond_onset, onset=(0.15, 0.3)),
    _port("drag", asymmetry_with_drag, width=(0.05, 0.2)),
    _lag("first_order", lag_first, "s", 0.1, 0.8),
    _lag("wagner", lag_wagner, "m", 0.1, 1.2),
    _lag("distance", lag_distance, "m", 0.05, 0.4),
    _lag("circulation", lag_circulation, "s", 0.1, 0.8),
)
