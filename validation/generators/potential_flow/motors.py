"""Laws of servo, motor and thrust in time and speed."""

from __future__ import annotations

import numpy as np

# Servo: the head angle (rad) in time. The command comes shortly before the motor starts, so that
# the share k of the angle is still to come at t = 0.


def servo_first_order(s, k, p):
    """Angle phi (1 - k e^(-t/tau))."""
    return s.command * (1 - k * np.exp(-s.t / p["tau"]))


def servo_second_order(s, k, p):
    """Angle phi (1 - k (1 + t/tau) e^(-t/tau)): second order, critically damped."""
    return s.command * (1 - k * (1 + s.t / p["tau"]) * np.exp(-s.t / p["tau"]))


def servo_underdamped(s, k, p):
    """Second order with damping ratio z: 1 - k e^(-z t/tau) (cos + z/sqrt(1 - z^2) sin)."""
    z = p["damping"]
    wave = np.sqrt(1 - z**2) * s.t / p["tau"]
    ring = np.cos(wave) + z / np.sqrt(1 - z**2) * np.sin(wave)
    return s.command * (1 - k * np.exp(-z * s.t / p["tau"]) * ring)


def servo_rate_limited(s, k, p):
    """The share k comes at a constant rate within the time 2 tau."""
    return s.command * (1 - k * np.maximum(1 - s.t / (2 * p["tau"]), 0))


def servo_dead_time(s, k, p):
    """The share k waits for tau, then comes as first order with tau/2."""
    late = np.maximum(s.t - p["tau"], 0) / (0.5 * p["tau"])
    return s.command * (1 - k * np.exp(-late))


def offset_constant(s, k, _):
    """Angle phi + k (rad)."""
    return s.command + k + 0 * s.t


def offset_gain(s, k, _):
    """Angle phi (1 + k)."""
    return s.command * (1 + k) + 0 * s.t


def offset_backlash(s, k, _):
    """A turned head is pushed back by k (rad) within its play; a straight one is not."""
    return s.command - k * np.sign(np.round(s.command, 6)) + 0 * s.t


# Motor: factor of the flapping frequency.


def spin_up_first_order(s, k, _):
    """1 - e^(-t/k)."""
    return 1 - np.exp(-s.t / k)


def spin_up_critically_damped(s, k, _):
    """1 - (1 + t/k) e^(-t/k)."""
    return 1 - (1 + s.t / k) * np.exp(-s.t / k)


def spin_up_ramp(s, k, _):
    """Linear in time up to 2 k."""
    return np.minimum(s.t / (2 * k), 1)


def spin_up_s_curve(s, k, _):
    """3 x^2 - 2 x^3, x = t / (2 k)."""
    x = np.minimum(s.t / (2 * k), 1)
    return x**2 * (3 - 2 * x)


def sag_linear(s, k, _):
    """Falls by k in 8 s."""
    return 1 - k * s.t / 8


def sag_exponential(s, k, p):
    """Falls by k with the time constant tau."""
    return 1 - k * (1 - np.exp(-s.t / p["tau"]))


def sag_hyperbolic(s, k, p):
    """1 / (1 + k t / tau)."""
    return 1 / (1 + k * s.t / p["tau"])


def sag_load_dependent(s, k, _):
    """Falls by k in 8 s at full power, with the square of the power."""
    return 1 - k * (s.power / 100) ** 2 * s.t / 8


# Thrust: factor of the thrust.


def advance_ratio(s):
    """Speed ahead along the core over frequency and tail length, u / (f l)."""
    return np.maximum(s.core.real, 0) / (s.flap * s.craft.tail_length + 1e-3)


def thrust_loss_linear(s, k, _):
    """1 - k J (propeller in open water)."""
    return 1 - k * advance_ratio(s)


def thrust_loss_quadratic(s, k, _):
    """1 - k J^2 (momentum of the slipstream; Lighthill's reactive thrust)."""
    return 1 - k * advance_ratio(s) ** 2


def thrust_loss_exponential(s, k, _):
    """e^(-k J)."""
    return np.exp(-k * advance_ratio(s))


def thrust_loss_strouhal(s, k, p):
    """Falls by k beyond the advance ratio J_0 (below a Strouhal number)."""
    return 1 - k * 0.5 * (1 + np.tanh((advance_ratio(s) - p["J_0"]) / 0.15))


def _area_ratio(s):
    return s.head / s.craft.head_length


def thrust_area_blend(s, k, _):
    """Effective area A_0 + (1 - k)(A - A_0): grows less than the head."""
    g = _area_ratio(s)
    return (1 + (1 - k) * (g - 1)) / g


def thrust_area_power(s, k, _):
    """Effective area A_0 (A/A_0)^(1 - k)."""
    return _area_ratio(s) ** -k


def thrust_area_harmonic(s, k, _):
    """1/A_eff = (1 - k)/A + k/A_0."""
    g = _area_ratio(s)
    return 1 / (1 - k + k * g)


def wake_logistic(s, k, p):
    """Falls by k once the robot has turned by `turn` (rad)."""
    return 1 - k * 0.5 * (1 + np.tanh((np.abs(s.turned) - p["turn"]) / 0.3))


def wake_ramp(s, k, p):
    """Falls by k per rad beyond `turn`, at most to a fifth."""
    return np.maximum(1 - k * np.maximum(np.abs(s.turned) - p["turn"], 0), 0.2)


def wake_saturating(s, k, p):
    """1 - k (1 - e^(-(turned/turn)^2))."""
    return 1 - k * (1 - np.exp(-((s.turned / p["turn"]) ** 2)))


def wake_decay_with_age(s, k, p):
    """Falls beyond `turn`, less so where the wake is old: e^(-t/15 s)."""
    met = 0.5 * (1 + np.tanh((np.abs(s.turned) - p["turn"]) / 0.4))
    return 1 - k * met * np.exp(-s.t / 15.0)
