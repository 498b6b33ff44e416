"""Laws of the head's plate: they change the factors of lift, drag and moment in place."""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .motion import Flow


def _logistic(c: Flow, p: Shape) -> Any:
    return 1 / (1 + np.exp(-(np.abs(c.alpha) - p["onset"]) / p["width"]))


def _stall_step(c: Flow, k: float, p: Shape) -> None:
    loss = 1 - k * _logistic(c, p)
    c.lift, c.moment = c.lift * loss, c.moment * loss


def _stall_kirchhoff(c: Flow, k: float, p: Shape) -> None:
    # C_N of a separated plate ((1 + sqrt f) / 2)^2 (Kirchhoff; Leishman and Beddoes 1989)
    attached = np.clip(1 - k * _logistic(c, p), 0.0, 1)
    loss = (0.5 * (1 + np.sqrt(attached))) ** 2
    c.lift, c.moment = c.lift * loss, c.moment * loss


def _stall_moment(c: Flow, k: float, p: Shape) -> None:
    loss = _logistic(c, p)
    c.lift, c.moment = c.lift * (1 - k * loss), c.moment * (1 - min(2 * k, 1.0) * loss)


def _stall_delayed(c: Flow, k: float, _: Shape) -> None:
    loss = 1 - k * c.z[0]  # separated share with a relaxation time (Goman and Khrabrov 1994)
    c.lift, c.moment = c.lift * loss, c.moment * loss


def _separation(c: Flow, _k: float, p: Shape) -> Any:
    if "delay" not in p:
        return np.zeros_like(c.z)
    time = p["delay"] * c.lanes.head / np.maximum(c.V, 0.03)
    return np.stack([(_logistic(c, p) - c.z[0]) / time, 0 * c.z[0]])


def _sine_of_double_angle(c: Flow) -> Any:
    s = np.sin(2 * c.alpha)
    return np.where(np.abs(s) < 1e-6, 1e-6, s)


def _lag_first(c: Flow, _k: float, _: Shape) -> None:
    ratio = c.z[0] / _sine_of_double_angle(c)
    c.lift, c.moment = c.lift * ratio, c.moment * ratio


def _lag_lift_only(c: Flow, _k: float, _: Shape) -> None:
    c.lift = c.lift * c.z[0] / _sine_of_double_angle(c)


def _lag_wagner(c: Flow, _k: float, _: Shape) -> None:
    # Jones: 1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s), s in half chords
    ratio = 0.5 + (0.165 * c.z[0] + 0.335 * c.z[1]) / _sine_of_double_angle(c)
    c.lift, c.moment = c.lift * ratio, c.moment * ratio


def _lag_circulation(c: Flow, _k: float, _: Shape) -> None:
    ratio = c.z[0] / np.maximum(c.V, 0.02) / _sine_of_double_angle(c)  # z is V sin(2 alpha)
    c.lift, c.moment = c.lift * ratio, c.moment * ratio


def _lift_memory_rate(c: Flow, k: float, p: Shape) -> Any:
    """Memory of sin(2 alpha) over k chords; with `jones`, over two lengths."""
    s, rate = np.sin(2 * c.alpha), np.maximum(c.V, 0.02) / (k * c.lanes.head)
    if "jones" in p:
        fast = 2 * np.maximum(c.V, 0.02) / (k * c.lanes.head)
        return np.stack([0.0455 * fast * (s - c.z[0]), 0.3 * fast * (s - c.z[1])])
    target = s * c.V if "circulation" in p else s
    return np.stack([rate * (target - c.z[0]), 0 * s])


def _side_asymmetry(name: str) -> Any:
    def law(c: Flow, k: float, p: Shape) -> None:
        a = c.alpha
        size = {"step": np.tanh(a / 0.01), "drag too": np.tanh(a / 0.01),
                "smooth": np.tanh(a / p.get("width", 0.2)),
                "large": np.sign(a) * np.clip((np.abs(a) - 0.08) / 0.3, 0, 1)}[name]  # fmt: skip
        c.lift, c.moment = c.lift * (1 + k * size), c.moment * (1 + k * size)
        if name == "drag too":
            c.drag = c.drag * (1 + 0.5 * k * size)

    return law


_ONSET_RANGES = {"onset": (0.18, 0.35), "width": (0.02, 0.06)}
FORMS: list[Form] = [
    *forms(
        "stall",
        "head",
        0.02,
        0.95,
        "",
        "sway yaw",
        {
            "step": _stall_step,
            "kirchhoff": _stall_kirchhoff,
            "separate moment": _stall_moment,
            "delayed": (_stall_delayed, {**_ONSET_RANGES, "delay": (0.5, 3.0)}),
        },
        _ONSET_RANGES,
        memory=_separation,
    ),
    *forms(
        "lift_lag",
        "head",
        0.06,
        8.0,
        "chords",
        "sway yaw",
        {
            "first order": _lag_first,
            "lift alone": _lag_lift_only,
            "wagner": (_lag_wagner, {"jones": (1, 1)}),
            "circulation": (_lag_circulation, {"circulation": (1, 1)}),
        },
        memory=_lift_memory_rate,
    ),
    *forms(
        "port_starboard_asymmetry",
        "head",
        0.002,
        0.5,
        "",
        "sway yaw",
        {
            "step": _side_asymmetry("step"),
            "drag too": _side_asymmetry("drag too"),
            "large": _side_asymmetry("large"),
            "smooth": (_side_asymmetry("smooth"), {"width": (0.1, 0.35)}),
        },
        signed=True,
    ),
]
