"""Keypoint files: DeepLabCut csv and h5, SLEAP h5, odd ones and hostile ones."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bluekoi.data import BODY_PART_NAMES, Keypoints, is_confident
from bluekoi.errors import InputError
from bluekoi.keypoints import deeplabcut, keypoint_source_module, keypoint_source_names
from bluekoi.keypoints.files.noise import frame_to_frame_noise_std_px
from bluekoi.study import Trial
from keypoint_files import read_all_parts


def make_trial(**changes) -> Trial:
    values = {
        "trial_id": "T01", "source": "k.csv", "power_pct": 50, "head_angle_deg": 0,
        "head_length_m": 0.12, "fps": 30.0,
    }  # fmt: skip
    return Trial(**(values | changes))


def keypoint_rows(parts=BODY_PART_NAMES, rows=4, *, who=None, likelihood=True) -> list[list[str]]:
    coords = ["x", "y", "likelihood"] if likelihood else ["x", "y"]
    head = [["scorer", *["s"] * len(parts) * len(coords)]]
    if who:
        head.append(["individuals", *[who] * len(parts) * len(coords)])
    head.append(["bodyparts", *[p for p in parts for _ in coords]])
    head.append(["coords", *coords * len(parts)])
    body = [
        [str(i)] + [{"x": f"{10 * k + i}", "y": f"{k}", "likelihood": "0.9"}[c]
                    for k in range(len(parts)) for c in coords]
        for i in range(rows)
    ]  # fmt: skip
    return head + body


def write_csv(path: Path, rows: list[list[str]]) -> Path:
    path.write_text("\n".join(",".join(row) for row in rows) + "\n", encoding="utf-8")
    return path


def test_sources_are_the_modules_of_the_folder():
    assert {"deeplabcut", "sleap", "silhouette"} <= set(keypoint_source_names())
    assert keypoint_source_module("deeplabcut") is deeplabcut
    with pytest.raises(InputError, match="Did you mean 'silhouette'"):
        keypoint_source_module("silhouete")


def test_plain_csv(tmp_path):
    found = deeplabcut.read_keypoints_of_trial(
        write_csv(tmp_path / "k.csv", keypoint_rows()), make_trial()
    )
    assert found.names == BODY_PART_NAMES
    assert found.time_s == pytest.approx(np.arange(4) / 30)
    assert found.part("core_center")[3] == pytest.approx([23, 2])
    assert np.all(found.likelihood == 0.9)


def test_columns_are_found_by_name_in_any_order(tmp_path):
    rows = keypoint_rows()
    order = [0, *np.random.default_rng(1).permutation(np.arange(1, len(rows[0])))]
    shuffled = write_csv(tmp_path / "s.csv", [[row[i] for i in order] for row in rows])
    plain = write_csv(tmp_path / "p.csv", rows)
    a, b = (
        deeplabcut.read_keypoints_of_trial(shuffled, make_trial()),
        deeplabcut.read_keypoints_of_trial(plain, make_trial()),
    )
    np.testing.assert_array_equal(a.xy_px, b.xy_px)


def test_first_row_without_values_is_kept(tmp_path):
    rows = keypoint_rows()
    rows[3] = ["0", *[""] * (len(rows[0]) - 1)]
    found = deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())
    assert len(found.time_s) == 4
    assert np.isnan(found.xy_px[0]).all()
    assert np.all(found.likelihood[0] == 0)


def test_missing_position_has_no_likelihood_whatever_the_file_says(tmp_path):
    rows = keypoint_rows()
    rows[4][1:4] = ["", "", "1.0"]
    rows[5][1:4] = ["0.0", "0.0", "0.0"]
    found = deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())
    assert found.likelihood[1, 0] == 0.0
    assert np.isnan(found.xy_px[2, 0]).all()


def test_likelihoods_in_percent_are_reported_with_their_row(tmp_path):
    rows = keypoint_rows()
    rows[4][3] = "92"
    with pytest.raises(InputError, match=r"row 5: found a likelihood of 92; expected 0 to 1"):
        deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())


def test_labels_without_likelihood_and_picture_paths(tmp_path):
    rows = keypoint_rows(likelihood=False)
    for i, row in enumerate(rows[3:]):
        row[0] = f"labeled-data/v/img{10 * i:04d}.png"
    found = deeplabcut.read_keypoints_of_trial(
        write_csv(tmp_path / "CollectedData_x.csv", rows), make_trial()
    )
    assert found.time_s == pytest.approx(np.arange(4) * 10 / 30)
    assert np.all(found.likelihood == 1.0)


def test_of_several_animals_the_one_with_the_parts_is_taken(tmp_path):
    ours, other = keypoint_rows(who="fish"), keypoint_rows(("nose", "tail"), who="toy")
    rows = [a + b[1:] for a, b in zip(ours, other, strict=True)]
    found = deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())
    assert found.names == BODY_PART_NAMES
    assert read_all_parts(tmp_path / "k.csv", 30).names[-1] == "toy/tail"


def test_of_two_robots_the_one_seen_most_is_taken_and_reported(tmp_path):
    ours, other = keypoint_rows(who="fish"), keypoint_rows(who="toy")
    for row in other[4:6]:
        row[1:] = [""] * (len(row) - 1)
    rows = [a + b[1:] for a, b in zip(other, ours, strict=True)]
    found = deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())
    assert np.isfinite(found.xy_px).all()
    assert any("toy" in remark for remark in found.remarks)


def test_body_parts_are_mapped_names_with_spaces_too(tmp_path):
    names = ("Nose tip", "hinge", "Butt/Proximal Tail", "tail_base", "tail_tip")
    path = write_csv(tmp_path / "k.csv", keypoint_rows(names))
    mapped = {"head_tip": "Nose tip", "core_center": "Butt/Proximal Tail"}
    assert deeplabcut.read_keypoints_of_trial(path, make_trial(), mapped).names == BODY_PART_NAMES
    with pytest.raises(InputError, match="no head_tip"):
        deeplabcut.read_keypoints_of_trial(path, make_trial())


def test_parts_that_are_not_needed_may_be_missing(tmp_path):
    path = write_csv(tmp_path / "k.csv", keypoint_rows(("head_tip", "core_center", "tail_base")))
    assert deeplabcut.read_keypoints_of_trial(path, make_trial()).names == (
        "head_tip",
        "core_center",
        "tail_base",
    )


def test_filtered_files_are_reported(tmp_path):
    found = deeplabcut.read_keypoints_of_trial(
        write_csv(tmp_path / "k_filtered.csv", keypoint_rows()), make_trial()
    )
    assert any("filtered" in remark for remark in found.remarks)


def test_part_of_the_recording(tmp_path):
    path = write_csv(tmp_path / "k.csv", keypoint_rows(rows=60))
    found = deeplabcut.read_keypoints_of_trial(path, make_trial(start_s=0.5, end_s=1.0))
    assert found.time_s[[0, -1]] == pytest.approx([0.5, 1.0])
    with pytest.raises(InputError) as caught:
        deeplabcut.read_keypoints_of_trial(path, make_trial(start_s=50.0))
    assert str(caught.value) == (
        "trials.csv: trial T01, start_s: found 50 s; expected a part of k.csv, whose frames are "
        "from 0 to 1.967 s."
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: [], "empty file"),
        (lambda rows: rows[:3], "without a single frame"),
        (lambda rows: rows[1:], "no row 'scorer'"),
        (lambda rows: [*rows, rows[3][:-1]], "row 8: found 15 cells"),
        (lambda rows: [*rows[:5], ["2", "abc", *rows[5][2:]]], "row 6, head_tip x: found 'abc'"),
        (lambda rows: [*rows[:5], ["2", "1_00", *rows[5][2:]]], "row 6, head_tip x: found '1_00'"),
        (lambda rows: [*rows[:-1], ["3000000000", *rows[-1][1:]]], "frame 3000000000 after"),
        (lambda rows: [*rows[:-1], ["1000.5", *rows[-1][1:]]], "frame 1000.5"),
        (lambda rows: [*rows[:3], *(["0", *row[1:]] for row in rows[3:])], "frame 0 after 0"),
        (lambda rows: [[";".join(r)] for r in rows], "separated by semicolons"),
        (lambda rows: [*rows[:5], ["2", "1e300", *rows[5][2:]]], "expected pixels"),
        (lambda rows: [row[:1] + row[1:4] * 5 for row in rows], "twice"),
        (lambda rows: [row[:1] + row[2:] for row in rows], "without x or y"),
        (lambda rows: [["time_s", "angle_deg"], ["0", "1"]], "no row 'scorer'"),
    ],
)
def test_wrong_files_are_reported_with_the_place(tmp_path, change, message):
    path = write_csv(tmp_path / "k.csv", change(keypoint_rows()))
    with pytest.raises(InputError, match=message) as caught:
        deeplabcut.read_keypoints_of_trial(path, make_trial())
    assert "k.csv" in str(caught.value)


@given(st.text(alphabet="scorebdypatxlikh,0123456789.-\n\r\"' \0é", max_size=300))
@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_any_text_is_read_or_a_fault(tmp_path, text):
    path = tmp_path / "f.csv"
    path.write_text("scorer,s,s\n" + text, encoding="utf-8", newline="")
    with pytest.raises(InputError, match=r"f\.csv"):
        deeplabcut.read_keypoints_of_trial(path, make_trial())


def test_what_is_written_is_read_back(tmp_path):
    rng = np.random.default_rng(3)
    spread = rng.normal(size=(20, 5, 2, 2))
    cov = spread @ spread.transpose(0, 1, 3, 2)
    xy = rng.uniform(0, 2000, (20, 5, 2))
    xy[3, 1], cov[3, 1] = np.nan, np.nan
    likelihood = np.where(np.isfinite(xy[..., 0]), rng.uniform(0.2, 1, (20, 5)), 0.0)
    time_s = np.cumsum(rng.uniform(0.02, 0.05, 20))
    lengths = np.where(rng.uniform(size=20) < 0.5, rng.normal(1, 0.01, 20), np.nan)
    given_points = Keypoints(time_s, BODY_PART_NAMES, xy, likelihood, cov, length_seen=lengths)
    deeplabcut.write_keypoints_csv(
        tmp_path / "T01.csv", given_points, "markers", stated_length_m=0.4
    )
    assert deeplabcut.detector_of_file(tmp_path / "T01.csv") == "markers"
    assert deeplabcut.is_written_by_bluekoi(tmp_path / "T01.csv")
    found = deeplabcut.read_keypoints_of_trial(
        tmp_path / "T01.csv", make_trial(), stated_length_m=0.5
    )
    assert (tmp_path / "T01.cov.csv").is_file()
    np.testing.assert_allclose(found.xy_px, xy, rtol=1e-5)
    np.testing.assert_allclose(found.cov_px2, cov, rtol=1e-6)
    np.testing.assert_allclose(found.time_s, time_s, rtol=1e-8)
    np.testing.assert_allclose(found.length_seen, 0.8 * lengths, rtol=1e-6)


@pytest.mark.parametrize("sigma", [0.2, 1.0])
def test_white_noise_is_found_under_swimming_tail_beat_and_outliers(sigma):
    rng = np.random.default_rng(5)
    t = np.arange(240) / 29.97
    motion = 200 * t + 15 * np.sin(2 * np.pi * 5.8 * t) * np.minimum(1, t)
    xy = np.column_stack([motion, 0.5 * motion]) + rng.normal(0, sigma, (240, 2))
    xy[::40] += 60.0
    assert frame_to_frame_noise_std_px(xy, np.ones(240)) == pytest.approx(sigma, rel=0.35)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: rows[2].__setitem__(3, "likelyhood"),
         r"coords, column 4: found 'likelyhood'; .*Did you mean 'likelihood'"),
        (lambda rows: [row.pop() for row in rows], "part 'tail_tip' without a likelihood"),
    ],
)  # fmt: skip
def test_a_damaged_header_of_coordinates_is_named(change, message, tmp_path):
    rows = keypoint_rows()
    change(rows)
    with pytest.raises(InputError, match=message):
        deeplabcut.read_keypoints_of_trial(write_csv(tmp_path / "k.csv", rows), make_trial())


def file_of_a_motion(path: Path, likelihood: np.ndarray, *, scorer: str = "net") -> None:
    """Positions with noise of 0.4 px on a wavy path, all parts at the likelihood of their frame."""
    rng, n = np.random.default_rng(8), len(likelihood)
    line = np.column_stack([400 + 3.0 * np.arange(n), 300 + 20 * np.sin(0.1 * np.arange(n))])
    true = line[:, None] + 40.0 * np.arange(5)[:, None] * [1.0, 0.0]
    xy = true + 0.4 * rng.normal(size=true.shape)
    rows = keypoint_rows(rows=n)
    rows[0] = ["scorer", *[scorer] * 15]
    for i, row in enumerate(rows[3:]):
        cells = np.column_stack([xy[i], np.full(5, likelihood[i])]).ravel()
        row[1:] = [f"{cell:.4f}" for cell in cells]
    write_csv(path, rows)


def test_points_of_a_file_count_as_seen_from_a_likelihood_of_a_tenth_on(tmp_path):
    likelihood = np.where(np.arange(80) % 4 == 0, 0.09, 0.3)
    file_of_a_motion(tmp_path / "k.csv", likelihood)
    found = deeplabcut.read_keypoints_of_trial(tmp_path / "k.csv", make_trial())
    assert np.array_equal(is_confident(found.likelihood[:, 0]), likelihood > 0.1)
    std = np.sqrt(found.cov_px2[likelihood > 0.1][..., 0, 0])
    assert std.mean() == pytest.approx(0.4, rel=0.3)


def test_few_points_of_little_confidence_are_left_out_with_a_remark(tmp_path):
    likelihood = np.where(np.arange(80) % 4 < 1, 0.3, 0.95)
    file_of_a_motion(tmp_path / "k.csv", likelihood)
    found = deeplabcut.read_keypoints_of_trial(tmp_path / "k.csv", make_trial())
    assert np.array_equal(is_confident(found.likelihood[:, 0]), likelihood > 0.6)
    assert any(remark.startswith("25 % of the points are left out") for remark in found.remarks)


@pytest.mark.parametrize("detected_here", [True, False])
def test_points_of_our_detectors_count_from_their_own_limit(detected_here, tmp_path):
    """A file of others may bear the scorer's name, but has no covariances beside it."""
    likelihood = np.where(np.arange(80) % 4 < 3, 0.3, 0.95)
    file_of_a_motion(path := tmp_path / "k.csv", likelihood, scorer=deeplabcut.SCORER)
    if detected_here:
        own = np.tile(likelihood[:, None], (1, 5))
        deeplabcut.write_keypoints_csv(
            path, replace(deeplabcut.read_keypoints_of_trial(path, make_trial()), likelihood=own)
        )
    found = deeplabcut.read_keypoints_of_trial(path, make_trial())
    used = likelihood > 0.6 if detected_here else likelihood > 0.1
    assert np.array_equal(is_confident(found.likelihood[:, 0]), used)


