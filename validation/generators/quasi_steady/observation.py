"""How the studies' camera sees a trial and what a competent lab would decode from it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.quasi_steady import camera as cam
from validation.generators.quasi_steady.effects import Effect
from validation.generators.quasi_steady.laws import sink_depth
from validation.generators.quasi_steady.trials import LENGTH, WIDTH, Lab, Trial


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml says of pool, water and camera, and the pose it implies."""

    camera: cam.Camera
    length: float
    width: float
    corners_px: np.ndarray


def strength_of(effects: Sequence[Effect], cause: str, variant: int | None = None) -> float:
    """Strength of a cause (of one variant) among the effects, 0 without it."""
    return sum(e.k for e in effects if e.form.cause == cause and variant in (None, e.form.variant))


def stated_setup(lab: Lab, effects: Sequence[Effect]) -> StatedSetup:
    """The lab's statement, with the hidden errors of scale, lens and refractive index."""
    true = lab.camera
    pixels = (
        cam.to_pixels(true, cam.pool_corners(LENGTH, WIDTH, lab.mark_height)) + lab.corner_error_px
    )
    long = 1 + strength_of(effects, "scale_error")
    short = 1 + strength_of(effects, "scale_error", 0)
    bent = (true.distortion[0] + strength_of(effects, "lens_error", 0), *true.distortion[1:])
    centre = (true.centre[0] + strength_of(effects, "lens_error", 1), true.centre[1])
    index = true.index - strength_of(effects, "uncorrected_refraction", 1)
    guess = replace(true, distortion=bent, centre=centre, index=index)
    marks = cam.pool_corners(LENGTH * long, WIDTH * short, lab.mark_height)
    return StatedSetup(
        cam.with_fitted_pose(guess, marks, pixels), LENGTH * long, WIDTH * short, pixels
    )


def keypoint_depth(lab: Lab, effects: Sequence[Effect], times: np.ndarray) -> np.ndarray:
    """True depth (m) of the keypoints at `times`."""
    out = np.full(len(times), lab.depth + strength_of(effects, "uncorrected_refraction", 0))
    for e in effects:
        if e.form.cause == "sinking":
            out += np.array([sink_depth(e.form.variant, e.k, t) for t in times])
    return out


def camera_rotation(trial: Trial, effects: Sequence[Effect], times: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3) of a camera displaced in every third trial, or drifting in all."""
    out = np.zeros((len(times), 3))
    for e in effects:
        if e.form.cause == "camera_shift":
            moved = np.clip(times / max(trial.seconds, 1.0), 0, 1)
            if e.form.variant == 0:
                hit = int(trial.name[1:]) % 3 == 1
                moved = (moved > e.b).astype(float) * hit
            out += np.radians(e.k) * moved[:, None] * [np.cos(e.a), np.sin(e.a), 0.0]
    return out


def with_label_bias(points: np.ndarray, effects: Sequence[Effect]) -> np.ndarray:
    """Keypoints (n, 5, 2) with a biased core_center, in metres behind and to the left."""
    out = points.copy()
    core = (points[:, 1] - points[:, 3]) @ [1, 1j]
    core /= np.abs(core)
    aft = strength_of(effects, "keypoint_bias", 0)
    move = core * (-aft + 1j * strength_of(effects, "keypoint_bias", 1))
    out[:, 2] += np.column_stack([move.real, move.imag])
    return out


def keypoint_pixels(
    lab: Lab, trial: Trial, effects: Sequence[Effect], times: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Raw pixels (n, 5, 2) of the true points (n, 5, 2) at `times`, free of tracking errors."""
    n, m = points.shape[:2]
    xyz = np.empty((n, m, 3))
    xyz[..., :2] = with_label_bias(points, effects)
    xyz[..., 2] = -keypoint_depth(lab, effects, times)[:, None]
    turned = np.repeat(camera_rotation(trial, effects, times), m, axis=0)
    return cam.project(lab.camera, xyz.reshape(-1, 3), turned).reshape(n, m, 2)


def pixels_to_stated_pool(lab: Lab, stated: StatedSetup, seen: np.ndarray) -> np.ndarray:
    """Pool positions (n, 5, 2) of pixels (n, 5, 2), as the study's statements imply."""
    flat = cam.pixels_to_pool(stated.camera, seen.reshape(-1, 2), lab.depth)
    return flat.reshape(seen.shape)
