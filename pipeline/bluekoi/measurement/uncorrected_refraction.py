"""Refraction at the surface not corrected, or for the wrong depth.

For a camera above the point (x_c, y_c), a keypoint that lies deeper than assumed appears closer to
that point: seen = true - k (true - c) (1 + b rho^2), with b from the camera's height
(camera/displacement.py).
Source: Snell's law to second order in the angle; Treibitz et al., IEEE TPAMI 34 (2012), 51.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("surge", "sway")
STATEMENT = (
    "Refraction at the water's surface was not corrected, or for the wrong depth: lengths "
    "come out too short, more so towards the edges."
)
REGIME = "everything, more so towards the edges of the pool"
CONFUSED_WITH = ("scale_error", "lens_error")
PARAMETERS = (
    Parameter("inward_shift", "1", 0.005, -0.05, 0.05,
              "share by which positions appear too close to the camera axis", symbol="k"),
)  # fmt: skip


def observe(
    x: float, y: float, cpsi: float, spsi: float, x_cam: float, y_cam: float, bend: float,
    ahead: float, k: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Change of what is seen (m, m, rad, rad); ahead: see `scale_error`."""
    dx, dy = x + ahead * cpsi - x_cam, y + ahead * spsi - y_cam
    s = -k * (1.0 + bend * (dx * dx + dy * dy))
    return s * dx, s * dy, 0.0, 0.0
