"""A wrong scale from pixels to metres.

A point at the position `true` is measured at the position `seen`. Relative to the middle c of the
pool,

    seen - c = ((1 + e (1 + a)) x, (1 + e (1 - a)) y),  x, y = true - c,  e = k (1 + d (2 o - 1))

k is the scale error, the mean of the errors along and across the pool and over the session. With a
= 1 or a = -1, only the length or only the width of the pool was stated wrongly. d is the trend over
the session, relative to k, as of a camera that sinks slowly; o is the place of the trial in the
session, from 0 (first) to 1 (last).

Some detectors find the nose and place the other keypoints at stated lengths behind it. Then the
formula applies to the position of the nose, and the other keypoints keep their distances from it.

Source: own statement (pool dimensions or corner marks wrong).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("surge", "sway")
EFFECT_DESCRIPTION = (
    "The scale is wrong: all lengths appear too long or too short by the same factor."
)
MOST_VISIBLE_WHERE = "all positions, in proportion"
CONFUSED_WITH = ("uncorrected_refraction", "clock_error")
EFFECT_PARAMETERS = (
    Parameter("length_error", "1", 0.01, -0.3, 0.3, "share by which lengths are observed too long",
              symbol="k"),
    Parameter("axis_difference", "1", 0.0, -1.0, 1.0,
              "half the difference of the errors along x and y, over k",
              spread=0.5, tries=(1.0, -1.0), symbol="a"),
    Parameter("session_trend", "1", 0.0, -2.0, 2.0,
              "change of the error over half a session, relative to its mean", spread=0.5,
              tries=(1.0, -1.0), symbol="d"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "uniform": {},
    "along the pool": {"axis_difference": 1.0},
    "across the pool": {"axis_difference": -1.0},
    "growing": {"session_trend": 1.0},
}


def observe(
    x: float, y: float, cpsi: float, spsi: float, L_pool: float, W_pool: float, ahead: float,
    session: float, k: float, a: float, d: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Change of what is seen (m, m, rad, rad)."""
    dx, dy = x + ahead * cpsi - 0.5 * L_pool, y + ahead * spsi - 0.5 * W_pool
    e = k * (1.0 + d * (2.0 * session - 1.0))
    return e * (1.0 + a) * dx, e * (1.0 - a) * dy, 0.0, 0.0
