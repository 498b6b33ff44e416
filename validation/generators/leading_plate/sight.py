"""How true places appear to a laboratory that trusts its study.yaml: errors of measurement."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .here import Law, Setting
from .optics import INDEX, Camera, corner_points, with_pose_of
from .robots import Array, Robot
from .water_laws import mass_shift

OPTICAL = ("scale_error", "camera_shift", "uncorrected_refraction", "lens_error", "sinking")
"""Causes that act between the water and the stated map of the picture."""


@dataclass(frozen=True)
class Scene:
    """Pool, marks, camera and depth of the labels as they are, and as the study states them."""

    robot: Robot
    pool: tuple[float, float]
    camera: Camera
    depth: float
    mark_height: float
    stated_pool: tuple[float, float]
    stated_depth: float
    stated_index: float
    stated_distortion: tuple[float, ...]
    marks: Array

    def stated_camera(self) -> Camera:
        """The camera as it follows from the stated marks."""
        camera = replace(self.camera, distortion=self.stated_distortion)
        return with_pose_of(camera, corner_points(self.stated_pool, self.mark_height), self.marks)


def true_scene(
    robot: Robot, pool: tuple[float, float], camera: Camera, depth: float, height: float
) -> Scene:
    """A scene that is stated as it is."""
    return Scene(robot, pool, camera, depth, height, pool, depth, INDEX, camera.distortion,
                 camera.project(corner_points(pool, height)))  # fmt: skip


def with_error(scene: Scene, law: Law) -> Scene:
    """The scene with an error of measurement in what is stated, or in the lens."""
    size = law.side * law.size
    if law.name == "scale_error":
        if law.form == "rim":  # marks on a rim inside the corners
            inset = abs(size) * scene.pool[0] / 2
            marks = scene.camera.project(corner_points(scene.pool, scene.mark_height, inset))
            return replace(scene, marks=marks)
        length, width = scene.pool
        return replace(scene, stated_pool=(length * (1 + size), width * (1 + size)))
    if law.name == "uncorrected_refraction":
        if law.form == "depth":
            return replace(scene, stated_depth=scene.depth * (1 - law.size) + 0.001)
        return replace(scene, stated_index=1 + (INDEX - 1) * (1 - law.size))
    if law.name == "lens_error":
        terms = np.array(scene.camera.distortion)
        if law.form == "quintic":
            terms[1] += 2 * size
        elif law.form == "tangential":
            angle = 6 * law.shape[0]
            terms[2:4] += 0.15 * size * np.array([np.cos(angle), np.sin(angle)])
        else:
            terms[0] += size
        camera = replace(scene.camera, distortion=tuple(terms.tolist()))
        marks = camera.project(corner_points(scene.pool, scene.mark_height))
        return replace(scene, camera=camera, marks=marks)
    return scene


def with_delay(setting: Setting, law: Law) -> Setting:
    """A setting whose recordings start before the release."""
    spread = (7.31 * setting.order + law.shape[0]) % 1.0
    factor = 0.3 + 1.4 * spread if law.form == "by_trial" else np.ones_like(spread)
    return setting.but(delay=law.size * factor)


def clock_error(law: Law, order: Array) -> Array:
    """Stated over true frame rate, less one."""
    part = order >= 0.5 if law.form == "later_trials" else np.ones_like(order)
    return law.side * law.size * part


def label_shift(law: Law, robot: Robot) -> complex:
    """Displacement of labels in axes of the core (m)."""
    angle = np.pi * (0.2 + 0.6 * law.shape[0])
    return law.size * robot.body_length * np.exp(1j * law.side * angle)


def sunk(law: Law, robot: Robot, time: Array) -> Array:
    """Depth gained (m)."""
    x = np.maximum(time, 0) / 12.0
    if law.form == "accelerating":
        grown = x**2
    elif law.form == "saturating":
        grown = (1 - np.exp(-3 * x)) / (1 - np.exp(-3))
    else:
        grown = x
    return law.size * robot.body_length * grown


def moved_pixels(law: Law, scene: Scene, setting: Setting, pixels: Array, time: Array) -> Array:
    """Pixels (..., 2) of a camera that is knocked during some of the trials."""
    span, order = setting.span[:, None, None], setting.order[:, None, None]
    hit = ((5.17 * order + law.shape[1]) % 1.0 < 0.6) * 1.0
    step = 0.5 + 0.5 * np.tanh((time - (0.35 + 0.3 * law.shape[0]) * span) / 0.02)
    middle = np.array(scene.camera.size) / 2
    away = (pixels[..., 0] - middle[0]) + 1j * (pixels[..., 1] - middle[1])
    if law.form == "turn":
        away = away * np.exp(1j * law.side * law.size * hit * step)
    else:
        back = 0.5 + 0.5 * np.tanh((time - 0.8 * span) / 0.02) if law.form == "returning" else 0.0
        unit = scene.camera.focal[0] / (scene.camera.position[2] + scene.depth)
        far = law.size * scene.robot.body_length * unit * np.exp(6.28j * law.shape[1])
        away = away + far * hit * (step - back)
    return np.stack([away.real + middle[0], away.imag + middle[1]], axis=-1)


def seen_places(laws: tuple[Law, ...], scene: Scene, setting: Setting, time: Array,
                labels: Array) -> Array:  # fmt: skip
    """Pixels of labels (complex, columns x instants x labels) at times (columns x instants)."""
    depth = np.full(time.shape, scene.depth)
    for law in laws:
        if law.name == "sinking":
            depth = depth + sunk(law, scene.robot, time - setting.delay[:, None])
    places = np.stack([labels.real, labels.imag], axis=-1)
    pixels = scene.camera.film(places, np.broadcast_to(depth[..., None], labels.shape))
    for law in laws:
        if law.name == "camera_shift":
            pixels = moved_pixels(law, scene, setting, pixels, time[..., None])
    return pixels


def apparent(laws: tuple[Law, ...], scene: Scene, setting: Setting, time: Array, *,
             place: Array, core: Array) -> tuple[Array, Array, Array]:  # fmt: skip
    """Apparent place (complex), direction of the core, length ratio; arrays columns x instants."""
    core_axis = np.exp(1j * core)
    half = 0.25 * scene.robot.body_length
    middle = place + 0j
    for law in laws:
        if law.name == "centre_of_mass_shift":
            shift = mass_shift(law, setting.phi)[:, None] * scene.robot.body_length
            middle = middle - shift * core_axis
        elif law.name == "keypoint_bias":
            middle = middle + label_shift(law, scene.robot) * core_axis
    labels = np.stack([middle, middle + half * core_axis, middle - half * core_axis], axis=-1)
    if any(law.name in OPTICAL for law in laws):
        for law in laws:
            scene = with_error(scene, law)
        pixels = seen_places(laws, scene, setting, time, labels)
        seen = scene.stated_camera().locate(pixels, scene.stated_depth, scene.stated_index)
        labels = seen[..., 0] + 1j * seen[..., 1]
    along = labels[..., 1] - labels[..., 2]
    turned = np.angle(along / core_axis)
    return labels[..., 0], core + turned, np.abs(along) / (2 * half)
