"""From a swum path to pixels, with measurement errors, and back with the stated camera."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import dynamics as dy
from .camera import (
    Camera,
    corner_points,
    distort,
    pixels_to_pool,
    project,
    undistort,
    with_fitted_pose,
)
from .effects import BODY, HEAD1, HINGE, TAIL

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Optics:
    """Camera, depth of the keypoints (m), corners (4, 2) as imaged at `corner_height` (m)."""

    camera: Camera
    depth: float
    corners_px: Array
    corner_height: float
    axis: float


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml says of the optics."""

    camera: Camera
    depth: float
    pool: tuple[float, float]
    corners_px: Array


def body_points(path: Array, trial: Array, R: Array, E: Array, times: Array) -> Array:
    """Keypoints (frames, 5), complex (m): tip, hinge, stated centre, tail base, tail tip."""
    phi = np.array([dy.head_angle(t, trial, E) for t in times])
    head = np.exp(1j * (path[:, 2] + path[:, 12]))
    core = head * np.exp(1j * phi)
    centre = path[:, 0] + 1j * path[:, 1] + 1j * core * path[:, 14] - dy.com_shift(E[dy.COM]) * core
    hinge = centre + R[HINGE] * core
    base = centre - (R[BODY] - R[HEAD1] - R[HINGE]) * core
    beat = 0.45 * path[:, 16] * np.sin(2 * np.pi * path[:, 6])
    tip = base - R[TAIL] * core * np.exp(1j * beat)
    return np.stack([hinge + trial[dy.HEAD] * head, hinge, centre, base, tip], axis=1)


def label_bias(points: Array, errors: dict[str, tuple[int, float]]) -> Array:
    """Keypoints with a misplaced label: 1, 2 core centre along, across; 3 head tip across."""
    form, size = errors.get("keypoint_bias", (0, 0.0))
    moved = points.copy()
    core = points[:, 1] - points[:, 3]
    core = core / np.abs(core)
    if form in (1, 2):
        moved[:, 2] += size * core * (1.0 if form == 1 else 1j)
    elif form == 3:
        head = points[:, 0] - points[:, 1]
        moved[:, 0] += 1j * size * head / np.abs(head)
    return moved


def keypoint_depths(depth: float, p: Array, path: Array, times: Array) -> Array:
    """Depth (m) of the keypoints in time; sinking: 1 constant rate; 2 terminal; 3 squat, U^2."""
    drop = np.zeros_like(times)
    if p[0] == 1:
        drop = p[1] * times / 6.0
    elif p[0] == 2:
        drop = p[1] * (1 - np.exp(-times / 2.0))
    elif p[0] == 3:
        drop = p[1] * (path[:, 3] ** 2 + path[:, 4] ** 2) / 0.16
    return np.minimum(depth + drop, 0.28)


def camera_displacement_px(
    errors: dict[str, tuple[int, float]], order: float, times: Array
) -> Array:
    """Displacement (px) by a moved camera: 1 steps in some trials; 2 drift; 3 sway, 4.1 s."""
    form, size = errors.get("camera_shift", (0, 0.0))
    if form == 1:
        number = round(order * 100)
        return size * (times > 0.8 + (number % 7) * 0.35) * (1.0 if number % 4 == 0 else 0.0)
    if form == 2:
        return size * (1 - np.exp(-times / 2.5))
    if form == 3:
        return size * np.sin(2 * np.pi * times / 4.1 + 6 * order)
    return np.zeros_like(times)


def pixels_of_turned_camera(camera: Camera, pixels: Array, shift: Array, axis: float) -> Array:
    """Pixels (frames, parts, 2) after the camera turned by shift (px) / focal about `axis`."""
    if not np.any(shift):
        return pixels
    p = undistort(camera, (pixels - np.asarray(camera.centre)) / np.asarray(camera.focal))
    way = np.array([np.cos(axis), np.sin(axis)])
    tan = np.tan(shift / camera.focal[0])[:, None]
    along = p @ way
    new = (along + tan) / (1 - along * tan)
    across = (p @ np.array([-way[1], way[0]])) * np.cos(np.arctan(along)) / np.cos(np.arctan(new))
    p = new[..., None] * way + across[..., None] * np.array([-way[1], way[0]])
    return distort(camera, p) * np.asarray(camera.focal) + np.asarray(camera.centre)