FILES = [
    ("dlc_csv/bsoid_raw_clip1DLC_resnet50_OpenFieldHighResApr8shuffle1_1030000.csv", 7200, 6),
    ("dlc_csv/deepof_testDLC_csv_table.csv", 97, 14),
    ("dlc_csv/deepof_testDLC_csv_table_madlc.csv", 97, 28),
    ("dlc_csv/deepof_testDLC_h5_table_multi.h5", 100, 28),
    ("dlc_csv/ethome_openfield_dlc_inference_example_missingdata.csv", 2330, 4),
    ("dlc_csv/heatmapper_test.csv", 10377, 3),
    ("dlc_csv/madlc_demo_CollectedData_Daniel.csv", 42, 32),
    ("openfield_mouse/labeled-data/m4s1/CollectedData_Pranav.h5", 116, 4),
]


@pytest.mark.recordings
@pytest.mark.parametrize(("name", "frames", "parts"), FILES)
def test_other_peoples_files_read_whole(recordings, name, frames, parts):
    found = read_all_parts(recordings / name, 30.0)
    assert found.xy_px.shape == (frames, parts, 2)
    assert np.all(found.likelihood[np.isnan(found.xy_px[..., 0])] == 0)


@pytest.mark.recordings
def test_blank_first_row_of_a_real_file_is_kept(recordings):
    name = "dlc_csv/ethome_openfield_dlc_inference_example_missingdata.csv"
    found = read_all_parts(recordings / name, 30.0)
    assert found.time_s[0] == 0.0
    assert np.isnan(found.part("snout")[0]).all()
    assert np.isfinite(found.part("leftear")[0]).all()


