"""Errors of the measurement: stated pool, clock, camera, refraction, lens and labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .form import MEASUREMENT, Cause, Clock, Family, Look, Marks, Quantity, Shape
from .robots import Robot

SCALED = {"uniform": [1, 1], "length": [1, 0], "width": [0, 1]}
"""Which of length and width of the pool a form of the scale error changes."""


def _scale(marks: Marks, strength: Quantity, cause: Cause) -> None:
    """The stated pool is (1 + strength) times the true one."""
    marks.size = marks.size / (1 + strength * np.array(SCALED[cause.form]))


def _clock(clock: Clock, strength: Quantity, cause: Cause) -> None:
    """True time t (1 + strength), in all or in some trials, or t (1 + strength t / 10 s)."""
    t = clock.stated
    if cause.form == "constant":
        clock.t = clock.t + strength * t
    elif cause.form == "some_trials":
        clock.t = clock.t + strength * t * np.isin(clock.trial, cause.shape["trials"])
    else:
        clock.t = clock.t + strength * t * t / 10


def _some_trials(rng: np.random.Generator, n: int, share: float) -> list[int]:
    """Sorted indices of a share of n trials."""
    count = max(1, round(share * n))
    return sorted(int(i) for i in rng.choice(n, count, replace=False))


def _draw_clock(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """The trials with the wrong clock, counted from 0."""
    return {"trials": _some_trials(rng, robot.trials, 0.4)} if form == "some_trials" else {}


def _offset(clock: Clock, strength: Quantity, cause: Cause) -> None:
    """The video starts `strength` seconds before the motor, after it, or varies by trial."""
    sign = {"video_first": -1.0, "log_first": 1.0}.get(cause.form, 0.0)
    clock.t = clock.t + strength * sign
    if cause.form == "per_trial":
        clock.t = clock.t + strength * np.array(cause.shape["factors"])[clock.trial]


def _draw_offset(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Share of the strength in each trial."""
    if form != "per_trial":
        return {}
    return {"factors": [round(float(v), 3) for v in rng.uniform(-1, 0.6, robot.trials)]}


def _displacement_direction(clock: Clock, shape: Shape) -> Quantity:
    """Unit vector of the image displacement at each frame, 0 before the camera is displaced."""
    moved = np.zeros(np.broadcast(clock.stated, clock.trial).shape, complex)
    for trial, start_s, angle in shape["displacements"]:
        moved = moved + ((clock.trial == trial) & (clock.stated >= start_s)) * np.exp(1j * angle)
    return moved


def _shift(look: Look, strength: Quantity, cause: Cause) -> None:
    """Image displaced by `strength` px: a step, a rotation, a drift, or steps in several trials.

    The turn moves a point 500 px from the middle by `strength`; the drift is that after 10 s.
    """
    clock, shape = look.clock, cause.shape
    if cause.form == "several":
        look.pixels = look.pixels + strength * _displacement_direction(clock, shape)
        return
    way, first = np.exp(1j * shape["to_rad"]), shape["trial"]
    after = (clock.trial == first) & (clock.stated >= shape["at_s"])
    moved = (clock.trial > first) | after
    if cause.form == "rotation":
        turn = np.exp(1j * strength / 500) - 1
        look.pixels = look.pixels + moved * (look.pixels - look.middle) * turn
    elif cause.form == "drift":
        late = clock.trial >= first
        look.pixels = look.pixels + late * strength * clock.stated / 10 * way
    else:
        look.pixels = look.pixels + strength * moved * way