def keypoint_pixels(
    path: Array, times: Array, trial: Array, R: Array, E: Array, *, optics: Optics,
    errors: dict[str, tuple[int, float]],
) -> Array:  # fmt: skip
    """Exact raw pixels (frames, 5, 2) of the keypoints."""
    points = label_bias(body_points(path, trial, R, E, times), errors)
    z = -keypoint_depths(optics.depth, E[dy.SINK], path, times)
    xyz = np.stack([points.real, points.imag, np.repeat(z[:, None], 5, axis=1)], axis=-1)
    pixels = project(optics.camera, xyz)
    shift = camera_displacement_px(errors, trial[dy.ORDER], times)
    return pixels_of_turned_camera(optics.camera, pixels, shift, optics.axis)


def wrong_lens(camera: Camera, form: int, size: float) -> Camera:
    """A camera whose lens model is wrong by `size` px near the corner of the image.

    1 radial (k1); 2 decentering (fisheye: k2); 3 principal point, by a third of the size.
    """
    rim = 0.5 * camera.size[0] / camera.focal[0]
    k = list(camera.distortion)
    relative = size / camera.focal[0]
    if form == 1:
        k[0] += relative / rim**3
    elif form == 2 and camera.model == "fisheye":
        k[1] += relative / np.arctan(rim) ** 5
    elif form == 2:
        k[2], k[3] = k[2] + 0.5 * relative / rim**2, k[3] + 0.5 * relative / rim**2
    else:
        u, v = camera.centre
        return replace(camera, centre=(u + 0.3 * size, v + 0.2 * size))
    return replace(camera, distortion=tuple(k))


def stated_setup(optics: Optics, errors: dict[str, tuple[int, float]]) -> StatedSetup:
    """What a lab states, and the camera pose that follows from it."""
    camera, depth, pool, corners = optics.camera, optics.depth, (2.6, 1.6), optics.corners_px
    form, size = errors.get("scale_error", (0, 0.0))
    if form == 1:
        pool = (round(2.6 * (1 + size), 4), round(1.6 * (1 + size), 4))
    elif form == 2:
        pool = (round(2.6 * (1 + size), 4), 1.6)
    elif form == 3:
        marks = corner_points(2.6, 1.6, optics.corner_height)
        middle = np.array([1.3, 0.8, optics.corner_height])
        corners = corners - project(camera, marks)
        corners = corners + project(camera, middle + (marks - middle) / (1 + size))
    form, size = errors.get("lens_error", (0, 0.0))
    if form:
        camera = wrong_lens(camera, form, size)
    form, size = errors.get("uncorrected_refraction", (0, 0.0))
    if form == 1:
        camera = replace(camera, index=round(1.333 - 0.333 * size, 4))
    elif form == 2:
        depth = round(depth * (1 - size), 4)
    marks = corner_points(*pool, optics.corner_height)
    return StatedSetup(with_fitted_pose(camera, corners, marks), depth, pool, corners)


def apparent_pose(pixels: Array, view: StatedSetup) -> Array:
    """Core centre x, y (m), heading, head angle (rad) and log length as the lab sees them."""
    xy = pixels_to_pool(view.camera, pixels, view.depth)
    p = xy[..., 0] + 1j * xy[..., 1]
    head, core = p[:, 0] - p[:, 1], p[:, 1] - p[:, 3]
    length = np.log(np.abs(head) + np.abs(core))
    phi = np.angle(core / head)
    return np.stack([p[:, 2].real, p[:, 2].imag, np.unwrap(np.angle(head)), phi, length], axis=1)
