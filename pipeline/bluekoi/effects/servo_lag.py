"""Delay of the head servo.

At the time t since the start of the trial, the head angle is

    phi(t) = phi - k (phi - s phi_0) exp(-((t - t_d) / T)^n) S
    T = tau (1 - q + q |phi - s phi_0| / 45 deg)
    S = 1 - w + w (cos z + sin(z) / b),  z = b (t - t_d) / T

- phi on the right-hand side: the commanded angle;
- phi_0: the angle commanded in the trial before, in the order of `trials.csv`; 0 in the first
  trial, and in trials that `bluekoi simulate` computes;
- s: determines the angle s phi_0 from which the servo turns the head: 0 with s = 0, the angle of
  the trial before with s = 1;
- k: share of the change phi - s phi_0 that is still missing at the start. With k = 1, the trial
  begins at the angle s phi_0, with k = 0 at the commanded angle;
- t_d: dead time (s), after which the servo begins to move. The formulas hold from then on;
- T: time constant (s); tau: its value for a change of 45 deg;
- q: dependence of T on the change. With q = 0, T is tau for all changes. With q = 1, T is
  proportional to the change, as for a servo with a limited rate;
- n: exponent. A servo with a limited rate has a larger n. With n = 1 and q = 0, the head follows
  with a first-order lag;
- S: factor that describes an oscillation, with the phase z (rad). b is the phase at t - t_d = T;
- w: weight of the oscillation. With w = 0, S is 1 and the head does not oscillate. With w = 1,
  n = 1 and q = 0, the head oscillates about its commanded angle, as in a second-order lag with the
  damping ratio (1 + b^2)^(-1/2).

While the servo moves, it turns the head against the core, the rigid body behind the head. The core
makes the share c of the change of the head angle phi. The head makes the share 1 - c in the
opposite direction. The water also turns the robot, with the yaw rate r. The heading psi of the core
therefore changes by

    psi' = r + c phi'.

With c = 0, the servo turns the head alone. With c = 1, it turns the core alone; this agrees with
Eq. 8 of the paper, whose state is the direction of the head. The trials of the paper do not
determine c, because each has only one head angle. If the head stands at its commanded angle from
the start (k = 0), the servo does not move and c has no effect.

Source: Nise, Control Systems Engineering (2015), sec. 4.3 (first-order response) and 4.6
(underdamped second-order response).
"""

from __future__ import annotations

from ..integrate.branchless import branchless_power, exponential, sin_cos
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw", "sway")
DEPENDS_ON_VARIABLES = ("early",)
EFFECT_DESCRIPTION = (
    "The head does not stand at its commanded angle from the start: the servo needs time to turn "
    "it."
)
MOST_VISIBLE_WHERE = (
    "the first second of turns; if the head starts at the angle of the trial before, after a trial "
    "at another head angle"
)
CONFUSED_WITH = ("motor_spin_up", "lift_lag", "time_offset")
EFFECT_PARAMETERS = (
    Parameter("missing_share", "1", 0.5, 0.0, 1.2, "share of the change missing at the start",
              symbol="k"),
    Parameter("time_constant", "s", 0.4, 0.05, 1.5, "time constant of a change of 45 deg",
              symbol="tau"),
    Parameter("rate_limit_exponent", "1", 1.5, 1.0, 5.0, "1: first-order lag, larger: limited rate",
              symbol="n"),
    Parameter("angle_dependence", "1", 0.5, 0.0, 1.0,
              "0: same time constant for all changes, 1: proportional to them", symbol="q"),
    Parameter("core_share", "1", 0.0, 0.0, 1.2, "share of the rotation that the core makes",
              spread=0.5, symbol="c"),
    Parameter("dead_time", "s", 0.0, 0.0, 0.6, "time in which the angle does not change",
              spread=0.15, symbol="t_d"),
    Parameter("overshoot_share", "1", 0.0, 0.0, 1.0, "weight of the oscillation about the angle",
              spread=0.5, symbol="w"),
    Parameter("swing_rate", "1", 3.0, 0.5, 8.0, "phase of the oscillation (rad) in a time constant",
              spread=2.0, symbol="b"),
    Parameter("start_angle_share", "1", 0.0, 0.0, 1.0,
              "0: the head starts straight, 1: at the angle of the trial before", spread=0.5,
              symbol="s"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "first order": {"rate_limit_exponent": 1.0, "angle_dependence": 0.0},
    "second order, overshooting": {"overshoot_share": 1.0},
    "limited rate": {"rate_limit_exponent": 3.0, "angle_dependence": 1.0},
    "dead time": {"dead_time": 0.3},
    "core turns instead": {"core_share": 1.0},
    "from the angle of the trial before": {"start_angle_share": 1.0},
    "fast": {"time_constant": 0.15},
    "slow": {"time_constant": 1.0},
}


def actuation_inputs(
    t: float, head_angle: float, phi0: float, k: float, tau: float, n: float, q: float, t_d: float,
    w: float, b: float, s: float,
) -> tuple[float, float]:  # fmt: skip
    """Change of head angle (rad) and flapping frequency (Hz)."""
    change = head_angle - s * phi0
    T = tau * (1.0 - q + q * (abs(change) + 1e-3) / 0.7853981633974483)
    late = max(t - t_d, 1e-9) / T
    sin_z, cos_z = sin_cos(b * late)
    swing = 1.0 - w + w * (cos_z + sin_z / b)
    return -change * k * exponential(-branchless_power(late, n)) * swing, 0.0


def core_turn_rate(
    t: float, head_angle: float, phi0: float, k: float, tau: float, n: float, q: float, c: float,
    t_d: float, w: float, b: float, s: float,
) -> tuple[float]:  # fmt: skip
    """Rate at which the core turns (rad/s): c times that of the head angle."""
    change = head_angle - s * phi0
    T = tau * (1.0 - q + q * (abs(change) + 1e-3) / 0.7853981633974483)
    late = max(t - t_d, 1e-9) / T
    left = branchless_power(late, n)
    moving = min(max(1.0 + 1e6 * (t - t_d), 0.0), 1.0)  # 0 until a microsecond before t_d
    sin_z, cos_z = sin_cos(b * late)
    swing = 1.0 - w + w * (cos_z + sin_z / b)
    swing_slope = w * (cos_z - b * sin_z)  # of `swing` over time / T
    slope = left * n / late * swing - swing_slope
    return (moving * c * k * change * exponential(-left) * slope / T,)
