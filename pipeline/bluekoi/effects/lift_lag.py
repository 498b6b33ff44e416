"""Lift that follows the angle of attack with a delay.

In steady motion, the lift of the head plate is 1/2 rho A C_La V^2 sin 2 alpha, with the angle of
attack alpha and the speed V. After a change of alpha or V, the lift approaches its new value while
the robot travels about s head lengths h. The states z and y describe this lag:

    z' = (V^(2 - e) sin 2 alpha - z) V / (s h),    y' = (z - y) V / (s h)

In the lift, V^2 sin 2 alpha is replaced by

    (1 - k) V^2 sin 2 alpha + k V^e ((1 - w) z + w y)

- z, y: values of V^(2 - e) sin 2 alpha after one lag and after two lags in series;
- k: share of the lift that lags. The yaw moment q C_Ma sin 2 alpha of the head, with
  q = 1/2 rho A V^2, lags in the same way with m k instead of k;
- w: weight of the second-order lag. With w = 0, the lag is of first order. With w = 1, there are
  two lags in series: the flow turns, and then the circulation follows;
- e: exponent that determines what lags: the force (e = 0), the circulation (e = 1), or the lift
  coefficient (e = 2).

The effect vanishes in steady motion.

Source: Leishman, Principles of Helicopter Aerodynamics (2006), sec. 8.10 (Wagner's indicial lift)
and ch. 9 (lags of pressure and boundary layer in series).
"""

from __future__ import annotations

from ..integrate.branchless import branchless_power
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("sway", "yaw")
DEPENDS_ON_VARIABLES = ("angle of attack",)
EFFECT_DESCRIPTION = (
    "The lift of the head follows changes of angle of attack and speed with a delay."
)
MOST_VISIBLE_WHERE = "the start of turns and every change of speed; not the steady circle"
CONFUSED_WITH = ("servo_lag", "added_mass", "motor_spin_up")
EFFECT_PARAMETERS = (
    Parameter("lagging_share", "1", 0.5, 0.0, 1.2, "share of the lift that lags", symbol="k"),
    Parameter("build_up_lengths", "1", 4.0, 0.1, 20.0, "head lengths travelled as lift builds up",
              symbol="s"),
    Parameter("second_order_share", "1", 0.0, 0.0, 1.0, "weight of two lags in series",
              spread=0.5, symbol="w"),
    Parameter("speed_exponent", "1", 1.0, 0.0, 2.0, "power of the speed that acts without lag",
              spread=0.5, symbol="e"),
    Parameter("moment_share", "1", 0.0, 0.0, 1.2,
              "share of the yaw moment that lags, over that of the lift", spread=0.5, symbol="m"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "force": {"speed_exponent": 0.0},
    "circulation": {},
    "coefficient": {"speed_exponent": 2.0},
    "two lags in series": {"second_order_share": 1.0},
    "moment as well": {"moment_share": 1.0},
    "short lag": {"build_up_lengths": 0.5},
}
EFFECT_STATE_NAMES = ("z", "y_lag")


def head_plate_force(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float,
    z: float, y_lag: float, k: float, w: float, e: float,
) -> tuple[float, float]:  # fmt: skip
    """Lift that is not there yet, in the head's frame (N)."""
    late = branchless_power(V, e) * (z + w * (y_lag - z))
    L = 0.5 * rho * A * C_La * k * (late + 2.0 * uh * vh) / V
    return -L * vh, L * uh


def force(
    rho: float, A: float, uh: float, vh: float, V: float, C_Ma: float,
    z: float, y_lag: float, k: float, w: float, e: float, m: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Moment that is not there yet (N m)."""
    late = branchless_power(V, e) * (z + w * (y_lag - z))
    return 0.0, 0.0, 0.5 * rho * A * C_Ma * m * k * (late + 2.0 * uh * vh)


def effect_state_derivatives(
    uh: float,
    vh: float,
    V: float,
    h: float,
    time_unit: float,
    z: float,
    y_lag: float,
    s: float,
    e: float,
) -> tuple[float, float]:
    """Derivatives of z and y, (m/s)^(2 - e) a second; not faster than the integrator follows."""
    rate = min(V / (s * h), 60.0 / time_unit)
    return (-2.0 * uh * vh * branchless_power(V, -e) - z) * rate, (z - y_lag) * rate
