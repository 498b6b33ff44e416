"""Warnings from the robot's rigid lengths where the verdict names no error of measurement."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from ..data.majority_deviation import deviations_from_majority
from ..study.setup_warnings import INDEX_OF_WATER, MAX_INDEX_DIFFERENCE
from .rigid_distances import STATED_LENGTH_STD_SHARE
from .smoothing_detection import CAUSES_CONFOUNDED_WITH_SMOOTHING

WARN_ABOVE_SIGMAS = 5.0
"""Standard errors by which a length must be off for a warning."""
MIN_LENGTH_ERROR_SHARE = 2 * STATED_LENGTH_STD_SHARE
"""Differences below twice the accuracy to which lengths are measured are no reason to warn."""
CAMERA_ERROR_HYPOTHESES = ("camera_shift", "lens_error", "uncorrected_refraction")
"""Hypotheses of the geometry check that are an error of the camera."""
SCALE_CAUSES = ("scale_error", "uncorrected_refraction", "lens_error", "sinking")
"""Causes that account for rigid lengths of another size."""
HARMLESS_SMOOTHING_S = 0.17
"""An average over five frames at 30 frames/s, not corrected, changed no cause of the study of
decision 080."""
MIN_CAUSE_PROBABILITY = 0.5
"""A cause below this probability accounts for nothing."""


def rigid_length_warnings(
    geometry: Mapping[str, Any] | None,
    mismatch: Mapping[str, Any] | None,
    refractive_index: float = INDEX_OF_WATER,
    failed: Collection[str] = (),
) -> list[str]:
    """A sentence for each doubt that the rigid lengths raise and the verdict does not settle: their
    size, an error of the camera by their pattern over the pool, trials that differ from the others.

    geometry, mismatch: content of geometry.json and mismatch.json. refractive_index: that of
    study.yaml. failed: trials without a track, which have a message of their own.
    """
    causes = (mismatch or {}).get("causes") or []
    named = {c["name"] for c in causes if c.get("weight", 1.0) >= MIN_CAUSE_PROBABILITY}
    return [
        *_unseen_tail_end_warnings(geometry or {}, failed),
        *_undetectable_displacement_warnings(geometry or {}),
        *_smoothing_warnings(geometry or {}),
        *_undetectable_smoothing_warnings(geometry or {}, named),
        *_scale_warnings(geometry or {}, named),
        *_camera_error_warnings(geometry or {}, named, refractive_index),
        *_deviating_trial_warnings(geometry),
    ]


def _unseen_tail_end_warnings(
    geometry: Mapping[str, Any], failed: Collection[str]
) -> Iterator[str]:
    if not geometry.get("tail_end_seen", True):
        yield (
            "No frame shows the end of the robot's tail near the position that study.yaml gives: "
            "the robot's lengths and the scale are not checked. If the tail is visible in the "
            "frames, measure body_length_m (nose to caudal base, with the standard head) and "
            "tail_length_m (caudal base to tip) again."
        )
    for name in geometry.get("trials_without_tail_end", ()):
        if name in failed:
            continue
        yield (
            f"Trial {name}: no frame shows the end of the robot's tail near the position that "
            "study.yaml gives, while most other recordings do. Was its picture zoomed, cropped or "
            "taken by another camera, or is head_length_m not this trial's?"
        )


def _undetectable_displacement_warnings(geometry: Mapping[str, Any]) -> Iterator[str]:
    if not geometry.get("keypoint_displacements_visible", True):
        yield (
            "Fewer than three keypoints are connected by rigid lengths: it is not checked whether "
            "a keypoint is displaced from its place on the robot, for instance by a highlight, and "
            "a displaced keypoint changes the verdict. Label head tip, hinge, core centre and tail "
            "base."
        )


def _smoothing_warnings(geometry: Mapping[str, Any]) -> Iterator[str]:
    if smoothing := geometry.get("keypoint_smoothing"):
        yield (
            "The robot's rigid lengths become shorter in fast turns, as if the keypoints had been "
            f"averaged over {smoothing['duration_s']:.2f} s. The start of each trial is left out "
            "of the fits for this duration, and causes that act as briefly "
            f"({', '.join(CAUSES_CONFOUNDED_WITH_SMOOTHING)}) are not candidates. Use the files as "
            "the network wrote them, before any smoothing or filter over time (DeepLabCut: those "
            "without `_filtered` in their name)."
        )


def _undetectable_smoothing_warnings(geometry: Mapping[str, Any], named: set[str]) -> Iterator[str]:
    like = sorted(named & set(CAUSES_CONFOUNDED_WITH_SMOOTHING))
    least_s = geometry.get("least_visible_smoothing_s")
    if not like or geometry.get("keypoint_smoothing") or (least_s or 0.0) <= HARMLESS_SMOOTHING_S:
        return
    yield (
        f"Keypoints that are smoothed over time look like {' or '.join(like)}, and the robot's "
        f"rigid lengths would not show a smoothing over less than {least_s:.2f} s. The verdict "
        "holds only if no filter over time was applied to the keypoint files."
    )


def _scale_warnings(geometry: Mapping[str, Any], named: set[str]) -> Iterator[str]:
    scale, std = (geometry.get(key) for key in ("scale", "scale_std"))
    if scale is None or std is None:
        return
    off = float(scale) - 1.0
    if abs(off) < max(MIN_LENGTH_ERROR_SHARE, WARN_ABOVE_SIGMAS * float(std)) or named & set(
        SCALE_CAUSES
    ):
        return
    yield (
        f"The robot's rigid lengths come out {100 * off:+.1f} +- {100 * float(std):.1f} % against "
        "study.yaml and trials.csv, and the verdict does not say why: speeds and radii may be off "
        "by as much. Check the pool's size, pool_corners_px, refractive_index, keypoint_depth_m "
        "and the robot's lengths."
    )


def _camera_error_warnings(
    geometry: Mapping[str, Any], named: set[str], refractive_index: float
) -> Iterator[str]:
    likely = geometry.get("likely")
    if likely in CAMERA_ERROR_HYPOTHESES and not named & {
        *CAMERA_ERROR_HYPOTHESES,
        *geometry.get("rivals", ()),
    }:
        yield (
            f"The pattern of the robot's rigid lengths over the pool shows {likely}, which the "
            f"verdict does not name: {geometry.get('sentence', '')}. "
            + _camera_remedy(str(likely), refractive_index)
        )


def _camera_remedy(likely: str, refractive_index: float) -> str:
    """What to check in study.yaml for an error of the camera."""
    if likely != "uncorrected_refraction":
        return "Check pool_corners_px, their order, and the camera's matrix against the recordings."
    stated = f"refractive_index is {refractive_index:g} in study.yaml"
    if abs(refractive_index - INDEX_OF_WATER) > MAX_INDEX_DIFFERENCE:
        return f"{stated}, water has {INDEX_OF_WATER:g}: correct it, and check keypoint_depth_m."
    return f"Check keypoint_depth_m and the water's depth; {stated}."


def length_deviation_by_trial(
    geometry: Mapping[str, Any] | None, least: float = MIN_LENGTH_ERROR_SHARE
) -> dict[str, float]:
    """Trial -> relative deviation of its rigid lengths from those of most trials, of the trials
    that deviate by more than the scatter and by more than `least`. geometry: of geometry.json.
    """
    by_trial = (geometry or {}).get("by_trial") or {}
    shares, stds = (np.array([row[key] for row in by_trial.values()]) for key in ("excess", "std"))
    found = deviations_from_majority(shares, stds, least)
    return {name: float(off) for name, off in zip(by_trial, found, strict=True) if off}


def _deviating_trial_warnings(geometry: Mapping[str, Any] | None) -> Iterator[str]:
    for name, off in length_deviation_by_trial(geometry).items():
        yield (
            f"Trial {name}: the robot's rigid lengths come out {100 * off:+.1f} % against the "
            "other trials. Its picture is not theirs (turned, mirrored, cropped, zoomed, or "
            "another camera), a keypoint is displaced, or head_length_m is not this trial's."
        )
