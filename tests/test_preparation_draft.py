"""study.yaml and trials.csv edited as text: checked, saved whole, comments kept."""

from __future__ import annotations

import difflib
import os
from dataclasses import replace

import pytest

from bluekoi.errors import InputError
from bluekoi.preparation.draft import read_draft
from bluekoi.preparation.draft_check import draft_findings, study_from_draft
from bluekoi.preparation.draft_saving import save_draft
from bluekoi.study import load_study

COMMENTED_YAML = """# pool in the cellar
pool:
  length_m: 2.6   # measured twice
  # the short side
  width_m: 1.6
  depth_m: 0.3
water: {density_kg_m3: 998.0, refractive_index: 1.333}  # tap water
robot:
  mass_kg: 0.68
  yaw_inertia_kg_m2: 0.0095
  body_length_m: 0.331
  head_length_m: 0.12
  head_span_m: 0.069
  hinge_to_com_m: 0.04
  tail_length_m: 0.066
  keypoint_depth_m: 0.05
  # end of the robot
camera:
  pool_corners_px:
    - [255.3, 939.7]
    - [1607.7, 946.4]
    - [1623.7, 115.9]
    - [256.2, 93.7]   # under the lamp
  # at the rim
  pool_corners_height_m: 0.0
"""
TRIALS_CSV = "source,trial_id,power_pct,head_angle_deg,head_length_m,fps\nT1.csv,T1,50,0,0.12,30\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "study.yaml").write_text(COMMENTED_YAML, encoding="utf-8")
    (tmp_path / "trials.csv").write_text(TRIALS_CSV, encoding="utf-8")
    (tmp_path / "T1.csv").write_text("scorer\n", encoding="utf-8")
    return tmp_path


def with_study_values(draft, **changes):
    values = {k: v for k, v in draft.values.items() if changes.get(k.replace(".", "__"), v)}
    return replace(
        draft, values=values | {k.replace("__", "."): v for k, v in changes.items() if v}
    )


def test_a_draft_saved_unchanged_changes_no_byte(folder):
    draft, done = save_draft(read_draft(folder), folder)
    assert done == []
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML
    assert (folder / "trials.csv").read_text() == TRIALS_CSV
    assert draft.values["camera.pool_corners_px"].startswith("[[255.3, 939.7], [1607.7, 946.4]")
    assert not (folder / ".backup").exists()


def test_values_are_changed_with_every_comment_kept(folder):
    draft = with_study_values(
        read_draft(folder), pool__length_m="2.5", robot__keypoint_depth_m="",
        camera__pool_corners_px="[[250, 939], [1607.7, 946.4], [1623.7, 115.9], [256.2, 93.7]]",
        camera__pool_corners_height_m="0.02",
    )  # fmt: skip
    saved, done = save_draft(draft, folder)
    text = (folder / "study.yaml").read_text()
    assert done == ["study.yaml changed"]
    for line in COMMENTED_YAML.splitlines():
        comment = line.partition("#")[2]
        assert comment in text, comment
    assert "length_m: 2.5   # measured twice" in text
    assert "keypoint_depth_m" not in text
    setup = load_study(folder).setup
    assert setup.camera.pool_corners_px[0] == (250, 939)
    assert setup.camera.pool_corners_height_m == 0.02
    assert not setup.robot.keypoint_depth_given
    assert saved.values["pool.length_m"] == "2.5"


def test_what_is_replaced_is_kept_beside(folder):
    save_draft(with_study_values(read_draft(folder), pool__length_m="2.5"), folder)
    (kept,) = (folder / ".backup").iterdir()
    assert kept.read_text() == COMMENTED_YAML


def test_a_file_changed_by_others_is_not_overwritten(folder):
    draft = with_study_values(read_draft(folder), pool__length_m="2.5")
    (folder / "trials.csv").write_text(TRIALS_CSV.replace("50", "60"), encoding="utf-8")
    with pytest.raises(InputError, match="changed by another program"):
        save_draft(draft, folder)
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML


def test_a_draft_that_names_no_revision_does_not_replace_a_study(folder):
    with pytest.raises(InputError, match=r"does not say which revision.*Reload the page"):
        save_draft(replace(read_draft(folder), values={}, rows=[], revision=""), folder)
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML
    assert (folder / "trials.csv").read_text() == TRIALS_CSV


def test_a_study_folder_that_was_deleted_is_not_made_again(tmp_path):
    folder = tmp_path / "lab"
    folder.mkdir()
    draft = read_draft(folder)
    folder.rmdir()
    for revision in (draft.revision, ""):
        with pytest.raises(InputError, match=r"lab: found no such folder.*moved or deleted"):
            save_draft(replace(draft, revision=revision), folder)
    assert not folder.exists()


