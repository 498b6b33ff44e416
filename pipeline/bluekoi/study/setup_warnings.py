"""Doubts about the robot and the camera of a study that do not stop it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .consistency_rules import BODY_WIDTH_TO_HEIGHT_RANGE

if TYPE_CHECKING:
    from .setup import Camera, Robot, StudySettings

GYRATION_RADIUS_OVER_LENGTH_RANGE = ((1 / 28) ** 0.5, (7 / 48) ** 0.5)
"""Radius of gyration over length: that of a spindle (a parabola turned about its axis), 0.19, and
that of a rod with all mass in its outer quarters, 0.38. A uniform rod has (1/12)^0.5 = 0.29."""
CAUSES_THAT_MIMIC_WRONG_INERTIA = ("thrust_line_offset",)
"""Causes that the finder names where yaw inertia or mass alone is wrong (docs/results.md)."""
MIN_MIMIC_PROBABILITY = 0.5
"""As for the causes that the finder names."""
VALIDATED_BODY_LENGTHS_M = (0.2, 1.2)
"""Shortest and longest robots of the simulated studies with hidden causes (docs/evidence.md)."""
PRINCIPAL_POINT_OFFSET_SHARE = 0.1
"""The axis of a lens meets the sensor within this share of its size from the middle."""
MAX_KEYPOINT_DEPTH_SHARE = 0.5
"""Keypoints deeper than this share of the water are nearer to the floor than to the surface."""
INDEX_OF_WATER, MAX_INDEX_DIFFERENCE = 1.333, 0.01
"""Refractive index of water, and how far that of warm, cold or salt water may be from it."""


def setup_warnings(setup: StudySettings) -> list[str]:
    """A sentence where mass, yaw inertia and size are not those of one body, the lens is not in the
    middle of the picture, the refractive index is not that of water, or keypoints lie deep. No
    motion shows the first of these: coefficients are proportional to the mass, those of forces
    inversely to head span and density.
    """
    return [
        *_gyration_radius_warnings(setup.robot),
        *_body_volume_warnings(setup),
        *_unvalidated_size_warnings(setup.robot),
        *_principal_point_warnings(setup.camera),
        *_refractive_index_warnings(setup.water.refractive_index),
        *_keypoint_depth_warnings(setup),
    ]


def _keypoint_depth_warnings(setup: StudySettings) -> list[str]:
    depth, water = setup.robot.keypoint_depth_m, setup.pool.depth_m
    if not setup.robot.keypoint_depth_given or depth <= MAX_KEYPOINT_DEPTH_SHARE * water:
        return []
    return [
        f"keypoint_depth_m is {depth:g}: the keypoints are nearer to the floor than to the surface "
        f"of {water:g} m of water. The depth is measured from the surface down. Is it measured "
        "from the floor?"
    ]


def _refractive_index_warnings(index: float) -> list[str]:
    if abs(index - INDEX_OF_WATER) <= MAX_INDEX_DIFFERENCE:
        return []
    return [
        f"refractive_index is {index:g}, that of water is {INDEX_OF_WATER:g}: positions of "
        "keypoints below the surface and all speeds are wrong if the robot swims in water."
    ]


def _principal_point_warnings(camera: Camera) -> list[str]:
    if camera.matrix is None or camera.image_size_px is None:
        return []
    point, size = (camera.matrix[0][2], camera.matrix[1][2]), camera.image_size_px
    off = max(abs(at / full - 0.5) for at, full in zip(point, size, strict=True))
    if off <= PRINCIPAL_POINT_OFFSET_SHARE:
        return []
    return [
        f"The camera matrix has the axis of the lens at ({point[0]:.0f}, {point[1]:.0f}) px, "
        f"{100 * off:.0f} % of the picture from the middle of its {size[0]} x {size[1]} px. Is "
        "image_size_px the size of the calibration's pictures? A cropped picture is no whole one."
    ]


def _unvalidated_size_warnings(robot: Robot) -> list[str]:
    shortest, longest = VALIDATED_BODY_LENGTHS_M
    if shortest <= robot.body_length_m <= longest:
        return []
    return [
        f"body_length_m {robot.body_length_m:g} is outside {shortest:g} to {longest:g} m, the "
        "sizes on which the search for missing physics was validated. Is it in metres? If so, rely "
        "on named causes only where they reduce the error on held-out trials."
    ]


def _gyration_radius_warnings(robot: Robot) -> list[str]:
    length = robot.body_length_m + robot.tail_length_m
    radius = (robot.yaw_inertia_kg_m2 / robot.mass_kg) ** 0.5
    low, high = GYRATION_RADIUS_OVER_LENGTH_RANGE
    if low * length <= radius <= high * length:
        return []
    return [
        f"yaw_inertia_kg_m2 {robot.yaw_inertia_kg_m2:g} and mass_kg {robot.mass_kg:g} give a "
        f"radius of gyration of {radius:.3f} m, {radius / length:.2f} of the length from nose to "
        f"tail tip (expected: {low:.2f}, a spindle, to {high:.2f}, a rod with its mass at the "
        "ends; a uniform rod has 0.29). Check both and their units: all coefficients are "
        "proportional to mass_kg."
    ]


def inertia_warnings(robot: Robot, mismatch: Mapping[str, Any] | None) -> list[str]:
    """A sentence where a cause is probable that a wrong yaw inertia or mass looks like.

    mismatch: content of mismatch.json.
    """
    probabilities = (mismatch or {}).get("probabilities") or {}
    return [
        f"{name} has a probability of {probabilities[name]:.2f}, and a wrong yaw_inertia_kg_m2 or "
        f"mass_kg looks like it. study.yaml has {robot.yaw_inertia_kg_m2:g} kg m2 and "
        f"{robot.mass_kg:g} kg: check that both were measured, and their units, before you rely "
        "on this cause."
        for name in CAUSES_THAT_MIMIC_WRONG_INERTIA
        if probabilities.get(name, 0.0) > MIN_MIMIC_PROBABILITY
    ]


def _body_volume_warnings(setup: StudySettings) -> list[str]:
    """A body displaces its own mass of water: mean width = mass / (density x length x span)."""
    robot = setup.robot
    side = setup.water.density_kg_m3 * robot.body_length_m * robot.head_span_m
    width = robot.mass_kg / side
    share = width / robot.head_span_m
    if BODY_WIDTH_TO_HEIGHT_RANGE[0] <= share <= BODY_WIDTH_TO_HEIGHT_RANGE[1]:
        return []
    return [
        f"mass_kg {robot.mass_kg:g} displaces the water of a body {1000 * width:.0f} mm wide where "
        f"it is as high as head_span_m {robot.head_span_m:g}: width over height {share:.2g} "
        f"(plausible: {BODY_WIDTH_TO_HEIGHT_RANGE[0]:g} to {BODY_WIDTH_TO_HEIGHT_RANGE[1]:g}). "
        "Check both and their units: coefficients of "
        "forces are proportional to mass_kg and inversely proportional to head_span_m."
    ]
