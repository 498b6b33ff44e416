"""Stages of the observation model: rate of true time, and the recorded pose."""

from __future__ import annotations

from ..integrate import Stage

OBSERVATIONS = ("x", "y", "heading", "head_angle")
"""What the camera observes: place, heading of the core, head angle."""


def clock() -> tuple[float]:
    """Rate of true time against the recording's time."""
    return (1.0,)


def observe(x: float, y: float, psi: float, phi: float) -> tuple[float, float, float, float]:
    """What the camera records: centre of mass (m), core heading and head angle (rad)."""
    return x, y, psi, phi


CLOCK = Stage("clock", ("clock_rate",), clock, open=True)
OBSERVE = Stage("observe", OBSERVATIONS, observe, open=True)
