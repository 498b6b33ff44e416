"""Label files in DeepLabCut's layout and motor logs, with the faults of real ones."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator
from scipy.signal import lfilter

from .view import POINTS, Beat, Track, View, skeleton

NOISE_FACTOR = {
    "head_tip": 1.1,
    "hinge": 0.85,
    "core_center": 1.0,
    "tail_base": 1.0,
    "tail_tip": 1.9,
}
SCORER = "DLC_resnet50_dockSep12shuffle1_300000"
LOG_INTERVAL = 0.005
"""s."""


@dataclass(frozen=True)
class Footage:
    """What is filmed and how well it is tracked."""

    view: View
    track: Track
    noise: dict[str, float]


@dataclass(frozen=True)
class Style:
    """How the files of a study look.

    names: of the labels in the files; unseen: `empty` where points that were not seen are left out,
    else they have a low likelihood; dead_zone: what the log says there (`hold`, `zero`, `empty`);
    dead_deg: its width.
    """

    names: dict[str, str]
    unseen: str
    dead_zone: str
    dead_deg: float


@dataclass(frozen=True)
class Take:
    """One trial and the angle of the shaft at its start, in turns."""

    trial: int
    phase: float


def draw_noise(rng: Generator) -> dict[str, float]:
    """Numbers of the tracking noise and of the recoil for a whole study."""
    return {
        "white_px": float(rng.uniform(0.35, 0.9)),
        "correlated_px": float(rng.uniform(0.4, 1.1)),
        "correlation_s": float(rng.uniform(0.12, 0.5)),
        "outlier_rate": float(rng.uniform(0.002, 0.012)),
        "outlier_px": float(rng.uniform(15, 70)),
        "confident_outliers": float(rng.uniform(0.05, 0.3)),
        "gaps_per_10_s": float(rng.uniform(0.2, 1.0)),
        "recoil_deg": float(rng.uniform(0.5, 2.5)),
        "sway_over_length": float(rng.uniform(0.002, 0.008)),
        "tail_deg": float(rng.uniform(14, 26)),
        "recoil_lag_rad": float(rng.uniform(0.4, 1.6)),
        "end_label_along_body_over_length": float(rng.normal(0, 0.002)),
    }


def draw_style(rng: Generator) -> Style:
    """The look of a study's files."""
    own = {"head_tip": "nose", "hinge": "neck", "core_center": "core", "tail_base": "peduncle",
           "tail_tip": "fin_tip"}  # fmt: skip
    return Style(
        names=own if rng.random() < 0.25 else {name: name for name in POINTS},
        unseen=str(rng.choice(["likelihood", "likelihood", "empty"])),
        dead_zone=str(rng.choice(["hold", "zero", "empty"])),
        dead_deg=float(rng.uniform(8, 24)),
    )


def _tracking_error(
    rng: Generator, count: int, interval: float, noise: dict[str, float]
) -> np.ndarray:
    """White and correlated errors of one label, px, (frames, 2)."""
    memory = float(np.exp(-interval / noise["correlation_s"]))
    kicks = rng.standard_normal((count + 200, 2))
    slow = lfilter([np.sqrt(1 - memory * memory)], [1.0, -memory], kicks, axis=0)[200:]
    return noise["correlated_px"] * slow + noise["white_px"] * rng.standard_normal((count, 2))


