"""Hidden laws of the place: moving water (complex velocity, m/s), walls, and unlisted forces."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .form import UNLISTED, Array, Form, InstantaneousState, ParallelTrials

ShapeParameters = Mapping[str, float]
ForceAndMoment = tuple[Array, Array | float]


def current_constant(
    _: Array, place: Array, __: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """The same everywhere and always."""
    return s * np.exp(1j * p["direction"]) + 0 * place


def current_drifting(
    t: Array, place: Array, _: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """Rises or falls within a trial as after the filling of a basin."""
    return s * np.exp(1j * p["direction"]) * (1 + p["drift"] * (t - 4) / 4) + 0 * place


def current_sheared(
    _: Array, place: Array, lanes: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """Along x, with a parabola across: flow of a channel (Poiseuille profile)."""
    half = lanes.pool[1] / 2
    return s * np.sign(np.cos(p["direction"])) * (1 - 0.8 * (place.imag / half - 1) ** 2) + 0j


def _offset_from_gyre(
    place: Array, lanes: ParallelTrials, p: ShapeParameters
) -> tuple[Array, Array]:
    """Offset from the axis of the gyre and its size, m."""
    length, width = lanes.pool
    offset = place - complex(p["x"] * length, p["y"] * width)
    return offset, np.maximum(np.abs(offset), 1e-6)


def gyre_cell(_: Array, place: Array, lanes: ParallelTrials, s: float, p: ShapeParameters) -> Array:
    """Stream function sin(pi x/L) sin(pi y/W), greatest speed s."""
    length, width = lanes.pool
    X, Y = np.pi * place.real / length, np.pi * place.imag / width
    sign = np.sign(p["x"] - 0.5)
    return sign * s * (np.sin(X) * np.cos(Y) - 1j * width / length * np.cos(X) * np.sin(Y))


def gyre_solid(
    _: Array, place: Array, lanes: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """Solid-body rotation, speed s at a metre from the axis."""
    offset, _radius = _offset_from_gyre(place, lanes, p)
    return 1j * s * offset


def gyre_gaussian(
    _: Array, place: Array, lanes: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """Shielded vortex, speed s e^(1/2) (r/c) exp(-r^2 / 2 c^2)."""
    offset, radius = _offset_from_gyre(place, lanes, p)
    return 1j * s * 1.6487 * offset / p["core"] * np.exp(-((radius / p["core"]) ** 2) / 2)


def gyre_scully(
    _: Array, place: Array, lanes: ParallelTrials, s: float, p: ShapeParameters
) -> Array:
    """2 s c r / (c^2 + r^2) (Scully 1975, MIT ASRL TR 178-1)."""
    offset, radius = _offset_from_gyre(place, lanes, p)
    return 2j * s * p["core"] * offset / (p["core"] ** 2 + radius**2)


def _wall_distances(m: InstantaneousState) -> tuple[tuple[Array, complex], ...]:
    """Distance to each of the four walls and the direction towards it in the pool frame."""
    length, width = m.lanes.pool
    x, y = m.place.real, m.place.imag
    return ((x, -1), (length - x, 1), (y, -1j), (width - y, 1j))


def _suction(m: InstantaneousState, strength: object) -> ForceAndMoment:
    """Force towards the walls, in core axes, proportional to V^2."""
    pull = sum(strength(np.maximum(gap, 0.05)) * to for gap, to in _wall_distances(m))  # type: ignore[operator]
    return m.speed**2 * pull * np.exp(-1j * m.heading), 0.0


def wall_exponential(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Suction s V^2 exp(-gap / d) (bank effect, Norrbin 1974)."""
    return _suction(m, lambda gap: s * np.exp(-gap / p["reach"]))


