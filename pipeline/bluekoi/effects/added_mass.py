"""Water carried along by the body.

Kirchhoff's equations with added masses A11, A22 and added inertia A66 in the frame of the core;
their cross terms are in the rates: surge gains (m + A22) v r, sway -(m + A11) u r, yaw the Munk
moment -(A22 - A11) u v, which pushes a long body broadside on.
A11 and A66 go with A22 by the proportions of a slender body (A11 = c A22, c = 0.1;
A66 = j A22 L^2/12 with the body length L, j = 1). A body that sheds vortices at its tail feels the
share e of the Munk moment. Zero at rest only as a force: it resists every acceleration.
Source: Fossen, Handbook of Marine Craft Hydrodynamics (2011), sec. 6.3; Newman (1977), sec. 4.13.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway", "yaw")
VARIABLES = (
    "drift",
    "turn",
)
STATEMENT = (
    "The water around the robot has to be accelerated with it, most of all sideways, so it "
    "starts, drifts and turns as if it were heavier."
)
REGIME = "start-up and every change of speed; drifting turns"
CONFUSED_WITH = ("tail_fin_lift", "motor_spin_up", "lift_lag")
PARAMETERS = (
    Parameter("sway_mass", "kg", 0.2, 0.0, 3.0, "added mass in sway", symbol="A22"),
    Parameter("surge_to_sway", "1", 0.1, 0.0, 0.8, "added mass in surge over that in sway",
              spread=0.1, symbol="c"),
    Parameter("inertia_ratio", "1", 1.0, 0.0, 4.0, "added inertia over that of a slender body",
              spread=0.5, symbol="j"),
    Parameter("munk_share", "1", 1.0, 0.0, 1.2, "share of the Munk moment that acts",
              spread=0.3, symbol="e"),
)  # fmt: skip


def inertia(length: float, A22: float, c: float, j: float) -> tuple[float, float, float]:
    """Added mass in surge and sway (kg) and added yaw inertia (kg m2)."""
    return c * A22, A22, j * A22 * length * length / 12.0


def force(uc: float, vc: float, A22: float, c: float, e: float) -> tuple[float, float, float]:
    """What the Munk moment lacks (N m); no force."""
    return 0.0, 0.0, (1.0 - e) * (1.0 - c) * A22 * uc * vc
