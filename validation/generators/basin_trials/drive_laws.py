"""Laws of motor, battery and servo: flapping frequency and head angle as functions of time."""

from __future__ import annotations

import numpy as np

from .form import HiddenLaw, Situation


def motor_spin_up(now: Situation, law: HiddenLaw) -> None:
    """Frequency that rises in k seconds, s = t/k: 1 - exp(-(1.3 s)^p) and variants.

    Weibull (1951), Gompertz (1825) exp(-3.5 exp(-3 s)), or a ramp that ends in a relaxation.
    """
    s = np.maximum(now.t, 0.0) / law.size
    if law.form == "weibull":
        now.f = now.f * (1 - np.exp(-((1.3 * s) ** (1.3 + 0.7 * law.shape[0]))))
    elif law.form == "gompertz":
        rise = np.exp(-3.5 * np.exp(-3.0 * s)) - np.exp(-3.5)
        now.f = now.f * rise / (1 - np.exp(-3.5))
    else:
        now.f = now.f * np.where(s < 0.6, s, 1 - 0.4 * np.exp(-np.maximum(s - 0.6, 0) / 0.4))


def battery_sag(now: Situation, law: HiddenLaw) -> None:
    """Thrust that falls by the share k in 5 s.

    Shepherd (1965): k (t/5) (11/6) / (1 + t/6). relaxing: 1 - exp(-t/tau). load: in proportion to
    f^1.5. late: t^1.6.
    """
    t, k = np.maximum(now.t, 0.0), law.size
    if law.form == "shepherd":
        loss = k * (t / 5) * (1 + 5 / 6) / (1 + t / 6)
    elif law.form == "relaxing":
        tau = 1.5 + 2 * law.shape[0]
        loss = k * (1 - np.exp(-t / tau)) / (1 - np.exp(-5 / tau))
    elif law.form == "load":
        loss = k * (t / 5) * (now.runs.flap / 4) ** 1.5
    else:
        loss = k * (t / 5) ** 1.6
    now.f = now.f * np.sqrt(np.clip(1 - loss, 0.2, 1))


def servo_lag(now: Situation, law: HiddenLaw) -> None:
    """Head angle that is reached after about k seconds.

    quintic: s^3 (10 - 15 s + 6 s^2), s = t / (1.3 k). second_order: damping 0.4 to 0.7, natural
    frequency 3/k. slew_rate: 40 degrees in k seconds.
    """
    t, k = np.maximum(now.t, 0.0), law.size
    if law.form == "quintic":
        s = np.clip(t / (1.3 * k), 0, 1)
        share = s**3 * (10 - 15 * s + 6 * s * s)
    elif law.form == "second_order":
        zeta, omega = 0.4 + 0.3 * law.shape[0], 3.0 / k
        root = omega * np.sqrt(1 - zeta**2)
        swing = np.cos(root * t) + zeta * omega / root * np.sin(root * t)
        share = 1 - np.exp(-zeta * omega * t) * swing
    else:
        rate = np.radians(40) / k
        share = np.clip(rate * t / np.maximum(np.abs(now.command), 1e-6), 0, 1)
    now.phi = now.phi * share


def head_angle_offset(now: Situation, law: HiddenLaw) -> None:
    """Head angle with the error k rad: constant, k cos(1.2 phi), or different on the two sides."""
    if law.form == "constant":
        now.phi = now.phi + law.size
    elif law.form == "bent_horn":
        now.phi = now.phi + law.size * np.cos(1.2 * now.command)
    else:
        now.phi = now.phi + law.size * (0.75 + 0.45 * np.tanh(now.command / 0.15))