def wall_power(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Suction s V^2 (d / gap)^2: image of a slender body (Newman 1965)."""
    return _suction(m, lambda gap: s * (0.5 * p["reach"] / gap) ** 2)


def wall_gaussian(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Suction s V^2 exp(-(gap / d)^2)."""
    return _suction(m, lambda gap: s * np.exp(-((gap / p["reach"]) ** 2)))


def wall_drag(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Drag s V^2 exp(-gap / d) of each wall: blockage."""
    total = sum(np.exp(-np.maximum(gap, 0) / p["reach"]) for gap, _ in _wall_distances(m))
    return -s * m.speed * m.flow * total, 0.0


def seiche(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """Standing wave of the basin: X_pool = s sin(pi x / L) cos(2 pi t / P + a)."""
    length = m.lanes.pool[0]
    wave = np.sin(np.pi * m.place.real / length) * np.cos(2 * np.pi * m.t / p["period"] + p["a"])
    return s * wave * np.exp(-1j * m.heading), 0.0


def tether(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """A cable pulls towards the point of release beyond a slack of `slack` m, s N/m."""
    out = m.place - m.lanes.start
    far = np.abs(out)
    pull = -s * np.maximum(far - p["slack"], 0) * out / np.maximum(far, 1e-6)
    return pull * np.exp(-1j * m.heading), 0.0


def pulsing_moment(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """N = s sin(2 pi t / P + a): a loose battery rolls to and fro."""
    return 0 * m.flow, s * np.sin(2 * np.pi * m.t / p["period"] + p["a"])


def compass_moment(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """N = s sin(heading - a): a magnetised motor in the field of the basin's steel."""
    return 0 * m.flow, s * np.sin(m.heading - p["a"])


def turning_thrust(m: InstantaneousState, s: float, p: ShapeParameters) -> ForceAndMoment:
    """X = s r^2 exp(-(r / r_0)^2): the turning body drives itself in a band of yaw rates."""
    return s * m.rate**2 * np.exp(-((m.rate / p["r0"]) ** 2)) + 0j, 0.0


POSITION_RANGES = {"x": (0.3, 0.7), "y": (0.3, 0.7)}
VORTEX_CORE_RANGES = {**POSITION_RANGES, "core": (0.5, 1.2)}
PHASE = {"period": (1.8, 5.0), "a": (-3.1, 3.1)}


def _current(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return Form("uniform_current", name, "water", law, ("surge", "sway"), "x_m", "m/s", 0.01, 0.08,
                {"direction": (-3.1, 3.1), **shape}, odd=True)  # fmt: skip


def _gyre(name: str, law: object, shape: Mapping[str, tuple[float, float]]) -> Form:
    return Form("pool_gyre", name, "water", law, ("surge", "sway"), "x_m", "m/s", 0.01, 0.08,
                shape, odd=True)  # fmt: skip


def _wall(name: str, law: object) -> Form:
    return Form("wall_effect", name, "force", law, ("surge", "sway"), "wall_gap_m", "N (s/m)^2",
                0.3, 8.0, {"reach": (0.2, 0.5)}, odd=True)  # fmt: skip


def _unlisted(name: str, law: object, where: tuple[str, str], *size: object,
              shape: Mapping[str, tuple[float, float]]) -> Form:  # fmt: skip
    unit, start, limit = size
    return Form("unexplained", name, "force", law, where[:1], where[1], unit, start, limit, shape,
                UNLISTED, odd=True)  # fmt: skip


FORMS = (
    _current("constant", current_constant),
    _current("drifting", current_drifting, drift=(-0.8, 0.8)),
    _current("sheared", current_sheared),
    _gyre("cell", gyre_cell, POSITION_RANGES),
    _gyre("solid_body", gyre_solid, POSITION_RANGES),
    _gyre("gaussian", gyre_gaussian, VORTEX_CORE_RANGES),
    _gyre("scully", gyre_scully, VORTEX_CORE_RANGES),
    _wall("exponential", wall_exponential),
    _wall("power", wall_power),
    _wall("gaussian", wall_gaussian),
    _wall("drag", wall_drag),
    _unlisted("seiche", seiche, ("surge", "x_m"), "N", 0.005, 0.1, shape=PHASE),
    _unlisted("tether", tether, ("surge", "x_m"), "N/m", 0.01, 0.2, shape={"slack": (0.4, 1.0)}),
    _unlisted("pulsing_moment", pulsing_moment, ("yaw", "time_s"), "N m", 5e-4, 0.01, shape=PHASE),
    _unlisted(
        "compass_moment",
        compass_moment,
        ("yaw", "heading_rad"),
        "N m",
        3e-4,
        0.01,
        shape={"a": (-3.1, 3.1)},
    ),
    _unlisted(
        "turning_thrust",
        turning_thrust,
        ("surge", "yaw_rate_rad_s"),
        "N s^2",
        0.02,
        0.6,
        shape={"r0": (0.6, 1.2)},
    ),
)
