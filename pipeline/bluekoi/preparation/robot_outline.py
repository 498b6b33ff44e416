"""The robot's lengths of study.yaml drawn to scale over a frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..camera.pool_projection import map_to_pool, pool_to_pixels
from ..camera.study_camera import pool_camera_from_parts
from ..data import Float
from ..study import Camera, Pool, Robot


@dataclass(frozen=True)
class ProjectedSkeleton:
    """Pixels of the robot's parts as a camera sees them.

    head: (2, 2) nose and hinge. core: (2, 2) hinge and caudal base. tail: (2, 2) caudal base and
    tail tip. com: (2,).
    """

    head: Float
    core: Float
    tail: Float
    com: Float


def robot_outline(
    camera: Camera, pool: Pool, robot: Robot, *, com_px: tuple[float, float], toward_px:
    tuple[float, float], head_angle_rad: float, head_length_m: float | None = None,
    refractive_index: float = 1.333,
) -> ProjectedSkeleton:  # fmt: skip
    """The robot with its centre of mass at a pixel, its core pointing toward another pixel.

    The direction of the head is heading minus head angle. head_length_m: of this trial's head, by
    default the 1x head.

    Raises: InputError where the corners fit no camera.
    """
    depth = robot.keypoint_depth_m
    over = pool_camera_from_parts(camera, pool, refractive_index, depth)
    com, toward = map_to_pool(over, np.array([com_px, toward_px]), depth)
    heading_rad = math.atan2(*(toward - com)[::-1])
    length = head_length_m or robot.head_length_m
    nose, hinge, _, base = robot.body_points(length, com, heading_rad, head_angle_rad)
    core = np.array([math.cos(heading_rad), math.sin(heading_rad)])
    points = np.array([nose, hinge, base, base - robot.tail_length_m * core, com])
    px = pool_to_pixels(over, np.column_stack([points, np.full(len(points), -depth)]))
    return ProjectedSkeleton(px[[0, 1]], px[[1, 2]], px[[2, 3]], px[4])
