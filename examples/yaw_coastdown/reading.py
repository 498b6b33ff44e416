"""Spin-downs as the engine takes them: column I yaw rate in rad/s, column J time in s."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.explain import Trial

from ..spreadsheet import columns, sheets

COMPASS_STD = 0.015
"""rad/s: a compass that is wrong by 0.3 rad, over 20 s."""


def read_folder(folder: Path) -> list[Trial]:
    """One `Trial` a workbook.

    Raises: InputError where there is none, or where one has no rows of rate and time.
    """
    paths = sorted(Path(folder).glob("*.xlsx"))
    if not paths:
        raise input_error(folder, "", "no .xlsx", "one workbook a spin-down")
    return [read(path) for path in paths]


def read(path: Path) -> Trial:
    """One spin-down."""
    table = columns(sheets(path).get("Sheet1", {}), "JI")
    if len(table) < 20:
        raise input_error(path, "Sheet1", f"{len(table)} rows", "20 or more with columns I and J")
    times, rate = np.ascontiguousarray(table.T)
    return Trial(path.stem, times - times[0], {"rate": rate}, source=str(path),
                 evidence={"compass": (gyro_over_compass(path), COMPASS_STD)})  # fmt: skip


def gyro_over_compass(path: Path) -> float:
    """What the gyro reads beyond the turning that the compass shows, rad/s.

    Over the whole recording, run-up and all: the mean of column B (yaw rate) less the turn of
    column E (compass heading, clockwise) over its time, column F (ms).
    """
    clock, heading, rate = columns(sheets(path)["Sheet1"], "FEB").T
    seconds = (clock - clock[0]) / 1000.0
    turned = -(np.unwrap(heading)[-1] - heading[0])
    read_ = float(np.sum(0.5 * (rate[1:] + rate[:-1]) * np.diff(seconds)))
    return (read_ - turned) / float(seconds[-1])
