"""Thrust that does not grow with the head area.

In Eq. 1 of the paper as printed, the thrust T is proportional to the area A of the head plate, so
that a longer head gives more thrust. This effect removes the share k of that growth:

    dT = -k T (1 - A_1 / A)

A_1 is the area of the standard (1x) head, for which the change dT of the thrust vanishes. With
k = 1, the thrust is proportional to A_1 for every head.

Source: audit of Eq. 1, docs/paper.md.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge",)
DEPENDS_ON_VARIABLES = ("head length",)
EFFECT_DESCRIPTION = (
    "Thrust does not grow with the length of the head, contrary to Eq. 1 of the paper."
)
MOST_VISIBLE_WHERE = "trials with another head than the standard (1x) head"
CONFUSED_WITH = ("centre_of_mass_shift", "added_mass")
EFFECT_PARAMETERS = (
    Parameter("missing_share", "1", 0.5, 0.0, 1.5,
              "share of the growth with head area that is missing", symbol="k"),
)  # fmt: skip


def thrust(rho: float, f: float, C_T: float, A: float, A_ref: float, k: float) -> tuple[float]:
    """Change of thrust (N)."""
    return (-k * C_T * 0.5 * rho * (A - A_ref) * f * f,)
