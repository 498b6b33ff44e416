"""The pool seen from above: walls, and the robot at positions along a track."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from ...data import Track
from ...study import Robot, Study


def draw_pool(axes: Axes, study: Study, *, labels: bool = True) -> None:
    """Walls of the pool, equal scales, metres on both axes."""
    size = study.setup.pool
    axes.add_patch(
        Rectangle((0, 0), size.length_m, size.width_m, fc="#f2f7fa", ec="#8fa3b0", zorder=0)
    )
    axes.set_aspect("equal")
    axes.set_xlim(-0.08, size.length_m + 0.08)
    axes.set_ylim(-0.08, size.width_m + 0.08)
    axes.grid(visible=False)
    if labels:
        axes.set_xlabel("x (m)")
        axes.set_ylabel("y (m)")


def draw_robot_along_track(axes: Axes, robot: Robot, head_length_m: float, track: Track) -> None:
    """The robot as two plates along a track, 1.25 body lengths apart."""
    apart = 1.25 * (robot.body_length_m + head_length_m - robot.head_length_m)
    distance_m = np.concatenate(
        [[0.0], np.cumsum(np.hypot(np.diff(track.x_m), np.diff(track.y_m)))]
    )
    for distance in np.arange(0.0, distance_m[-1], apart):
        i = int(np.searchsorted(distance_m, distance))
        centre = np.array([track.x_m[i], track.y_m[i]])
        angles = track.heading_rad[i], track.head_angle_rad[i]
        points = robot.body_points(head_length_m, centre, *angles)
        axes.plot(*points[1:].T, color="#7c8894", lw=2.6, solid_capstyle="round", zorder=3)
        axes.plot(*points[:2].T, color="#e08214", lw=2.6, solid_capstyle="round", zorder=4)
        axes.plot(*points[2], marker="o", ms=2.2, color="white", zorder=5)
