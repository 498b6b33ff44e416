"""What the camera is shown, what the study states, and faults of either."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .articulated import frequency, head_angle, laws_of_stage
from .camera import Camera, pool_corners
from .form import HiddenLaw
from .robots import ParallelTrials, Robot

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
SHAFT_STEP_S = 0.005
LINKAGE_STD = np.deg2rad(15)
"""Play between motor shaft and tail, trial by trial, rad of a beat."""


@dataclass(frozen=True)
class Scene:
    """Truth of the filming: labels (5,) m complex, in the frame of head or core; recoil and tail.

    recoil: amplitudes of heading (rad) and sway (m); phases: of both and of the tail (3, trials),
    rad; swing: amplitude of the tail, rad; height: of the marks above the water, m.
    """

    camera: Camera
    pool: tuple[float, float, float]
    height: float
    labels: Complex
    recoil: tuple[float, float]
    swing: float
    phases: Array


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml states: pool (m), matrix, distortion, index, depth (m), marks (4, 2) px."""

    pool: tuple[float, float, float]
    matrix: Array
    distortion: Array
    index: float
    depth: float
    marks: Array


def draw_scene(rng: np.random.Generator, camera: Camera, pool: tuple[float, float, float],
               trials: int) -> Scene:  # fmt: skip
    """Label errors below 1 mm; recoil of 0.4 to 2 deg and 0.5 to 2.5 mm; a tail that beats."""
    labels = np.clip(rng.normal(0, 3e-4, (2, 5)), -6e-4, 6e-4)
    phases = rng.uniform(0, 2 * np.pi, (3, 1)) + LINKAGE_STD * rng.normal(size=trials)
    return Scene(camera, pool, float(rng.choice([0.0, 0.0, 0.05, 0.1])), labels[0] + 1j * labels[1],
                 (np.deg2rad(rng.uniform(0.4, 2.0)), rng.uniform(5e-4, 2.5e-3)),
                 np.deg2rad(rng.uniform(12, 24)), phases)  # fmt: skip


def shaft_motion(
    lanes: ParallelTrials, laws: Sequence[HiddenLaw], seconds: float
) -> tuple[Array, Array]:
    """Times, s, and revolutions of the motor shaft (times, lanes), every 5 ms."""
    t = np.arange(int(np.ceil(seconds / SHAFT_STEP_S)) + 1) * SHAFT_STEP_S
    f = frequency(lanes, laws, t)
    sum_ = np.cumsum((f[1:] + f[:-1]) / 2 * SHAFT_STEP_S, 0)
    return t, lanes.shaft + np.concatenate([np.zeros((1, lanes.count)), sum_])


def body_points(
    states: Array,
    lanes: ParallelTrials,
    robot: Robot,
    laws: Sequence[HiddenLaw],
    times: Array,
    *,
    labels: Complex | None = None,
) -> Complex:
    """Places of head tip, hinge, core centre and tail base, m, (times, 4, lanes), complex."""
    x, th = states[:, 0] + 1j * states[:, 1], states[:, 2]
    phi, _ = head_angle(lanes, laws, np.asarray(times))
    nose, axis = np.exp(1j * th), np.exp(1j * (th + phi))
    shift = np.zeros_like(x)
    for i, law in laws_of_stage(laws, "mass"):
        c = type("C", (), {"phi": phi, "head": lanes.head, "robot": robot})
        shift = shift + law.form.law(c, lanes.size[i], law.shape)
    core = x + shift * axis
    hinge = core + robot.hinge_to_com * axis
    off = np.zeros(5, complex) if labels is None else labels
    return np.stack(
        [
            hinge + (lanes.head + off[0]) * nose,
            hinge + off[1] * axis,
            core + off[2] * axis,
            core + (off[3] - robot.tail_base) * axis,
        ],
        1,
    )


def keypoint_depth(
    robot: Robot, lanes: ParallelTrials, laws: Sequence[HiddenLaw], times: Array
) -> Array:
    """Depth of the keypoints, m, (times, lanes)."""
    depth = np.full((len(times), lanes.count), robot.depth)
    for i, law in laws_of_stage(laws, "sink"):
        depth = depth + law.form.law(np.asarray(times), lanes.size[i], law.shape)
    for i, _ in laws_of_stage(laws, "deep"):
        depth = depth + lanes.size[i]
    return depth


def stated_setup(scene: Scene, robot: Robot, laws: Sequence[HiddenLaw]) -> StatedSetup:
    """What the study states, with a fault where one is hidden."""
    camera = scene.camera
    marks = camera.project(pool_corners(scene.pool, scene.height))
    said = StatedSetup(
        scene.pool, camera.matrix, camera.distortion, camera.index, robot.depth, marks
    )
    for _, law in laws_of_stage(laws, "stated"):
        said = law.form.law(said, scene, law.sign * law.strength, law.shape)
    return said


def exposure_times(laws: Sequence[HiddenLaw], times: Array, k: int, trials: int) -> Array:
    """Motion times, s, of frames at stated times, s, in trial k; below zero before the start."""
    for _, law in laws_of_stage(laws, "clock"):
        return np.asarray(law.form.law(times, k, trials, law.sign * law.strength, law.shape))
    return times


def with_label_bias(points: Complex, phi: Array, laws: Sequence[HiddenLaw]) -> Complex:
    """Points (times, n, ...) whose labels are displaced by a bias; n from POINTS in order."""
    for _, law in laws_of_stage(laws, "label"):
        axis = points[:, 1] - points[:, 3]
        points = points.copy()
        law.form.law(points, axis / np.abs(axis), phi, law.sign * law.strength, law.shape)
    return points


def pixels_after_camera_shift(
    px: Array, times: Array, k: int, laws: Sequence[HiddenLaw], camera: Camera
) -> Array:
    """Pixels (times, n, 2) of trial k as a camera that was moved sees them."""
    for _, law in laws_of_stage(laws, "shift"):
        px = law.form.law(px, times[:, None], k, law.sign * law.strength, law.shape, camera)
    return px


def with_recoil(points: Complex, turns: Array, scene: Scene, k: int, times: Array, *,
          tail: float) -> Complex:  # fmt: skip
    """Points (times, 4) of trial k with recoil about the core's centre, and the tail's tip.

    turns: shaft, revolutions, at the motion times, s; tail: length, m. Result: (times, 5).
    """
    grown = 1 - np.exp(-np.clip(times, 0, None) / 0.2)
    beat = 2 * np.pi * turns[:, None] + scene.phases[:, k]
    yaw, sway, swing = (np.sin(beat) * grown[:, None]).T
    axis = points[:, 2] - points[:, 3]
    axis = axis / np.abs(axis)
    turn = np.exp(1j * scene.recoil[0] * yaw)
    centre = points[:, 2] + 1j * scene.recoil[1] * sway * axis
    body = centre[:, None] + (points - points[:, 2:3]) * turn[:, None]
    tip = body[:, 3] - axis * turn * (tail - scene.labels[4]) * np.exp(1j * scene.swing * swing)
    return np.concatenate([body, tip[:, None]], 1)
