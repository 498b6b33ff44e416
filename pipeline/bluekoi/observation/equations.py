"""Stages of the observation model: rate of true time, and the recorded pose."""

from __future__ import annotations

from ..integrate import Stage

OBSERVED_QUANTITIES = ("x", "y", "heading", "head_angle")
"""What the camera observes: place, heading of the core, head angle."""


def true_time_rate() -> tuple[float]:
    """Rate of true time against the recording's time."""
    return (1.0,)


def observe(x: float, y: float, psi: float, phi: float) -> tuple[float, float, float, float]:
    """What the camera records: centre of mass (m), core heading and head angle (rad)."""
    return x, y, psi, phi


CLOCK_STAGE = Stage("true_time_rate", ("clock_rate",), true_time_rate, open=True)
OBSERVATION_STAGE = Stage("observe", OBSERVED_QUANTITIES, observe, open=True)