def test_unknown_keys_and_columns_are_refused_by_name(folder):
    draft = read_draft(folder)
    unknown = {**draft.values, "robot.mas_kg": "1", "pool": "{length_m: 2}"}
    rows = [{**draft.rows[0], "powr_pct": "50"}]
    with pytest.raises(InputError) as refused:
        save_draft(replace(draft, values=unknown, rows=rows), folder)
    named = [(finding.file, finding.where) for finding in refused.value.findings]
    assert named == [("study.yaml", "robot.mas_kg"), ("study.yaml", "pool"),
                     ("trials.csv", "powr_pct")]  # fmt: skip
    assert "Did you mean 'robot.mass_kg'? Nothing was saved." in str(refused.value)
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML


def test_unknown_names_that_the_files_have_already_can_be_saved(folder):
    (folder / "trials.csv").write_text(TRIALS_CSV.replace("fps", "note"), encoding="utf-8")
    (folder / "study.yaml").write_text(
        COMMENTED_YAML.replace("mass_kg", "mas_kg"), encoding="utf-8"
    )
    save_draft(with_study_values(read_draft(folder), robot__mas_kg="0.7"), folder)
    assert "  mas_kg: 0.7\n" in (folder / "study.yaml").read_text()


def test_nothing_is_saved_where_no_copy_can_be_kept(folder):
    (folder / ".backup").write_text("a file", encoding="utf-8")
    draft = with_study_values(read_draft(folder), pool__length_m="2.5")
    with pytest.raises(InputError, match=r"\.backup: found 'File exists' on copying study\.yaml"):
        save_draft(draft, folder)
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML


@pytest.mark.parametrize("broken", ["study.yaml", "trials.csv"])
@pytest.mark.parametrize("is_new", [False, True])
def test_both_files_are_saved_or_neither(folder, monkeypatch, broken, is_new):
    texts = (COMMENTED_YAML, TRIALS_CSV)
    draft = with_study_values(read_draft(folder), pool__length_m="2.5")
    draft = replace(draft, rows=[{**draft.rows[0], "power_pct": "60"}])
    if is_new:
        for name in ("study.yaml", "trials.csv"):
            (folder / name).unlink()
        draft, texts = replace(draft, revision=""), (None, None)
    replaced = os.replace

    def refuse(source, target):
        if target.name == broken:
            raise PermissionError(1, "Operation not permitted")
        replaced(source, target)

    monkeypatch.setattr("bluekoi.files.os.replace", refuse)
    with pytest.raises(InputError, match=f"{broken}.*not permitted.*nothing was saved"):
        save_draft(draft, folder)
    found = [folder / name for name in ("study.yaml", "trials.csv")]
    assert tuple(path.read_text() if path.exists() else None for path in found) == texts
    assert not list(folder.glob(".study*")) + list(folder.glob(".trials*"))


def test_a_file_that_cannot_be_read_is_refused_and_left(folder):
    for name, text in (("study.yaml", "pool: [1\n"), ("trials.csv", "a,a\n1,2\n")):
        before = (folder / name).read_text()
        (folder / name).write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="Mend it in an editor"):
            read_draft(folder)
        assert (folder / name).read_text() == text
        (folder / name).write_text(before, encoding="utf-8")


def test_an_unknown_key_stays_and_is_reported(folder):
    (folder / "study.yaml").write_text(
        COMMENTED_YAML.replace("mass_kg", "mas_kg"), encoding="utf-8"
    )
    draft = read_draft(folder)
    texts = [f.text for f in draft_findings(draft, folder)]
    assert any("robot.mas_kg" in text and "Did you mean 'mass_kg'?" in text for text in texts)
    assert ("robot.mass_kg", "found nothing") in {
        (f.key, f.text[:13]) for f in draft_findings(draft, folder)
    }


def test_findings_stand_beside_their_fields(folder):
    draft = with_study_values(
        read_draft(folder), pool__length_m="2,6", camera__pool_corners_px="[[1, 2]]"
    )
    rows = [{**draft.rows[0], "power_pct": "half"}, {**draft.rows[0], "trial_id": "T2",
            "source": "gone.csv", "motor_log": "gone_log.csv"}]  # fmt: skip
    found = draft_findings(replace(draft, rows=rows), folder)
    assert {"pool.length_m", "camera.pool_corners_px"} <= {f.key for f in found}
    places = {(f.row, f.column) for f in found if f.row is not None}
    assert {(0, "power_pct"), (1, "source"), (1, "motor_log")} <= places
    assert (folder / "study.yaml").read_text() == COMMENTED_YAML


def test_an_incomplete_draft_is_no_study_and_says_so_in_the_words_of_its_file(folder):
    draft = with_study_values(read_draft(folder), robot__mass_kg="")
    with pytest.raises(InputError, match=r"^study\.yaml: robot\.mass_kg: found nothing") as refused:
        study_from_draft(draft, folder)
    assert str(refused.value).count("\n") == 0
    assert study_from_draft(read_draft(folder), folder).trials[0].trial_id == "T1"


