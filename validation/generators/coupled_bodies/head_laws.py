"""Flow about the head: stall, lag of the lift, unequal sides, trim, lines of action."""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .articulated import head_moment
from .form import Form, form_maker

Array = NDArray[np.float64]
ShapeParameters = Any


def folded_angle_of_attack(c: SimpleNamespace) -> Array:
    """Angle of attack folded into 0 to 90 deg, rad."""
    return np.arcsin(np.minimum(np.abs(np.sin(c.alpha)), 1))


def plate_lift(c: SimpleNamespace) -> Array:
    """Lift of the published plate, N."""
    return c.q * c.lanes.coef[3] * np.sin(2 * c.alpha)


def _lost_lift(c: SimpleNamespace, share: Array, drag: Array | float = 0.0) -> tuple[Any, Array]:
    """Force and moment of a loss of lift and a gain of drag (share of the lost lift)."""
    loss = share * plate_lift(c)
    F = c.along * (-1j * loss - drag * np.abs(loss))
    return F, head_moment(c, F)


def _logistic(c: SimpleNamespace, p: ShapeParameters) -> Array:
    """Separated share of the chord at rest in the flow, 0 to 1."""
    return 1 / (
        1
        + np.exp(
            -(folded_angle_of_attack(c) - np.deg2rad(p["onset_deg"])) / np.deg2rad(p["width_deg"])
        )
    )


