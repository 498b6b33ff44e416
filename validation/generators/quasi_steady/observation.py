"""How the studies' camera sees a trial and what a competent lab would decode from it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.quasi_steady import camera as cam
from validation.generators.quasi_steady.effects import Effect
from validation.generators.quasi_steady.laws import sink_depth
from validation.generators.quasi_steady.trials import LENGTH, WIDTH, Lab, Trial


@dataclass(frozen=True)
class Stated:
    """What study.yaml says of pool, water and camera, and the pose it implies."""

    camera: cam.Camera
    length: float
    width: float
    corners_px: np.ndarray


def strength(effects: Sequence[Effect], cause: str, variant: int | None = None) -> float:
    """Strength of a cause (of one variant) among the effects, 0 without it."""
    return sum(e.k for e in effects if e.form.cause == cause and variant in (None, e.form.variant))


def state(lab: Lab, effects: Sequence[Effect]) -> Stated:
    """The lab's statement, with the hidden errors of scale, lens and refractive index."""
    true = lab.camera
    pixels = cam.to_pixels(true, cam.corners(LENGTH, WIDTH, lab.mark_height)) + lab.corner_error_px
    long = 1 + strength(effects, "scale_error")
    short = 1 + strength(effects, "scale_error", 0)
    bent = (true.distortion[0] + strength(effects, "lens_error", 0), *true.distortion[1:])
    centre = (true.centre[0] + strength(effects, "lens_error", 1), true.centre[1])
    index = true.index - strength(effects, "uncorrected_refraction", 1)
    guess = replace(true, distortion=bent, centre=centre, index=index)
    marks = cam.corners(LENGTH * long, WIDTH * short, lab.mark_height)
    return Stated(cam.with_pose(guess, marks, pixels), LENGTH * long, WIDTH * short, pixels)


def depth(lab: Lab, effects: Sequence[Effect], times: np.ndarray) -> np.ndarray:
    """True depth (m) of the keypoints at `times`."""
    out = np.full(len(times), lab.depth + strength(effects, "uncorrected_refraction", 0))
    for e in effects:
        if e.form.cause == "sinking":
            out += np.array([sink_depth(e.form.variant, e.k, t) for t in times])
    return out


def wobble(trial: Trial, effects: Sequence[Effect], times: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3) of a camera knocked in a third of the trials, or creeping in all."""
    out = np.zeros((len(times), 3))
    for e in effects:
        if e.form.cause == "camera_shift":
            moved = np.clip(times / max(trial.seconds, 1.0), 0, 1)
            if e.form.variant == 0:
                hit = int(trial.name[1:]) % 3 == 1
                moved = (moved > e.b).astype(float) * hit
            out += np.radians(e.k) * moved[:, None] * [np.cos(e.a), np.sin(e.a), 0.0]
    return out


def mislabelled(points: np.ndarray, effects: Sequence[Effect]) -> np.ndarray:
    """Keypoints (n, 5, 2) with a biased core_center, in metres behind and to the left."""
    out = points.copy()
    core = (points[:, 1] - points[:, 3]) @ [1, 1j]
    core /= np.abs(core)
    aft = strength(effects, "keypoint_bias", 0)
    move = core * (-aft + 1j * strength(effects, "keypoint_bias", 1))
    out[:, 2] += np.column_stack([move.real, move.imag])
    return out


def pixels(
    lab: Lab, trial: Trial, effects: Sequence[Effect], times: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Raw pixels (n, 5, 2) of the true points (n, 5, 2) at `times`, free of tracking errors."""
    n, m = points.shape[:2]
    xyz = np.empty((n, m, 3))
    xyz[..., :2] = mislabelled(points, effects)
    xyz[..., 2] = -depth(lab, effects, times)[:, None]
    turned = np.repeat(wobble(trial, effects, times), m, axis=0)
    return cam.project(lab.camera, xyz.reshape(-1, 3), turned).reshape(n, m, 2)


def decode(lab: Lab, stated: Stated, seen: np.ndarray) -> np.ndarray:
    """Pool positions (n, 5, 2) of pixels (n, 5, 2), as the study's statements imply."""
    flat = cam.unproject(stated.camera, seen.reshape(-1, 2), lab.depth)
    return flat.reshape(seen.shape)
