"""Errors of tracking that last: what is measured wanders about the truth and forgets itself.

Keypoints that sit beside their place on one frame sit beside it on the next: caustics, glare and
a network's habits change slowly; so does what is left of the tail beat. Errors along and across
the core and of its heading, each with e' = -e / tau + white noise, are added to what is seen.
Present in every filter (their size is fitted), absent from simulations.
Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation
(2001), sec. 8.2 (autocorrelated measurement noise).
"""

from __future__ import annotations

from ..integrate.branchless import sin_cos
from ..integrate.system import Parameter

EFFECT_KIND = "disturbance"
EFFECT_DESCRIPTION = "Tracked points err for several frames on end."
EFFECT_PARAMETERS = (
    Parameter("present", "1", 1.0, 0.0, 1.0, "1 where the errors are added"),
    Parameter("tau_along", "s", 0.2, 0.05, 1.0, "time within which an error along is forgotten"),
    Parameter("tau_across", "s", 0.2, 0.05, 1.0, "time within which one across is forgotten"),
    Parameter("tau_heading", "s", 0.2, 0.05, 1.0, "time within which one of the heading is"),
)
EFFECT_STATE_NAMES = ("e_along", "e_across", "e_heading")


def observe(
    psi: float, e_along: float, e_across: float, e_heading: float
) -> tuple[float, float, float, float]:
    """What the errors add to x and y (m), heading and head angle (rad)."""
    s, c = sin_cos(psi)
    return e_along * c - e_across * s, e_along * s + e_across * c, e_heading, 0.0


def effect_state_derivatives(
    e_along: float, e_across: float, e_heading: float, tau_along: float, tau_across: float,
    tau_heading: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Derivatives of the three errors (m/s, rad/s)."""
    return -e_along / tau_along, -e_across / tau_across, -e_heading / tau_heading
