"""Thrust that falls during a trial with the supply voltage.

At the time t since the start of the trial, the thrust T changes by

    dT = -k T (f / f_1)^e (1 - exp(-w t)) / w,   f_1 = 3.5 Hz

- k: relative loss of thrust per second (1/s) at first, at the flapping frequency f = f_1;
- w: rate at which the voltage settles under load (1/s). Later, dT therefore approaches -k T / w (at
  f = f_1). With w = 0, dT is -k t T at all times;
- e: exponent of the frequency. With e > 0, the relative loss dT / T is larger at a higher flapping
  frequency.

Thrust is proportional to f^2, with the flapping frequency f. In a motor log, or in the tail beat in
the video, the effect therefore appears as a falling frequency. The relative loss of frequency is
half that of the thrust. The model keeps f constant during a trial, because otherwise it would count
the loss twice.

Source: own statement; terminal voltage falls with charge drawn (Linden, Handbook of Batteries, ch.
2).
"""

from __future__ import annotations

import math

from ..integrate.branchless import branchless_power, exponential
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge",)
DEPENDS_ON_VARIABLES = ("time",)
EFFECT_DESCRIPTION = "Thrust decreases during a trial because the supply voltage falls."
MOST_VISIBLE_WHERE = "the late part of long trials"
CONFUSED_WITH = ("sinking", "thrust_loss_with_speed", "wake_reentry")
EFFECT_PARAMETERS = (
    Parameter("loss_rate", "1/s", 0.03, 0.0, 1.0, "share of thrust lost per second at first",
              symbol="k"),
    Parameter("settling_rate", "1/s", 0.002, 1e-4, 1.0, "rate at which the voltage settles",
              spread=0.3, symbol="w"),
    Parameter("load_exponent", "1", 0.0, 0.0, 3.0, "exponent of the flapping frequency",
              spread=1.0, symbol="e"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "linear": {},
    "exponential": {"settling_rate": 0.25},
    "in proportion to the load": {"load_exponent": 2.0},
}


def frequency_drift(
    t: float, flap_hz: float, time_unit: float, k: float, w: float, e: float
) -> float:
    """Relative change of the flapping frequency per second (1/s) in the middle of a trial, at t."""
    return _initial_frequency_drift(flap_hz * time_unit, k, e) * math.exp(-w * t)


def mid_trial_frequency_deviation(
    t: float, flap_hz: float, time_unit: float, k: float, w: float, e: float
) -> float:
    """Relative difference of the tail beat in the middle of a trial from that at its start."""
    return -_initial_frequency_drift(flap_hz * time_unit, k, e) * math.expm1(-w * t) / w


def _initial_frequency_drift(scaled_flap_hz: float, k: float, e: float) -> float:
    """Relative change of the flapping frequency per second (1/s) at the start of a trial."""
    return -0.5 * k * (max(scaled_flap_hz, 1e-9) / 3.5) ** e


SIDE_MEASUREMENT_PREDICTIONS = {
    "frequency_drift": frequency_drift,
    "tail_beat_drift": frequency_drift,
    "stated_ratio": mid_trial_frequency_deviation,
}


def thrust(
    rho: float, A: float, f: float, t: float, time_unit: float, C_T: float, k: float, w: float,
    e: float,
) -> tuple[float]:  # fmt: skip
    """Change of thrust (N)."""
    load = branchless_power(max(f * time_unit, 1e-9) / 3.5, e)
    return (-k * load * (1.0 - exponential(-w * t)) / w * C_T * 0.5 * rho * A * f * f,)
