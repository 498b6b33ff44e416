"""Simulated log of the potentiometer on the motor shaft."""

from pathlib import Path

import numpy as np

from bluekoi.files import write_rows
from bluekoi.synthetic.motion_simulation import TrialMotion

SAMPLE_INTERVAL_S = 0.005
DEAD_ZONE_RANGE_DEG = (336.0, 360.0)
ANGLE_NOISE_STD_DEG = 0.8
DEAD_ZONE_FLOATING_SHARE = 0.15


def motor_angles(motion: TrialMotion, duration_s: float, rng: np.random.Generator) -> np.ndarray:
    """Rows `(samples, 2)` of time (s) and shaft angle (deg, 0 to 360), one turn a tail beat.

    In the dead zone the reading stays at its border and now and then floats to anywhere.
    """
    time_s = np.arange(0, duration_s, SAMPLE_INTERVAL_S)
    true = np.degrees(motion.state_without_recoil(time_s)[:, 6]) % 360
    read = (true + rng.normal(0, ANGLE_NOISE_STD_DEG, len(true))) % 360
    dead = (true > DEAD_ZONE_RANGE_DEG[0]) & (true < DEAD_ZONE_RANGE_DEG[1])
    stuck = DEAD_ZONE_RANGE_DEG[0] + rng.normal(0, 0.5 * ANGLE_NOISE_STD_DEG, len(true))
    floating = rng.random(len(true)) < DEAD_ZONE_FLOATING_SHARE
    lost = np.where(floating, rng.uniform(0, DEAD_ZONE_RANGE_DEG[0], len(true)), stuck)
    return np.column_stack([time_s, np.where(dead, lost, read)])


def write_motor_log(path: Path, rows: np.ndarray) -> None:
    """Write `time_s,angle_deg` rows as csv."""
    cells = ([f"{t:.3f}", f"{angle:.4f}"] for t, angle in rows)
    write_rows(path, [["time_s", "angle_deg"], *cells])
