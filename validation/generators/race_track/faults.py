"""Errors of measurement: what study.yaml, trials.csv, labels or clock state wrongly.

The size is such that the apparent displacement in a typical place (before any refit) is a drawn
multiple of the floor of the path error; a size outside its plausible range is held to the range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .robots import Array, Robot

FAULTS = {
    "scale_error": ("uniform", "length_only", "width_only"),
    "clock_error": ("constant", "some_trials", "drift"),
    "camera_shift": ("step", "turn", "creep"),
    "uncorrected_refraction": ("depth", "index"),
    "lens_error": ("k1", "none_stated", "tangential"),
    "time_offset": ("video_first", "log_first", "per_trial"),
    "keypoint_bias": ("across", "along", "with_head_angle"),
}
UNITS = {
    "scale_error": "1", "clock_error": "1", "camera_shift": "m", "uncorrected_refraction": "m",
    "lens_error": "1", "time_offset": "s", "keypoint_bias": "m",
}  # fmt: skip
NEEDS_LOG = ("time_offset", "clock_error")


@dataclass(frozen=True)
class Fault:
    """An error. where: which trials have it. amount: factor on the size, a trial."""

    name: str
    form: str
    size: float
    where: Array
    amount: Array
    displacement: float

    def of(self, trial: int) -> float:
        """Size in one trial."""
        return float(self.size * self.where[trial] * self.amount[trial])


@dataclass(frozen=True)
class Place:
    """Lengths (m) that turn a size into a displacement: reach in the pool, camera height."""

    reach: float
    height: float
    floor: float


def _lever(name: str, robot: Robot, place: Place) -> tuple[float, float, float]:
    """Displacement (m) by unit of size, and the plausible range of the size."""
    tilt = place.reach / place.height
    return {
        "scale_error": (place.reach, 0.01, 0.08),
        "clock_error": (4 * robot.body_length, 0.01, 0.1),
        "camera_shift": (1.0, 0.004, 0.2 * robot.body_length),
        "uncorrected_refraction": (0.25 * tilt, 0.06, 0.35),
        "lens_error": (place.reach * tilt**2, 0.015, 0.25),
        "time_offset": (0.6 * robot.speed, 0.05, 1.2 * robot.body_length / robot.speed),
        "keypoint_bias": (1.0, 0.003, 0.07 * robot.body_length),
    }[name]


def draw_fault(
    rng: np.random.Generator, name: str, robot: Robot, trials: int, place: Place
) -> Fault:
    """An error of the named kind."""
    form = str(rng.choice(FAULTS[name]))
    lever, low, high = _lever(name, robot, place)
    size = float(
        np.clip(np.exp(rng.uniform(np.log(2.3), np.log(7))) * place.floor / lever, low, high)
    )
    sign = 1.0 if name in ("uncorrected_refraction", "time_offset") else rng.choice([-1.0, 1.0])
    where, amount = np.ones(trials), np.ones(trials)
    if name == "camera_shift" or form == "some_trials":
        where = np.zeros(trials)
        where[rng.permutation(trials)[: max(3, int(rng.uniform(0.35, 0.7) * trials))]] = 1
    if form == "per_trial":
        amount = rng.uniform(0.4, 1.5, trials) * rng.choice([-1, 1], trials)
    return Fault(name, form, float(sign * size), where, amount, lever * size)


def wait(fault: Fault | None, trial: int) -> float:
    """Time (s) from the first frame to the start of motor and log; below 0 the film is late."""
    if fault is None or fault.name != "time_offset":
        return 0.0
    return fault.of(trial) * (-1 if fault.form == "log_first" else 1)


def frame_times(fault: Fault | None, trial: int, frames: int, fps: float) -> Array:
    """True times (s) of frames that the study states to be 1/fps apart."""
    stated = np.arange(frames) / fps
    if fault is None or fault.name != "clock_error":
        return stated
    error = fault.of(trial)
    if fault.form == "drift":
        return stated * (1 + 2 * error * np.arange(frames) / frames)
    return stated * (1 + error)


def moved_pixels(
    fault: Fault | None, trial: int, pixels: Array, *, scale: float, centre: Array
) -> Array:
    """Pixels (frames, points, 2) after the camera moved. scale: pixels by metre."""
    if fault is None or fault.name != "camera_shift" or not fault.where[trial]:
        return pixels
    rng = np.random.default_rng(trial + int(1e6 * abs(fault.size)))
    part = np.arange(len(pixels)) / len(pixels)
    ramp = part if fault.form == "creep" else (part > rng.uniform(0.3, 0.7)) * 1.0
    step = fault.of(trial) * scale * ramp[:, None, None]
    if fault.form == "turn":
        away = pixels - centre
        return pixels + step * 3.5 * away[..., ::-1] * [-1, 1] / centre[0]
    direction = rng.uniform(0, 2 * np.pi)
    return pixels + step * np.array([np.cos(direction), np.sin(direction)])


def moved_labels(fault: Fault | None, points: Array, psi: Array, phi: Array) -> Array:
    """Points (frames, 5), complex, with the core's label misplaced in axes of the core."""
    if fault is None or fault.name != "keypoint_bias":
        return points
    offset = {
        "across": 1j + 0 * phi,
        "along": 1 + 0j * phi,
        "with_head_angle": 1j * np.sin(2 * phi) + 0.3j,
    }[fault.form]
    out = points.copy()
    out[:, 2] += fault.size * offset * np.exp(1j * psi)
    return out
