"""Errors of measurement: each law takes a `View` and returns one with the error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from .form import MEASUREMENT, Array, Form
from .optics import Camera

Clock = Callable[[Array, Array], Array]
Shift = Callable[[Array, Array, Array], Array]
Labels = Callable[[str, Array], Array]


@dataclass(frozen=True)
class View:
    """What the camera does and what the study states of it.

    camera: the true one. lens: the stated one before its pose is found from the marks.
    index, depth: true; stated_index, stated_depth: stated. pool: true; stated_pool: stated.
    marks: stated pixels of the corners. clock: (video time, luck) -> time of the motion, s.
    shift: (pixels, video time, luck) -> recorded pixels. labels: (part, phi) -> offset of the label
    in core axes, complex, m.
    """

    camera: Camera
    lens: Camera
    pool: tuple[float, float]
    stated_pool: tuple[float, float]
    index: float
    stated_index: float
    depth: float
    stated_depth: float
    marks: Array
    marks_height: float
    clock: Clock
    shift: Shift
    labels: Labels


def scale_uniform(view: View, s: float) -> View:
    """Pool lengths stated (1 + s) times too long: a stretched tape."""
    length, width = view.pool
    return replace(view, stated_pool=(length * (1 + s), width * (1 + s)))


def scale_along(view: View, s: float) -> View:
    """Only the pool's length is stated wrong."""
    return replace(view, stated_pool=(view.pool[0] * (1 + s), view.pool[1]))


def scale_of_marks(view: View, s: float) -> View:
    """Corner pixels picked (1 + s) times too near their middle: rim in place of water line."""
    middle = view.marks.mean()
    return replace(view, marks=middle + (view.marks - middle) / (1 + s))


def clock_constant(view: View, s: float) -> View:
    """The recording runs (1 + s) times slower than stated."""
    return replace(view, clock=lambda t, _: t * (1 + s))


def clock_in_some(view: View, s: float, part: float) -> View:
    """Only a part of the trials has the wrong rate: a setting changed between days."""
    return replace(view, clock=lambda t, luck: t * (1 + s * (luck < part)))


def clock_drifting(view: View, s: float) -> View:
    """The rate error grows in a trial to twice its mean over 10 s: a warming oscillator."""
    return replace(view, clock=lambda t, _: t * (1 + s * t / 10))


def _since(t: Array, luck: Array) -> Array:
    """Step at 25 to 75 % of 10 s, over 0.1 s."""
    return 1 / (1 + np.exp(-np.clip((t - (2.5 + 5 * luck)) / 0.05, -60, 60)))


def shift_translation(view: View, px: float, way: float) -> View:
    """The picture jumps by px pixels once in each trial."""
    step = px * np.exp(1j * way)
    return replace(view, shift=lambda z, t, luck: z + step * _since(t, luck))


def shift_rotation(view: View, px: float) -> View:
    """The picture turns about its middle once in each trial; px: at the left edge."""
    middle = complex(view.camera.size[0], view.camera.size[1]) / 2
    angle = px / middle.real
    return replace(
        view, shift=lambda z, t, luck: middle + (z - middle) * np.exp(1j * angle * _since(t, luck))
    )


def shift_drift(view: View, px: float, way: float) -> View:
    """The picture moves steadily, px pixels in 10 s: a mount that sags."""
    pace = px * np.exp(1j * way) / 10
    return replace(view, shift=lambda z, t, _: z + pace * t)


def refraction_depth(view: View, s: float) -> View:
    """Keypoints are stated shallower by a share s of their depth."""
    return replace(view, stated_depth=view.depth * (1 - s))


def refraction_index(view: View, s: float) -> View:
    """The index is stated nearer to 1 by a share s."""
    return replace(view, stated_index=1 + (view.index - 1) * (1 - s))


def refraction_both(view: View, s: float) -> View:
    """Depth and index are both stated too small, by s and s/2."""
    return replace(refraction_index(view, s / 2), stated_depth=view.depth * (1 - s))


def _with_lens(view: View, k: int, change: float) -> View:
    values = list(view.lens.distortion)
    values[k] += change
    return replace(view, lens=replace(view.lens, distortion=tuple(values)))


def lens_cubic(view: View, s: float) -> View:
    """k1 stated wrong by s (Zhang 2000, calibration with few boards)."""
    return _with_lens(view, 0, s)