def clean_pixels(footage: Footage, take: Take) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Label times (s) and noise-free pixels of a trial, beating tail and recoil included."""
    view, noise, trial = footage.view, footage.noise, take.trial
    length = view.robot.length
    label_time = np.arange(int(view.trials.duration[trial] * view.trials.fps) + 1)
    label_time = label_time / view.trials.fps
    time = view.true_time(label_time, trial)
    rising = np.where(time > 0, 1 - np.exp(-np.maximum(time, 0) / 0.4), 0.0)
    wave = 2 * np.pi * (footage.track.at("beats", time, trial) + take.phase)
    lag = noise["recoil_lag_rad"]
    beat = Beat(
        sway=noise["sway_over_length"] * length * rising * np.sin(wave - lag + 1.9),
        recoil=np.deg2rad(noise["recoil_deg"]) * rising * np.sin(wave - lag),
        tail=np.deg2rad(noise["tail_deg"]) * rising * np.sin(wave),
    )
    points, depth = skeleton(view, footage.track, time, trial, beat)
    ahead = points["head_tip"] - points["hinge"]
    misplaced = noise["end_label_along_body_over_length"] * length
    points["head_tip"] = points["head_tip"] + misplaced * ahead / np.abs(ahead)
    pixels = {name: view.pixels(points[name], depth, label_time, trial) for name in POINTS}
    return label_time, pixels


def _gaps(
    rng: Generator, count: int, mean: float, fps: float, spans: tuple[float, float]
) -> np.ndarray:
    """Frames that are lost: a Poisson number of gaps, each between `spans` (s) long."""
    lost = np.zeros(count, bool)
    for _ in range(rng.poisson(mean)):
        first = int(rng.integers(count))
        lost[first : first + int(rng.uniform(*spans) * fps) + 1] = True
    return lost


def _tracked(
    rng: Generator, footage: Footage, name: str, pixels: np.ndarray, lost: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels with errors, likelihood, and frames without this label; lost: without any."""
    noise, fps, count = footage.noise, footage.view.trials.fps, len(pixels)
    factor = NOISE_FACTOR[name]
    seconds = (count - 1) / fps
    found = pixels + factor * _tracking_error(rng, count, 1 / fps, noise)
    likelihood = 1 - np.minimum(0.25, 0.012 * rng.gamma(1.0, 1.0, count) * factor)
    wild = rng.random(count) < noise["outlier_rate"] * factor
    found[wild] += noise["outlier_px"] * rng.standard_t(3, (int(wild.sum()), 2))
    doubted = wild & ~(rng.random(count) < noise["confident_outliers"])
    likelihood[doubted] = rng.uniform(0.12, 0.6, int(doubted.sum()))
    gaps = noise["gaps_per_10_s"] * seconds / 10 * factor**2
    gone = lost | _gaps(rng, count, gaps, fps, (0.06, 0.5))
    found[gone] += rng.normal(0, 25, (int(gone.sum()), 2))
    likelihood[gone] = rng.uniform(0.001, 0.08, int(gone.sum()))
    width, height = footage.view.camera.size
    return np.clip(found, 0, [width - 1, height - 1]), likelihood, gone


def write_labels(rng: Generator, file: Path, footage: Footage, style: Style, take: Take) -> None:
    """One DeepLabCut csv."""
    label_time, pixels = clean_pixels(footage, take)
    fps, gaps = footage.view.trials.fps, footage.noise["gaps_per_10_s"]
    lost = _gaps(rng, len(label_time), 0.4 * gaps * label_time[-1] / 10, fps, (0.1, 0.4))
    columns: list[list[str]] = []
    for name in POINTS:
        found, likelihood, gone = _tracked(rng, footage, name, pixels[name], lost)
        x, y = ([f"{value:.3f}" for value in values] for values in found.T)
        if style.unseen == "empty":
            for frame in np.flatnonzero(gone):
                x[frame], y[frame] = "", ""
        columns += [x, y, [f"{value:.4f}" for value in likelihood]]
    rows = [
        ["scorer"] + [SCORER] * (3 * len(POINTS)),
        ["bodyparts"] + [style.names[name] for name in POINTS for _ in range(3)],
        ["coords"] + ["x", "y", "likelihood"] * len(POINTS),
        *[[f"{i}", *row] for i, row in enumerate(zip(*columns, strict=True))],
    ]
    file.write_text("\n".join(",".join(row) for row in rows) + "\n")


def write_log(rng: Generator, file: Path, track: Track, style: Style, take: Take, *,
              end: float) -> None:  # fmt: skip
    """Shaft angle (deg) every 5 ms from the start of the motor to `end` (s), a turn a tail beat."""
    time = np.arange(int(end / LOG_INTERVAL) + 1) * LOG_INTERVAL
    angle = np.mod(360.0 * (track.at("beats", time, take.trial) + take.phase), 360.0)
    read = np.clip(angle + rng.normal(0, 0.25, len(time)), 0.0, 359.99)
    written = [f"{value:.2f}" for value in read]
    last = written[0]
    for i in range(len(time)):
        if angle[i] > 360.0 - style.dead_deg:
            written[i] = {"hold": last, "zero": "0.00", "empty": ""}[style.dead_zone]
        else:
            last = written[i]
    rows = [f"{when:.3f},{value}" for when, value in zip(time, written, strict=True)]
    file.write_text("\n".join(["time_s,angle_deg", *rows]) + "\n")
