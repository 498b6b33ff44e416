"""Residual lens distortion.

A point at the position `true` on the water is measured at the position

    seen = true + k [(rho^2 - q Q) (true - c) + a] + (p_x, p_y) (rho^2 - q Q)

- c: point where the lens axis meets the water; rho: distance of `true` from c (m);
- k: radial distortion (1/m2);
- p_x, p_y: tangential distortion of a lens whose elements are not aligned (1/m);
- Q (m2), a (m3): change of scale and shift by which the fitted camera pose compensates part of the
  lens error;
- q: actual change of scale over the computed one, Q.

The pose of the camera is fitted to the corners of the pool, with the same wrong lens. It therefore
compensates part of the lens error. To determine this part, the program changes the first distortion
coefficient of the study's camera and fits the pose again (camera/camera_error_displacement.py). It
then approximates the resulting displacement of points on the water by the formula with q = 1. This
approximation gives Q, a and c.

The full formula for tangential distortion with the vector p = (p_x, p_y) is 2 (p . d) d + rho^2 p,
where d = true - c is the vector from the lens axis to the point, and rho its length. The first term
is left out. It acts like a tilt of the camera, which the fitted pose compensates.

Source: Brown, Photogrammetric Engineering 37 (1971), 855 (radial and tangential distortion).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("surge", "sway")
EFFECT_DESCRIPTION = (
    "The lens correction is wrong: towards the edges of the picture, positions are displaced "
    "outwards or inwards."
)
STRENGTH_PARAMETER_COUNT = 3
MOST_VISIBLE_WHERE = "positions towards the edges of the pool"
CONFUSED_WITH = ("uncorrected_refraction", "scale_error")
EFFECT_PARAMETERS = (
    Parameter("radial_distortion", "1/m2", 0.005, -0.3, 0.3, "radial distortion on the water",
              symbol="k"),
    Parameter("tangential_x", "1/m", 0.005, -0.3, 0.3, "tangential distortion along the pool",
              symbol="p_x"),
    Parameter("tangential_y", "1/m", 0.005, -0.3, 0.3, "tangential distortion across the pool",
              symbol="p_y"),
    Parameter("compensated_share", "1", 1.0, 0.0, 2.0,
              "change of scale by the fitted pose, relative to the computed one", spread=0.25,
              symbol="q"),
)  # fmt: skip


def observe(
    x: float, y: float, cpsi: float, spsi: float, x_lens: float, y_lens: float, Q_lens: float,
    ax_lens: float, ay_lens: float, ahead: float,
    k: float, p_x: float, p_y: float, q: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Change of what is seen (m, m, rad, rad); ahead: see `scale_error`."""
    dx, dy = x + ahead * cpsi - x_lens, y + ahead * spsi - y_lens
    s = dx * dx + dy * dy - q * Q_lens
    return k * (s * dx + ax_lens) + p_x * s, k * (s * dy + ay_lens) + p_y * s, 0.0, 0.0
