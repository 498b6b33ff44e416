"""Thrust that does not grow with the head area.

    dT = -k T (1 - A_1 / A)

As printed, Eq. 1 scales thrust with the head plate's area A; with k = 1 it scales with the area
A_1 of the 1x head, for which the effect vanishes. Source: audit of Eq. 1, docs/paper.md.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge",)
VARIABLES = ("head length",)
STATEMENT = "Thrust does not grow with the length of the head, contrary to Eq. 1."
REGIME = "trials with another head than the 1x head"
CONFUSED_WITH = ("centre_of_mass_shift", "added_mass")
PARAMETERS = (
    Parameter("missing_share", "1", 0.5, 0.0, 1.5,
              "share of the growth with head area that is missing", symbol="k"),
)  # fmt: skip


def thrust(rho: float, f: float, C_T: float, A: float, A_ref: float, k: float) -> tuple[float]:
    """Change of thrust (N)."""
    return (-k * C_T * 0.5 * rho * (A - A_ref) * f * f,)
