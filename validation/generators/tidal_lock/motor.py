"""Motor logs: shaft angle every 5 ms, wrapped, with a potentiometer's dead zone."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

LOG_STEP = 0.005  # s


@dataclass(frozen=True)
class Potentiometer:
    """Dead zone below 360 degrees, what the log holds in it, and noise in degrees.

    `mounting` is the angle read at phase zero of the tail beat.
    """

    dead_zone: float
    filler: str
    noise: float
    mounting: float


def draw_potentiometer(rng: np.random.Generator) -> Potentiometer:
    """A potentiometer that holds the last value, reads 0 or nothing in its dead zone."""
    filler = str(rng.choice(["last", "zero", "empty"]))
    return Potentiometer(rng.uniform(8, 35), filler, rng.uniform(0.1, 0.6), rng.uniform(0, 360))


def write_log(
    rng: np.random.Generator, path: Path, times: np.ndarray, phase: np.ndarray, pot: Potentiometer
) -> None:
    """Write `time_s,angle_deg` for the beat `phase` (rad) at `times`."""
    logged = np.arange(0, times[-1], LOG_STEP)
    degrees = (np.degrees(np.interp(logged, times, phase)) + pot.mounting) % 360
    live = degrees < 360 - pot.dead_zone
    read = np.clip(degrees + pot.noise * rng.standard_normal(len(logged)), 0, 359.99)
    texts = [f"{v:.2f}" for v in read]
    last = "0.00"
    rows = []
    for t, alive, text in zip(logged, live, texts, strict=True):
        shown = text if alive else {"last": last, "zero": "0.00", "empty": ""}[pot.filler]
        last = text if alive else last
        rows.append(f"{t:.3f},{shown}")
    path.write_text("time_s,angle_deg\n" + "\n".join(rows) + "\n")
