"""Error of the observed head angle in one trial.

The detector places its keypoints in the same way in all frames of a trial, and in a slightly
different way in each trial:

    observed head angle = phi + error

Fits integrate the errors out, as trial effects with mean 0; an error that all trials share belongs
to the cause `keypoint_bias`. It has a parameter of its own, since the functional form of that cause
(in proportion to the sine of the head angle) says nothing about the scatter between trials. Absent
from simulations.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "trial error"
EFFECT_DESCRIPTION = "The observed head angle has a slightly different error in each trial."
EFFECT_PARAMETERS = (Parameter("angle", "rad", 0.01, -0.4, 0.4, "observed minus true head angle"),)
"""Plausible magnitude: 0.6 degrees (`HEAD_ANGLE_STD_RAD`). Bounds: those of `head_angle_offset`."""


def observe(angle: float) -> tuple[float, float, float, float]:
    """Change of what is seen: x, y (m), heading and head angle (rad)."""
    return 0.0, 0.0, 0.0, angle
