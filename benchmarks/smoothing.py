"""Errors of speed and yaw rate against rivals at their best setting, widths of normalised errors
(speed, yaw rate, x, y, heading), also where errors last from frame to frame, and the time that a
campaign takes.

    python benchmarks/smoothing.py [--trials 6] [--seed 3] [--widths]

With --widths the rivals are left out, so that many trials can be run.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import exact_motions
import other_smoothers
from bluekoi.smoothing import smooth_pose

CONDITIONS = {
    "2.37 Hz, 8 s": (exact_motions.CameraConditions(hz=2.37, gap_s=(4.0, 4.5)), 240),
    "5.82 Hz, 4 s": (exact_motions.CameraConditions(hz=5.82, gap_s=(2.0, 2.3)), 120),
    "5.82 Hz, 4 s, errors that last": (
        exact_motions.CameraConditions(hz=5.82, gap_s=(2.0, 2.3)),
        120,
    ),
    "2.37 Hz, no recoil": (
        exact_motions.CameraConditions(2.37, 0.0, 0.0, 0.0, gap_s=(4.0, 4.5)),
        240,
    ),
}


def rms(parts: list[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def rate_errors(
    truth: exact_motions.Motion, velocity: np.ndarray, rate: np.ndarray
) -> list[np.ndarray]:
    return [np.hypot(*velocity.T) - truth.speed, rate - truth.yaw_rate]


def rms_over_cases(cases: list, method: Callable) -> np.ndarray:
    """Root mean square errors of speed and yaw rate over the cases (truth, pose)."""
    both = [rate_errors(truth, *method(pose)) for truth, pose in cases]
    return np.array([rms([e[i] for e in both]) for i in (0, 1)])


def our_errors(cases: list, hz: float) -> tuple[np.ndarray, list[list[np.ndarray]]]:
    found, pulls = [], []
    for truth, pose in cases:
        track = smooth_pose(pose, hz)
        e = rate_errors(truth, np.column_stack([track.vx_m_s, track.vy_m_s]), track.yaw_rate_rad_s)
        found.append(e)
        pulls.append([e[0] / track.speed_m_s_std, e[1] / track.yaw_rate_rad_s_std])
        pulls[-1] += [
            (track.x_m - truth.xy[:, 0]) / track.x_m_std,
            (track.y_m - truth.xy[:, 1]) / track.y_m_std,
            (track.heading_rad - truth.heading) / track.heading_rad_std,
        ]
    return np.array([rms([e[i] for e in found]) for i in (0, 1)]), pulls


def seen_with_autocorrelated_errors(
    truth: exact_motions.Motion, rng: np.random.Generator, seen: exact_motions.CameraConditions
) -> object:
    """A motion seen with errors of which 0.6 is still there in the next frame."""
    clean = replace(seen, noise_m=1e-9, noise_rad=1e-9, outliers=0.0)
    stated = exact_motions.observed_pose(truth, rng, seen)
    return exact_motions.with_autocorrelated_noise(
        stated, exact_motions.observed_pose(truth, rng, clean), rng, 0.6
    )


def simulated_cases(
    seen: exact_motions.CameraConditions, frames: int, trials: int, *, lasting: bool, seed: int
) -> dict:
    """Motion -> its trials, (truth, pose seen)."""
    rng, t = np.random.default_rng(seed), exact_motions.frame_times(frames)
    look = seen_with_autocorrelated_errors if lasting else exact_motions.observed_pose
    return {
        name: [(truth := make(t), look(truth, rng, seen)) for _ in range(trials)]
        for name, make in exact_motions.MOTIONS.items()
    }


def compare_methods(cases: dict, hz: float, frames: int) -> dict:
    """Per motion: ours and each rival's errors at its best single setting over all motions, and at
    the setting best for that motion alone (which nobody who does not know the truth can choose)."""
    result: dict = {"ours": {}, "pulls": {}, "rivals": {}}
    for name, case in cases.items():
        result["ours"][name], result["pulls"][name] = our_errors(case, hz)
    for rival, (method, settings) in other_smoothers.rival_settings(frames).items():
        table = np.array(
            [
                [
                    rms_over_cases(case, lambda pose, s=s, m=method: m(pose, s))
                    for case in cases.values()
                ]
                for s in settings
            ]
        )
        pooled = np.sqrt((table**2).mean(axis=1))
        best = pooled.argmin(axis=0)
        result["rivals"][rival] = {
            "fixed": {
                n: np.array([table[best[j], i, j] for j in (0, 1)]) for i, n in enumerate(cases)
            },
            "oracle": {n: table[:, i].min(axis=0) for i, n in enumerate(cases)},
        }
    return result


def print_table(label: str, result: dict) -> None:
    print(f"\n{label}: rms error of speed (mm/s) and yaw rate (mrad/s)")
    print(f"{'':16s}{'ours':>16s}{'best rival':>18s}{'ours/rival':>16s}{'own best':>18s}  width")
    for name, own in result["ours"].items():
        fixed = np.min([r["fixed"][name] for r in result["rivals"].values()], axis=0)
        oracle = np.min([r["oracle"][name] for r in result["rivals"].values()], axis=0)
        width = [rms([p[i] for p in result["pulls"][name]]) for i in (0, 1)]
        print(
            f"{name:16s}{1e3 * own[0]:8.2f}{1e3 * own[1]:8.2f}  {1e3 * fixed[0]:8.2f}"
            f"{1e3 * fixed[1]:8.2f}{own[0] / fixed[0]:8.2f}{own[1] / fixed[1]:8.2f}  "
            f"{1e3 * oracle[0]:8.2f}{1e3 * oracle[1]:8.2f}  {width[0]:.2f} {width[1]:.2f}"
        )
    total, best = pooled_errors(result)
    width = normalised_error_widths(result)
    print(f"all: ours / best rival {total[0] / best[0]:.2f} {total[1] / best[1]:.2f}; ", end="")
    print("width " + " ".join(f"{one:.2f}" for one in width))


def pooled_errors(result: dict) -> tuple[np.ndarray, np.ndarray]:
    """Errors over all motions: ours, and the best rival's at its best setting."""
    own = np.sqrt(np.mean([e**2 for e in result["ours"].values()], axis=0))
    each = [np.mean([e**2 for e in r["fixed"].values()], axis=0) for r in result["rivals"].values()]
    return own, np.sqrt(np.min(each, axis=0))


