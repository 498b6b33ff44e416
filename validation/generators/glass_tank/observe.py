"""From the state of the robot to the pixels of its labels, with the errors of the measurement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import camera
from .design import Study
from .form import Array, Cause, Clock, Look, Marks, Quantity, act

LABELS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Pose:
    """x, y: centre of mass, m. psi, phi: core direction and head angle, rad. head: length, m."""

    x: Array
    y: Array
    psi: Array
    phi: Array
    head: Array


def frame_times(
    stated: Array, trial: Array, causes: Sequence[Cause], strengths: Sequence[float] | Array
) -> Array:
    """Motor time (s) of frames of these trials that the study dates `stated` (s)."""
    clock = Clock(stated, trial, np.asarray(stated, float))
    act("clock", clock, causes, strengths)
    return clock.t


def label_pixels(
    study: Study,
    pose: Pose,
    clock: Clock,
    strengths: Sequence[float] | Array,
    *,
    beat: Quantity = 0.0,
    misplaced: Array | None = None,
    pose_change: Array | None = None,
) -> Array:
    """Pixels of the five labels, complex u + i v, (5, frames).

    beat: angle of the tail, rad. misplaced: shifts of the first four labels, complex, m, core axes.
    pose_change: of the camera, as in `Camera.moved`.
    """
    robot, view, hinge = study.robot, study.camera, study.robot.hinge_to_com
    tail = -robot.tail_arm + 0j
    labels = [hinge + pose.head * np.exp(-1j * pose.phi), hinge + 0j, 0j, tail]
    if misplaced is not None:
        labels = [a + b for a, b in zip(labels, misplaced, strict=True)]
    labels.append(tail - robot.tail_length * np.exp(1j * beat))
    look = Look(
        pose.phi,
        clock,
        labels,
        depth=robot.keypoint_depth + 0 * pose.x,
        index=study.index_stated,
        pool_depth=robot.pool_depth,
        camera=view,
        middle=view.size[0] / 2 + 0.5j * view.size[1],
    )
    for place in ("body", "depth", "lens"):
        act(place, look, study.causes, strengths)
    lens = look.camera if pose_change is None else look.camera.moved(pose_change)
    axis, centre = np.exp(1j * pose.psi), pose.x + 1j * pose.y
    pixels = []
    for label in look.labels:
        point = centre + axis * (label + look.offset)
        u, v = camera.project(lens, point.real, point.imag, look.depth, look.index)
        pixels.append(u + 1j * v)
    look.pixels = np.stack(pixels)
    act("pixel", look, study.causes, strengths)
    return look.pixels


def corner_marks(
    study: Study, strengths: Sequence[float] | Array, pose_change: Array | None = None
) -> Array:
    """Pixels (4, 2) where the marks should appear, given the stated pool and the strengths."""
    marks = Marks(np.array(study.size_stated, float), study.camera)
    for place in ("lens", "corners"):
        act(place, marks, study.causes, strengths)
    lens = marks.camera if pose_change is None else marks.camera.moved(pose_change)
    return camera.corner_pixels(lens, marks.size, study.mark_height)
