"""Forces that differ between the two sides.

The head's lift is (1 + k) times as large with the flow from one side and (1 - k) from the other:

    dL = k |L| to the left of the flow

Even where the model is odd; vanishes with the flow straight on.
Source: own statement (asymmetric hull or head cap).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("sway", "yaw")
STATEMENT = "The robot turns better to one side than to the other."
REGIME = "turns, with opposite sign to port and starboard"
CONFUSED_WITH = ("head_angle_offset", "trim_moment", "keypoint_bias")
PARAMETERS = (
    Parameter(
        "k",
        "1",
        0.05,
        -1.0,
        1.0,
        "share by which the lift to the left exceeds the lift to the right",
    ),
)


def plate(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float, k: float
) -> tuple[float, float]:
    """Additional lift, in the head's frame (N)."""
    L = 0.5 * rho * A * C_La * k * abs(2.0 * uh * vh) / V
    return -L * vh, L * uh
