"""Errors of the measurement: what differs between the true set-up and the files of the study.

Sizes are prescribed, since a refit of the coefficients absorbs most of the effect on paths.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .camera import Camera
from .form import Array

_FORMS = {
    "scale_error": (("uniform", "length_only"), (0.025, 0.06), "1"),
    "clock_error": (("all_trials", "later_trials"), (0.025, 0.08), "1"),
    "camera_shift": (("tilted", "moved"), (0.010, 0.025), "m"),
    "uncorrected_refraction": (("index_1", "depth_0"), (0.10, 0.17), "m"),
    "lens_error": (("k1", "k1_and_k2"), (0.04, 0.09), "1"),
    "time_offset": (("video_first", "by_hand"), (0.35, 0.9), "s"),
    "keypoint_bias": (("core_center", "core_and_hinge", "with_head_angle"), (0.007, 0.014), "m"),
}
"""Forms, range of the size, and unit of each error."""
_SIGNED = ("scale_error", "clock_error", "lens_error", "keypoint_bias")
HINGE, CORE_CENTER = 1, 2
"""Indices of keypoints that may be misplaced."""


@dataclass(frozen=True)
class Fault:
    """An error of the measurement. size: in `unit`. where: trials in which it acts (trials,)."""

    name: str
    form: str
    size: float
    unit: str
    where: Array


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml states. pool, keypoint_depth, corner_height: m. corners: px (4, 2)."""

    pool: tuple[float, float]
    distortion: tuple[float, ...]
    index: float
    keypoint_depth: float
    corners: Array
    corner_height: float
    renamed: bool


@dataclass(frozen=True)
class Bump:
    """Trial, and share of its frames, after which the camera is the bumped one."""

    trial: int
    share: float
    camera: Camera


def draw_fault(rng: np.random.Generator, name: str, trials: int) -> Fault:
    """The error of this name with form and size.

    All errors are drawn, so that the draws that follow do not depend on the name.
    """
    sign = rng.choice([-1.0, 1.0])
    later = np.arange(trials) >= rng.integers(trials // 3, trials // 2 + 1)
    drawn = {
        key: (str(rng.choice(forms)), float(rng.uniform(*span)), unit)
        for key, (forms, span, unit) in _FORMS.items()
    }
    form, size, unit = drawn[name]
    where = later if form == "later_trials" else np.ones(trials, bool)
    return Fault(name, form, float(sign * size) if name in _SIGNED else size, unit, where)


def misstated(fault: Fault | None, stated: StatedSetup) -> StatedSetup:
    """The set-up as the study states it, with the error."""
    if fault is None:
        return stated
    k, form = fault.size, fault.form
    if fault.name == "scale_error":
        length, width = stated.pool
        return replace(stated, pool=(length * (1 + k), width * (1 + k if form == "uniform" else 1)))
    if fault.name == "lens_error":
        k1, k2, *others = stated.distortion
        k2 = k2 - (0.4 * k if form == "k1_and_k2" else 0)
        return replace(stated, distortion=(k1 + k, k2, *others))
    if fault.name == "uncorrected_refraction":
        without_index = form == "index_1"
        return replace(stated, index=1.0) if without_index else replace(stated, keypoint_depth=0.0)
    return stated


def clock_rate(fault: Fault | None, trial: int) -> float:
    """Stated over true frame rate of a trial."""
    slow = fault is not None and fault.name == "clock_error" and fault.where[trial]
    return 1 + fault.size if fault and slow else 1.0


def draw_delays(rng: np.random.Generator, fault: Fault | None, trials: int) -> Array:
    """Seconds (trials,) by which the video starts before the motor."""
    if fault is None or fault.name != "time_offset":
        return np.zeros(trials)
    spread = 0.12 if fault.form == "by_hand" else 0.0
    return np.maximum(fault.size + spread * rng.standard_normal(trials), 0.1)


def misplaced(fault: Fault | None, points: Array, psi: Array, phi: Array) -> Array:
    """Keypoints (frames, 5, 2) with labels that are always placed to one side of the core."""
    if fault is None or fault.name != "keypoint_bias":
        return points
    turning = fault.form == "with_head_angle"
    growth = np.sin(phi) / np.sin(np.radians(35)) if turning else np.ones_like(phi)
    size = fault.size * growth
    side = size[:, None] * np.stack([-np.sin(psi), np.cos(psi)], -1)
    points = points.copy()
    for label in [CORE_CENTER, HINGE] if fault.form == "core_and_hinge" else [CORE_CENTER]:
        points[:, label] += side
    return points


def draw_bump(
    rng: np.random.Generator, fault: Fault | None, camera: Camera, trials: int
) -> Bump | None:
    """The bump of a camera shift, in the middle half of the trials."""
    if fault is None or fault.name != "camera_shift":
        return None
    angle = rng.uniform(0, 2 * np.pi)
    d = fault.size * np.array([np.cos(angle), np.sin(angle)])
    height = camera.position[2]
    if fault.form == "tilted":
        moved = camera.bumped(d[0] / height, d[1] / height, (0, 0))
    else:
        moved = camera.bumped(0, 0, d)
    trial = int(rng.integers(trials // 4, trials - trials // 4))
    return Bump(trial, float(rng.uniform(0.2, 0.7)), moved)
