"""A wrong scale from pixels to metres.

    seen = c + (1 + k) (true - c), c the middle of the pool

Source: own statement (pool dimensions or corner marks wrong).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("surge", "sway")
STATEMENT = "The scale is wrong: all lengths are seen too long or too short by the same share."
REGIME = "everything, in proportion"
CONFUSED_WITH = ("uncorrected_refraction", "clock_error")
EVIDENCE = {"scale": {"k": 1.0}}
PARAMETERS = (Parameter("k", "1", 0.01, -0.3, 0.3, "share by which lengths are seen too long"),)


def observe(
    x: float, y: float, L_pool: float, W_pool: float, k: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    return k * (x - 0.5 * L_pool), k * (y - 0.5 * W_pool), 0.0, 0.0