def lens_quintic(view: View, s: float) -> View:
    """k2 stated wrong by s."""
    return _with_lens(view, 1, s)


def lens_focal(view: View, s: float) -> View:
    """Focal length stated (1 + s) times too long: zoom moved after the calibration."""
    fx, fy = view.lens.focal
    return replace(view, lens=replace(view.lens, focal=(fx * (1 + s), fy * (1 + s))))


def video_first(view: View, delay: float) -> View:
    """The recording starts `delay` s before the motor, in every trial."""
    return replace(view, clock=lambda t, _: np.maximum(t - abs(delay), 0))


def video_first_varying(view: View, delay: float) -> View:
    """The delay differs among trials, 0.5 to 1.5 times its mean: two hands."""
    return replace(view, clock=lambda t, luck: np.maximum(t - abs(delay) * (0.5 + luck), 0))


def video_first_in_some(view: View, delay: float, part: float) -> View:
    """A part of the trials has the delay."""
    return replace(view, clock=lambda t, luck: np.maximum(t - abs(delay) * (luck < part), 0))


def label_across(view: View, size: float) -> View:
    """All labels lie `size` m to port of the midline: parallax of a raised back."""
    return replace(view, labels=lambda _, phi: 1j * size + 0 * phi)


def label_with_angle(view: View, size: float) -> View:
    """All labels move across by size sin(phi)/sin(30 deg): a sticker that twists."""
    return replace(view, labels=lambda _, phi: 2j * size * np.sin(phi))


def label_of_core(view: View, size: float) -> View:
    """Only the label of the core's centre is off, across."""
    return replace(
        view, labels=lambda part, phi: (1j * size if part == "core_center" else 0j) + 0 * phi
    )


def _view_form(
    cause: str,
    law: Callable[..., View],
    unit: str,
    start: float,
    limit: float,
    *,
    variable: str,
    shape: Mapping[str, tuple[float, float]] | None = None,
    signed: bool = True,
) -> Form:
    """A form that acts on the view; the seen motion changes in all channels."""
    return Form(cause, law, "view", unit, start, limit, ("surge", "sway", "yaw"), variable,
                MEASUREMENT, shape or {}, signed)  # fmt: skip


_WAY = {"way": (-3.14, 3.14)}
_PART = {"part": (0.35, 0.65)}
FORMS: tuple[Form, ...] = (
    *(_view_form("scale_error", law, "-", 0.03, 0.15, variable="position")
      for law in (scale_uniform, scale_along, scale_of_marks)),
    _view_form("clock_error", clock_constant, "-", 0.03, 0.2, variable="all rates"),
    _view_form("clock_error", clock_in_some, "-", 0.03, 0.2, variable="all rates", shape=_PART),
    _view_form("clock_error", clock_drifting, "-", 0.02, 0.12, variable="all rates"),
    _view_form("camera_shift", shift_translation, "px", 6, 60, variable="time", shape=_WAY,
               signed=False),
    _view_form("camera_shift", shift_rotation, "px", 8, 60, variable="time"),
    _view_form("camera_shift", shift_drift, "px", 10, 80, variable="time", shape=_WAY,
               signed=False),
    *(_view_form("uncorrected_refraction", law, "-", 0.5, 1.0,
                 variable="distance from the middle", signed=False)
      for law in (refraction_depth, refraction_index, refraction_both)),
    _view_form("lens_error", lens_cubic, "-", 0.03, 0.2, variable="distance from the middle"),
    _view_form("lens_error", lens_quintic, "-", 0.05, 0.4, variable="distance from the middle"),
    _view_form("lens_error", lens_focal, "-", 0.05, 0.25, variable="distance from the middle"),
    _view_form("time_offset", video_first, "s", 0.3, 2.0, variable="t at the start", signed=False),
    _view_form("time_offset", video_first_varying, "s", 0.3, 2.0, variable="t at the start",
               signed=False),
    _view_form("time_offset", video_first_in_some, "s", 0.3, 2.0, variable="t at the start",
               shape=_PART, signed=False),
    *(_view_form("keypoint_bias", law, "m", 0.008, 0.03, variable="heading")
      for law in (label_across, label_with_angle, label_of_core)),
)  # fmt: skip
