"""Head angle and flapping frequency as functions of time."""

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.parameters import KEYS

Floats = NDArray[np.float64]


def head_angle(t: Floats, command: float, error: float, P: Floats) -> Floats:
    """Actual head angle (rad) at `t` (s) after the command; `error` is the servo's (rad).

    Lag forms, strength tau: 1 first order; 2 rate limit (a 30 degree command takes tau);
    3 critically damped second order; 4 dead time tau/2, then first order tau/2 (Pade-type servo).
    Offset: 1 constant; 2 backlash, the same loss towards either side.
    """
    tau, form = P[KEYS.SERVO], P[KEYS.SERVO_FORM]
    share = np.ones_like(t)
    if tau > 0.0:
        t = np.maximum(t, 0.0)
        if form == 1:
            share = 1.0 - np.exp(-t / tau)
        elif form == 2:
            duration = tau * max(abs(command), 0.02) / np.radians(30.0)
            share = np.clip(t / duration, 0.0, 1.0)
        elif form == 3:
            share = 1.0 - (1.0 + 2.0 * t / tau) * np.exp(-2.0 * t / tau)
        else:
            share = 1.0 - np.exp(-np.maximum(t - 0.5 * tau, 0.0) / (0.5 * tau))
    offset = P[KEYS.OFF] * (np.sign(command) if P[KEYS.OFF_FORM] == 2 else 1.0)
    return command * share + offset + error


def flapping_frequency(t: Floats, f: float, P: Floats) -> Floats:
    """Flapping frequency (Hz) at `t` (s) since the motor was switched on; zero before.

    Spin-up: 1 first order (DC motor, electromechanical time constant); 2 ramp of the controller;
    3 tanh (quadratic load). Sag: 1 linear in time; 2 exponential; 3 square root of time (diffusion
    in the cell); 4 ohmic drop with slow recovery.
    """
    since = np.maximum(t, 0.0)
    tau, form = P[KEYS.SPIN], P[KEYS.SPIN_FORM]
    share = np.ones_like(t)
    if tau > 0.0:
        ramp = np.minimum(since / (2.0 * tau), 1.0)
        share = {1: 1.0 - np.exp(-since / tau), 2: ramp, 3: np.tanh(since / tau)}[int(form)]
    sag, form, slow = P[KEYS.SAG], P[KEYS.SAG_FORM], P[KEYS.SAG_TAU]
    if sag > 0.0:
        fall = {1: since / 6.0, 2: 1.0 - np.exp(-since / slow), 3: np.sqrt(since / 6.0),
                4: (1.0 - np.exp(-since / 0.3)) * (0.4 + 0.6 * np.exp(-since / slow))}  # fmt: skip
        share = share * (1.0 - sag * np.minimum(fall[int(form)], 1.5))
    return np.where(t >= 0.0, f * share, 0.0)
