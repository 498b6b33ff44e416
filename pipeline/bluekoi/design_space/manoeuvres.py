"""Commands over time: power and head angle as schedules, of one's own or well-known ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..data import Float, read_columns
from ..errors import did_you_mean, input_error

SCHEDULE_VALUE_RANGES = {"time_s": (0, 600), "head_angle_deg": (-120, 120), "power_pct": (0, 300),
          "flap_hz": (0, 100)}  # fmt: skip
"""Columns of a schedule with the least and the largest value allowed."""
SCHEDULE_COLUMNS = tuple(SCHEDULE_VALUE_RANGES)


@dataclass(frozen=True)
class Schedule:
    """Flapping frequency (Hz) and head angle (rad) at times (s), each (rows,), lines between them.

    Two rows at one time are a jump.
    """

    time_s: Float
    flap_hz: Float
    head_angle_rad: Float

    def at(self, times: Float) -> tuple[Float, Float]:
        """Flapping frequency and head angle at times, the last row's value after the end."""
        return (
            np.interp(times, self.time_s, self.flap_hz),
            np.interp(times, self.time_s, self.head_angle_rad),
        )


def read_schedule(path: Path, hz_of_power: Callable[[float], float]) -> Schedule:
    """Schedule from a csv: `time_s`, `head_angle_deg`, and `power_pct` or `flap_hz`.

    Raises: InputError naming an unknown column, a time that runs backwards, or an empty cell.
    """
    columns = read_columns(path, ("time_s", "head_angle_deg"))
    for name in columns:
        if name not in SCHEDULE_COLUMNS:
            raise input_error(
                path,
                name,
                "an unknown column",
                ", ".join(SCHEDULE_COLUMNS),
                did_you_mean(name, SCHEDULE_COLUMNS),
            )
    if ("power_pct" in columns) == ("flap_hz" in columns):
        raise input_error(path, "", "both or neither of power_pct and flap_hz", "one of them")
    for name, values in columns.items():
        low, high = SCHEDULE_VALUE_RANGES[name]
        bad = np.flatnonzero(~((values >= low) & (values <= high)))
        if len(bad):
            raise input_error(path, f"row {bad[0] + 2}", f"{name} {values[bad[0]]:g}",
                        f"a number from {low:g} to {high:g}")  # fmt: skip
    time = columns["time_s"]
    back = np.flatnonzero(np.diff(time) < 0)
    if len(time) == 0 or len(back):
        where = f"row {back[0] + 3}" if len(back) else ""
        raise input_error(path, where, "times that run backwards" if len(back) else "no row",
                    "rows in the order of time")  # fmt: skip
    hz = columns.get("flap_hz")
    if hz is None:
        hz = np.array([hz_of_power(p) for p in columns["power_pct"]])
    return Schedule(time, hz, np.radians(columns["head_angle_deg"]))


def _schedule(*rows: tuple[float, float, float]) -> Schedule:
    time, hz, angle = np.array(rows).T
    return Schedule(time, hz, angle)


def s_turn(hz: float, angle_rad: float, seconds: float) -> Schedule:
    """To one side, then as long to the other; the head takes 0.3 s to swing over."""
    middle = 0.5 * seconds
    return _schedule((0.0, hz, angle_rad), (middle, hz, angle_rad), (middle + 0.3, hz, -angle_rad),
                     (seconds, hz, -angle_rad))  # fmt: skip


def underpowered_turn(hz: float, angle_rad: float, seconds: float) -> Schedule:
    """Straight at full thrust for 60 % of the time; then thrust off and head turned in 0.3 s."""
    off = 0.6 * seconds
    return _schedule((0.0, hz, 0.0), (off, hz, 0.0), (off, 0.0, 0.0), (off + 0.3, 0.0, angle_rad),
                     (seconds, 0.0, angle_rad))  # fmt: skip


def start_stop(hz: float, angle_rad: float, seconds: float) -> Schedule:
    """Thrust on for 40 % of the time, off for 30 %, on again, the head held."""
    on, off = 0.4 * seconds, 0.7 * seconds
    return _schedule((0.0, hz, angle_rad), (on, hz, angle_rad), (on, 0.0, angle_rad),
                     (off, 0.0, angle_rad), (off, hz, angle_rad),
                     (seconds, hz, angle_rad))  # fmt: skip


MANOEUVRES: dict[str, Callable[[float, float, float], Schedule]] = {
    "s-turn": s_turn,
    "underpowered-turn": underpowered_turn,
    "start-stop": start_stop,
}
"""Name -> schedule of a flapping frequency (Hz), a head angle (rad) and a length of time (s)."""
