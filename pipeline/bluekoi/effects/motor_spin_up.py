"""Spin-up of the motor.

In the dead time t_d after the start of the motor, the flapping frequency is constant. At the time t
after the dead time, it is

    f(t) = f (1 - k ((1 - w) exp(-t / tau) + w ((1 - q) z + q z^2 (3 - 2 z)))),
    z = max(1 - t / (2 tau), 0)

- f on the right-hand side: the full frequency (Hz);
- k: share of the full frequency that is missing at the start and during the dead time;
- tau: time constant (s);
- w: weight of a motor with a controller, which reaches the full frequency at t = 2 tau. With w = 0,
  the motor has a first-order lag;
- q: form of the rise with a controller: a linear ramp (q = 0) or a smooth one (q = 1).

The tail makes f k (tau + t_d) fewer beats than a tail that beats at the full frequency f from the
start. Here k is the share of f that is missing at the start, tau the time constant and t_d the dead
time. The spin-up thus costs the time k (tau + t_d), for all values of w and q. A motor log shows
this lost time (`motor/spin_up.py`).

Source: Nise, Control Systems Engineering (2015), sec. 2.8 (motor with load, first order).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge",)
DEPENDS_ON_VARIABLES = ("early",)
EFFECT_DESCRIPTION = (
    "The tail does not beat at full frequency from the start: the motor needs time to reach its "
    "speed."
)
MOST_VISIBLE_WHERE = "the first second of every trial"
CONFUSED_WITH = ("added_mass", "time_offset", "thrust_loss_with_speed")
EFFECT_PARAMETERS = (
    Parameter("missing_share", "1", 0.5, 0.0, 1.0, "share of the frequency missing at the start",
              symbol="k"),
    Parameter("time_constant", "s", 0.4, 0.05, 3.0, "time constant, half the duration of a ramp",
              symbol="tau"),
    Parameter("ramp_share", "1", 0.5, 0.0, 1.0, "0: first-order lag, 1: ramp of a controller",
              symbol="w"),
    Parameter("ramp_smoothness", "1", 0.0, 0.0, 1.0, "0: linear ramp, 1: smooth step",
              spread=0.5, symbol="q"),
    Parameter("dead_time", "s", 0.0, 0.0, 1.0, "time in which the frequency does not rise",
              spread=0.15, symbol="t_d"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "first order": {"ramp_share": 0.0},
    "ramp": {"ramp_share": 1.0},
    "S-curve": {"ramp_share": 1.0, "ramp_smoothness": 1.0},
    "dead time": {"dead_time": 0.3},
    "fast": {"time_constant": 0.1},
    "slow": {"time_constant": 1.5},
}


def lost_time(k: float, tau: float, t_d: float) -> float:
    """Time (s) that the spin-up costs."""
    return k * (tau + t_d)


SIDE_MEASUREMENT_PREDICTIONS = {"lost_time": lost_time}


def actuation_inputs(
    t: float, t_start: float, flap_hz: float, k: float, tau: float, w: float, q: float, t_d: float
) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    since = max(t - t_start - t_d, 0.0)
    z = max(1.0 - 0.5 * since / tau, 0.0)
    ramp = z + q * (z * z * (3.0 - 2.0 * z) - z)
    return 0.0, -flap_hz * k * ((1.0 - w) * exponential(-since / tau) + w * ramp)