def _draw_shift(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Direction, trial (counted from 0) and time of the camera displacement."""
    n = robot.trials
    shape: Shape = {
        "to_rad": round(rng.uniform(-np.pi, np.pi), 3),
        "trial": int(rng.integers(n // 4, n // 2 + 1)),
        "at_s": round(rng.uniform(2.0, 4.0), 2),
    }
    if form == "several":
        shape["displacements"] = [
            [k, round(rng.uniform(1.5, 4.5), 2), round(rng.uniform(-np.pi, np.pi), 3)]
            for k in _some_trials(rng, n, 0.3)
        ]
    return shape


def _refraction(look: Look, strength: Quantity, cause: Cause) -> None:
    """True depth (in pool depths) or true refractive index exceeds the stated one."""
    if cause.form == "wrong_depth":
        look.depth = look.depth + strength * look.pool_depth
    else:
        look.index = look.index + strength


def _lens(view: Look | Marks, strength: Quantity, cause: Cause) -> None:
    """True less stated lens: k1, k2, p1 (tangential), or the share of the focal length."""
    lens = view.camera
    if cause.form == "focal":
        view.camera = replace(lens, fx=lens.fx * (1 + strength), fy=lens.fy * (1 + strength))
        return
    place, change = {"k1": 0, "k2": 1, "tangential": 2}[cause.form], strength * cause.shape["gain"]
    distortion = (v + change if j == place else v for j, v in enumerate(lens.distortion))
    view.camera = replace(lens, distortion=tuple(distortion))


def _draw_lens(_rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Factor on the strength."""
    return {"gain": 0.1 if form == "tangential" else 1.0}


def _bias(look: Look, strength: Quantity, cause: Cause) -> None:
    """Labels placed `strength` m beside their spot.

    One across, the core's along, the head tip's across with the head angle, or all across.
    """
    if cause.form == "one_across":
        which = cause.shape["label"]
        look.labels[which] = look.labels[which] + 1j * strength
    elif cause.form == "core_along":
        look.labels[2] = look.labels[2] + strength
    elif cause.form == "with_head_angle":
        look.labels[0] = look.labels[0] + 1j * strength * np.sin(look.phi) / 0.5
    else:
        look.offset = look.offset + 1j * strength


def _draw_bias(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """The label that is misplaced."""
    return {"label": int(rng.choice([0, 2, 3]))} if form == "one_across" else {}


FAMILIES = (
    Family(
        "scale_error", {"corners": _scale}, ("uniform", "length", "width"),
        channels=("surge", "sway", "yaw"), variable="position", unit="-",
        scale="1", span=(0.006, 0.1), kind=MEASUREMENT, signed=True,
    ),
    Family(
        "clock_error", {"clock": _clock}, ("constant", "some_trials", "drift"),
        channels=("surge", "sway", "yaw"), variable="t", unit="-",
        scale="1", span=(0.003, 0.2), kind=MEASUREMENT, signed=True, draw=_draw_clock,
    ),
    Family(
        "time_offset", {"clock": _offset}, ("video_first", "log_first", "per_trial"),
        channels=("surge",), variable="t", unit="s",
        scale="s", span=(0.03, 2.0), kind=MEASUREMENT, draw=_draw_offset,
    ),
    Family(
        "camera_shift", {"pixel": _shift}, ("translation", "rotation", "drift", "several"),
        channels=("sway",), variable="t", unit="px",
        scale="px", span=(1.0, 60.0), kind=MEASUREMENT, draw=_draw_shift,
    ),
    Family(
        "uncorrected_refraction", {"depth": _refraction}, ("wrong_depth", "wrong_index"),
        channels=("surge", "sway"), variable="position", unit="-",
        scale="1", span=(0.03, 0.333), kind=MEASUREMENT,
    ),
    Family(
        "lens_error", {"lens": _lens}, ("k1", "k2", "tangential", "focal"),
        channels=("sway", "yaw"), variable="position", unit="-",
        scale="1", span=(0.004, 0.2), kind=MEASUREMENT, signed=True, draw=_draw_lens,
    ),
    Family(
        "keypoint_bias", {"body": _bias},
        ("one_across", "core_along", "with_head_angle", "all_across"),
        channels=("sway", "yaw"), variable="body axes", unit="m", scale="L", span=(0.003, 0.07),
        kind=MEASUREMENT, signed=True, parity="odd", draw=_draw_bias,
    ),
)  # fmt: skip
