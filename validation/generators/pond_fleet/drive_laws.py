"""Motor, thrust and head servo."""

from __future__ import annotations

import numpy as np

from .flow import Flow, Load, pure_moment
from .law import Family, by_name
from .robots import Array

# --- thrust falls with speed; advance j = (u / f) / (U0 / f0) ---


def _advance(flow: Flow) -> Array:
    robot = flow.robot
    along, _ = flow.core
    per_beat = along / np.maximum(flow.flap, 0.02 * robot.flap)
    return np.clip(per_beat * robot.flap / robot.speed, 0.0, 2.0)


def falling_line(flow: Flow, size: Array, _: float) -> Array:
    """1 - c j: thrust line of a propeller (Carlton 2012, ch. 6)."""
    return 1 - size * _advance(flow)


def falling_parabola(flow: Flow, size: Array, _: float) -> Array:
    """1 - c j^2: reactive thrust by the wake's slip (Lighthill 1960)."""
    return 1 - size * _advance(flow) ** 2


def decaying(flow: Flow, size: Array, _: float) -> Array:
    """exp(-c j)."""
    return np.exp(-size * _advance(flow))


def actuator_disc(flow: Flow, size: Array, shape: float) -> Array:
    """Loss by the inflow of a disc of given power: 1 / (1 + c j) and its square."""
    lost = size * _advance(flow)
    return 1 / (1 + lost + (0.5 + shape) * lost**2)


def strouhal_window(flow: Flow, size: Array, shape: float) -> Array:
    """A bell about the best advance (Triantafyllou 1993), 0.3 to 0.6 of the cruising one."""
    best = 0.3 + 0.3 * shape
    return 1 - size * np.minimum(((_advance(flow) - best) / 0.6) ** 2, 1.0)


# --- thrust and head size: the published model makes it grow with the head's area ---


def _shorter(flow: Flow) -> Array:
    return flow.robot.head_length / flow.setting.head


def area_power(flow: Flow, size: Array, _: float) -> Array:
    """A^-c: thrust of the area to a power below one."""
    return _shorter(flow) ** size


def fixed_share(flow: Flow, size: Array, _: float) -> Array:
    """The share c of the thrust comes from the tail alone."""
    return 1 - size + size * _shorter(flow)


def shaded_tail(flow: Flow, size: Array, _: float) -> Array:
    """A longer head also disturbs the inflow of the tail."""
    return _shorter(flow) * (1 - 0.6 * size * (1 - _shorter(flow)))


def levelling(flow: Flow, size: Array, _: float) -> Array:
    """Growth that levels off exponentially with the added length."""
    longer = 1 / _shorter(flow) - 1
    return _shorter(flow) * (1 + (1 - size) * (1 - np.exp(-longer)))


# --- wake of own earlier turns ---


def _on_thrust(size: Array, met: Array) -> Array:
    return 1 - size * met


def logistic_turn(flow: Flow, size: Array, shape: float) -> Array:
    """Wake met after about half a turn or more, smoothly."""
    onset = np.pi * (0.7 + 0.5 * shape)
    return _on_thrust(size, 1 / (1 + np.exp(-(flow.turned - onset) / 0.3)))


def ramp_turn(flow: Flow, size: Array, _: float) -> Array:
    """Wake that fills in from half a turn to one turn."""
    return _on_thrust(size, np.clip(flow.turned / np.pi - 0.8, 0, 1))


def saturating_turn(flow: Flow, size: Array, _: float) -> Array:
    """Wake that has built up in proportion to its own decay."""
    return _on_thrust(size, 1 - np.exp(-((flow.turned / np.pi) ** 2)))


def ageing_wake(flow: Flow, size: Array, shape: float) -> Array:
    """Wake met after half a turn, weaker the longer the turn took."""
    age = flow.time / (flow.robot.body_time * (8 + 8 * shape))
    met = 1 / (1 + np.exp(-(flow.turned - 0.9 * np.pi) / 0.25))
    return _on_thrust(size, met * np.exp(-age))


# --- frequency of the shaft in the course of a trial ---


def _elapsed(flow: Flow) -> Array:
    return flow.time / flow.setting.duration


def linear_sag(flow: Flow, size: Array, _: float) -> Array:
    """Open-circuit voltage along the flat part of the discharge."""
    return 1 - size * _elapsed(flow)


def exponential_sag(flow: Flow, size: Array, _: float) -> Array:
    """Polarisation of one time constant."""
    return 1 - size * (1 - np.exp(-3 * _elapsed(flow)))


def hyperbolic_sag(flow: Flow, size: Array, _: float) -> Array:
    """1 / (1 + c t), Shepherd 1965."""
    return 1 / (1 + size * _elapsed(flow))


def two_stage_sag(flow: Flow, size: Array, _: float) -> Array:
    """A fast drop of an RC branch and a linear discharge (Chen and Rincon-Mora 2006)."""
    return 1 - size * (0.5 * (1 - np.exp(-9 * _elapsed(flow))) + 0.5 * _elapsed(flow))


def loaded_sag(flow: Flow, size: Array, _: float) -> Array:
    """Linear, in proportion to the current, which grows as f^2."""
    load = (flow.setting.flap / flow.robot.flap) ** 2
    return 1 - size * load * _elapsed(flow)


def _phase(flow: Flow, size: Array) -> Array:
    """Time over the rise time, which the size states in body times."""
    return flow.time / np.maximum(size * flow.robot.body_time, 1e-6)


def first_order_rise(flow: Flow, size: Array, _: float) -> Array:
    """Speed of a motor with inertia alone."""
    return 1 - np.exp(-_phase(flow, size))


def second_order_rise(flow: Flow, size: Array, _: float) -> Array:
    """Inertia and inductance: two equal time constants of half the size."""
    phase = 2 * _phase(flow, size)
    return 1 - (1 + phase) * np.exp(-phase)


