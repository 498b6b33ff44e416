"""Thrust and motor laws: loss with speed, head area, spin-up, sagging battery."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form


def _advance(w: Any) -> Any:
    """Advance ratio, one at the typical speed and frequency of steady straight swimming."""
    f0 = w.sc.frequency * 0.7
    return (w.speed / w.sc.speed) / (w.f / f0 + 0.05)


@form("thrust_loss_with_speed", "linear_advance", "force", 0.1, 0.6)
def _(w: Any, p: dict[str, float]) -> None:
    """Propeller-like fall of thrust, linear in the advance ratio."""
    w.thrust = w.thrust * (1 - p["amp"] * np.minimum(_advance(w), 1.6))


@form("thrust_loss_with_speed", "square_advance", "force", 0.1, 0.5)
def _(w: Any, p: dict[str, float]) -> None:
    """Elongated-body fall of thrust with the square of the advance ratio."""
    w.thrust = w.thrust * (1 - p["amp"] * np.minimum(_advance(w), 1.6) ** 2)


@form("thrust_loss_with_speed", "actuator_disc", "force", 0.15, 2.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Momentum theory at fixed power: thrust falls hyperbolically with speed."""
    w.thrust = w.thrust / (1 + p["amp"] * _advance(w))


@form(
    "thrust_loss_with_speed",
    "strouhal_window",
    "force",
    0.1,
    0.6,
    centre=(0.6, 0.9),
    width=(0.1, 0.3),
)
def _(w: Any, p: dict[str, float]) -> None:
    """A share of the thrust is lost when the Strouhal number falls below a window."""
    step = 0.5 * (1 + np.tanh((_advance(w) - p["centre"]) / p["width"]))
    w.thrust = w.thrust * (1 - p["amp"] * step)


@form("thrust_area", "power_of_area", "force", 0.3, 1.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Thrust grows with a fractional power of the head area."""
    w.thrust = w.thrust * (w.k.head / w.rb.head) ** (-p["amp"])


@form("thrust_area", "shared_with_tail", "force", 0.3, 1.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Only a share of the thrust follows the head area; the rest belongs to the tail."""
    w.thrust = w.thrust * (1 - p["amp"] + p["amp"] * w.rb.head / w.k.head)


@form("thrust_area", "saturating_area", "force", 0.5, 4.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Thrust levels off as the head grows."""
    s = w.k.head / w.rb.head
    w.thrust = w.thrust * (1 + p["amp"]) / (1 + p["amp"] * s)


@form("thrust_area", "fixed_above_size", "force", 0.5, 1.0, size=(0.9, 1.1))
def _(w: Any, p: dict[str, float]) -> None:
    """Head plates beyond a size add little thrust."""
    s = w.k.head / w.rb.head
    over = np.maximum(s - p["size"], 0) + np.minimum(s - p["size"], 0) * 0.4
    w.thrust = w.thrust * (1 - p["amp"] * over / s)


@form("motor_spin_up", "first_order", "command", 0.3, 3.0, floor=(0.0, 0.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Exponential approach to the steady frequency after a start from rest."""
    t = np.maximum(w.t - w.k.t_on, 0)
    gain = 1 - (1 - p["floor"]) * np.exp(-t / (p["amp"] * w.sc.time))
    w.f_gain = w.f_gain * np.where(w.k.rest > 0, gain, 1.0)


@form("motor_spin_up", "linear_ramp", "command", 0.5, 4.0, floor=(0.0, 0.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Drive ramp of constant slope."""
    t = np.maximum(w.t - w.k.t_on, 0)
    gain = p["floor"] + (1 - p["floor"]) * np.clip(t / (p["amp"] * w.sc.time), 0, 1)
    w.f_gain = w.f_gain * np.where(w.k.rest > 0, gain, 1.0)


@form("motor_spin_up", "s_curve", "command", 0.5, 4.0)
def _(w: Any, p: dict[str, float]) -> None:
    """S-shaped soft start."""
    s = np.clip(np.maximum(w.t - w.k.t_on, 0) / (p["amp"] * w.sc.time), 0, 1)
    w.f_gain = w.f_gain * np.where(w.k.rest > 0, s * s * (3 - 2 * s), 1.0)


@form("motor_spin_up", "loaded_motor", "command", 0.3, 2.0, slope=(0.5, 1.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Spin-up against quadratic load (tanh), slower at high power."""
    tau = p["amp"] * w.sc.time * (w.k.power / 70.0) ** p["slope"]
    gain = np.tanh(np.maximum(w.t - w.k.t_on, 0) / tau)
    w.f_gain = w.f_gain * np.where(w.k.rest > 0, gain, 1.0)


@form("battery_sag", "linear", "command", 0.05, 0.4)
def _(w: Any, p: dict[str, float]) -> None:
    """Frequency falls linearly during a trial."""
    w.f_gain = w.f_gain * (1 - p["amp"] * np.maximum(w.t - w.k.t_on, 0) / w.world.duration)


@form("battery_sag", "relaxation", "command", 0.05, 0.3, tau=(0.15, 0.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Voltage relaxes to a plateau under load."""
    s = np.maximum(w.t - w.k.t_on, 0) / (p["tau"] * w.world.duration)
    w.f_gain = w.f_gain * (1 - p["amp"] * (1 - np.exp(-s)))


@form("battery_sag", "diffusion", "command", 0.05, 0.3)
def _(w: Any, p: dict[str, float]) -> None:
    """Ion diffusion: frequency falls as the root of time, more at high power."""
    s = np.maximum(w.t - w.k.t_on, 0) / w.world.duration
    w.f_gain = w.f_gain * (1 - p["amp"] * np.sqrt(s + 1e-4) * w.k.power / 70.0)


@form("battery_sag", "tired_pack", "command", 0.1, 0.5, ageing=(0.6, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Faster sag in later trials of the session and at high power."""
    s = np.maximum(w.t - w.k.t_on, 0) / w.world.duration
    age = 1 - p["ageing"] + p["ageing"] * w.k.order
    w.f_gain = w.f_gain * (1 - p["amp"] * age * s * (w.k.power / 70.0) ** 2)