def test_a_broken_recording_is_found_beside_its_row(folder):
    (folder / "T9.mp4").write_bytes(b"no video at all")
    draft = read_draft(folder)
    row = {**draft.rows[0], "trial_id": "T9", "source": "T9.mp4"}
    found = draft_findings(replace(draft, rows=[row]), folder, files=True)
    assert [(f.row, f.column) for f in found] == [(0, "source")]
    assert "a text file" in found[0].text


def test_a_folder_without_study_is_pre_filled_and_saved_as_one(tmp_path):
    (tmp_path / "videos").mkdir()
    (tmp_path / "videos/p50_phi20.mp4").write_bytes(b"")
    draft = read_draft(tmp_path)
    assert draft.rows[0]["power_pct"] == "50"
    assert "pool.length_m" not in draft.values
    full = with_study_values(
        draft, pool__length_m="2.6", pool__width_m="1.6", pool__depth_m="0.3",
        robot__mass_kg="0.68",
        robot__yaw_inertia_kg_m2="0.0095", robot__body_length_m="0.331",
        robot__head_length_m="0.12",
        robot__head_span_m="0.069", robot__hinge_to_com_m="0.04", robot__tail_length_m="0.066",
        camera__pool_corners_px="[[255, 939], [1607, 946], [1623, 115], [256, 93]]",
    )  # fmt: skip
    rows = [{**draft.rows[0], "head_length_m": "0.12"}]
    _, done = save_draft(replace(full, rows=rows), tmp_path)
    assert done == ["study.yaml saved", "trials.csv saved"]
    assert load_study(tmp_path).trials[0].head_angle_deg == 20
    assert "# Mass of the robot" in (tmp_path / "study.yaml").read_text()


def test_a_key_that_stood_there_as_a_comment_is_set_below_its_own_explanation(tmp_path):
    draft = read_draft(tmp_path)
    save_draft(with_study_values(draft, camera__image_size_px="[1920, 1080]"), tmp_path)
    lines = (tmp_path / "study.yaml").read_text().splitlines()
    at = lines.index("  image_size_px: [1920, 1080]")
    assert lines[at - 1].startswith("  # Width and height of the calibration images")
    assert "  # matrix:" in lines
    assert sum("image_size_px" in line for line in lines) == 1


@pytest.mark.parametrize(
    "key",
    ["pool__length_m", "pool__width_m", "water__density_kg_m3", "robot__mass_kg",
     "robot__keypoint_depth_m", "camera__pool_corners_px", "camera__pool_corners_height_m"],
)  # fmt: skip
def test_a_deleted_value_takes_no_comment_with_it(folder, key):
    name = key.replace("__", ".")
    saved, _ = save_draft(with_study_values(read_draft(folder), **{key: ""}), folder)
    text = (folder / "study.yaml").read_text()
    assert name not in saved.values
    for comment in ("# measured twice", "# the short side", "# tap water", "# end of the robot",
                    "# under the lamp", "# at the rim"):  # fmt: skip
        assert comment in text, comment


def test_all_values_of_a_section_are_deleted_and_its_comments_stay(folder):
    gone = ("pool__length_m", "pool__width_m", "pool__depth_m", "water__density_kg_m3",
            "water__refractive_index")  # fmt: skip
    save_draft(with_study_values(read_draft(folder), **dict.fromkeys(gone, "")), folder)
    assert (
        (folder / "study.yaml")
        .read_text()
        .startswith(
            "# pool in the cellar\n  # measured twice\n  # the short side\n# tap water\nrobot:\n"
        )
    )


WIDE_YAML = """pool:
    length_m:   2.6
    width_m:    1.6
    depth_m:    0.3   # in the middle

water: {density_kg_m3: 998.0,  refractive_index: 1.333}
camera:
    matrix: [[1140,0,960],
             [0,1140,540],
             [0,0,1]]
    pool_corners_px:
      - [255.3,939.7]
      - [1607.7,946.4]
      - [1623.7,115.9]
      - [256.2,93.7]
"""


@pytest.mark.parametrize("text", [COMMENTED_YAML, WIDE_YAML])
@pytest.mark.parametrize(
    ("key", "value", "lines"),
    [
        ("pool__length_m", "2.5", ["-", "+"]),
        ("pool__width_m", "", ["-"]),
        ("camera__image_size_px", "[1920, 1080]", ["+"]),
        ("robot__mass_kg", "0.5", ["-", "+"]),
        ("detection__source", "markers", ["+", "+"]),
    ],
)
def test_what_was_not_changed_keeps_its_formatting(folder, text, key, value, lines):
    if text == WIDE_YAML and key == "robot__mass_kg":
        lines = ["+", "+"]
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    save_draft(with_study_values(read_draft(folder), **{key: value}), folder)
    after = (folder / "study.yaml").read_text()
    marks = [line[0] for line in difflib.ndiff(text.splitlines(), after.splitlines())]
    assert [mark for mark in marks if mark in "+-"] == lines
