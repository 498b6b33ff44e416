"""A head that does not stand at the angle commanded.

    phi = commanded + d

Source: own statement (servo horn or push rod set one notch off).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw", "sway")
VARIABLES = ("side",)
STATEMENT = (
    "The head does not stand at the commanded angle: a constant offset, so that straight "
    "runs bend and the two sides differ."
)
REGIME = "all trials, to one side"
CONFUSED_WITH = ("trim_moment", "port_starboard_asymmetry", "keypoint_bias")
PARAMETERS = (
    Parameter("offset", "rad", 0.02, -0.4, 0.4, "counter-clockwise positive", symbol="d"),
)  # fmt: skip


def drive(d: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    return d, 0.0
