"""Hidden faults of the measurement; every one changes the camera, the clock or study.yaml."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.random import Generator

from .law import Law, pick
from .typical import Typical
from .view import View


def _law(*head: Any, act: Callable[[View, float], None], **more: Any) -> Law:
    """A law of the measurement; head: name, form, key, unit, size, largest."""
    return Law(*head, kind="measurement", hooks={"view": act}, **more)


def scale_error(rng: Generator, _typical: Typical) -> Law:
    """Basin dimensions in study.yaml wrong by a factor."""
    form = pick(rng, "pool_dimensions", "length_only", "marks_inside_rim")
    sign = float(rng.choice([-1.0, 1.0]))
    # wrong tape, or outer instead of inner wall: typical blunders, Luhmann et al. (2014),
    # Close-Range Photogrammetry, ch. 7

    def act(view: View, size: float) -> None:
        length, width = view.pool_written
        if form == "pool_dimensions":
            view.pool_written = (length * (1 + sign * size), width * (1 + sign * size))
        elif form == "length_only":
            view.pool_written = (length * (1 + sign * size), width)
        else:
            view.marks_inset = size * length / 2

    return _law(
        "scale_error",
        form,
        "factor_minus_1",
        "1",
        0.03,
        0.10,
        act=act,
        sign=1.0 if form == "marks_inside_rim" else sign,
    )


def clock_error(rng: Generator, typical: Typical) -> Law:
    """Frame rate in trials.csv wrong."""
    form = pick(rng, "second_session", "drift_within_recording", "dropped_frames_some")
    count = len(typical.trials.phi)
    first = int(rng.integers(count // 3, 2 * count // 3 + 1))
    some = np.sort(rng.permutation(count)[: max(3, int(0.45 * count))])
    sign = float(rng.choice([-1.0, 1.0]))
    # variable frame rate and dropped frames of consumer cameras: Hedrick (2008), Bioinspir. Biomim.
    # 3, 034001; oscillator drift: Allan (1966), Proc. IEEE 54, 221

    def act(view: View, size: float) -> None:
        if form == "second_session":
            view.clock_rate[first:] *= 1 + sign * size
        elif form == "drift_within_recording":
            view.clock_drift += sign * size / 10.0
        else:
            view.clock_rate[some] *= 1 + size

    which = {"second_session": np.arange(first, count), "dropped_frames_some": some}.get(
        form, np.arange(count)
    )
    return _law(
        "clock_error",
        form,
        "rate_error",
        "1",
        0.02,
        0.06,
        act=act,
        sign=1.0 if form == "dropped_frames_some" else sign,
        extra={"trials_from_0": (which, "index")},
    )


def camera_shift(rng: Generator, typical: Typical) -> Law:
    """The camera moves during trials."""
    form = pick(rng, "knock_translation", "knock_rotation", "creep", "several_knocks")
    count = len(typical.trials.phi)
    hit = np.sort(
        rng.permutation(count)[: int(rng.integers(max(3, count // 4), max(4, count // 2)) + 1)]
    )
    when = np.array([rng.uniform(0.3, 0.65) * d for d in typical.trials.duration])
    later = np.array(
        [
            w + rng.uniform(0.15, 0.25) * d
            for w, d in zip(when, typical.trials.duration, strict=True)
        ]
    )
    towards = rng.uniform(-np.pi, np.pi, count)
    turning = rng.choice([-1.0, 1.0], count)
    length = typical.trials.pool[0]

    def act(view: View, size: float) -> None:
        def moves(time: np.ndarray, trial: int) -> np.ndarray:
            moved = np.zeros((len(time), 3))
            if trial not in hit:
                return moved
            way = np.array([np.cos(towards[trial]), np.sin(towards[trial])])
            if form == "creep":  # clamp giving way slowly, logarithmic creep (Andrade)
                share = np.log1p(np.maximum(time, 0) / 1.5) / np.log1p(
                    typical.trials.duration[trial] / 1.5
                )
            else:
                share = 1.0 / (1.0 + np.exp(-np.clip((time - when[trial]) / 0.03, -50, 50)))
            moved[:, :2] = size * share[:, None] * way
            if form == "knock_rotation":
                moved[:, :2] *= 0.3
                moved[:, 2] = turning[trial] * size * share / (0.25 * length)
            if form == "several_knocks":
                second = 1.0 / (1.0 + np.exp(-np.clip((time - later[trial]) / 0.03, -50, 50)))
                moved[:, :2] += size * 0.8 * second[:, None] * np.array([-way[1], way[0]])
            return moved

        view.moves = moves

    return _law(
        "camera_shift",
        form,
        "size",
        "m",
        0.02,
        0.08,
        act=act,
        extra={"trials_from_0": (hit, "index"), "time": (when[hit].round(3), "s")},
    )


def uncorrected_refraction(rng: Generator, typical: Typical) -> Law:
    """Index or depth in study.yaml too small."""
    form = pick(rng, "depth_understated", "index_too_low")
    # n = 1 forgotten, or water line assumed too low: Treibitz et al. (2012), IEEE TPAMI 34, 51

    def act(view: View, size: float) -> None:
        if form == "depth_understated":  # robot deeper than written
            view.depth = view.depth_written + size * typical.length
        else:
            view.depth = view.depth_written = view.robot.depth + 1.2 * size * typical.length
            view.index_written = 1.333 - 0.333 * min(size / 0.25, 1.0)

    return _law("uncorrected_refraction", form, "size_over_body_length", "1", 0.3, 1.2, act=act)


def lens_error(rng: Generator, typical: Typical) -> Law:
    """Lens of the wrong zoom or calibration in study.yaml."""
    form = pick(rng, "k2_wrong", "k1_wrong", "tangential", "focal_length")
    sign = float(rng.choice([-1.0, 1.0]))
    if form == "tangential" and typical.lens_model == "fisheye":
        form = "k2_wrong"
    # Brown (1971), Photogramm. Eng. 37, 855; changes with focus: Fraser & Al-Ajlouni (2006)

    def act(view: View, size: float) -> None:
        dist, k = view.lens_written.dist, view.lens_written.k
        if form == "k1_wrong":
            dist[0] += sign * size
        elif form == "k2_wrong":
            dist[1] += sign * size * 1.2
        elif form == "tangential":
            dist[2] += sign * size * 0.3
            dist[3] -= sign * size * 0.2
        else:
            k[0] *= 1 + sign * size * 1.2
            k[1] *= 1 + sign * size * 1.2

    return _law("lens_error", form, "error", "1", 0.03, 0.12, act=act, sign=sign)


def time_offset(rng: Generator, typical: Typical) -> Law:
    """Motor log and video started apart."""
    form = pick(rng, "per_trial", "video_first", "log_first")
    count = len(typical.trials.phi)
    spread = (
        np.abs(1 + 0.35 * rng.standard_normal(count)) if form == "per_trial" else np.ones(count)
    )

    def act(view: View, size: float) -> None:
        view.time_shift = view.time_shift + (size if form == "log_first" else -size) * spread

    return _law(
        "time_offset",
        form,
        "delay",
        "s",
        0.2,
        0.6,
        act=act,
        extra={"times_per_trial": (spread.round(4), "1")},
    )


def keypoint_bias(rng: Generator, typical: Typical) -> Law:
    """A label that sits beside its place on the body."""
    form = pick(rng, "core_across", "core_with_head_angle", "head_tip_across", "tail_base_across")
    sign = float(rng.choice([-1.0, 1.0]))
    # systematic label placement: Mathis et al. (2018), Nat. Neurosci. 21, 1281

    def act(view: View, size: float) -> None:
        left_offset = sign * size
        if form == "core_across":
            view.bias["core_center"] = lambda phi: np.full(len(phi), 1j * left_offset)
        elif form == "core_with_head_angle":
            view.bias["core_center"] = lambda phi: (0.4 + 1j) * left_offset * np.sin(phi) * 2
        elif form == "head_tip_across":
            view.bias["head_tip"] = lambda phi: 1j * left_offset * np.exp(-1j * phi)
        else:
            view.bias["tail_base"] = lambda phi: np.full(len(phi), 1j * left_offset)

    return _law(
        "keypoint_bias",
        form,
        "displacement",
        "m",
        0.02 * typical.length,
        0.12 * typical.length,
        act=act,
        sign=sign,
    )
