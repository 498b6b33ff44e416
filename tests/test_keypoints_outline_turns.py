"""Front and rear told by all frames of a run."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.keypoints.outline.turns import turned_round


def circling(count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Front and rear of a body 100 px long that swims a circle."""
    angle = np.linspace(0, 4, count)
    middle = 300 + 150 * np.column_stack([np.cos(angle), np.sin(angle)])
    ahead = 50 * np.column_stack([-np.sin(angle), np.cos(angle)])
    return middle + ahead, middle - ahead


def swapped(front, rear, frames):
    front, rear = front.copy(), rear.copy()
    front[frames], rear[frames] = rear[frames].copy(), front[frames].copy()
    return front, rear


@pytest.mark.parametrize("frames", [[], [7], [0], [39], [10, 11, 12], [3, 20, 21, 30]])
def test_frames_the_wrong_way_round_are_named(frames):
    front, rear = swapped(*circling(), frames)
    wrong, doubt = turned_round(front, rear, np.full(40, 40.0), np.ones(40))
    assert np.flatnonzero(wrong).tolist() == frames
    assert not doubt.any()


def test_surer_frames_have_more_to_say():
    unsure = list(range(12, 40))
    front, rear = swapped(*circling(), unsure)
    weight = np.ones(40)
    weight[unsure] = 0.1
    wrong, doubt = turned_round(front, rear, np.full(40, 40.0), weight)
    assert np.flatnonzero(wrong).tolist() == unsure
    assert not doubt.any()
    _, doubt = turned_round(front, rear, np.full(40, 40.0), np.where(weight < 1, 0.3, 1.0))
    assert doubt.all()


def test_a_gap_or_a_jump_begins_a_new_run():
    front, rear = swapped(*circling(), [20])
    front[10], rear[10] = np.nan, np.nan
    front[25:], rear[25:] = front[25:] + 200, rear[25:] + 200
    wrong, _ = turned_round(front, rear, np.full(40, 40.0), np.ones(40))
    assert np.flatnonzero(wrong).tolist() == [20]
    lone, doubt = turned_round(front, rear, np.zeros(40), np.ones(40))
    assert not lone.any()
    assert not doubt.any()
