"""Lens distortion left over.

    seen = true + k (rho^2 - q R^2) (true - c)

with rho the distance from the point below the camera and R that of the pool's corners: the camera's
height was found from the corners and makes up for the error there, wholly where q = 1.

Source: Brown, Photogrammetric Engineering 37 (1971), 855 (radial distortion).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("surge", "sway")
STATEMENT = (
    "The lens correction is wrong: positions are bent outwards or inwards towards the edges."
)
REGIME = "towards the edges of the pool"
CONFUSED_WITH = ("uncorrected_refraction", "scale_error")
EVIDENCE = {"lens": 1.0}
PARAMETERS = (
    Parameter("k", "1/m2", 0.005, -0.3, 0.3, "radial distortion on the water"),
    Parameter("q", "1", 0.5, 0.0, 1.5, "how far out it is made up for, squared", 0.25),
)


def observe(
    x: float, y: float, x_cam: float, y_cam: float, k: float, q: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    dx, dy = x - x_cam, y - y_cam
    s = k * (dx * dx + dy * dy - q * (x_cam * x_cam + y_cam * y_cam))
    return s * dx, s * dy, 0.0, 0.0
