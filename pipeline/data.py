"""The types that flow between the stages, each with its reader and writer.

Frozen; constructors check shape, finiteness and increasing time, collect all faults and raise once.
SI units and radians; frames of reference are named in `docs/conventions.md`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .faults import Fault, Finding, fault
from .files import whole_file

Float = npt.NDArray[np.float64]

PARTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
"""Body parts from nose to tail tip; `core_center` is the centre of mass."""


@dataclass(frozen=True)
class Frame:
    """One picture of a recording: true time [s], luma (height, width) and, if asked, bgr."""

    index: int
    time_s: float
    luma: npt.NDArray[np.uint8]
    bgr: npt.NDArray[np.uint8] | None = None


@dataclass(frozen=True)
class Keypoints:
    """Detections of one trial, in raw camera pixels.

    time_s: (frames,), increasing. names: the parts. xy_px: (frames, parts, 2), NaN where not
    seen. likelihood: (frames, parts) in [0, 1]. cov_px2: (frames, parts, 2, 2), NaN where not
    known. remarks: what a reader of the report must know (frames lost, files cut short, ...).
    """

    time_s: Float
    names: tuple[str, ...]
    xy_px: Float
    likelihood: Float
    cov_px2: Float
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n, p = len(self.time_s), len(self.names)
        check_shapes(
            self,
            {"xy_px": (n, p, 2), "likelihood": (n, p), "cov_px2": (n, p, 2, 2)},
        )

    def part(self, name: str) -> Float:
        """Pixels of one part, (frames, 2)."""
        return self.xy_px[:, self.names.index(name)]


@dataclass(frozen=True)
class Positions:
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
    recoil: (frames, 3): the tail-beat oscillation taken out of x, y [m] and heading [rad].
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
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.time_s)
        columns = {f.name: (n,) for f in fields(self) if f.name not in ("recoil", "remarks")}
        if len(self.recoil) == 0:
            object.__setattr__(self, "recoil", np.zeros((n, 3)))
        check_shapes(self, {**columns, "recoil": (n, 3)})


@dataclass(frozen=True)
class Flapping:
    """Flapping frequency of one trial from its motor log [Hz], with uncertainty and over time.

    source: `motor_log`, `flap_hz` (given in trials.csv), `video` or `nominal`. video_hz: tail-beat
    frequency seen in the keypoints, NaN where it cannot be seen. agrees: the two within 3 sigma.
    """

    flap_hz: float
    flap_hz_std: float
    source: str
    time_s: Float = field(default_factory=lambda: np.zeros(0))
    hz: Float = field(default_factory=lambda: np.zeros(0))
    video_hz: float = float("nan")
    video_hz_std: float = float("nan")
    agrees: bool = True
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Steady:
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
    """Raise one Fault for all fields of `value` with a wrong shape or a time that goes back."""
    name = type(value).__name__
    findings = [
        Finding(name, key, f"shape {np.shape(getattr(value, key))}", f"shape {shape}")
        for key, shape in shapes.items()
        if np.shape(getattr(value, key)) != shape
    ]
    if not np.all(np.isfinite(value.time_s)) or np.any(np.diff(value.time_s) <= 0):
        findings.append(Finding(name, "time_s", "times that repeat or go back", "increasing times"))
    if findings:
        raise Fault(findings)


TRACK_COLUMNS = tuple(
    f.name for f in fields(Track) if f.name not in ("recoil", "remarks", "speed_std_m_s")
)


def write_columns(path: str | Path, columns: dict[str, Any]) -> None:
    """Write equally long columns as csv, whole or not at all; NaN as an empty cell."""
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    with whole_file(path) as temporary, temporary.open("w", encoding="utf-8") as out:
        out.write(",".join(names) + "\n")
        out.writelines(",".join(_cell(cell) for cell in row) + "\n" for row in rows)


def read_columns(path: str | Path, required: tuple[str, ...]) -> dict[str, Float]:
    """Numeric columns of a csv by name; empty cells are NaN.

    Raises: Fault naming the file and the missing column, or the row with a wrong cell.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise fault(path, "", f"an unreadable file ({error})", "a csv file") from error
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise fault(path, "", "an empty file", f"a csv with columns {', '.join(required)}")
    names = [name.strip() for name in lines[0].split(",")]
    missing = [name for name in required if name not in names]
    if missing:
        raise fault(
            path, "row 1", f"columns {', '.join(names)[:200]}", f"a column {', '.join(missing)}"
        )
    table = np.array([_row(path, i, line, len(names)) for i, line in enumerate(lines[1:], start=2)])
    table = table.reshape(len(lines) - 1, len(names))
    return {name: table[:, i] for i, name in enumerate(names)}


def _row(path: str | Path, number: int, line: str, width: int) -> list[float]:
    cells = line.split(",")
    if len(cells) != width:
        raise fault(path, f"row {number}", f"{len(cells)} cells", f"{width} cells")
    try:
        return [float(cell) if cell.strip() else float("nan") for cell in cells]
    except ValueError as error:
        raise fault(path, f"row {number}", str(error), "numbers") from error


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if set(value) & set(',"\n') else value
    if isinstance(value, (bool, np.bool_, int, np.integer)):
        return str(int(value))
    return "" if not np.isfinite(value) else format(float(value), ".9g")


def write_track(path: str | Path, track: Track) -> None:
    """Write tracks/ID.csv as the contract lists it, with the recoil as extra columns."""
    columns = {name: getattr(track, name) for name in TRACK_COLUMNS}
    recoil = ("recoil_x_m", "recoil_y_m", "recoil_heading_rad")
    write_columns(path, columns | {name: track.recoil[:, i] for i, name in enumerate(recoil)})


def read_track(path: str | Path) -> Track:
    """Track of one trial from tracks/ID.csv."""
    columns = read_columns(path, TRACK_COLUMNS)
    recoil = [
        columns[f"recoil_{k}"] for k in ("x_m", "y_m", "heading_rad") if f"recoil_{k}" in columns
    ]
    values: dict[str, Any] = {name: columns[name] for name in TRACK_COLUMNS}
    return Track(**values, recoil=np.column_stack(recoil) if recoil else np.zeros((0, 3)))


_POSE_PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]
POSE_COLUMNS = (
    "time_s",
    "x_m",
    "y_m",
    "heading_rad",
    "head_angle_rad",
    *(f"cov_{i}{j}" for i, j in _POSE_PAIRS),
)


def write_pose(path: str | Path, pose: Pose) -> None:
    """Write poses/ID.csv: measured pose and the upper triangle of its covariance."""
    columns = {"time_s": pose.time_s} | dict(zip(POSE_COLUMNS[1:5], pose.values.T, strict=True))
    write_columns(path, columns | {f"cov_{i}{j}": pose.cov[:, i, j] for i, j in _POSE_PAIRS})


def read_pose(path: str | Path) -> Pose:
    """Pose of one trial from poses/ID.csv."""
    columns = read_columns(path, POSE_COLUMNS)
    cov = np.empty((len(columns["time_s"]), 4, 4))
    for i, j in _POSE_PAIRS:
        cov[:, i, j] = cov[:, j, i] = columns[f"cov_{i}{j}"]
    return Pose(columns["time_s"], np.column_stack([columns[c] for c in POSE_COLUMNS[1:5]]), cov)
