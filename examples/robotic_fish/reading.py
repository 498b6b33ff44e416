"""Trials of the fish as the engine takes them, from folders named after amplitude and bias."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bluekoi.data import Float, Pose, Track
from bluekoi.errors import input_error
from bluekoi.explain import Trial
from bluekoi.motor import tail_beat_from_video
from bluekoi.smoothing import smooth_pose

from ..averaging import block_means

COLUMNS = 7
POSITION_STD_M = 1e-3
HEADING_STD_RAD = 0.01
_FOLDER = re.compile(r"Amp(?P<amp>\d+(?:\.\d+)?)Bias(?P<bias>-?\d+(?:\.\d+)?)$")


@dataclass(frozen=True)
class Recording:
    """One trial: amplitude and bias in degrees, times (n,), x, y [m] and heading [rad] (n, 3),
    the track smoothed without the recoil; the tail beat that the recoil shows, Hz, and the
    amplitude of the recoil in yaw, rad.
    """

    name: str
    amplitude_deg: float
    bias_deg: float
    times: Float
    seen: Float
    track: Track
    beat_hz: float
    beat_std_hz: float
    recoil_rad: float

    @property
    def condition(self) -> str:
        """What repeats share."""
        return f"Amp{self.amplitude_deg:g}Bias{self.bias_deg:g}"


def read_folder(folder: Path) -> list[Trial]:
    """All trials of a folder, by their means over tail beats."""
    return [by_beats(one) for one in read_recordings(folder)]


def read_recordings(folder: Path) -> list[Recording]:
    """All recordings of a folder of `AmpABiasB/STATESn.txt`, by amplitude and bias.

    Raises: InputError where there is none, or where a file does not hold seven columns of numbers.
    """
    found = sorted(p for p in Path(folder).glob("Amp*Bias*/*STATES*.txt"))
    if not found:
        raise input_error(folder, "", "no AmpABiasB/STATESn.txt", "one folder a condition")
    recordings = [read(path) for path in found]
    return sorted(recordings, key=lambda r: (r.amplitude_deg, r.bias_deg, r.name))


def read(path: Path) -> Recording:
    """One trial; columns t s, v1, v2 m/s, yaw rate rad/s, heading rad, x, y m."""
    name = _FOLDER.search(path.parent.name)
    if name is None:
        raise input_error(path, "folder", path.parent.name, "a name like Amp15Bias-20")
    rows = _numbers(path)
    times = rows[:, 0] - rows[0, 0]
    seen = np.column_stack([rows[:, 5:7], np.unwrap(rows[:, 4])])
    pose = Pose(times, np.column_stack([seen, np.full(len(seen), np.nan)]), _cov(len(seen), 4))
    hz, std = tail_beat_from_video(pose, 2.1)
    track = smooth_pose(pose, hz)
    recoil = float(np.sqrt(2.0) * np.std(track.recoil[:, 2]))
    return Recording(f"{path.parent.name}/{path.stem}", float(name["amp"]), float(name["bias"]),
                     times, seen, track, hz, std, recoil)  # fmt: skip


def _numbers(path: Path) -> Float:
    try:
        rows = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise input_error(path, "", str(error), "rows of seven numbers") from None
    if rows.shape[1] != COLUMNS or len(rows) < 20 or not np.isfinite(rows).all():
        raise input_error(
            path, "", f"{rows.shape[0]} rows of {rows.shape[1]}", "20 or more rows of 7"
        )
    if np.any(np.diff(rows[:, 0]) <= 0):
        raise input_error(path, "column 1", "times that do not increase", "increasing times")
    return rows


def _cov(frames: int, size: int) -> Float:
    std = np.array([POSITION_STD_M, POSITION_STD_M, HEADING_STD_RAD, 1.0][:size])
    return np.tile(np.diag(std**2), (frames, 1, 1))


def by_beats(one: Recording) -> Trial:
    """A trial by its means over tail beats.

    The model knows thrust as its mean over a beat; over a beat the recoil, with all that its
    harmonics do, averages to nothing.
    """
    times, seen = block_means(one.times, one.seen - one.track.recoil[:, :3], 1.0 / one.beat_hz)
    amplitude, bias = np.radians([one.amplitude_deg, one.bias_deg])
    inputs = {"bias": bias, "amplitude": amplitude, "beat_hz": one.beat_hz,
              "recoil": one.recoil_rad}  # fmt: skip
    return Trial(
        one.name, times, dict(zip(("x_seen", "y_seen", "heading"), seen.T, strict=True)),
        {name: np.full(len(times), value) for name, value in inputs.items()},
        condition=one.condition, start=_start(one),
    )  # fmt: skip


def _start(one: Recording) -> dict[str, float]:
    """State at the first frame, from the smoothed track."""
    k = one.track
    c, s = np.cos(k.heading_rad[0]), np.sin(k.heading_rad[0])
    vx, vy = k.vx_m_s[0], k.vy_m_s[0]
    own = {"x": k.x_m[0], "y": k.y_m[0], "psi": k.heading_rad[0], "u": vx * c + vy * s,
           "v": vy * c - vx * s, "r": k.yaw_rate_rad_s[0]}  # fmt: skip
    return {name: float(value) for name, value in own.items()}