@pytest.mark.recordings
def test_zebrafish_files_read(recordings):
    files = sorted((recordings / "zebrafish_kinematics" / "dlc").glob("*.csv"))
    found = [read_all_parts(path, 1000.0) for path in files]
    assert len(found) == 7
    assert all(one.names == ("TS", "S1", "S2", "T1", "T2", "T3", "T4") for one in found)


def test_a_sleap_project_names_reader_and_export_where_it_cannot_be_read(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "sleap_io", None)  # as where it is not installed
    path = tmp_path / "fish.slp"
    path.write_bytes(b"x")
    with pytest.raises(InputError, match=r"pip install sleap-io.*Export Analysis HDF5"):
        read_all_parts(path, 30.0)


def test_a_sleap_project_is_read_through_sleaps_own_reader(tmp_path):
    sleap_io = pytest.importorskip("sleap_io", reason="sleap-io is not installed")
    points = np.random.default_rng(1).normal(100, 10, (6, 2, 2))
    skeleton = sleap_io.Skeleton(nodes=["nose", "hinge"])
    video = sleap_io.Video(filename="fish.mp4", open_backend=False)
    make = sleap_io.PredictedInstance.from_numpy
    frames = [
        sleap_io.LabeledFrame(video=video, frame_idx=i, instances=[
            make(xy, skeleton=skeleton, point_scores=np.full(2, 0.8), score=0.8)])
        for i, xy in enumerate(points)
    ]  # fmt: skip
    path = tmp_path / "fish.slp"
    sleap_io.Labels(videos=[video], skeletons=[skeleton], labeled_frames=frames).save(str(path))
    found = read_all_parts(path, 30.0)
    assert found.names == ("nose", "hinge")
    np.testing.assert_allclose(found.xy_px, points, atol=1e-4)
    np.testing.assert_allclose(found.likelihood, 0.8, atol=1e-6)
