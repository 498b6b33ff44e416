"""Errors of measurement: their forms and sizes, what the study states, and what they displace."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .camera import Camera, corner_points, with_fitted_pose
from .experiment import PER_SEGMENT, SEGMENTS
from .robots import Array, Robot
from .trials import Session

INDEX = 1.333
FORMS = {
    "scale_error": ("both_sides", "length_alone", "width_alone", "marks_inside_the_rim"),
    "clock_error": ("whole_session", "second_camera", "growing", "every_third_trial"),
    "camera_shift": ("step", "rotation", "drift", "two_steps"),
    "uncorrected_refraction": ("air", "shallow_depth", "low_index", "depth_of_surface"),
    "lens_error": ("barrel", "higher_order", "tangential", "none_stated"),
    "time_offset": ("late_motor", "late_in_part", "scattered", "growing_delay"),
    "keypoint_bias": ("core_to_port", "core_forward", "core_with_head", "hinge_to_port"),
}
"""Forms of each error."""
RANGES = {
    "scale_error": (0.02, 0.07, "1"), "clock_error": (0.015, 0.06, "1"),
    "camera_shift": (0.04, 0.14, "body lengths"),
    "uncorrected_refraction": (0.35, 0.9, "body lengths"), "lens_error": (0.03, 0.12, "1"),
    "time_offset": (0.3, 1.2, "body times"), "keypoint_bias": (0.025, 0.1, "body lengths"),
}  # fmt: skip
"""Sizes and unit. Of refraction: true depth of the labels."""
SIGNED = ("scale_error", "clock_error", "lens_error", "keypoint_bias", "camera_shift")


@dataclass(frozen=True)
class Fault:
    """An error with its size. strength: share of it in each trial. moment: when it begins, share of
    a trial. direction (rad): of shifts.
    """

    name: str
    form: str
    size: float
    strength: Array
    moment: Array
    direction: float


@dataclass(frozen=True)
class Stated:
    """What study.yaml states of pool (m), water, depth of the labels (m) and lens."""

    pool: tuple[float, float]
    index: float
    depth: float
    distortion: tuple[float, ...]


@dataclass(frozen=True)
class Scene:
    """Robot, session, pool and camera; true depth of the labels (m) and height of the marks (m)."""

    robot: Robot
    session: Session
    pool: tuple[float, float]
    camera: Camera
    depth: float
    mark_height: float


def draw_fault(rng: np.random.Generator, name: str, session: Session) -> Fault:
    """An error of a drawn form and size."""
    form = str(rng.choice(FORMS[name]))
    low, high, _ = RANGES[name]
    size = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    sign = rng.choice([-1, 1]) if name in SIGNED else 1
    count = session.count
    strength = np.ones(count)
    if form == "second_camera":
        strength = (rng.permutation(count) < count // 2).astype(float)
    elif form == "every_third_trial":
        strength = (np.arange(count) % 3 == rng.integers(3)).astype(float)
    elif form in {"growing", "growing_delay"}:
        strength = 0.3 + 1.4 * session.order
    elif form == "late_in_part" or name == "camera_shift":
        strength = (rng.permutation(count) < max(3, 0.6 * count)).astype(float)
    elif form == "scattered":
        strength = rng.uniform(0.2, 1.8, count)
    return Fault(name, form, float(sign * size), strength, rng.uniform(0.25, 0.6, count),
                 float(rng.uniform(-np.pi, np.pi)))  # fmt: skip


def true_depth(fault: Fault | None, robot: Robot) -> float:
    """Depth of the labels (m); refraction left out shows in a robot that swims well below."""
    deep = fault is not None and fault.name == "uncorrected_refraction"
    return round(fault.size * robot.body_length, 3) if fault and deep else robot.keypoint_depth


def stated_of(fault: Fault | None, scene: Scene) -> Stated:
    """What the study states, with the error."""
    (length, width), index, depth = scene.pool, INDEX, scene.depth
    distortion = scene.camera.distortion
    form, size = (fault.form, fault.size) if fault else ("", 0.0)
    if fault and fault.name == "scale_error":
        inset = size * width if form == "marks_inside_the_rim" else 0.0
        length = length + inset + (size * length if form in {"both_sides", "length_alone"} else 0)
        width = width + inset + (size * width if form in {"both_sides", "width_alone"} else 0)
    index = {"air": 1.0, "low_index": 1.1}.get(form, index)
    depth = {"shallow_depth": 0.3 * depth, "depth_of_surface": 0.0}.get(form, depth)
    if fault and fault.name == "lens_error":
        distortion = _other_lens(distortion, form, size)
    return Stated((round(length, 4), round(width, 4)), index, round(depth, 4), distortion)


def _other_lens(k: tuple[float, ...], form: str, size: float) -> tuple[float, ...]:
    """Distortion with an error: of k1, of k2, tangential (of k1 and k3 in a fisheye), or none."""
    if form == "barrel":
        return (k[0] + size, *k[1:])
    if form == "higher_order":
        return (k[0], k[1] + 1.5 * size, *k[2:])
    if form == "tangential" and len(k) == 5:
        return (*k[:2], k[2] + 0.12 * size, k[3] - 0.08 * size, k[4])
    if form == "tangential":
        return (k[0] + 0.8 * size, k[1], k[2] - size, k[3])
    return (round(k[0] + size, 5) if abs(k[0]) < 0.03 else 0.0, *(0.0 for _ in k[1:]))


def reconstruction(fault: Fault | None, scene: Scene) -> Camera:
    """Camera as it is inferred from the stated lens and the marks."""
    stated = stated_of(fault, scene)
    lens = replace(scene.camera, distortion=stated.distortion)
    pixels = scene.camera.project(corner_points(scene.pool, scene.mark_height))
    return with_fitted_pose(lens, corner_points(stated.pool, scene.mark_height), pixels)


def apparent(fault: Fault, scene: Scene, observation: Array) -> Array:
    """An observation (..., trials, SAMPLES, 3) as it appears with the error."""
    if fault.name in {"scale_error", "uncorrected_refraction", "lens_error"}:
        return _misplaced(fault, scene, observation)
    if fault.name in {"clock_error", "time_offset"}:
        return _mistimed(fault, scene, observation)
    seen = observation.copy()
    if fault.name == "camera_shift":
        steps = (np.arange(seen.shape[-2]) + 1) / seen.shape[-2]
        moved = shift_course(fault, steps[None, :], np.arange(scene.session.count)[:, None])
        length = scene.robot.body_length
        along, turn = fault.size * length * moved[0], fault.size * moved[1] * length / scene.pool[1]
        dx, dy = (seen[..., i] - scene.pool[i] / 2 for i in (0, 1))
        seen[..., 0] += along * np.cos(fault.direction) - turn * dy
        seen[..., 1] += along * np.sin(fault.direction) + turn * dx
        seen[..., 2] += turn
        return seen
    forward, port, turned = label_shift(fault, scene.robot, scene.session.phi[:, None])
    c, s = np.cos(seen[..., 2]), np.sin(seen[..., 2])
    seen[..., 0] += forward * c - port * s
    seen[..., 1] += forward * s + port * c
    seen[..., 2] += turned
    return seen


def _misplaced(fault: Fault, scene: Scene, observation: Array) -> Array:
    """Filmed by the true camera and located by the inferred one."""
    stated, inferred = stated_of(fault, scene), reconstruction(fault, scene)
    x, y, theta = (observation[..., i] for i in range(3))
    reach = 0.2 * scene.robot.body_length
    places = []
    for ahead in (0.0, reach):
        pixels = scene.camera.film(
            x + ahead * np.cos(theta), y + ahead * np.sin(theta), scene.depth, INDEX
        )
        places.append(inferred.locate(pixels, stated.depth, stated.index))
    heading = np.arctan2(places[1][1] - places[0][1], places[1][0] - places[0][0])
    turned = (heading - theta + np.pi) % (2 * np.pi) - np.pi
    return np.stack([*places[0], theta + turned], axis=-1)


def _mistimed(fault: Fault, scene: Scene, observation: Array) -> Array:
    """Segments seen at another rate, or the first one later; first order in the time error."""
    parts = observation.reshape(*observation.shape[:-2], SEGMENTS, PER_SEGMENT, 3)
    slope = np.gradient(parts, axis=-2)
    step = np.arange(1, PER_SEGMENT + 1)[:, None]
    if fault.name == "clock_error":
        late = fault.size * fault.strength[:, None, None, None] * step
        return np.asarray((parts - late * slope).reshape(observation.shape))
    interval = scene.session.duration / observation.shape[-2]
    delay = fault.size * fault.strength * scene.robot.body_time / interval
    first = np.arange(SEGMENTS)[:, None, None] == 0
    late = np.minimum(delay[:, None, None, None], step) * first
    return np.asarray((parts - late * slope).reshape(observation.shape))


def shift_course(fault: Fault, share: Array, trial: Array) -> tuple[Array, Array]:
    """Shift and rotation of the camera in units of the size at a share of a trial."""
    begin = fault.moment[trial]
    strength = fault.strength[trial]
    gone = strength * (share >= begin)
    if fault.form == "drift":
        return strength * share * 1.3, 0 * share
    if fault.form == "rotation":
        return 0 * share, gone * 2.0
    if fault.form == "two_steps":
        return gone * 0.7 + 0.7 * strength * (share >= begin + 0.25), 0 * share
    return gone, 0 * share


def label_shift(fault: Fault, robot: Robot, phi: Array) -> tuple[Array, Array, Array]:
    """Displacement of the core label, forward and to port of the head (m), and of the heading."""
    length = fault.size * robot.body_length
    if fault.form == "core_to_port":
        return -length * np.sin(phi), length * np.cos(phi), 0 * phi
    if fault.form == "core_forward":
        return length * np.cos(phi), length * np.sin(phi), 0 * phi
    if fault.form == "core_with_head":
        return 0.5 * length + 0 * phi, length + 0 * phi, 0 * phi
    return 0 * phi, 0 * phi, np.arctan2(-length, robot.head_length) + 0 * phi
