"""Runs of the fish robot as the engine takes them, tracking errors removed and counted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from bluekoi.data import Float
from bluekoi.errors import input_error
from bluekoi.explain import Trial

from ..averaging import block_means

TANK_M = (6.0, 2.04)
"""ASSUME length and width of the tank: the light is seen from 0 to 5.9 m and from 0 to 2.01 m."""
FASTEST_M_S = 1.0
"""Faster than any robot here swims by twice: what moves faster was mistaken for the light."""
SWIMMING_M_S = 0.08


@dataclass(frozen=True)
class Run:
    """One run: frequency Hz, amplitude deg, lag; times (n,), places (n, 2) m, each seen once.

    faults: positions removed, since nothing swims so fast; gap_s: longest time without light.
    """

    name: str
    condition: str
    beat_hz: float
    times: Float
    places: Float
    faults: int
    gap_s: float


def read_folder(folder: Path) -> list[Trial]:
    """All runs of a folder of `data_FREQUENCY_AMPLITUDE_LAG_STAMP.csv`.

    Raises: InputError where there is none.
    """
    return [trial(run) for run in read_runs(folder)]


def read_runs(folder: Path) -> list[Run]:
    """The runs of a folder, their tracking errors removed.

    Raises: InputError where there is none.
    """
    paths = sorted(Path(folder).glob("data_*.csv"))
    if not paths:
        raise input_error(folder, "", "no data_*.csv", "one file a run")
    return [read(path) for path in paths]


def read(path: Path) -> Run:
    """One run; a place held over several rows counts once, at its first."""
    table = pd.read_csv(path).to_numpy(dtype=float)
    new = np.concatenate([[True], np.any(np.diff(table[:, 1:], axis=0) != 0, axis=1)])
    times, places = table[new, 0], table[new, 1:3]
    kept = followed(times, places)
    hz, amplitude, lag = path.stem.split("_")[1:4]
    first, last = swimming(times[kept], places[kept])
    times_, places_ = times[kept][first:last], places[kept][first:last]
    gap = float(np.diff(times_).max(initial=0.0))
    return Run(path.stem[5:], f"{hz}_{amplitude}_{lag}", float(hz), times_ - times_[0], places_,
               int((~kept).sum()), gap)  # fmt: skip


def followed(times: Float, places: Float) -> np.ndarray:
    """Which places (n,) belong to the longest chain in which nothing moves too fast.

    From each place the chain goes on to the next that can be reached; chains that break off are
    shorter.
    """
    length, before = np.ones(len(times)), np.full(len(times), -1)
    for i in range(1, len(times)):
        near = np.arange(max(0, i - 40), i)
        step = np.hypot(*(places[near] - places[i]).T)
        reach = near[step <= FASTEST_M_S * (times[i] - times[near]) + 0.02]
        if len(reach):
            before[i] = reach[np.argmax(length[reach])]
            length[i] = length[before[i]] + 1
    kept, i = np.zeros(len(times), dtype=bool), int(np.argmax(length))
    while i >= 0:
        kept[i] = True
        i = int(before[i])
    return kept


def swimming(times: Float, places: Float) -> tuple[int, int]:
    """First and last frame of the longest stretch in which the robot swims."""
    grid = np.interp
    back, ahead = times - 0.75, times + 0.75
    moved = np.hypot(*[grid(ahead, times, p) - grid(back, times, p) for p in places.T])
    span = np.minimum(ahead, times[-1]) - np.maximum(back, times[0])
    swims = moved / span > SWIMMING_M_S
    edges = np.flatnonzero(np.diff(np.concatenate([[0], swims.astype(int), [0]])))
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[2 * longest]), int(edges[2 * longest + 1])


def trial(run: Run) -> Trial:
    """A run by its means over body beats, in which the swing of the light averages out."""
    times, places = block_means(run.times, run.places, 1.0 / run.beat_hz)
    return Trial(run.name, times, {"x_seen": places[:, 0], "y_seen": places[:, 1]},
                 condition=run.name, group=run.condition)  # fmt: skip


def start(times: Float, seen: Float) -> tuple[float, ...]:
    """Place, course and speed at the first frame, from the first four."""
    (x, y), (vx, vy) = np.polynomial.polynomial.polyfit(times[:4] - times[0], seen[:4], 1)
    return float(x), float(y), float(np.arctan2(vy, vx)), float(np.hypot(vx, vy))