def stall_logistic(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Blend to a share 1 - s of the lift (Beard and McLain 2012, eq. 4.9)."""
    return _lost_lift(c, s * _logistic(c, p))


def stall_kirchhoff(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """((1 + sqrt f)/2)^2 with attached share f (Thwaites 1960; Leishman and Beddoes 1989)."""
    kept = ((1 + np.sqrt(1 - _logistic(c, p))) / 2) ** 2
    return _lost_lift(c, s * (1 - kept) / 0.75)


def stall_viterna(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift held at its value at the onset, with rising drag (Viterna and Corrigan 1981)."""
    onset = np.deg2rad(p["onset_deg"])
    over = folded_angle_of_attack(c) > onset
    ratio = (
        np.sin(2 * onset)
        * np.cos(folded_angle_of_attack(c)) ** 2
        / np.maximum(np.sin(folded_angle_of_attack(c)), 0.05)
    )
    ratio = ratio * np.sin(onset) / np.cos(onset) ** 2
    kept = np.where(over, ratio / np.maximum(np.sin(2 * folded_angle_of_attack(c)), 0.05), 1)
    return _lost_lift(c, s * (1 - np.minimum(kept, 1)), drag=0.3)


def stall_moment(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift and, with the centre of pressure, the moment are lost."""
    F, N = _lost_lift(c, s * _logistic(c, p))
    return F, N - s * _logistic(c, p) * c.q * c.lanes.coef[4] * np.sin(2 * c.alpha)


def stall_goman(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array, Array]:
    """Separation x' = (x_0(alpha) - x)/tau_1, tau_1 in chords (Goman and Khrabrov 1994)."""
    x = c.memory[0]
    kept = ((1 + np.sqrt(np.clip(1 - x, 0, 1))) / 2) ** 2
    rate = (_logistic(c, p) - x) * _chord_passing_rate(c, p["chords"])
    return *_lost_lift(c, s * (1 - kept) / 0.75), np.stack([rate, 0 * rate])


def _chord_passing_rate(c: SimpleNamespace, chords: float) -> Array:
    """1/s in which the flow covers some lengths of the head."""
    return c.V / (chords * c.head) + 0.05


def _lift_memory(c: SimpleNamespace, s: Array, goal: Array, weights: tuple[float, float],
            paces: tuple[float, float]) -> tuple[Any, Array, Array]:  # fmt: skip
    """Lift short by s sum A_i (goal - z_i), z_i following the goal."""
    short = [goal - z for z in c.memory]
    lag = weights[0] * short[0] + weights[1] * short[1]
    F = -1j * c.along * s * lag
    follow = [d * _chord_passing_rate(c, pace) for d, pace in zip(short, paces, strict=True)]
    return F, head_moment(c, F), np.stack(follow)


def lag_first(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array, Array]:
    """A share s of the lift follows with a constant number of chords."""
    return _lift_memory(c, s, plate_lift(c), (1.0, 0.0), (p["chords"], 1.0))


def lag_wagner(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array, Array]:
    """1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s), s in half chords (Jones 1940, TR 681)."""
    return _lift_memory(c, 2 * s, plate_lift(c), (0.165, 0.335), (1 / 0.091, 1 / 0.6))


def lag_kussner(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array, Array]:
    """1 - exp(-0.13 s)/2 - exp(-s)/2, entry into a gust (Sears 1940)."""
    return _lift_memory(c, s, plate_lift(c), (0.5, 0.5), (1 / 0.26, 0.5))


def lag_coefficient(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array, Array]:
    """Not the lift but its coefficient follows; pressure of the flow acts at once."""
    goal = c.lanes.coef[3] * np.sin(2 * c.alpha)
    F, N, follow = _lift_memory(c, s, goal, (1.0, 0.0), (p["chords"], 1.0))
    return F * c.q, N * c.q, follow


def asymmetry_step(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift s weaker for flow from one side."""
    return _lost_lift(c, s * np.tanh(np.sin(c.alpha) / 0.005))


def asymmetry_tanh(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift s tanh(alpha/alpha_0) weaker."""
    return _lost_lift(c, s * np.tanh(c.alpha / np.deg2rad(p["scale_deg"])))


def asymmetry_beyond_onset(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Only at angles above an onset, on one side."""
    return _lost_lift(c, s * _logistic(c, p) * np.sign(c.alpha))


def asymmetry_with_drag(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift and drag differ between the sides: a plate bent to one side (camber)."""
    F = (
        -s
        * c.along
        * c.q
        * (
            0.5j * c.lanes.coef[3] * np.abs(np.sin(2 * c.alpha))
            + c.lanes.coef[2] * np.sin(c.alpha) * np.abs(np.sin(c.alpha))
        )
    )
    return F, head_moment(c, F)


def trim_square(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = s (V/0.3 m/s)^2."""
    return 0j, s * (c.V / 0.3) ** 2


def trim_forward(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = s u|u|, u at 0.3 m/s."""
    return 0j, s * c.u * np.abs(c.u) / 0.09


def trim_thrust(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Thrust beside the axis, N = T d with d scaled at 0.1 N."""
    return 0j, s * c.thrust / 0.1


def trim_linear(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = s V, a cable that drags on one side."""
    return 0j, s * c.V / 0.3


def thrust_line_sine(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = T s sin phi: thrust turns about a point off the centre of mass."""
    return 0j, -s * c.thrust * np.sin(c.phi)


def thrust_line_linear(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = T s phi."""
    return 0j, -s * c.thrust * c.phi


def thrust_line_double_angle(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = T s sin(2 phi)/2: the tail is turned with the core and offset sideways."""
    return 0j, -s * c.thrust * np.sin(2 * c.phi) / 2


def mass_shift_fixed(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """The centre of mass lies s behind its label."""
    return s


def mass_shift_with_angle(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """It moves back as the head turns: s (1 - cos phi)/(1 - cos 45 deg)."""
    return s * (1 - np.cos(c.phi)) / (1 - np.cos(np.pi / 4))


def mass_shift_with_head(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Array:
    """Ballast for the longer head: back by s where the head is 1.5 times as long."""
    return s * (c.head / c.robot.head_length - 1) / 0.5


_stall = form_maker("stall", "force", "1", ("sway", "yaw", "surge"))
_goman = form_maker("stall", "memory", "1", ("sway", "yaw", "surge"))
_lag = form_maker("lift_lag", "memory", "1", ("sway", "yaw"))
_sides = form_maker("port_starboard_asymmetry", "force", "1", ("sway", "yaw"), signed=True)
_trim = form_maker("trim_moment", "force", "N m", ("yaw",), signed=True)
_line = form_maker("thrust_line_offset", "force", "m", ("yaw",), signed=True)
_com = form_maker("centre_of_mass_shift", "mass", "m", ("yaw",))
STALL_ONSET_RANGES = {"onset_deg": (8.0, 16.0), "width_deg": (1.5, 3.0)}
FORMS: tuple[Form, ...] = (
    _stall("logistic", stall_logistic, 0.01, 0.9, **STALL_ONSET_RANGES),
    _stall("kirchhoff", stall_kirchhoff, 0.01, 0.9, **STALL_ONSET_RANGES),
    _stall("viterna", stall_viterna, 0.01, 1, onset_deg=(8.0, 14.0)),
    _stall("moment", stall_moment, 0.01, 0.9, **STALL_ONSET_RANGES),
    _goman("goman_khrabrov", stall_goman, 0.01, 0.9, **STALL_ONSET_RANGES, chords=(0.5, 3.0)),
    _lag("first_order", lag_first, 0.01, 1, chords=(1.0, 5.0)),
    _lag("wagner", lag_wagner, 0.01, 1),
    _lag("kussner", lag_kussner, 0.01, 1),
    _lag("coefficient", lag_coefficient, 0.01, 1, chords=(1.0, 5.0)),
    _sides("step", asymmetry_step, 0.002, 0.5),
    _sides("tanh", asymmetry_tanh, 0.002, 0.5, scale_deg=(4.0, 10.0)),
    _sides("late", asymmetry_beyond_onset, 0.002, 0.8, onset_deg=(6.0, 12.0), width_deg=(1.5, 3.0)),
    _sides("camber", asymmetry_with_drag, 0.002, 0.5),
    _trim("square", trim_square, 2e-6, 0.02),
    _trim("forward", trim_forward, 2e-6, 0.02),
    _trim("thrust", trim_thrust, 2e-6, 0.02),
    _trim("linear", trim_linear, 2e-6, 0.02),
    _line("sine", thrust_line_sine, 1e-4, 0.06),
    _line("angle", thrust_line_linear, 1e-4, 0.06),
    _line("double", thrust_line_double_angle, 1e-4, 0.06),
    _com("fixed", mass_shift_fixed, 5e-4, 0.05),
    _com("with_angle", mass_shift_with_angle, 5e-4, 0.05),
    _com("with_head", mass_shift_with_head, 5e-4, 0.05),
)
