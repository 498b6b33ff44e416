"""Constant offset of the head angle.

The true head angle phi differs from the commanded one:

    phi = commanded + d ((1 - g - b) + g commanded / phi_1 + b sign(commanded)),  phi_1 = 35 deg

- d: size of the error (rad). With g = b = 0, the error is a constant offset;
- g: weight of a gain error, which is proportional to the commanded angle. It has the size d at the
  commanded angle phi_1;
- b: weight of backlash, an error of the constant size d with the sign of the commanded angle.

Source: own statement (servo horn or push rod set one notch off; length of the horn; play).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw", "sway")
DEPENDS_ON_VARIABLES = ("side",)
EFFECT_DESCRIPTION = (
    "The head does not stand at the commanded angle: a constant offset bends straight runs and "
    "makes turns to the two sides unequal."
)
MOST_VISIBLE_WHERE = "all trials; a constant offset with the same sign in all of them"
CONFUSED_WITH = ("trim_moment", "port_starboard_asymmetry", "keypoint_bias")
EFFECT_PARAMETERS = (
    Parameter("offset", "rad", 0.02, -0.4, 0.4, "size of the error, counter-clockwise positive",
              symbol="d"),
    Parameter("gain_share", "1", 0.0, 0.0, 1.0, "weight of an error proportional to the angle",
              spread=0.5, symbol="g"),
    Parameter("backlash_share", "1", 0.0, 0.0, 1.0, "weight of an error with the sign of the angle",
              spread=0.5, symbol="b"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "constant": {},
    "gain": {"gain_share": 1.0},
    "backlash": {"backlash_share": 1.0},
}


def actuation_inputs(head_angle: float, d: float, g: float, b: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    side = head_angle / math.sqrt(head_angle * head_angle + 1e-4)
    return d * (1.0 - g - b + g * head_angle / 0.6108652381980153 + b * side), 0.0
