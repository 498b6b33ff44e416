"""Laws that change lift, moment or thrust of the published model, or the centre of mass."""

from __future__ import annotations

import numpy as np

from .form import HiddenLaw, Quantity, Situation
from .robots import Robot


def separated_share(alpha: Quantity, law: HiddenLaw) -> Quantity:
    """Share of the lift lost if all of it could be lost: a^6 / (a^6 + a_0^6), a = |alpha|.

    beddoes: Kirchhoff's lift with the separation point fitted by Leishman and Beddoes (1989).
    The onset a_0 is 13 to 22 degrees. A plate at 180 degrees is one at 0 degrees.
    """
    a = np.abs(np.angle(np.exp(2j * alpha))) / 2
    onset = np.radians(13 + 9 * law.shape[0])
    if law.form == "beddoes":
        low = 1 - 0.3 * np.exp(np.minimum(a - onset, 0) / 0.06)
        high = 0.04 + 0.66 * np.exp(np.minimum(onset - a, 0) / 0.08)
        attached = np.where(a < onset, low, high)
        return (1 - ((1 + np.sqrt(attached)) / 2) ** 2) / 0.64
    s = (a / onset) ** 6
    return s / (1 + s)


def stall(now: Situation, law: HiddenLaw) -> None:
    """Lift (and moment) of the head less the share k of what is separated."""
    loss = law.size * separated_share(now.alpha, law)
    now.lift_factor = now.lift_factor * (1 - loss)
    if law.form == "hill_and_moment":
        now.moment_factor = now.moment_factor * (1 - loss)


def lift_lag(now: Situation, law: HiddenLaw) -> None:
    """Lift of which the share k follows with a lag of 2.5 to 6.5 head lengths.

    circulation: the product of speed and sine follows. fixed_time: 0.15 to 0.4 s.
    """
    lengths = 2.5 + 4 * law.shape[0]
    sine, speed = now.lift_sine, np.maximum(now.speed, 0.02)
    lagging = now.lag
    if law.form == "fixed_time":
        now.lag_rate = (sine - now.lag) / (0.15 + 0.25 * law.shape[0])
    elif law.form == "circulation":
        now.lag_rate = (now.speed * sine - now.lag) * now.speed / (lengths * now.head)
        lagging = now.lag / speed
    else:
        now.lag_rate = (sine - now.lag) * now.speed / (lengths * now.head)
    now.lift_sine = (1 - law.size) * sine + law.size * lagging


def port_starboard_asymmetry(now: Situation, law: HiddenLaw) -> None:
    """Lift to port 1 + k times, to starboard 1 - k times that of a symmetric head."""
    proportional = law.form == "proportional"
    side = now.lift_sine / 0.5 if proportional else np.tanh(now.lift_sine / 0.15)
    now.lift_factor = now.lift_factor * (1 + law.size * side)
    if law.form == "with_drag":
        now.drag_factor = now.drag_factor * (1 + 0.8 * law.size * side)


def thrust_loss_with_speed(now: Situation, law: HiddenLaw) -> None:
    """Thrust that loses up to the share k as the advance J = u/f (m) grows past about a stride.

    logistic: width 0.018 m. rational: J^3 / (J^3 + J_0^3). gaussian: 1 - exp(-(J/J_0)^4 / 1.4).
    """
    advance, middle = np.maximum(now.u, 0) / np.maximum(now.f, 0.2), 0.06 + 0.03 * law.shape[0]
    advance = np.minimum(advance, 0.3)
    if law.form == "logistic":
        at_rest = 1 / (1 + np.exp(middle / 0.018))
        gone = 1 / (1 + np.exp(-(advance - middle) / 0.018)) - at_rest
    elif law.form == "rational":
        gone = advance**3 / (advance**3 + middle**3)
    else:
        gone = 1 - np.exp(-((advance / middle) ** 4) / 1.4)
    now.thrust_factor = now.thrust_factor * (1 - law.size * gone)


def thrust_area(now: Situation, law: HiddenLaw) -> None:
    """Thrust that grows less than the area: times (A1/A)^k, or 1 / (1 + k (A/A1 - 1))."""
    ratio, k = now.head / now.robot.head_length, law.size
    factor = ratio**-k if law.form == "power" else 1 / (1 + k * (ratio - 1))
    now.thrust_factor = now.thrust_factor * factor


def mass_shift(robot: Robot, head: Quantity, law: HiddenLaw) -> Quantity:
    """Shift of the centre of mass towards the head, m; with_cap: it grows with the head length."""
    if law.form == "fixed":
        return law.size + 0 * head
    return law.size * (0.5 + 2.0 * (head / robot.head_length - 1))


def centre_of_mass_shift(now: Situation, law: HiddenLaw) -> None:
    """Centre of mass that lies about k m nearer to the head than stated."""
    now.shift = mass_shift(now.robot, now.head, law)