def normalised_error_widths(result: dict) -> list[float]:
    every = [p for pulls in result["pulls"].values() for p in pulls]
    return [rms([p[i] for p in every]) for i in range(5)]


def time_campaign(trials: int = 66) -> float:
    """Seconds of one core for so many trials of 240 frames."""
    rng = np.random.default_rng(5)
    makers = list(exact_motions.MOTIONS.values())[1:]
    t = exact_motions.frame_times(240)
    poses = [exact_motions.observed_pose(makers[i % len(makers)](t), rng) for i in range(trials)]
    start = time.process_time()
    for pose in poses:
        smooth_pose(pose, 2.37)
    return time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=6)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--widths", action="store_true")
    given = parser.parse_args()
    for label, (seen, frames) in CONDITIONS.items():
        cases = simulated_cases(
            seen, frames, given.trials, lasting="last" in label, seed=given.seed
        )
        if given.widths:
            pulls = [p for case in cases.values() for p in our_errors(case, seen.hz)[1]]
            width = " ".join(f"{rms([p[i] for p in pulls]):.2f}" for i in range(5))
            print(f"{label}: width {width} ({len(pulls)} runs)", flush=True)
        else:
            print_table(label, compare_methods(cases, seen.hz, frames))
    print(f"\n66 trials of 240 frames: {time_campaign():.1f} s of one core")


if __name__ == "__main__":
    main()
