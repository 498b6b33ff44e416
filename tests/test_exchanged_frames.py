"""Frames in which a keypoint file has head and tail exchanged are named and put right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from test_pose import HEAD_M, ROBOT, circle_poses, keypoint_positions

from bluekoi.cli import main
from bluekoi.data import BODY_PART_NAMES, KeypointPositions, read_track
from bluekoi.files import read_json
from bluekoi.pose.head_tail_swap import undo_head_tail_swaps
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.tracks import tracks
from small_studies import small_study

STD_M = 8e-4
SWAPPED = np.r_[40, 100:120, 170:174]


def end_for_end(positions: KeypointPositions, frames: np.ndarray) -> KeypointPositions:
    """Positions whose labels are in the reverse order in some frames."""
    xy, likelihood = positions.xy_m.copy(), positions.likelihood.copy()
    xy[frames], likelihood[frames] = xy[frames, ::-1], likelihood[frames, ::-1]
    return replace(positions, xy_m=xy, likelihood=likelihood)


def named_frames(times: list[list[float]]) -> np.ndarray:
    runs = [np.arange(round(30 * first), round(30 * last) + 1) for first, last in times]
    return np.concatenate([*runs, np.zeros(0, dtype=int)])


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("phi", [0.0, 0.5, -0.8])
def test_exchanged_frames_are_found_and_put_right(phi, stated):
    good = keypoint_positions(circle_poses(phi=phi), STD_M, stated=stated)
    found, times = undo_head_tail_swaps(end_for_end(good, SWAPPED), ROBOT, HEAD_M)
    assert named_frames(times).tolist() == SWAPPED.tolist()
    assert np.array_equal(found.xy_m, good.xy_m)
    assert np.array_equal(found.likelihood, good.likelihood)


def test_files_without_a_tail_tip():
    good = keypoint_positions(circle_poses(), STD_M)
    cut = KeypointPositions(
        good.time_s, BODY_PART_NAMES[:4], good.xy_m[:, :4], good.cov_m2[:, :4],
        good.likelihood[:, :4],
    )  # fmt: skip
    found, times = undo_head_tail_swaps(end_for_end(cut, SWAPPED), ROBOT, HEAD_M)
    assert named_frames(times).tolist() == SWAPPED.tolist()
    assert np.array_equal(found.xy_m, cut.xy_m)


@pytest.mark.parametrize("understated", [1.0, 10.0])
def test_right_and_otherwise_wrong_frames_stay(understated):
    """Noise, covariances that are too small, single wrong points, and points not seen."""
    good = keypoint_positions(circle_poses(n=2000), STD_M)
    xy, likelihood = good.xy_m.copy(), good.likelihood.copy()
    for part in range(5):
        xy[100 * part : 100 * part + 50, part] += [0.1, -0.05]
        likelihood[1000 + 100 * part : 1050 + 100 * part, part] = 0.01
    xy[800:820] = xy[800:820, [0, 2, 1, 3, 4]]
    shown = replace(good, xy_m=xy, likelihood=likelihood, cov_m2=good.cov_m2 / understated**2)
    found, times = undo_head_tail_swaps(shown, ROBOT, HEAD_M)
    assert times == []
    assert found is shown


def test_nothing_seen_is_no_exchange():
    good = keypoint_positions(circle_poses(n=40), STD_M)
    blind = replace(good, xy_m=np.full_like(good.xy_m, np.nan))
    assert undo_head_tail_swaps(blind, ROBOT, HEAD_M) == (blind, [])


@pytest.fixture
def study_with_exchange(tmp_path):
    """A small study, and the same with head and tail exchanged in frames 20 to 39 of T10."""
    good = small_study(tmp_path / "good")
    study = small_study(tmp_path / "study")
    file = next((study / "keypoints").glob("T10*.csv"))
    lines = file.read_text().splitlines()
    names = lines[1].split(",")[1::3]
    order = [names.index(name) for name in BODY_PART_NAMES]
    other = dict(zip(order, order[::-1], strict=True))
    for k in range(3 + 20, 3 + 40):
        frame, *cells = lines[k].split(",")
        columns = [3 * other[i] + j for i in range(len(names)) for j in range(3)]
        lines[k] = ",".join([frame, *(cells[c] for c in columns)])
    file.write_text("\n".join(lines) + "\n")
    return good, study


def test_check_names_the_frames(study_with_exchange):
    _, study = study_with_exchange
    shown = CliRunner().invoke(main, ["check", str(study)]).output
    assert "T10.csv, frames 20 to 39: the keypoints of head and tail are exchanged" in shown
    assert "another trial" not in shown


def test_the_track_is_that_of_the_right_file(study_with_exchange, tmp_path):
    tables = []
    for study in study_with_exchange:
        results = tmp_path / f"results-{study.name}"
        keypoints(study, results, "T10")
        tracks(study, results, "T10")
        tables.append(read_track(results / "tracks/T10.csv"))
        exchanged = read_json(results / "status/T10.json")["exchanged_frames"]
        assert len(exchanged) == (study.name == "study")
    good, mended = tables
    for name in ("x_m", "y_m", "heading_rad", "head_angle_rad"):
        error = np.abs(getattr(mended, name) - getattr(good, name))
        assert (error < getattr(good, f"{name}_std")).all()
