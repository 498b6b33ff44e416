"""Parts of a session in which keypoints are displaced in the pool in one way each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from ..data import Float, KeypointPositions
from ..study import Robot
from .keypoint_displacement import (
    FALSE_ALARM_PROBABILITY,
    MIN_KEYPOINTS,
    KeypointDisplacementEstimate,
    displacement_design_matrix,
    displacement_fields,
    estimate_keypoint_displacements,
    same_displacements,
)
from .keypoint_displacement_field import remove_keypoint_displacements
from .rigid_distances import rigid_distances
from .rigid_length_regression import length_misfit, regress_length_errors
from .rigid_length_windows import window_means

MAX_CANDIDATE_CHANGE_POINTS = 40
"""Limit of the computing time: places in the session at which a displacement may change, evenly
spread."""


def displacements_by_session_part(
    trials: Sequence[KeypointPositions], head_lengths_m: Sequence[float], robot: Robot
) -> list[tuple[range, dict[str, KeypointDisplacementEstimate]]]:
    """Displaced keypoints of each part of the session (places in `trials`, in the order of filming)
    in which there are any. There is one part, or two where a displacement begins, ends or changes,
    as when a lamp is moved.

    Raises: InputError where no rigid pair is ever seen.
    """
    common = estimate_keypoint_displacements(trials, head_lengths_m, robot)
    corrected = [remove_keypoint_displacements(one, displacement_fields(common)) for one in trials]
    parts = _split_session_at_change_point(corrected, head_lengths_m, robot)
    if len(parts) == 1:
        return [(parts[0], common)] if common else []
    each = [
        estimate_keypoint_displacements(
            [trials[k] for k in part], [head_lengths_m[k] for k in part], robot
        )
        for part in parts
    ]
    windows = window_means(rigid_distances(trials, head_lengths_m, robot))
    first, second = map(displacement_fields, each)
    if common and same_displacements(first, second, windows):
        return [(range(len(trials)), common)]
    displaced = [(part, found) for part, found in zip(parts, each, strict=True) if found]
    return displaced or ([(range(len(trials)), common)] if common else [])


def _split_session_at_change_point(
    trials: Sequence[KeypointPositions], head_lengths_m: Sequence[float], robot: Robot
) -> list[range]:
    """Parts with one displacement each. The best of up to `MAX_CANDIDATE_CHANGE_POINTS` places of a
    change counts if the misfit becomes smaller by more than chi-squared does by chance with
    `FALSE_ALARM_PROBABILITY` at any of these places, with as many degrees of freedom as a second
    part adds.

    Raises: InputError where no rigid pair is ever seen.
    """
    whole, count = range(len(trials)), len(trials)
    windows = window_means(rigid_distances(trials, head_lengths_m, robot))
    names, columns, stds = displacement_design_matrix(windows)
    places = np.linspace(2, count - 2, min(max(count - 3, 0), MAX_CANDIDATE_CHANGE_POINTS))
    if len(names) < MIN_KEYPOINTS or not len(places):
        return [whole]

    def in_two_parts(first: int) -> Float:
        before = (windows.trial < first)[:, None]
        return np.column_stack([columns * before, columns * ~before])

    _, _, variance = regress_length_errors(windows, columns, stds)
    twice = np.concatenate([stds, stds])
    tried = {int(first): length_misfit(windows, in_two_parts(int(first)), twice, variance)
             for first in places.round()}  # fmt: skip
    change = min(tried, key=lambda first: tried[first])
    _, _, variance = regress_length_errors(windows, in_two_parts(change), twice)
    gain = length_misfit(windows, columns, stds, variance) - length_misfit(
        windows, in_two_parts(change), twice, variance
    )
    if gain < chdtri(columns.shape[1], FALSE_ALARM_PROBABILITY / len(tried)):
        return [whole]
    return [range(change), range(change, count)]
