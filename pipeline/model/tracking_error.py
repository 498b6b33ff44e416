"""Errors of tracking that last: what is measured wanders about the truth and forgets itself.

Keypoints that sit beside their place on one frame sit beside it on the next: caustics, glare and
a network's habits change slowly. Three errors of their own with e' = -e / tau + white noise are
added to the seen position and heading. Present in every filter (their size is fitted), absent from
simulations.
Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation
(2001), sec. 8.2 (autocorrelated measurement noise).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "disturbance"
STATEMENT = "Tracked points err for several frames on end."
PARAMETERS = (
    Parameter("present", "1", 1.0, 0.0, 1.0, "1 where the errors are added"),
    Parameter("tau", "s", 0.2, 0.05, 1.0, "time within which an error is forgotten"),
)
STATES = ("e_x", "e_y", "e_heading")


def observe(e_x: float, e_y: float, e_heading: float) -> tuple[float, float, float, float]:
    """What the errors add to x and y (m), heading and head angle (rad)."""
    return e_x, e_y, e_heading, 0.0


def own_rates(e_x: float, e_y: float, e_heading: float, tau: float) -> tuple[float, float, float]:
    """Derivatives of the three errors (m/s, rad/s)."""
    return -e_x / tau, -e_y / tau, -e_heading / tau
