"""Studies of keypoints without video: what a tracker would have written, same truth behind it."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bluekoi.files import write_text
from bluekoi.synthetic.body import KEYPOINTS
from bluekoi.synthetic.encode import GOPRO_FRAME_RATE_HZ
from bluekoi.synthetic.study_rendering import (
    write_study_files,
    write_study_truth,
    write_trial_motor_log,
    write_trial_truth,
)
from bluekoi.synthetic.synthetic_study_design import StudyDesign
from bluekoi.synthetic.trial import frame_truth, solve_trial, trial_rng

__all__ = ["TrackingNoise", "dlc_text", "keypoint_study", "tracked_keypoints"]

SCORER = "synthetic_tank"


@dataclass(frozen=True)
class TrackingNoise:
    """How a tracker errs: per point and axis, in pixels.

    white_px, slow_px, slow_s     rms of white noise and of a first-order one, and its memory
    outlier_share, outlier_px     share of points far off, and how far; a tenth of them with
                                  a high likelihood
    gaps_per_s, gap_s             how often a point is lost (low likelihood), and for how long
    """

    white_px: float = 0.25
    slow_px: float = 0.20
    slow_s: float = 0.15
    outlier_share: float = 0.003
    outlier_px: float = 30.0
    gaps_per_s: float = 0.05
    gap_s: float = 0.15


def slow_noise(
    rng: np.random.Generator, shape: tuple[int, ...], noise: TrackingNoise, step_s: float
) -> np.ndarray:
    """First-order noise along axis 0: `e_k = a e_(k-1) + sqrt(1 - a^2) w`, `a = exp(-dt/T)`."""
    keep = np.exp(-step_s / noise.slow_s)
    draws = rng.standard_normal(shape)
    out = np.empty(shape)
    out[0] = draws[0]
    for k in range(1, shape[0]):
        out[k] = keep * out[k - 1] + np.sqrt(1 - keep**2) * draws[k]
    return noise.slow_px * out


def _draw_lost_points(
    rng: np.random.Generator, shape: tuple[int, int], noise: TrackingNoise, step_s: float
) -> np.ndarray:
    """Which points `(frames, 5)` are lost."""
    lost = rng.random(shape) < noise.gaps_per_s * step_s
    for _ in range(max(round(noise.gap_s / step_s) - 1, 0)):
        lost[1:] |= lost[:-1] & (rng.random((shape[0] - 1, shape[1])) < 0.97)
    return lost


def tracked_keypoints(
    truth_px: np.ndarray, noise: TrackingNoise, rng: np.random.Generator, *, step_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Pixels `(frames, 5, 2)` and likelihood `(frames, 5)` that a tracker would give."""
    frames = truth_px.shape[0]
    shape = (frames, truth_px.shape[1])
    seen = truth_px + noise.white_px * rng.standard_normal(truth_px.shape)
    seen += slow_noise(rng, truth_px.shape, noise, step_s)
    likelihood = rng.beta(60, 0.8, shape)
    lost = _draw_lost_points(rng, shape, noise, step_s)
    seen[lost] += rng.normal(0, 0.5 * noise.outlier_px, (int(lost.sum()), 2))
    likelihood[lost] = rng.uniform(0.0, 0.3, int(lost.sum()))
    wrong = rng.random(shape) < noise.outlier_share
    count = int(wrong.sum())
    direction = rng.uniform(0, 2 * np.pi, count)
    throw = noise.outlier_px * rng.uniform(0.5, 2.0, count)
    seen[wrong] += (throw * np.array([np.cos(direction), np.sin(direction)])).T
    sure = rng.random(count) < 0.1
    likelihood[wrong] = np.where(sure, rng.uniform(0.9, 1.0, count), rng.uniform(0, 0.6, count))
    return seen, likelihood


def dlc_text(pixels: np.ndarray, likelihood: np.ndarray) -> str:
    """Keypoints in DeepLabCut's csv layout."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = 3 * len(KEYPOINTS)
    writer.writerow(["scorer"] + [SCORER] * columns)
    writer.writerow(["bodyparts"] + [name for name in KEYPOINTS for _ in range(3)])
    writer.writerow(["coords"] + ["x", "y", "likelihood"] * len(KEYPOINTS))
    rows = np.concatenate([pixels, likelihood[..., None]], axis=-1).reshape(len(pixels), -1)
    writer.writerows([i, *(f"{value:.4f}" for value in row)] for i, row in enumerate(rows))
    return text.getvalue()


def keypoint_study(
    design: StudyDesign, folder: Path, truth_folder: Path, *, noise: TrackingNoise | None = None
) -> None:
    """Write a keypoint study to a folder; its truth goes elsewhere."""
    rate = float(GOPRO_FRAME_RATE_HZ)
    write_study_files(design, folder, source="keypoints/{}.csv", fps=rate)
    for plan in design.plans:
        trial = solve_trial(design, plan.trial_id)
        rng = trial_rng(design, plan.trial_id, "tracking")
        truth_px = frame_truth(design, trial)["keypoints_px"]
        seen, likelihood = tracked_keypoints(
            truth_px, noise or TrackingNoise(), rng, step_s=1 / rate
        )
        write_text(folder / "keypoints" / f"{plan.trial_id}.csv", dlc_text(seen, likelihood))
        write_trial_motor_log(design, trial, folder)
        write_trial_truth(design, trial, truth_folder)
    write_study_truth(design, truth_folder)
