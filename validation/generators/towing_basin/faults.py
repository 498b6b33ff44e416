"""What the study says about its own measurement, and hidden errors in it.

A law takes a `ViewingConditions` and returns another one with the error in it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from .form import MEASUREMENT, Array, Form

ShapeParameters = Mapping[str, float]
Clock = Callable[[int, Array], Array]
Shift = Callable[[int, Array, Array], Array]
Label = Callable[[Array], Array]


@dataclass(frozen=True)
class ViewingConditions:
    """Stated values and what happens between pool and file.

    depth, index, pool, focal, distortion: as study.yaml states them; focal is a factor.
    clock: (trial, stated time) -> true time, s. shift: (trial, time, pixels) -> pixels.
    labels: body part -> offset of the label in core axes, m, for head angles in rad.
    """

    depth: float
    index: float
    pool: tuple[float, float]
    focal: float = 1.0
    distortion: tuple[float, ...] = ()
    clock: Clock = lambda _, t: t
    shift: Shift = lambda _, __, pixels: pixels
    labels: Mapping[str, Label] = field(default_factory=dict)


def scale_uniform(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """Both lengths of the pool are stated 1 + s times too large."""
    return replace(v, pool=(v.pool[0] * (1 + s), v.pool[1] * (1 + s)), focal=v.focal)


def scale_length(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """Only the length."""
    return replace(v, pool=(v.pool[0] * (1 + s), v.pool[1]))


def scale_width(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """Only the width."""
    return replace(v, pool=(v.pool[0], v.pool[1] * (1 + s)))


def clock_constant(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The stated frame rate is 1 + s times too high."""
    return replace(v, clock=lambda _, t: t * (1 + s))


