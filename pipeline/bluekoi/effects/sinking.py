"""A robot that sinks during the trial.

    D = -1/2 rho A k t ((1 - w) + w t / t_1) V^2 v_hat,  t since the start, t_1 = 4 s
    seen = c + (1 - g t) (true - c),                     c the middle of the pool

w is the part that grows as t^2 (accelerated sinking). Trim and drag change as the robot leaves the
surface. As its distance from the camera grows, it appears smaller and nearer to the middle.
Source: own statement (the paper reports slight sinking, sec. III-A).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("time",)
STATEMENT = (
    "The robot sinks during the trial: drag grows with time, and it looks smaller and smaller."
)
REGIME = "late in long trials"
CONFUSED_WITH = ("battery_sag", "wake_reentry")
PARAMETERS = (
    Parameter("drag_growth_rate", "1/s", 0.03, 0.0, 0.5,
              "growth of the drag coefficient per second, over 4 s", symbol="k"),
    Parameter("quadratic_share", "1", 0.0, 0.0, 1.0, "part that grows as time squared",
              spread=0.4, tries=(0.8,), symbol="w"),
    Parameter("shrink_rate", "1/s", 0.0, -0.03, 0.03,
              "rate at which its image approaches the pool's middle", spread=0.003, symbol="g"),
)  # fmt: skip


def force(
    rho: float, A: float, t: float, uc: float, vc: float, V: float, k: float, w: float
) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    s = -0.5 * rho * A * k * t * ((1.0 - w) + 0.25 * w * t) * V
    return s * uc, s * vc, 0.0


def observe(
    t: float, x: float, y: float, L_pool: float, W_pool: float, g: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    return -g * t * (x - 0.5 * L_pool), -g * t * (y - 0.5 * W_pool), 0.0, 0.0
