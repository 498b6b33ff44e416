"""Error of the head servo in one trial.

A servo that repeats a commanded angle has another error in each trial, constant within it:

    phi = commanded + error

Fits integrate the errors out, as trial effects with mean 0; an error that all trials share is the
cause `head_angle_offset`. It has a parameter of its own, since the functional form of that cause (a
gain error, which is absent in straight trials) says nothing about the scatter between trials.
Absent from simulations.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "trial error"
EFFECT_DESCRIPTION = "The head stands at a slightly different angle in each trial."
EFFECT_PARAMETERS = (
    Parameter("angle", "rad", 0.005, -0.4, 0.4, "true minus commanded head angle"),
)
"""Plausible magnitude: 0.3 degrees (`SERVO_STD_RAD`). Bounds: those of `head_angle_offset`."""


def actuation_inputs(angle: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    return angle, 0.0
