"""Errors of the measurement, and sinking, which the camera sees as one.

A fault changes the time at which a frame is exposed, the depth or the place of a label, the
picture, or what study.yaml states. Its stage says which.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .optics import StatedSetup
from .robots import Array

KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class FrameTimes:
    """Frames of one trial: time by the stated clock, length of the trial (s), its number."""

    t: Array
    length: float
    trial: int
    trials: int

    def draw(self, p: Shape) -> float:
        """A number in 0 to 1 that belongs to this trial."""
        return float(np.random.default_rng([int(p["key"]), self.trial]).random())


def _offset_of_trial(m: FrameTimes, k: float, p: Shape) -> Array:
    return m.t - 2 * k * m.draw(p)


def _some_trials(m: FrameTimes, k: float, p: Shape) -> Array:
    return m.t * (1 + (k if m.trial >= p["from"] * m.trials else 0.0))


def _drifting_clock(m: FrameTimes, k: float, _: Shape) -> Array:
    return m.t * (1 + k * m.t / 8)


def _jolt_displacement(m: FrameTimes, p: Shape, times: int = 1) -> Array:
    """Displacement of the picture in units of the strength: 0 before a jolt, 1 after it."""
    if m.draw(p) > p["share"]:
        return np.zeros_like(m.t)
    at = np.random.default_rng([int(p["key"]), m.trial, 1]).uniform(0.25, 0.75, times)
    return sum((m.t > a * m.length).astype(float) * (-0.7) ** i for i, a in enumerate(at))


def _displaced_image(m: FrameTimes, k: float, p: Shape, times: int = 1) -> Array:
    return _jolt_displacement(m, p, times) * k * np.exp(1j * p["towards"])


def _drifting_camera(m: FrameTimes, k: float, p: Shape) -> Array:
    rate = 0.0 if m.draw(p) > p["share"] else 1.0
    return rate * k * m.t / 8 * np.exp(1j * p["towards"])


def _pool_scale(length: float, width: float) -> Any:
    def law(s: StatedSetup, k: float, _: Shape) -> StatedSetup:
        a, b, depth = s.pool
        return replace(s, pool=(a * (1 + k * length), b * (1 + k * width), depth))

    return law


def _inset_corners(s: StatedSetup, k: float, _: Shape) -> StatedSetup:
    a, b, depth = s.pool
    return replace(s, pool=(a + k * b, b + k * b, depth))  # the same strip on every side


def _lens_coefficient_error(place: int, share: float) -> Any:
    def law(s: StatedSetup, k: float, _: Shape) -> StatedSetup:
        wrong = s.distortion.copy()
        wrong[min(place, len(wrong) - 1)] += share * k
        return replace(s, distortion=wrong)

    return law


def _focal_length_error(s: StatedSetup, k: float, _: Shape) -> StatedSetup:
    wrong = s.matrix.copy()
    wrong[[0, 1], [0, 1]] *= 1 + 0.3 * k
    return replace(s, matrix=wrong)


_JOLT_RANGES = {"key": (1, 1e6), "share": (0.35, 0.8), "towards": (-3.1, 3.1)}
FAULTS: list[Form] = [
    *forms(
        "scale_error",
        "stated",
        0.003,
        0.09,
        "",
        "",
        {
            "both": _pool_scale(1, 1),
            "length": _pool_scale(1, 0),
            "width": _pool_scale(0, 1),
            "inset": _inset_corners,
        },
        signed=True,
    ),
    *forms(
        "clock_error",
        "time",
        0.002,
        0.08,
        "",
        "",
        {
            "constant": lambda m, k, _: m.t * (1 + k),
            "some trials": (_some_trials, {"from": (0.3, 0.6)}),
            "drift": _drifting_clock,
        },
        signed=True,
    ),
    *forms(
        "camera_shift",
        "picture",
        0.5,
        60.0,
        "px",
        "",
        {
            "translation": _displaced_image,
            "rotation": lambda m, k, p: _jolt_displacement(m, p) * k,
            "drift": _drifting_camera,
            "several": lambda m, k, p: _displaced_image(m, k, p, 3),
        },
        _JOLT_RANGES,
    ),
    *forms(
        "uncorrected_refraction",
        "depth",
        0.04,
        0.45,
        "m",
        "",
        {
            "no index": lambda s, _k, _p: replace(s, index=1.0),
            "low index": lambda s, _k, p: replace(s, index=p["index"]),
            "shallow": lambda s, _k, p: replace(s, depth=s.depth * p["depth"]),
        },
        {"index": (1.08, 1.2), "depth": (0.1, 0.5)},
    ),
    *forms(
        "lens_error",
        "stated",
        0.001,
        0.12,
        "",
        "",
        {
            "k1": _lens_coefficient_error(0, 1.0),
            "k2": _lens_coefficient_error(1, 2.0),
            "tangential": _lens_coefficient_error(2, 0.1),
            "focal": _focal_length_error,
        },
        signed=True,
    ),
    *forms(
        "time_offset",
        "time",
        0.01,
        0.9,
        "s",
        "",
        {
            "video first": lambda m, k, _: m.t - k,
            "log first": lambda m, k, _: m.t + 0.6 * k,
            "each trial": (_offset_of_trial, {"key": (1, 1e6)}),
        },
    ),
    *forms(
        "keypoint_bias",
        "label",
        5e-4,
        0.012,
        "m",
        "",
        {
            "along": lambda phi, k, _: {"core_center": k + 0 * phi},
            "across": lambda phi, k, _: {"core_center": 1j * k + 0 * phi},
            "hinge": lambda phi, k, _: {"hinge": 1j * k + 0 * phi},
            "with head": lambda phi, k, _: {"core_center": 1.5j * k * np.sin(phi)},
        },
        signed=True,
    ),
]
SINKING: list[Form] = forms("sinking", "sink", 0.004, 0.4, "m in 8 s", "surge", {
    "linear": lambda m, k, _: k * m.t / 8,
    "square": lambda m, k, _: k * (m.t / 8) ** 2,
    "saturating": lambda m, k, _: k * (1 - np.exp(-m.t / 2.5)),
})  # fmt: skip
