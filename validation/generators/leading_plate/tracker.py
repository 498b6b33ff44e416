"""Labels on the robot and how a tracker finds them: recoil, correlated errors, outliers, gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .here import Law, Setting
from .robots import Array, Robot
from .sight import label_shift
from .water_laws import mass_shift

LABELS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Tracker:
    """white, slow: standard deviations of a label (px); memory (s); shares of outliers and gaps;
    swing: of the tail (rad); sway: of the centre of mass with the beat (m); label_error: (5, 2) m.
    """

    white: float
    slow: float
    memory: float
    outliers: float
    gaps: float
    swing: float
    sway: float
    lead: float
    label_error: Array


def draw_tracker(rng: np.random.Generator, robot: Robot, width_px: int) -> Tracker:
    """A tracker of ordinary quality; errors grow with the resolution of the picture."""
    unit = width_px / 1920
    return Tracker(
        white=float(rng.uniform(0.25, 0.8) * unit), slow=float(rng.uniform(0.2, 0.7) * unit),
        memory=float(rng.uniform(0.08, 0.4)), outliers=float(rng.uniform(0.001, 0.012)),
        gaps=float(rng.uniform(0.0, 0.02)), swing=float(np.radians(rng.uniform(12, 28))),
        sway=float(rng.uniform(0.001, 0.004) * robot.body_length),
        lead=float(rng.uniform(0, 2 * np.pi)),
        label_error=rng.normal(0, 0.0012 * robot.body_length, (5, 2)),
    )  # fmt: skip


def label_places(
    robot: Robot, setting: Setting, laws: tuple[Law, ...], tracker: Tracker,
    *, place: Array, core: Array, phi: Array, beat: Array, strength: Array,
) -> Array:  # fmt: skip
    """True places of labels of one trial (complex, frames x labels).

    beat: angle of the shaft (rad); strength: of the beat, 0 to 1. setting: of this trial alone.
    """
    wave = np.sin(beat + tracker.lead)
    core = core + robot.recoil * strength * wave
    core_axis, head = np.exp(1j * core), np.exp(1j * (core - phi - 0.3 * robot.recoil * wave))
    middle = place + 1j * core_axis * tracker.sway * strength * np.cos(beat + tracker.lead)
    for law in laws:
        if law.name == "centre_of_mass_shift":
            middle = middle - mass_shift(law, setting.phi) * robot.body_length * core_axis
    tail = core - tracker.swing * strength * np.sin(beat + tracker.lead - 1.2)
    hinge = middle + robot.hinge_to_com * core_axis
    base = middle - robot.core_length * core_axis
    labels = np.stack([hinge + setting.head * head, hinge, middle, base,
                       base - robot.tail_length * np.exp(1j * tail)], axis=-1)  # fmt: skip
    for law in laws:
        if law.name == "keypoint_bias":
            moved = [1, 2, 3, 4] if law.form == "core_labels" else [2]
            labels[:, moved] += (label_shift(law, robot) * core_axis)[:, None]
    return labels + (tracker.label_error @ np.array([1, 1j])) * core_axis[:, None]


def tracked(
    rng: np.random.Generator, tracker: Tracker, pixels: Array, fps: float
) -> tuple[Array, Array]:
    """Found pixels and likelihoods of labels (frames x labels x 2); NaN where nothing is found."""
    frames, labels, _ = pixels.shape
    keep = np.exp(-1 / (fps * tracker.memory))
    fresh = rng.normal(0, tracker.slow * np.sqrt(1 - keep**2), pixels.shape)
    fresh[0] /= np.sqrt(1 - keep**2)
    heavy = rng.standard_t(6, pixels.shape) / np.sqrt(1.5)
    found = pixels + lfilter([1.0], [1.0, -keep], fresh, axis=0) + tracker.white * heavy
    likelihood = 1 - rng.beta(1.2, 40, (frames, labels))
    wild = rng.random((frames, labels)) < tracker.outliers
    jump = rng.normal(0, 25 * tracker.white + 8, pixels.shape)
    found[wild] += jump[wild]
    doubted = wild & (rng.random(wild.shape) < 0.7)
    likelihood[doubted] = rng.uniform(0.02, 0.7, int(doubted.sum()))
    lost = _gaps(rng, tracker.gaps, frames, labels)
    likelihood[lost] = rng.uniform(0, 0.09, int(lost.sum()))
    found[lost & (rng.random(lost.shape) < 0.5)] = np.nan
    return found, likelihood


def _gaps(rng: np.random.Generator, share: float, frames: int, labels: int) -> Array:
    """Runs of frames without a label, and a few without any."""
    lost = np.zeros((frames, labels), dtype=bool)
    for _ in range(rng.poisson(share * frames * labels / 6)):
        begin, label = rng.integers(frames), rng.integers(labels)
        lost[begin : begin + rng.geometric(1 / 6), label] = True
    for _ in range(rng.poisson(share * frames / 20)):
        begin = rng.integers(5, max(frames, 6))
        lost[begin : begin + rng.geometric(1 / 3)] = True
    return lost
