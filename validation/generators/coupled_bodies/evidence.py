"""Direct evidence: what motor logs and the beat of the tail show without a model of the motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .form import HiddenLaw
from .placing import PlacedMotion
from .robots import FLAP_STD
from .scene import LINKAGE_STD, Scene, exposure_times
from .tracking import Tracker

Array = NDArray[np.float64]


def direct_information(
    law: HiddenLaw, motion: PlacedMotion, tracker: Tracker, scene: Scene, *, logged: bool
) -> float:
    """Information of the strength of a law of the drive (from the log) or the clock, or 0."""
    if law.form.stage == "drive" and logged:
        return motor_log_information(law, motion)
    if law.form.stage == "clock":
        return tail_beat_information(law, motion, tracker, scene, logged)
    return 0.0


def frequency_drift_covariance(times: Array) -> Array:
    """Covariance of the relative flapping frequency: waves of 0.4 to 3 rad/s, grain."""
    lag = np.abs(times[:, None] - times) + 1e-9
    waves = (np.sin(3 * lag) - np.sin(0.4 * lag)) / (2.6 * lag)
    return np.asarray(FLAP_STD**2 * waves + 1.5e-3**2 * np.eye(len(times)))


def motor_log_information(law: HiddenLaw, motion: PlacedMotion) -> float:
    """From the logged frequency against its wander, with the level of each trial free."""
    total, lanes, s = 0.0, motion.lanes, law.strength
    for k, end in enumerate(motion.ends):
        t = np.arange(0.125, end, 0.25)
        lane = lanes.take(np.array([k]))
        f = [
            np.log(law.form.law(t, lane, np.array([size]), law.shape))[:, 0]
            for size in (s, 0.99 * s)
        ]
        slope = np.stack([(f[0] - f[1]) / (0.01 * s), np.ones(len(t))], 1)
        whole = slope.T @ np.linalg.solve(frequency_drift_covariance(t), slope)
        total += whole[0, 0] - whole[0, 1] ** 2 / whole[1, 1]
    return float(total)


def tail_beat_information(
    law: HiddenLaw, motion: PlacedMotion, tracker: Tracker, scene: Scene, logged: bool
) -> float:
    """From the phase of the tail in the video against the log, or its rate against flap_hz.

    The phase of each trial is free within the play of the linkage about a common one.
    """
    metre = scene.camera.place[2] / scene.camera.matrix[0, 0]
    std = np.hypot(tracker.slow, tracker.white) * metre / (0.066 * scene.swing)
    whole = np.zeros((2, 2))
    for k, end in enumerate(motion.ends):
        t = np.arange(0.5, end, 0.1)
        rate = 2 * np.pi * motion.lanes.flap[k]
        signal = rate * (exposure_times([law], t, k, motion.lanes.count) - t) / law.strength
        columns = np.stack([signal, np.ones(len(t)), np.ones(len(t)), rate * (t - end / 2)], 1)
        loose = np.array([LINKAGE_STD if logged else 1e3, 1e-5 if logged else FLAP_STD])
        noise = std**2 * np.eye(len(t)) + (columns[:, 2:] * loose**2) @ columns[:, 2:].T
        whole += columns[:, :2].T @ np.linalg.solve(noise, columns[:, :2])
    return float(whole[0, 0] - whole[0, 1] ** 2 / whole[1, 1])