def ramp_rise(flow: Flow, size: Array, _: float) -> Array:
    """Soft start of the speed controller."""
    return np.minimum(_phase(flow, size) / 2, 1.0)


def s_curve_rise(flow: Flow, size: Array, _: float) -> Array:
    """Soft start with limited jerk."""
    part = np.clip(_phase(flow, size) / 2, 0.0, 1.0)
    return part**2 * (3 - 2 * part)


def late_rise(flow: Flow, size: Array, _: float) -> Array:
    """Dead time of 0.4 of the size before a first-order rise."""
    return 1 - np.exp(-np.maximum(_phase(flow, size) - 0.4, 0) / 0.6)


# --- head servo: present head angle ---


def first_order_servo(flow: Flow, size: Array, _: float) -> Array:
    """Head starts straight and follows with one time constant."""
    return flow.phi * (1 - np.exp(-_phase(flow, size)))


def critical_servo(flow: Flow, size: Array, _: float) -> Array:
    """Critically damped position loop."""
    phase = 2 * _phase(flow, size)
    return flow.phi * (1 - (1 + phase) * np.exp(-phase))


def ringing_servo(flow: Flow, size: Array, shape: float) -> Array:
    """Underdamped loop, damping ratio 0.35 to 0.6."""
    damping = 0.35 + 0.25 * shape
    phase = 1.6 * _phase(flow, size)
    damped = np.sqrt(1 - damping**2)
    swing = np.cos(damped * phase) + damping / damped * np.sin(damped * phase)
    return flow.phi * (1 - np.exp(-damping * phase) * swing)


def slewing_servo(flow: Flow, size: Array, _: float) -> Array:
    """Constant slew rate: 30 degrees in twice the size."""
    reached = np.radians(30) * _phase(flow, size) / 2
    return np.sign(flow.phi) * np.minimum(np.abs(flow.phi), reached)


def late_servo(flow: Flow, size: Array, _: float) -> Array:
    """Dead time of the command link, then a quick first-order move."""
    late = np.maximum(_phase(flow, size) - 0.7, 0)
    return flow.phi * (1 - np.exp(-late / 0.3))


def fixed_offset(flow: Flow, size: Array, _: float) -> Array:
    """Servo horn mounted askew; size in rad."""
    return flow.phi + size


def offset_with_gain(flow: Flow, size: Array, shape: float) -> Array:
    """Askew horn and a linkage whose gain is off by up to 4 %."""
    return flow.phi * (1 + 0.08 * (shape - 0.5)) + size


def one_sided_play(flow: Flow, size: Array, _: float) -> Array:
    """Backlash taken up on one side alone: the offset vanishes at angles to starboard."""
    return flow.phi + 1.3 * size / (1 + np.exp(-flow.phi / np.radians(4)))


def creeping_zero(flow: Flow, size: Array, _: float) -> Array:
    """A zero that has crept away by the middle of the session."""
    return flow.phi + size * np.minimum(0.5 + flow.setting.order, 1.0)


# --- thrust past the centre of mass when the head is turned; lever = c L times a function ---


def _lever(flow: Flow, size: Array, turned: Array) -> Load:
    return pure_moment(-size * flow.robot.body_length * flow.thrust * turned)


def sine_lever(flow: Flow, size: Array, _: float) -> Load:
    """sin(phi): the line of thrust swings about the hinge."""
    return _lever(flow, size, np.sin(flow.phi))


def proportional_lever(flow: Flow, size: Array, _: float) -> Load:
    """phi: bending spread along a soft core."""
    return _lever(flow, size, flow.phi)


def double_sine_lever(flow: Flow, size: Array, _: float) -> Load:
    """sin(2 phi) / 2: a four-bar linkage."""
    return _lever(flow, size, 0.5 * np.sin(2 * flow.phi))


def limited_lever(flow: Flow, size: Array, _: float) -> Load:
    """tanh: skin folds that stop the bending at about 20 degrees."""
    bend = np.radians(20)
    return _lever(flow, size, bend * np.tanh(flow.phi / bend))


DRIVE_FAMILIES = (
    Family("thrust_loss_with_speed", "thrust", "loss at the cruising advance", "1", 0.02, 0.7,
           by_name(falling_line, falling_parabola, decaying, actuator_disc, strouhal_window)),
    Family("thrust_area", "thrust", "share of thrust that does not grow", "1", 0.1, 1.0,
           by_name(area_power, fixed_share, shaded_tail, levelling)),
    Family("wake_reentry", "thrust", "share of thrust lost in the wake", "1", 0.03, 0.5,
           by_name(logistic_turn, ramp_turn, saturating_turn, ageing_wake)),
    Family("battery_sag", "shaft", "fall of frequency in a trial", "1", 0.01, 0.35,
           by_name(linear_sag, exponential_sag, hyperbolic_sag, two_stage_sag, loaded_sag)),
    Family("motor_spin_up", "shaft", "rise time in body times", "1", 0.1, 2.0,
           by_name(first_order_rise, second_order_rise, ramp_rise, s_curve_rise, late_rise)),
    Family("servo_lag", "servo", "lag in body times", "1", 0.1, 2.5,
           by_name(first_order_servo, critical_servo, ringing_servo, slewing_servo, late_servo)),
    Family("head_angle_offset", "servo", "offset", "rad", 0.004, 0.14,
           by_name(fixed_offset, offset_with_gain, one_sided_play, creeping_zero), odd=True),
    Family("thrust_line_offset", "load", "lever over body length", "1", 0.005, 0.2,
           by_name(sine_lever, proportional_lever, double_sine_lever, limited_lever)),
)  # fmt: skip
