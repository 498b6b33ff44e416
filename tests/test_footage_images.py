"""Pictures as a recording: which files, in which order, at which times, and the same detection."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from PIL.ExifTags import Base

from bluekoi.errors import InputError
from bluekoi.footage import frames, open_recording
from bluekoi.footage.image_sequence import frame_numbers_from_file_names
from bluekoi.footage.picture_sizes import picture_size_px
from bluekoi.preparation.input_check import check_files, file_findings, recording_warnings
from bluekoi.stages.freshness import file_fingerprints
from bluekoi.stages.keypoints import unreadable_frames_remark
from bluekoi.study import Study, StudySettings, missing_files
from bluekoi.study.image_files import expand_source
from bluekoi.study.trials_csv import read_trials

HEADER = "trial_id,source,power_pct,head_angle_deg,head_length_m,fps\n"


@pytest.fixture
def folder(tmp_path):
    """Twelve pictures of 80 x 60 px, each as bright as its number; others beside them."""
    (tmp_path / "T1").mkdir()
    for i in range(1, 13):
        cv2.imwrite(str(tmp_path / f"T1/frame_{i}.png"), np.full((60, 80), 10 * i, np.uint8))
    cv2.imwrite(str(tmp_path / "T1/mask_1.png"), np.zeros((60, 80), np.uint8))
    (tmp_path / "T1/notes.txt").write_text("x")
    return tmp_path


@pytest.mark.parametrize("name", ["T1/frame_*.png", "T1/frame_%d.png", "T?/frame_[0-9]*.png"])
def test_a_pattern_is_its_pictures_as_people_count(folder, name):
    found = expand_source(folder, name)
    assert [path.name for path in found] == [f"frame_{i}.png" for i in range(1, 13)]


def test_a_folder_is_all_of_its_pictures(folder):
    assert len(expand_source(folder, "T1")) == len(expand_source(folder, "T1/")) == 13
    assert expand_source(folder, str(folder / "T1"))[0].is_absolute()


def test_what_is_not_there_stays_a_path_to_complain_of(folder):
    (folder / "trials.csv").write_text(HEADER + "A,T2/*.png,50,0,0.12,30\n")
    study = Study.model_construct(root=folder, setup=None, trials=tuple(trials_of_folder(folder)))
    assert ["T2/*.png" in str(one) for one in missing_files(study)] == [True]


def test_frames_have_the_times_of_the_stated_rate(folder):
    film = open_recording(expand_source(folder, "T1/frame_*.png"), fps=20.0, start_s=0.1, end_s=0.4)
    assert film.size_px == (80, 60)
    found = list(frames(film))
    np.testing.assert_allclose([one.time_s for one in found], np.arange(2, 9) / 20)
    assert [int(one.luma[0, 0]) for one in found] == [30, 40, 50, 60, 70, 80, 90]
    assert [int(one.luma[0, 0]) for one in frames(film).evenly_spaced(3)] == [30, 60, 90]
    assert next(iter(frames(film, colour=True))).bgr.shape == (60, 80, 3)
    small = next(iter(frames(film, colour=True, bgr_size=(40, 30))))
    assert (small.bgr.shape, small.luma.shape) == ((30, 40, 3), (60, 80))


def test_a_damaged_picture_costs_its_own_frame_alone(folder):
    (folder / "T1/frame_5.png").write_bytes(b"broken")
    cv2.imwrite(str(folder / "T1/frame_6.png"), np.zeros((10, 10), np.uint8))
    film = open_recording(expand_source(folder, "T1/frame_*.png"), fps=10.0)
    assert [one.index for one in frames(film)] == [0, 1, 2, 3, 6, 7, 8, 9, 10, 11]


@pytest.mark.parametrize(
    ("name", "fps", "text"),
    [("T1/frame_*.png", None, "State fps"), ("T1/none.png", 10.0, "no such file")],
)
def test_what_cannot_be_opened_is_refused(folder, name, fps, text):
    with pytest.raises(InputError, match=text):
        open_recording(expand_source(folder, name), fps=fps)


def test_the_state_of_many_pictures_changes_with_one_of_them(folder):
    paths = expand_source(folder, "T1/frame_*.png") * 2
    before = file_fingerprints(paths)
    cv2.imwrite(str(paths[3]), np.full((60, 80), 99, np.uint8))
    assert len(before) == 1
    assert file_fingerprints(paths) != before


def test_links_are_followed_and_absolute_paths_taken(folder, tmp_path_factory):
    other = tmp_path_factory.mktemp("elsewhere")
    (other / "pictures").symlink_to(folder / "T1")
    names = ["pictures", str(folder / "T1/frame_*.png")]
    rows = [f"A{i},{name},50,0,0.12,30\n" for i, name in enumerate(names)]
    (other / "trials.csv").write_text(HEADER + "".join(rows))
    study = Study.model_construct(root=other, setup=None, trials=tuple(trials_of_folder(other)))
    assert missing_files(study) == []
    assert [len(study.paths(trial)) for trial in study.trials] == [13, 12]


def test_two_trials_of_the_same_pictures_are_reported_once(folder):
    rows = [f"{name},T1/frame_*.png,50,0,0.12,30\n" for name in "AB"]
    (folder / "trials.csv").write_text(HEADER + "".join(rows))
    study = Study.model_construct(
        root=folder, setup=small_setup(), trials=tuple(trials_of_folder(folder))
    )
    (found,) = file_findings(study)
    assert "frame_1.png, whole, as trial A has it" in found.found


def small_setup() -> StudySettings:
    robot = {"mass_kg": 0.6, "yaw_inertia_kg_m2": 0.01, "body_length_m": 0.33,
             "tail_length_m": 0.06, "head_length_m": 0.12, "head_span_m": 0.07,
             "hinge_to_com_m": 0.04}  # fmt: skip
    corners = [[10, 50], [70, 50], [70, 10], [10, 10]]
    return StudySettings.model_validate({"robot": robot, "camera": {"pool_corners_px": corners}})


def trials_of_folder(folder):
    findings: list = []
    trials = read_trials(folder / "trials.csv", findings)
    assert findings == []
    return trials


def test_missing_pictures_leave_a_gap_and_not_a_shorter_recording(folder):
    for number in (5, 6, 7):
        (folder / f"T1/frame_{number}.png").unlink()
    film = open_recording(expand_source(folder, "T1/frame_*.png"), fps=20.0)
    assert film.duration_s == pytest.approx(12 / 20)
    (remark,) = film.remarks
    assert remark.startswith("3 pictures of 12 are missing")
    assert "between frame_4.png and frame_8.png" in remark
    expected = np.array([0, 1, 2, 3, 7, 8, 9, 10, 11]) / 20
    np.testing.assert_allclose([one.time_s for one in frames(film)], expected)


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (["a_0010", "a_0020", "a_0040", "a_0050"], (0, 1, 3, 4)),
        (["20261123_101500", "20261123_101700", "20261123_109901"], (0, 1, 2)),
        (["a", "b"], (0, 1)),
        (["a2", "a1"], (0, 1)),
        (["only7"], (0,)),
    ],
)
def test_numbers_in_names_count_frames_where_most_are_there(names, numbers):
    assert frame_numbers_from_file_names([Path(f"{name}.png") for name in names]) == numbers


def picture_study(folder, source="T1/frame_*.png"):
    (folder / "trials.csv").write_text(HEADER + f"A,{source},50,0,0.12,30\n")
    trials = tuple(trials_of_folder(folder))
    return Study.model_construct(root=folder.resolve(), setup=small_setup(), trials=trials)


def test_check_names_pictures_of_another_size(folder):
    for number in (1, 9, 10, 11, 12):
        cv2.imwrite(str(folder / f"T1/frame_{number}.png"), np.zeros((30, 40), np.uint8))
    study = picture_study(folder)
    findings, _, remarks = check_files(study)
    assert findings == []
    assert recording_warnings(study, remarks) == [
        "trial A: 5 of 12 pictures are not used, expected 80 x 60 px as in most of them: "
        "frame_1.png (40 x 30 px), frame_9.png (40 x 30 px), frame_10.png (40 x 30 px) and 2 more"
    ]
    film = open_recording(study.paths(study.trials[0]), fps=30.0)
    assert film.size_px == (80, 60)
    assert [one.index for one in frames(film)] == [1, 2, 3, 4, 5, 6, 7]


def test_check_names_pictures_whose_header_cannot_be_read(folder):
    (folder / "T1/frame_5.png").write_bytes(b"broken")
    study = picture_study(folder)
    (warning,) = recording_warnings(study, check_files(study)[2])
    assert "1 of 12 pictures is not readable: frame_5.png" in warning


@pytest.mark.parametrize("orientation", [1, 6])
def test_the_size_of_a_turned_photograph_is_that_of_the_picture_shown(tmp_path, orientation):
    exif = Image.Exif()
    exif[Base.Orientation] = orientation
    Image.new("L", (80, 60)).save(tmp_path / "a.jpg", exif=exif)
    shown = cv2.imread(str(tmp_path / "a.jpg"))
    assert picture_size_px(tmp_path / "a.jpg") == (shown.shape[1], shown.shape[0])


@pytest.mark.parametrize("suffix", ["png", "jpg", "tif", "bmp", "pgm"])
def test_the_size_of_a_picture_of_each_kind_is_read(tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    cv2.imwrite(str(path), np.zeros((60, 80), np.uint8))
    assert picture_size_px(path) == (80, 60)


def test_missing_pictures_are_not_unreadable(folder):
    for number in (5, 6, 7, 8):
        (folder / f"T1/frame_{number}.png").unlink()
    study = picture_study(folder)
    (trial,) = study.trials
    film = open_recording(study.paths(trial), fps=30.0)
    times = np.array([one.time_s for one in frames(film)])
    assert unreadable_frames_remark(trial, film, times) == ()
    (remark,) = unreadable_frames_remark(trial, film, times[[0, 1, 7]])
    assert remark == "5 of 8 pictures could not be read: copy them again"


def test_companions_that_macos_writes_are_no_pictures(folder):
    for i in range(1, 13):
        (folder / f"T1/._frame_{i}.png").write_bytes(b"\0\5\x16\7")
    for name in ("T1", "T1/*.png"):
        assert len(expand_source(folder, name)) == 13
    assert len(expand_source(folder, "T1/*frame_%d.png")) == 12


@pytest.mark.parametrize("name", ["T01.frames", "T01.mp4", "T01.csv", "T01.png", "T01.frames/"])
def test_a_folder_of_pictures_may_have_any_name(folder, name):
    (folder / "T1").rename(folder / name)
    study = picture_study(folder, name)
    (trial,) = study.trials
    assert trial.reads_images
    assert not trial.reads_keypoints
    assert missing_files(study) == []
    assert len(study.paths(trial)) == 13


@pytest.mark.parametrize("name", ["br[1]", "what?", "50%d", "a*b"])
def test_signs_of_a_pattern_may_be_in_the_name_of_a_folder(folder, name):
    (folder / "T1").rename(folder / name)
    for pattern in (f"{name}/frame_*.png", f"{name}/frame_%d.png", f"{name}/frame_[0-9]*.png"):
        assert len(expand_source(folder, pattern)) == 12
    assert len(expand_source(folder / name, "frame_*.png")) == 12
    assert len(expand_source(folder, name)) == 13


def test_sources_of_a_draft_are_relative_to_the_folder_of_the_study(folder, tmp_path_factory):
    (folder / "T1").rename(folder / "T01.frames")
    draft = tmp_path_factory.mktemp("draft") / "trials.csv"
    draft.write_text(HEADER + "A,T01.frames,50,0,0.12,30\n")
    findings: list = []
    (trial,) = read_trials(draft, findings, root=folder)
    assert (trial.source, findings) == ("T01.frames/", [])
