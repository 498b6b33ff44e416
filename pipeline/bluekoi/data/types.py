"""The types that flow between the stages.

Frozen; constructors check shape, finiteness and increasing time, collect all faults and raise once.
SI units and radians; frames of reference are named in `docs/conventions.md`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, fields
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from ..errors import InputError, InputIssue

Float = npt.NDArray[np.float64]
BoolNDArray = npt.NDArray[np.bool_]

BODY_PART_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
"""Body parts from nose to tail tip; `core_center` is the centre of mass."""


@dataclass(frozen=True)
class Frame:
    """One picture of a recording: true time [s], luma (height, width) and, if asked, bgr."""

    index: int
    time_s: float
    luma: npt.NDArray[np.uint8]
    bgr: npt.NDArray[np.uint8] | None = None


@runtime_checkable
class SeekableFilm(Protocol):
    """Frames of a recording that can be run through again, a few of them decoded alone."""

    def __iter__(self) -> Iterator[Frame]:
        """All frames, in order."""

    def evenly_spaced(self, count: int, at_most: int = 0) -> Iterator[Frame]:
        """About `count` frames evenly spaced over the recording, decoded alone; up to `at_most`
        where no others have to be decoded for these.
        """

    def prefetched(self) -> AbstractContextManager[Iterator[Frame]]:
        """All frames, decoded in the background from now on."""


@dataclass(frozen=True)
class Keypoints:
    """Detections of one trial, in raw camera pixels.

    time_s: (frames,), increasing. names: the parts. xy_px: (frames, parts, 2), NaN where not
    seen. likelihood: (frames, parts) in [0, 1]. cov_px2: (frames, parts, 2, 2), NaN where not
    known. remarks: what a reader of the report must know (frames lost, files cut short, ...).
    length_seen: (frames,) whole length of the body as seen over that stated, NaN where not seen;
    None where nobody looked.
    """

    time_s: Float
    names: tuple[str, ...]
    xy_px: Float
    likelihood: Float
    cov_px2: Float
    remarks: tuple[str, ...] = ()
    length_seen: Float | None = None

    def __post_init__(self) -> None:
        n, p = len(self.time_s), len(self.names)
        shapes: dict[str, tuple[int, ...]] = {
            "xy_px": (n, p, 2), "likelihood": (n, p), "cov_px2": (n, p, 2, 2),
        }  # fmt: skip
        check_shapes(self, shapes if self.length_seen is None else shapes | {"length_seen": (n,)})

    def part(self, name: str) -> Float:
        """Pixels of one part, (frames, 2)."""
        return self.xy_px[:, self.names.index(name)]


@dataclass(frozen=True)
class KeypointPositions:
    """Keypoints of one trial in the pool frame.

    time_s: (frames,). xy_m: (frames, parts, 2), NaN where not seen. cov_m2: (frames, parts, 2, 2):
    the detections' own, independent from frame to frame. likelihood: (frames, parts).
    """

    time_s: Float
    names: tuple[str, ...]
    xy_m: Float
    cov_m2: Float
    likelihood: Float
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n, p = len(self.time_s), len(self.names)
        check_shapes(self, {"xy_m": (n, p, 2), "likelihood": (n, p), "cov_m2": (n, p, 2, 2)})

    def part(self, name: str) -> Float:
        """Positions of one part, (frames, 2), m."""
        return self.xy_m[:, self.names.index(name)]


@dataclass(frozen=True)
class Pose:
    """Measured pose of the robot's rigid parts, frame by frame, not smoothed.

    time_s: (frames,). values: (frames, 4) = x, y of the centre of mass [m], heading of the core
    [rad, unwrapped], head angle (core direction minus head direction) [rad]; NaN where not seen.
    cov: (frames, 4, 4), independent from frame to frame.
    """

    time_s: Float
    values: Float
    cov: Float
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.time_s)
        check_shapes(self, {"values": (n, 4), "cov": (n, 4, 4)})


@dataclass(frozen=True)
class Track:
    """Smoothed motion of one trial; each field (frames,), with its standard deviation `_std`.

    x_m, y_m: centre of mass in the pool frame. heading_rad: core direction, unwrapped.
    head_angle_rad: core direction minus head direction. speed, velocity and yaw rate are
    derivatives of the smoothed position and heading, the tail-beat recoil taken out.
    recoil: (frames, 3): the tail-beat oscillation taken out of x, y [m] and heading [rad], with
    its standard deviation recoil_std.
    """

    time_s: Float
    x_m: Float
    y_m: Float
    heading_rad: Float
    head_angle_rad: Float
    speed_m_s: Float
    vx_m_s: Float
    vy_m_s: Float
    yaw_rate_rad_s: Float
    x_m_std: Float
    y_m_std: Float
    heading_rad_std: Float
    head_angle_rad_std: Float
    speed_m_s_std: Float
    vx_m_s_std: Float
    vy_m_s_std: Float
    yaw_rate_rad_s_std: Float
    recoil: Float = field(default_factory=lambda: np.zeros((0, 3)))
    recoil_std: Float = field(default_factory=lambda: np.zeros((0, 3)))
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n, others = len(self.time_s), ("recoil", "recoil_std", "remarks")
        columns = {f.name: (n,) for f in fields(self) if f.name not in others}
        for name in others[:2]:
            if len(getattr(self, name)) == 0:
                object.__setattr__(self, name, np.zeros((n, 3)))
        check_shapes(self, {**columns, "recoil": (n, 3), "recoil_std": (n, 3)})


@dataclass(frozen=True)
class FlappingFrequency:
    """Flapping frequency of one trial from its motor log [Hz], with uncertainty and over time.

    source: `motor_log`, `flap_hz` (given in trials.csv), `video` or `nominal`. ratio: tail-beat
    frequency in the video's clock over the motor's, k where the frame rate is stated k times too
    high; NaN where no beat is seen. video_hz: the former where the ratio is near 1. agrees: the
    ratio is 1 within 3 sigma. phase_rad: the shaft's phase at `time_s`, rising. beat_lag_rad: by
    how much the tail beat in the video is behind the log's shaft at the same time, (-pi, pi], NaN
    where it is unknown. start_s: start of the motor after that of the log; lost_time_s: time that
    its spin-up costs; NaN where no log shows them. drift_per_s: relative change of frequency per
    second after that, by the log, or without one by the video, with its standard deviation
    drift_std_per_s; NaN where neither shows it.
    """

    flap_hz: float
    flap_hz_std: float
    source: str
    time_s: Float = field(default_factory=lambda: np.zeros(0))
    hz: Float = field(default_factory=lambda: np.zeros(0))
    phase_rad: Float = field(default_factory=lambda: np.zeros(0))
    video_hz: float = float("nan")
    video_hz_std: float = float("nan")
    ratio: float = float("nan")
    ratio_std: float = float("nan")
    beat_lag_rad: float = float("nan")
    beat_lag_std_rad: float = float("nan")
    start_s: float = float("nan")
    lost_time_s: float = float("nan")
    drift_per_s: float = float("nan")
    drift_std_per_s: float = float("nan")
    agrees: bool = True
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class SteadyState:
    """Steady speed and turn of one trial: a row of steady.csv.

    speed: plateau of the speed [m/s]. radius: geometric circle [m], inf for a straight run.
    quality: `good`, `short_arc`, `straight`, `not_steady`, `no_data`; reason: what to try next.
    center_m: (2,) of the fitted circle. turn: +1 counter-clockwise, -1 clockwise, 0 straight.
    """

    flap_hz: float
    speed_m_s: float
    speed_std_m_s: float
    radius_m: float
    radius_std_m: float
    arc_deg: float
    steady_from_s: float
    steady_to_s: float
    quality: str
    reason: str
    turn: int = 0
    center_m: tuple[float, float] = (float("nan"), float("nan"))


def check_shapes(value: Any, shapes: dict[str, tuple[int, ...]]) -> None:
    """Raise one InputError for all fields of `value` with a wrong shape or a time that goes
    back.
    """
    name = type(value).__name__
    findings = [
        InputIssue(name, key, f"shape {np.shape(getattr(value, key))}", f"shape {shape}")
        for key, shape in shapes.items()
        if np.shape(getattr(value, key)) != shape
    ]
    if not np.all(np.isfinite(value.time_s)) or np.any(np.diff(value.time_s) <= 0):
        findings.append(
            InputIssue(name, "time_s", "times that repeat or go back", "increasing times")
        )
    if findings:
        raise InputError(findings)
