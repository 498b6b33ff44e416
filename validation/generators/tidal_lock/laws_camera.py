"""Measurement errors: camera and pool as stated, clock, start, labels, camera displacements.

Stages: `camera` maps the true camera to the stated one; `clock` maps recorded to true time;
`label` gives offsets (core_center in core axes, head_tip in head axes); `displacement` gives the
shift (px, complex) and rotation (rad) of the image at time t. Lens terms follow Brown (1971) and
Kannala and Brandt (2006).
"""

from dataclasses import replace

import numpy as np

from .form import Form, family


def _with_pool_size_error(camera, along, across):
    return replace(camera, size=(camera.size[0] * along, camera.size[1] * across))


def _corners_towards_centre(camera, p):
    middle = camera.corners.mean(axis=0)
    return replace(camera, corners=middle + (camera.corners - middle) * (1 - p.amp))


_SCALE = {
    "uniform": lambda c, p: _with_pool_size_error(c, 1 + p.amp, 1 + p.amp),
    "per_axis": lambda c, p: _with_pool_size_error(c, 1 + p.amp, 1.0),
    "corner_marks": _corners_towards_centre,
}
SCALE = family("scale_error", "camera", ("error", "1", lambda _b: 0.1), _SCALE, signed=True)


def _lower_refractive_index(camera, p):
    return replace(camera, index=1 + (camera.index - 1) * (1 - p.amp))


_REFRACTION = {
    "wrong_depth": lambda c, p: replace(c, depth=c.depth * (1 - p.amp)),
    "wrong_index": _lower_refractive_index,
    "both": lambda c, p: replace(_lower_refractive_index(c, p), depth=c.depth * (1 - 0.5 * p.amp)),
}
REFRACTION = family(
    "uncorrected_refraction", "camera", ("missing_share", "1", lambda _b: 1.0), _REFRACTION
)


def _distortion_error(place):
    def law(camera, p):
        distortion = list(camera.distortion)
        distortion[place] += p.amp
        return replace(camera, distortion=tuple(float(k) for k in distortion))

    return law


_LENS = {
    "k1": _distortion_error(0),
    "k2": _distortion_error(1),
    "third_term": (_distortion_error(2), {}, {"magnitude": ("error", "1", lambda _b: 0.015)}),
    "focal_length": lambda c, p: replace(
        c, focal=(float(c.focal[0] * (1 + p.amp)), float(c.focal[1] * (1 + p.amp)))
    ),
}
LENS = family("lens_error", "camera", ("error", "1", lambda _b: 0.08), _LENS, signed=True)

_CLOCK = {
    "constant": lambda t, p, _trial: t * (1 + p.amp),
    "part_of_trials": lambda t, p, trial: t * (1 + p.amp * (p.draw[trial, 0] > 0)),
    "drift": lambda t, p, _trial: t * (1 + p.amp * t / 10),
}
CLOCK = family("clock_error", "clock", ("error", "1", lambda _b: 0.06), _CLOCK, signed=True)

_OFFSET = {
    "video_first": lambda t, p, trial: t - p.amp + 0 * trial,
    "log_first": lambda t, p, trial: t + p.amp + 0 * trial,
    "per_trial": lambda t, p, trial: t + p.amp * np.clip(p.draw[trial, 0], -1.5, 1.5),
}
OFFSET = family("time_offset", "clock", ("offset", "s", lambda _b: 1.0), _OFFSET)


def _core(offset):
    return offset, 0j * offset


_LABEL = {
    "constant": lambda phi, p: _core(1j * p.amp + 0 * phi),
    "with_head_angle": lambda phi, p: _core(1j * p.amp * phi / 0.5),
    "along_core": lambda phi, p: _core(p.amp + 0j * phi),
    "one_label": lambda phi, p: (0j * phi, 1j * p.amp + 0 * phi),
}
LABEL = family(
    "keypoint_bias", "label", ("offset", "m", lambda b: 0.06 * b.length), _LABEL, signed=True
)


def _after_displacement(t, p, trial):
    """1 after a displacement, which happens in about half of the trials."""
    return (t > p.moment * (1 + 0.1 * p.draw[trial, 1])) * (p.draw[trial, 0] > -0.2)


def _two_displacements(t, p, trial):
    first = (t > p.moment) * np.exp(3j * p.draw[trial, 0])
    return first + (t > 2 * p.moment) * np.exp(3j * p.draw[trial, 1])


_DISPLACEMENT = {"moment": (1.5, 3.5, "s"), "direction": (0.0, 6.283, "rad")}
_PX = ("shift", "px", lambda _b: 25.0)
_SHIFT = {
    "translation": (
        lambda t, p, trial: (
            p.amp * np.exp(1j * p.direction) * _after_displacement(t, p, trial),
            0.0,
        ),
        _DISPLACEMENT,
    ),
    "rotation": (
        lambda t, p, trial: (0j * t, p.amp * _after_displacement(t, p, trial)),
        _DISPLACEMENT,
        {"magnitude": ("angle", "rad", lambda _b: 0.05)},
    ),
    "drift": (
        lambda t, p, trial: (p.amp * np.exp(1j * p.direction) * t + 0 * trial, 0.0),
        {"direction": (0.0, 6.283, "rad")},
        {"magnitude": ("drift", "px/s", lambda _b: 6.0)},
    ),
    "several": (lambda t, p, trial: (p.amp * _two_displacements(t, p, trial), 0.0), _DISPLACEMENT),
}
SHIFT = family("camera_shift", "displacement", _PX, _SHIFT)

CAMERA_FORMS: list[Form] = [
    replace(form, kind="measurement")
    for form in [*SCALE, *REFRACTION, *LENS, *CLOCK, *OFFSET, *LABEL, *SHIFT]
]
