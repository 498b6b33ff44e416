"""Lift that takes time to build up.

The circulation z follows its steady value over the time in which the flow passes the plate:

    z' = (V^2 sin 2 alpha - z) V / (s h),    L uses z in place of the share k of V^2 sin 2 alpha

h is the head length. Vanishes in steady motion.
Source: Leishman, Principles of Helicopter Aerodynamics (2006), sec. 8.10 (Wagner's indicial lift).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("sway", "yaw")
STATEMENT = "The lift of the head follows changes of angle and speed with a delay."
REGIME = "start of turns and every change; nothing in the steady circle"
CONFUSED_WITH = ("servo_lag", "added_mass", "motor_spin_up")
PARAMETERS = (
    Parameter("k", "1", 0.5, 0.0, 1.2, "share of the lift that lags"),
    Parameter("s", "1", 4.0, 0.5, 40.0, "head lengths travelled while it builds up"),
)
STATES = ("z",)


def plate(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float, z: float, k: float
) -> tuple[float, float]:
    """Lift that is not there yet, in the head's frame (N)."""
    L = 0.5 * rho * A * C_La * k * (z + 2.0 * uh * vh) / V
    return -L * vh, L * uh


def own_rates(uh: float, vh: float, V: float, h: float, z: float, s: float) -> tuple[float]:
    """Derivative of z (m2/s3)."""
    return ((-2.0 * uh * vh - z) * V / (s * h),)
