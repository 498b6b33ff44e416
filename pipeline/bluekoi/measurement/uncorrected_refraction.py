"""Refraction at the surface not corrected, or corrected for a wrong depth.

A keypoint that lies deeper than assumed appears closer to the point c = (x_c, y_c) below the
camera. If its position is `true`, it is measured at

    seen = true - k (1 + d (2 o - 1)) (true - c) (1 + q b rho^2),  rho = |true - c|

- k: relative shift near c, the mean over the session. A fit bounds k by the shifts of a keypoint on
  top of the body and of a keypoint on the floor of the pool;
- b: increase of the relative shift with the distance rho from c (1/m2). It is computed from the
  height of the camera and the stated refractive index (camera/camera_error_displacement.py);
- q: true increase over the computed increase b. It is 1 if only the index or only the depth is
  wrong;
- d: trend of the shift over the session, relative to its mean. A robot that takes on water lies
  deeper from trial to trial. With d = 1, the shift grows from 0 in the first trial;
- o: place of the trial in the session, from 0 (first) to 1 (last).

Source: Snell's law to second order in the angle; Treibitz et al., IEEE TPAMI 34 (2012), 51.
"""

from __future__ import annotations

from ..integrate.system import Parameter
from . import SESSION_TREND_PRIOR_STD

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("surge", "sway")
EFFECT_DESCRIPTION = (
    "Refraction at the water surface was not corrected, or corrected for a wrong depth: lengths "
    "appear too short, more so towards the edges of the pool."
)
MOST_VISIBLE_WHERE = "all positions, more so towards the edges of the pool"
CONFUSED_WITH = ("scale_error", "lens_error")
EFFECT_PARAMETERS = (
    Parameter("inward_shift", "1", 0.005, -0.05, 0.05,
              "relative shift of positions towards the point below the camera", symbol="k",
              bounded_by=("inward_min", "inward_max")),
    Parameter("bending_ratio", "1", 1.0, 0.0, 3.0,
              "increase of the shift with the distance, over the computed one", spread=0.5,
              symbol="q"),
    Parameter("session_trend", "1", 0.0, -1.0, 1.0,
              "change of the shift over half a session, relative to its mean",
              spread=SESSION_TREND_PRIOR_STD, symbol="d"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "wrong depth": {},
    "growing depth error": {"session_trend": 1.0},
    "shrinking depth error": {"session_trend": -1.0},
}


def observe(
    x: float, y: float, cpsi: float, spsi: float, x_cam: float, y_cam: float, bend: float,
    ahead: float, session_place: float, k: float, q: float, d: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Change of what is seen (m, m, rad, rad); ahead: see `scale_error`."""
    dx, dy = x + ahead * cpsi - x_cam, y + ahead * spsi - y_cam
    s = -k * (1.0 + d * (2.0 * session_place - 1.0)) * (1.0 + q * bend * (dx * dx + dy * dy))
    return s * dx, s * dy, 0.0, 0.0
