"""Frames of a keypoint file in which head and tail are exchanged, found by the rigid lengths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import log
from typing import Any

import numpy as np
from scipy.special import chdtri

from ..data import BODY_PART_NAMES, BoolNDArray, Float, KeypointPositions
from ..study import Robot, Trial
from .fit import (
    OUTLIER_FALSE_ALARM_PROBABILITY,
    covariance_with_estimated_noise,
    degrees_of_freedom,
    fit_rigid_poses,
    systematic_keypoint_offsets,
    usable_frames,
)
from .rigid_lengths import measured_rigid_lengths, trusted_points

MAX_LISTED_SWAPPED_INTERVALS = 5
"""Parts of a recording that a warning lists."""


def undo_head_tail_swaps(
    positions: KeypointPositions, robot: Robot, head_length_m: float
) -> tuple[KeypointPositions, list[list[float]]]:
    """Positions with the parts in their order from head to tail, and the times, s, of first and
    last frame of each part of the recording in which they were in the reverse order.

    A frame counts as exchanged where the rigid body fits its points in the reverse order, and is
    100 000 times less likely with the points as they are labelled (`FALSE_ALARM_PROBABILITY`). The
    lengths are the trial's own medians, so that fewer than half of its frames may be exchanged.
    Covariances stay with their parts: that of a column of a keypoint file was measured mostly in
    frames in which the part was in it. A part without one gets that of the point.
    """
    reverse = _with_reversed_part_names(positions)
    labelled, turned = trusted_points(positions), trusted_points(reverse)
    try:
        exchanged = _fits_only_reversed(labelled, turned, robot, head_length_m)
    except (np.linalg.LinAlgError, ArithmeticError):  # several parts in one place: no body
        return positions, []
    times = [[float(positions.time_s[k]) for k in run] for run in _runs_of_marked_frames(exchanged)]
    if not times:
        return positions, []
    unknown = exchanged[:, None] & ~np.isfinite(positions.cov_m2).all(axis=(2, 3))
    return replace(
        positions,
        xy_m=np.where(exchanged[:, None, None], reverse.xy_m, positions.xy_m),
        cov_m2=np.where(unknown[..., None, None], reverse.cov_m2, positions.cov_m2),
        likelihood=np.where(exchanged[:, None], reverse.likelihood, positions.likelihood),
    ), times


def head_tail_swap_warnings(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> Iterator[str]:
    """A sentence for each trial with exchanged frames, as `undo_head_tail_swaps` found them."""
    for name, status in statuses.items():
        times = status.get("exchanged_frames") or []
        if not times or name not in trials:
            continue
        trial = trials[name]
        shown = ", ".join(
            _time_interval_text(first, last, trial)
            for first, last in times[:MAX_LISTED_SWAPPED_INTERVALS]
        )
        more = (
            f" and {len(times) - MAX_LISTED_SWAPPED_INTERVALS} more"
            if times[MAX_LISTED_SWAPPED_INTERVALS:]
            else ""
        )
        remedy = " Correct these frames in the file." if trial.reads_keypoints else ""
        yield (
            f"Trial {name}: {trial.source}, {shown}{more}: the keypoints of head and tail are "
            "exchanged; found distances of the body in the order from tail to head, expected "
            f"those from head to tail. The names are exchanged back in these frames.{remedy}"
        )


def _time_interval_text(first_s: float, last_s: float, trial: Trial) -> str:
    if not trial.reads_keypoints or trial.fps is None:
        return f"{first_s:.2f} to {last_s:.2f} s"
    first, last = (round(t * trial.fps) for t in (first_s, last_s))
    return f"frames {first} to {last}" if last > first else f"frame {first}"


def _runs_of_marked_frames(frames: BoolNDArray) -> list[tuple[int, int]]:
    """First and last frame of each run of marked frames (n,)."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], frames.astype(int), [0]])))
    return [(int(first), int(last) - 1) for first, last in ends.reshape(-1, 2)]


def _with_reversed_part_names(positions: KeypointPositions) -> KeypointPositions:
    """Positions in which the parts that are there bear their names in the reverse order."""
    parts = [name for name in BODY_PART_NAMES if name in positions.names]
    other = dict(zip(parts, reversed(parts), strict=True))
    columns = [positions.names.index(other.get(name, name)) for name in positions.names]
    return replace(
        positions,
        xy_m=positions.xy_m[:, columns],
        cov_m2=positions.cov_m2[:, columns],
        likelihood=positions.likelihood[:, columns],
    )


def _fits_only_reversed(
    labelled: tuple[Float, Float], turned: tuple[Float, Float], robot: Robot, head_length_m: float
) -> BoolNDArray:
    xy, cov = labelled
    if not usable_frames(np.isfinite(xy[:, :, 0])).any():
        return np.zeros(len(xy), dtype=bool)
    body = measured_rigid_lengths(xy, np.zeros_like(cov), robot, head_length_m)
    body = replace(body, offset_m=systematic_keypoint_offsets(xy, body))
    cov = covariance_with_estimated_noise(xy, cov, body)
    by_part = _medians_over_frames(cov)
    known = np.asarray(np.isfinite(turned[1]).all(axis=(2, 3)))
    turned_cov = np.where(known[:, :, None, None], turned[1], by_part)
    given = fit_rigid_poses(xy, cov, body).misfit
    reverse = fit_rigid_poses(turned[0], turned_cov, body).misfit
    usual = max(1.0, float(np.nanmedian(given / np.maximum(degrees_of_freedom(xy), 1))))
    limit = chdtri(np.maximum(degrees_of_freedom(turned[0]), 1), OUTLIER_FALSE_ALARM_PROBABILITY)
    fits = reverse <= usual * limit
    return np.asarray(fits & (given - reverse > -2 * usual * log(OUTLIER_FALSE_ALARM_PROBABILITY)))


def _medians_over_frames(cov: Float) -> Float:
    """Medians (parts, 2, 2) of covariances (n, parts, 2, 2); NaN for a part that is never seen."""
    out = np.full(cov.shape[1:], np.nan)
    for part in range(cov.shape[1]):
        known = np.isfinite(cov[:, part]).all(axis=(1, 2))
        if known.any():
            out[part] = np.median(cov[known, part], axis=0)
    return out
