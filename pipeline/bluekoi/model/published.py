"""What the paper prints, in the unit reading of the audit (C_T and C_Md times 1e-3)."""

from __future__ import annotations

PUBLISHED_UNITS_NOTE = (
    "C_T read as 1e-3 m2 and C_Md as 1e-3 kg m2: as printed, straight speeds would be 9 to 18 m/s"
)
"""How the units of Table I are read, as a sentence."""

PUBLISHED_FLAP_HZ = {50: 2.37, 75: 4.02, 100: 5.82}
"""Flapping frequency by motor power, % (Table I)."""

TABLE_1: dict[int, dict[str, float]] = {
    power: {"C_T": 4.5e-3, "C_D0": 0.5, "C_Da": c_da, "C_La": 3.14, "C_Ma": 0.1, "C_Md": c_md}
    for power, c_da, c_md in ((50, 0.3, 0.145), (75, 2.5, 0.130), (100, 4.0, 0.104))
}
"""Table I by power, %: C_T [m2], C_D0, C_Da, C_La [1], C_Ma [m], C_Md [kg m2]."""

TABLE_2_ERRORS_PCT: dict[tuple[int, float], dict[int, float]] = {
    (30, 1.0): {50: 2.77, 75: -2.09, 100: -1.70},
    (45, 1.5): {50: -9.96, 75: -10.48, 100: 2.47},
}
"""Table II: (head angle in degrees, head length over 1x) -> power -> model minus data, %."""