def clock_some_trials(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """In some of the trials."""
    return replace(v, clock=lambda k, t: t * (1 + s * _has_error(p, k)))


def clock_drift(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The frame rate falls within a recording, by s at 10 s."""
    return replace(v, clock=lambda _, t: t * (1 + s * t / 10))


def offset_video_first(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The video begins s seconds before the motor."""
    return replace(v, clock=lambda _, t: t - s)


def offset_log_first(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The motor begins s seconds before the video."""
    return replace(v, clock=lambda _, t: t + s)


def offset_varies(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """Each trial has its own offset between 0 and 2 s seconds, video first."""
    return replace(v, clock=lambda k, t: t - 2 * s * _uniform_of_trial(p, k))


def shift_translation(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """The camera is pushed by s pixels within some of the trials and stays."""
    way = s * np.array([np.cos(p["way"]), np.sin(p["way"])])

    def shift(k: int, t: Array, pixels: Array) -> Array:
        late = (t > 1.5 + 2 * _uniform_of_trial(p, k + 500)) * _has_error(p, k)
        return pixels + late[..., None] * way

    return replace(v, shift=shift)


def shift_rotation(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """The camera turns by s milliradians about its axis within some of the trials."""

    def shift(k: int, t: Array, pixels: Array) -> Array:
        late = (t > 1.5 + 2 * _uniform_of_trial(p, k + 500)) * _has_error(p, k)
        centred = pixels - np.array([1920.0, 1080.0])
        across = np.stack([-centred[..., 1], centred[..., 0]], axis=-1)
        return pixels + 1e-3 * s * late[..., None] * across

    return replace(v, shift=shift)


def shift_drift(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """The mount sinks: s pixels in 10 s in every trial."""
    way = s * np.array([np.cos(p["way"]), np.sin(p["way"])])
    return replace(v, shift=lambda _, t, pixels: pixels + t[..., None] / 10 * way)


def refraction_depth(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The depth is stated as 1 - s of itself."""
    return replace(v, depth=v.depth * (1 - s))


def refraction_index(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The index is stated as 1 + (1 - s)(n - 1)."""
    return replace(v, index=1 + (1 - s) * (v.index - 1))


def refraction_both(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """Depth and index are stated too small."""
    return refraction_depth(refraction_index(v, s * p["part"], p), s, p)


def lens_k1(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The first radial coefficient is stated s too large."""
    return replace(v, distortion=(v.distortion[0] + s, *v.distortion[1:]))


def lens_k2(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The second radial coefficient."""
    return replace(v, distortion=(v.distortion[0], v.distortion[1] + s, *v.distortion[2:]))


def lens_focal(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The focal length is stated 1 + s times too long."""
    return replace(v, focal=1 + s)


def bias_across(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The core's label sits s to port."""
    return replace(v, labels={"core_center": lambda angle: 1j * s + 0 * angle})


def bias_with_angle(v: ViewingConditions, s: float, p: ShapeParameters) -> ViewingConditions:
    """The core's label moves with the head: parallax of a raised marker."""
    return replace(v, labels={"core_center": lambda a: s * np.exp(1j * p["way"]) * np.sin(a)})


def bias_along(v: ViewingConditions, s: float, _: ShapeParameters) -> ViewingConditions:
    """The core's label sits s ahead of the centre of mass."""
    return replace(v, labels={"core_center": lambda angle: s + 0j * angle})


def _uniform_of_trial(p: ShapeParameters, k: int) -> float:
    """A number from 0 to 1 that belongs to a trial."""
    return float(np.random.default_rng([int(p["draw"] * 1e6), k]).random())


def _has_error(p: ShapeParameters, k: int) -> float:
    """1 in the part of the trials that have the error."""
    return float(_uniform_of_trial(p, k) < p["part"])


SURGE_AND_SWAY = ("surge", "sway")
TRIAL_CHOICE_RANGES = {"draw": (0.0, 1.0), "part": (0.4, 0.7)}
DIRECTION_RANGE = {"way": (-3.1, 3.1)}


def _fault(cause: str, name: str, law: object, variable: str, *size: object,
           **shape: tuple[float, float]) -> Form:  # fmt: skip
    unit, start, limit = size
    return Form(
        cause, name, "fault", law, SURGE_AND_SWAY, variable, unit, start, limit, shape, MEASUREMENT
    )


FORMS = (
    _fault("scale_error", "uniform", scale_uniform, "x_m", "1", 0.02, 0.2),
    _fault("scale_error", "length", scale_length, "x_m", "1", 0.02, 0.2),
    _fault("scale_error", "width", scale_width, "y_m", "1", 0.02, 0.2),
    _fault("clock_error", "constant", clock_constant, "time_s", "1", 0.02, 0.2),
    _fault(
        "clock_error",
        "some_trials",
        clock_some_trials,
        "time_s",
        "1",
        0.02,
        0.2,
        **TRIAL_CHOICE_RANGES,
    ),
    _fault("clock_error", "drift", clock_drift, "time_s", "1", 0.02, 0.2),
    _fault("time_offset", "video_first", offset_video_first, "time_s", "s", 0.05, 0.8),
    _fault("time_offset", "log_first", offset_log_first, "time_s", "s", 0.05, 0.8),
    _fault(
        "time_offset", "per_trial", offset_varies, "time_s", "s", 0.05, 0.5, **TRIAL_CHOICE_RANGES
    ),
    _fault(
        "camera_shift",
        "translation",
        shift_translation,
        "time_s",
        "px",
        3.0,
        60.0,
        **TRIAL_CHOICE_RANGES,
        **DIRECTION_RANGE,
    ),
    _fault(
        "camera_shift",
        "rotation",
        shift_rotation,
        "time_s",
        "mrad",
        3.0,
        60.0,
        **TRIAL_CHOICE_RANGES,
    ),
    _fault("camera_shift", "drift", shift_drift, "time_s", "px", 5.0, 80.0, **DIRECTION_RANGE),
    _fault("uncorrected_refraction", "depth", refraction_depth, "x_m", "1", 0.5, 1.0),
    _fault("uncorrected_refraction", "index", refraction_index, "x_m", "1", 0.5, 1.0),
    _fault(
        "uncorrected_refraction", "both", refraction_both, "x_m", "1", 0.5, 1.0, part=(0.3, 0.9)
    ),
    _fault("lens_error", "k1", lens_k1, "x_m", "1", 0.01, 0.15),
    _fault("lens_error", "k2", lens_k2, "x_m", "1", 0.02, 0.3),
    _fault("lens_error", "focal", lens_focal, "x_m", "1", 0.02, 0.2),
    _fault("keypoint_bias", "across", bias_across, "yaw_rate_rad_s", "m", 0.004, 0.04),
    _fault(
        "keypoint_bias",
        "with_angle",
        bias_with_angle,
        "head_angle_rad",
        "m",
        0.01,
        0.06,
        **DIRECTION_RANGE,
    ),
    _fault("keypoint_bias", "along", bias_along, "yaw_rate_rad_s", "m", 0.004, 0.04),
)
