"""Added mass of the water around the body.

A body that accelerates in water must also accelerate the water around it. Kirchhoff's equations
describe this by the added masses A11 (surge) and A22 (sway) and the added yaw inertia A66, in the
axes of the core (the rigid body behind the head). The added mass and inertia also act when the
robot starts from rest.

The model computes A11 and A66 from A22:

    A11 = c A22,  A66 = j A22 L^2 / 12

- c: added mass in surge over that in sway. A slender body has c = 0.1;
- j: added yaw inertia over that of a slender body, which has j = 1;
- L: length of the body (m).

The equations of motion contain the Coriolis terms (m + A22) v r in surge and -(m + A11) u r in
sway. Here m is the mass of the robot, r the yaw rate, and u and v are the velocities in surge and
sway. In yaw, the equations contain the Munk moment -(A22 - A11) u v, which turns a body with
A22 > A11 broadside to the flow. If a body sheds vortices at its tail, only the share e of the Munk
moment acts.

Source: Fossen, Handbook of Marine Craft Hydrodynamics (2011), sec. 6.3; Newman, Marine
Hydrodynamics (1977), sec. 4.13.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
DEPENDS_ON_VARIABLES = (
    "drift",
    "turn",
)
EFFECT_DESCRIPTION = (
    "The body accelerates water together with itself, mostly sideways: it starts, drifts and "
    "turns like a heavier body."
)
MOST_VISIBLE_WHERE = "start-up and every change of speed; turns with sideways motion"
CONFUSED_WITH = ("tail_fin_lift", "motor_spin_up", "lift_lag")
EFFECT_PARAMETERS = (
    Parameter("sway_mass", "kg", 0.2, 0.0, 3.0, "added mass in sway", symbol="A22"),
    Parameter("surge_to_sway", "1", 0.1, 0.0, 0.8, "added mass in surge over that in sway",
              spread=0.1, symbol="c"),
    Parameter("inertia_ratio", "1", 1.0, 0.0, 4.0, "added inertia over that of a slender body",
              spread=0.5, symbol="j"),
    Parameter("munk_share", "1", 1.0, 0.0, 1.2, "share of the Munk moment that acts",
              spread=0.35, symbol="e"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "slender body": {},
    "ellipsoid, five times as long as wide": {"surge_to_sway": 0.066, "inertia_ratio": 0.5},
    "partial Munk moment": {"munk_share": 0.3},
}


def inertia(length: float, A22: float, c: float, j: float) -> tuple[float, float, float]:
    """Added mass in surge and sway (kg) and added yaw inertia (kg m2)."""
    return c * A22, A22, j * A22 * length * length / 12.0


def force(uc: float, vc: float, A22: float, c: float, e: float) -> tuple[float, float, float]:
    """What the Munk moment lacks (N m); no force."""
    return 0.0, 0.0, (1.0 - e) * (1.0 - c) * A22 * uc * vc
