"""Faults of measurement: clocks, labels, the camera's place and what the study states.

Stages: clock law(t, k, trials, s, p); label law(points, axis, phi, s, p), in place; shift
law(px, t, k, s, p, camera); stated law(statement, scene, s, p); deep: depth beyond the stated, m.
"""

# ruff: noqa: ARG001, PLR0917 - laws of one stage share their arguments

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .form import Form, form_maker
from .scene import Scene, StatedSetup

Array = NDArray[np.float64]
ShapeParameters = Any


def _uniform_of_trial(k: int, number: float) -> float:
    """A number from 0 to 1 that depends on the trial."""
    return float(np.modf(np.abs(np.sin((k + 1) * 12.9898 + number) * 43758.5453))[0])


def clock_constant(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """Frames are exposed a factor 1 + s later than the frame rate states."""
    return t * (1 + s)


def clock_some_trials(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """In about half of the trials."""
    return t * (1 + s * (_uniform_of_trial(k, p["seed"]) < 0.5))


def clock_drift(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """A rate that changes: t (1 + s t/8 s)."""
    return t * (1 + s * t / 8)


def offset_video_first(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """The video starts s before the motor and its log."""
    return t - s


def offset_log_first(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """The motor and its log start s before the video."""
    return t + s


def offset_varies(t: Array, k: int, n: int, s: float, p: ShapeParameters) -> Array:
    """The video starts earlier by up to 2 s, different in each trial."""
    return t - 2 * s * _uniform_of_trial(k, p["seed"])


def bias_across(points: Any, axis: Any, phi: Array, s: float, p: ShapeParameters) -> None:
    """All labels of the core lie s to port and some ahead of their marks."""
    points[:, 1:4] += s * np.exp(1j * p["way_rad"]) * 1j * axis[:, None]


def bias_with_head_angle(points: Any, axis: Any, phi: Array, s: float, p: ShapeParameters) -> None:
    """The core's centre is drawn to the inside of a bent body: s sin phi/sin 45 deg."""
    points[:, 2] += 1j * axis * s * np.sin(phi) / np.sin(np.pi / 4)


def bias_core_center(points: Any, axis: Any, phi: Array, s: float, p: ShapeParameters) -> None:
    """One label, the core's centre, along the axis and across."""
    points[:, 2] += s * np.exp(1j * p["way_rad"]) * axis


def bias_head_tip(points: Any, axis: Any, phi: Array, s: float, p: ShapeParameters) -> None:
    """One label, the head's tip, across the head."""
    nose = points[:, 0] - points[:, 1]
    points[:, 0] += 1j * s * nose / np.abs(nose)


def _displacements_so_far(t: Array, k: int, p: ShapeParameters, many: int = 1) -> Array:
    """Number of camera displacements before the time t; the first within 1.5 to 4 s."""
    first = 1.5 + 2.5 * _uniform_of_trial(k, p["seed"])
    return sum((t > first + 1.1 * i).astype(float) for i in range(many))  # type: ignore[return-value]


def _direction(p: ShapeParameters) -> Array:
    return np.array([np.cos(p["way_rad"]), np.sin(p["way_rad"])])


def shift_displacement(
    px: Array, t: Array, k: int, s: float, p: ShapeParameters, camera: Camera
) -> Array:
    """The image moves by s px at some time in half of the trials."""
    return px + s * (_displacements_so_far(t, k, p) * (_uniform_of_trial(k, p["seed"] + 1) < 0.5))[
        ..., None
    ] * _direction(p)


def shift_roll(px: Array, t: Array, k: int, s: float, p: ShapeParameters, camera: Camera) -> Array:
    """The camera rolls about its axis: s px at the image's edge, in half of the trials."""
    angle = (
        s
        / (camera.size[0] / 2)
        * _displacements_so_far(t, k, p)
        * (_uniform_of_trial(k, p["seed"] + 1) < 0.5)
    )
    from_centre = px - camera.matrix[:2, 2]
    turned = np.exp(1j * angle) * (from_centre[..., 0] + 1j * from_centre[..., 1])
    return np.stack([turned.real, turned.imag], -1) + camera.matrix[:2, 2]


def shift_drift(px: Array, t: Array, k: int, s: float, p: ShapeParameters, camera: Camera) -> Array:
    """The camera sinks on its stand: s px in 8 s, in every trial."""
    return px + s * (np.clip(t, 0, None) / 8)[..., None] * _direction(p)


def shift_repeated(
    px: Array, t: Array, k: int, s: float, p: ShapeParameters, camera: Camera
) -> Array:
    """Three displacements a trial, of s px each."""
    return px + s * _displacements_so_far(t, k, p, 3)[..., None] * _direction(p)


def _with_pool_scale(said: StatedSetup, length: float, width: float) -> StatedSetup:
    L, W, depth = said.pool
    return replace(said, pool=(L * length, W * width, depth))


def scale_uniform(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """Length and width stated a factor 1 + s too large."""
    return _with_pool_scale(said, 1 + s, 1 + s)


def scale_length(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """Only the length is wrong."""
    return _with_pool_scale(said, 1 + s, 1)


def scale_corner_marks(
    said: StatedSetup, scene: Scene, s: float, p: ShapeParameters
) -> StatedSetup:
    """The marks were clicked on a rim that is smaller than the pool by the factor 1 + s."""
    centre = said.marks.mean(0)
    return replace(said, marks=centre + (said.marks - centre) / (1 + s))


def refraction_index(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """The stated index corrects only a share 1 - s of the refraction."""
    return replace(said, index=1 + (said.index - 1) * (1 - s))


def refraction_index_and_depth(
    said: StatedSetup, scene: Scene, s: float, p: ShapeParameters
) -> StatedSetup:
    """Index and depth are both stated too low."""
    return replace(refraction_index(said, scene, s, p), depth=said.depth * (1 - 0.6 * s))


def _with_lens_error(said: StatedSetup, which: int, by: float) -> StatedSetup:
    k = said.distortion.copy()
    k[which] += by
    return replace(said, distortion=k)


def lens_first_radial(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """Wrong first radial coefficient."""
    return _with_lens_error(said, 0, s)


def lens_second_radial(
    said: StatedSetup, scene: Scene, s: float, p: ShapeParameters
) -> StatedSetup:
    """Wrong second radial coefficient."""
    return _with_lens_error(said, 1, 3 * s)


def lens_centre(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """Wrong tangential coefficient; for a fisheye lens a wrong principal point."""
    if not scene.camera.fisheye:
        return _with_lens_error(said, 2, s / 3)
    matrix = said.matrix.copy()
    matrix[0, 2] += s * matrix[0, 0]
    return replace(said, matrix=matrix)


def lens_focal(said: StatedSetup, scene: Scene, s: float, p: ShapeParameters) -> StatedSetup:
    """Wrong focal length, absorbed in part by the height of the pose."""
    return replace(said, matrix=said.matrix * [[1 + s], [1 + s], [1]] - np.array(
        [[0, 0, s * said.matrix[0, 2]], [0, 0, s * said.matrix[1, 2]], [0, 0, 0]]))  # fmt: skip


SEED, WAY = {"seed": (0.0, 100.0)}, {"way_rad": (0.0, 2 * np.pi)}
ALL_CHANNELS = ("surge", "sway", "yaw")
_clock = form_maker("clock_error", "clock", "1", ALL_CHANNELS, signed=True)
_time = form_maker("time_offset", "clock", "s", ALL_CHANNELS)
_bias = form_maker("keypoint_bias", "label", "m", ("sway", "yaw"), signed=True)
_shift = form_maker("camera_shift", "shift", "px", ALL_CHANNELS, signed=True)
_scale = form_maker("scale_error", "stated", "1", ALL_CHANNELS, signed=True)
_index = form_maker("uncorrected_refraction", "stated", "1", ALL_CHANNELS)
_depth = form_maker("uncorrected_refraction", "deep", "m", ALL_CHANNELS)
_lens_error = form_maker("lens_error", "stated", "1", ALL_CHANNELS, signed=True)
FORMS: tuple[Form, ...] = (
    _clock("constant", clock_constant, 1e-4, 0.12),
    _clock("part_of_trials", clock_some_trials, 1e-4, 0.12, **SEED),
    _clock("drift", clock_drift, 1e-4, 0.12),
    _time("video_first", offset_video_first, 1e-3, 0.8),
    _time("log_first", offset_log_first, 1e-3, 0.8),
    _time("per_trial", offset_varies, 1e-3, 0.6, **SEED),
    _bias("across", bias_across, 3e-4, 0.03, way_rad=(-0.7, 0.7)),
    _bias("with_angle", bias_with_head_angle, 3e-4, 0.03),
    _bias("centre", bias_core_center, 3e-4, 0.03, **WAY),
    _bias("tip", bias_head_tip, 3e-4, 0.03),
    _shift("translation", shift_displacement, 0.1, 40, **SEED, **WAY),
    _shift("rotation", shift_roll, 0.1, 60, **SEED),
    _shift("drift", shift_drift, 0.1, 60, **WAY),
    _shift("several", shift_repeated, 0.1, 25, **SEED, **WAY),
    _scale("uniform", scale_uniform, 5e-4, 0.2),
    _scale("length", scale_length, 5e-4, 0.2),
    _scale("marks", scale_corner_marks, 5e-4, 0.2),
    _depth("depth", lambda *_: None, 1e-3, 0.3),
    _index("index", refraction_index, 0.01, 1),
    _index("index_and_depth", refraction_index_and_depth, 0.01, 1),
    _lens_error("k1", lens_first_radial, 1e-4, 0.1),
    _lens_error("k2", lens_second_radial, 1e-4, 0.1),
    _lens_error("tangential", lens_centre, 1e-4, 0.1),
    _lens_error("focal", lens_focal, 1e-4, 0.15),
)
