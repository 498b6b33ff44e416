"""A wrong scale from pixels to metres.

The length of the pool is stated too long by the share s_1, its width by the share s_2. Each error
displaces a point from its true position `true` to the measured position `seen`:

    seen = true + sum over i = 1, 2 of  s_i ((g_ix X, g_iy Y) + (X, Y)(b_i . (X, Y)))
    s_1 = e (1 + a),  s_2 = e (1 - a),  e = k (1 + d (2 o - 1))

- X, Y: position relative to the middle of the pool (m);
- e: mean of the errors s_1 and s_2 in one trial;
- k: scale error, the mean of e over the session;
- a: half the difference of the two errors, over their mean e. With a = 1, only the length is wrong;
  with a = -1, only the width;
- d: trend of e over the session, relative to k. The scale changes if the camera or the water sinks
  from trial to trial;
- o: place of the trial in the session, from 0 (first) to 1 (last);
- g_i (no unit), b_i (1/m): coefficients of the displacement, which depend on the camera.

How an error of the length or the width displaces a point depends on the camera. If a homography
maps the corners of the pool, an error of the length stretches x alone, and an error of the width
stretches y alone. The coefficients are then g_1 = (1, 0), g_2 = (0, 1) and b_i = 0.

If the lens is known, the image shows the true proportions. An error of one side of the pool then
changes the scale along both sides. It also tilts the camera pose that is fitted to the corners,
unless the camera stands over the middle of the pool. The coefficients g_i and b_i describe both
(camera/camera_error_displacement.py).

Some detectors find the nose and place the other keypoints at stated lengths behind it. The formula
of `seen` then applies to the nose alone, and the other keypoints keep their distances from it.

Source: own statement (pool dimensions or corner marks wrong).
"""

from __future__ import annotations

from ..integrate.system import Parameter
from . import SESSION_TREND_PRIOR_STD

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
              "half the difference of the errors of length and width, over their mean",
              spread=0.5, tries=(1.0, -1.0), symbol="a"),
    Parameter("session_trend", "1", 0.0, -1.0, 1.0,
              "change of the error over half a session, relative to its mean",
              spread=SESSION_TREND_PRIOR_STD, symbol="d"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "uniform": {},
    "along the pool": {"axis_difference": 1.0},
    "across the pool": {"axis_difference": -1.0},
}


def observe(
    x: float, y: float, cpsi: float, spsi: float, L_pool: float, W_pool: float, ahead: float,
    session_place: float, length_to_x: float, length_to_y: float, length_tilt_x: float,
    length_tilt_y: float, width_to_x: float, width_to_y: float, width_tilt_x: float,
    width_tilt_y: float, k: float, a: float, d: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Change of what is seen (m, m, rad, rad)."""
    X, Y = x + ahead * cpsi - 0.5 * L_pool, y + ahead * spsi - 0.5 * W_pool
    e = k * (1.0 + d * (2.0 * session_place - 1.0))
    p, q = e * (1.0 + a), e * (1.0 - a)
    tilt = (p * length_tilt_x + q * width_tilt_x) * X + (p * length_tilt_y + q * width_tilt_y) * Y
    return (
        (p * length_to_x + q * width_to_x + tilt) * X,
        (p * length_to_y + q * width_to_y + tilt) * Y,
        0.0,
        0.0,
    )
