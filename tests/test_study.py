"""Checks of a study: all errors at once, each with file, place, found, expected and remedy."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bluekoi.errors import InputError, InputIssue
from bluekoi.stages.trial_failure import failed_trial_lines
from bluekoi.study import Camera, Robot, Trial, load_study, missing_files
from paper_robot import PAPER_ROBOT

SETUP = {
    "pool": {"length_m": 2.6, "width_m": 1.6, "depth_m": 0.3},
    "robot": PAPER_ROBOT,
    "camera": {
        "image_size_px": [1920, 1080],
        "matrix": [[1130.0, 0, 955.0], [0, 1130.0, 542.0], [0, 0, 1]],
        "distortion": [-0.12, 0.03, 0.0, 0.0, 0.0],
        "pool_corners_px": [[371, 975], [1603, 926], [1579, 171], [341, 212]],
    },
}
HEADER = "trial_id,source,power_pct,head_angle_deg,head_length_m,fps,motor_log,start_s,end_s,role"
TRIAL_ROW = "T01,keypoints/T01.csv,100,30,0.12,29.97,,,,"


def changed_setup(**sections):
    """SETUP with sections updated; a value of None deletes the key."""
    content = yaml.safe_load(yaml.safe_dump(SETUP))
    for name, update in sections.items():
        section = content.setdefault(name, {})
        section.update(update)
        for key in [key for key, value in update.items() if value is None]:
            del section[key]
    return content


def write_study(folder: Path, content=None, rows=(TRIAL_ROW,), header=HEADER) -> Path:
    folder.mkdir(exist_ok=True)
    text = content if isinstance(content, str) else yaml.safe_dump(content or SETUP)
    (folder / "study.yaml").write_text(text)
    (folder / "trials.csv").write_text("\n".join([header, *rows]) + "\n")
    return folder


def findings_of(folder: Path):
    with pytest.raises(InputError) as caught:
        load_study(folder)
    return caught.value.findings


def only_finding(folder: Path):
    (finding,) = findings_of(folder)
    return finding


def test_a_good_study_is_read_with_its_defaults(tmp_path):
    study = load_study(write_study(tmp_path / "s"))
    trial = study.trial("T01")
    assert study.setup.water.refractive_index == 1.333
    assert study.setup.robot.keypoint_depth_m == 0.04
    assert trial.head_angle_rad == pytest.approx(math.pi / 6)
    assert trial.motor_log is None
    assert trial.role is None
    assert study.paths(trial) == (study.root / "keypoints/T01.csv",)
    assert trial.condition == (100, 30, 0.12)


def test_derived_geometry_by_hand():
    robot = Robot(**SETUP["robot"])
    assert robot.aerodynamic_arm_m(0.12) == pytest.approx(0.12 + 0.04 - 0.331 / 4)
    assert robot.aerodynamic_arm_m(0.175) == pytest.approx(0.175 + 0.04 - (0.331 + 0.055) / 4)
    assert robot.head_area_m2(0.12) == pytest.approx(0.00828)
    assert robot.com_to_tail_base_m == pytest.approx(0.331 - 0.12 - 0.04)


def test_all_faults_of_both_files_come_at_once(tmp_path):
    content = changed_setup(robot={"mas_kg": 0.68, "mass_kg": None}, pool={"width_m": "wide"})
    rows = ["T01,keypoints/T01.csv,100,30,0.12,,,,,", "T02,../x.csv,abc,30,0.12,30,,,,"]
    found = findings_of(write_study(tmp_path / "s", content, rows))
    text = "\n".join(str(finding) for finding in found)
    assert len(found) == 5
    assert "robot.mas_kg: found an unknown key" in text
    assert "Did you mean 'mass_kg'?" in text
    assert "robot.mass_kg: found nothing; expected this key" in text
    assert "pool.width_m: found 'wide'" in text
    assert "row 2 (T01)" in text
    assert "fps is required" in text
    assert "row 3 (T02), power_pct: found 'abc'" in text


@pytest.mark.parametrize(
    ("section", "update", "where", "expected"),
    [
        ("robot", {"mass_kg": -0.68}, "robot.mass_kg", "greater than 0"),
        ("robot", {"mass_kg": float("nan")}, "robot.mass_kg", "finite"),
        ("robot", {"mass_kg": float("inf")}, "robot.mass_kg", "finite"),
        ("robot", {"yaw_inertia_kg_m2": 0}, "robot.yaw_inertia_kg_m2", "greater than 0"),
        ("robot", {"body_length_m": 0.1}, "robot.body_length_m", "smaller than body_length_m"),
        ("robot", {"head_length_m": 12}, "robot.body_length_m", "12 cm are 0.12 m"),
        ("robot", {"head_length_m": 120}, "robot.body_length_m", "120 mm are 0.12 m"),
        ("water", {"refractive_index": 13.33}, "water.refractive_index", "less than or equal"),
        ("camera", {"model": "fish eye"}, "camera.model", "'pinhole' or 'fisheye'"),
        ("camera", {"distortion": [0.1, 0.2, 0.3]}, "camera.distortion", "found 3 numbers"),
        ("camera", {"image_size_px": None}, "camera.image_size_px", "image_size_px is needed"),
        (
            "camera",
            {"matrix": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]},
            "camera.matrix",
            "focal lengths",
        ),
        (
            "camera",
            {"pool_corners_px": [[371, 975], [1603, 926], [1579, 171]]},
            "camera.pool_corners_px.3",
            "an entry here",
        ),
        (
            "camera",
            {"pool_corners_px": [[371, 975], [341, 212], [1579, 171], [1603, 926]]},
            "camera.pool_corners_px",
            "go round the other way",
        ),
        (
            "camera",
            {"pool_corners_px": [[371, 975], [1579, 171], [1603, 926], [341, 212]]},
            "camera.pool_corners_px",
            "cross over or lie on a line",
        ),
        ("bodyparts", {"head_tp": "nose"}, "bodyparts.head_tp", "Did you mean 'head_tip'?"),
        ("robot", {"mass_kg": True}, "robot.mass_kg", "not true or false"),
        ("robot", {"mass_kg": 680.0}, "robot.mass_kg", "Units are m, kg and kg m2"),
        ("robot", {"yaw_inertia_kg_m2": 95.0}, "robot.yaw_inertia_kg_m2", "kg m2"),
        ("robot", {"body_length_m": 33.1}, "robot.body_length_m", "shorter than the pool"),
        ("robot", {"keypoint_depth_m": 0.9}, "robot.keypoint_depth_m", "within the water"),
        ("camera", {"pool_corners_height_m": 50}, "camera.pool_corners_height_m", "Units are m"),
        ("camera", {"image_size_px": [1080, 1920]}, "camera.pool_corners_px", "width, then height"),
        (
            "camera",
            {"matrix": [[900, 0, 960], [0, 900, 540], [0, 0, 7]]},
            "camera.matrix",
            "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
        ),
        ("detection", {"sourc": "x"}, "detection.sourc", "Did you mean 'source'?"),
    ],
)
def test_a_wrong_value_is_named_with_its_place(tmp_path, section, update, where, expected):
    finding = only_finding(write_study(tmp_path / "s", changed_setup(**{section: update})))
    assert finding.file.endswith("study.yaml")
    assert finding.where == where
    assert expected in str(finding)


def test_a_misspelt_section_names_the_nearest(tmp_path):
    found = findings_of(write_study(tmp_path / "s", {**SETUP, "watr": {}}))
    assert "watr: found an unknown key; expected a known key. Did you mean 'water'?" in str(
        found[0]
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "found an empty file"),
        ("[1, 2]", "found [1, 2]"),
        ("robot: {mass_kg: 1, mass_kg: 2}", "'mass_kg' stands twice"),
        ("water: {density_kg_m3: 01000}", "'01000' is no decimal number"),
        ("robot: {mass_kg: 0x1}", "'0x1' is no decimal number"),
        ("pool: {length_m: 2:36}", "'2:36' is no decimal number"),
        ("robot: {mass_kg: 1_0.5}", "'1_0.5' is no decimal number"),
        ("a: !!python/object/apply:os.system ['true']", "no readable yaml"),
        ("a: [", "no readable yaml"),
        ("[" * 5000, "no readable yaml (brackets nested too deeply)"),
        ("a: 2026-13-45", "a date that does not exist"),
        ("a: " + "9" * 5000, "a number of thousands of digits"),
        ("x: " + "y" * 300_000, "300"),
    ],
)
def test_unreadable_yaml_is_one_message(tmp_path, text, expected):
    (folder := tmp_path / "s").mkdir()
    (folder / "study.yaml").write_text(text)
    (folder / "trials.csv").write_text(f"{HEADER}\n{TRIAL_ROW}\n")
    assert expected in str(only_finding(folder))


def test_yaml_that_doubles_itself_is_refused_quickly(tmp_path):
    bomb = "a0: &a0 [x, x]\n" + "".join(
        f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60)
    )
    found = findings_of(write_study(tmp_path / "s", bomb))
    assert all(len(str(finding)) < 500 for finding in found)
    assert any("an unknown key" in str(finding) for finding in found)


def test_decimal_commas_are_recognised(tmp_path):
    """In every row one message, whether the cells are quoted or not."""
    rows = [f"T0{i},k/T0{i}.csv,100,30,0.12,29,97,,,," for i in range(1, 6)]
    found = str(InputError(findings_of(write_study(tmp_path / "a", rows=rows))))
    assert "rows 2 to 6 (T01 to T05), number of cells: found 11; expected 10" in found
    assert "Decimals are written with a point" in found
    quoted = ['T01,k/T01.csv,100,30,0.12,"29,97",,,,']
    finding = only_finding(write_study(tmp_path / "b", rows=quoted))
    assert "found '29,97'; expected a number. Decimals are written with a point" in str(finding)


def test_a_negative_power_is_perhaps_a_head_angle(tmp_path):
    folder = write_study(tmp_path / "s", rows=["T01,k/T01.csv,-30,75,0.12,30,,,,"])
    assert "power_pct and head_angle_deg exchanged?" in str(only_finding(folder))


@pytest.mark.parametrize(
    ("rows", "where", "expected"),
    [
        (
            ["../T01,k/T01.csv,100,30,0.12,30,,,,"],
            "row 2 (../T01), trial_id",
            "letters, digits, _ and -",
        ),
        (["T01,../T01.csv,100,30,0.12,30,,,,"], "row 2 (T01), source", "without '..'"),
        (
            ["T01,k\0.csv,100,30,0.12,30,,,,"],
            "row 2 (T01), source",
            "without NUL characters (\\x00)",
        ),
        (["T01,k.csv,100,30,0.12,30,m\0,,,"], "row 2 (T01), motor_log", "without NUL characters"),
        (["T01,T01/*.png,100,30,0.12,,,,,"], "row 2 (T01), fps", "fps is required"),
        (["T01,a.mp4;T01/*.png,100,30,0.12,30,,,,"], "row 2 (T01), source", "videos or pictures"),
        (["T01,k.csv,100,30,0.12,30,../m.csv,,,"], "row 2 (T01), motor_log", "without '..'"),
        (["T01,k.txt,100,30,0.12,30,,,,"], "row 2 (T01), source", "a video or keypoint file"),
        (["T01,k.csv;l.csv,100,30,0.12,30,,,,"], "row 2 (T01), source", "one keypoint file"),
        (["T01,k.csv,100,30,0.12,30,,3,2,"], "row 2 (T01), end_s", "end_s must come after start_s"),
        (["T01,k.csv,100,30,0.12,30,,,,train"], "row 2 (T01), role", "'fit' or 'held_out'"),
        (["T01,k.csv,100,30,0.12,,,,,"], "row 2 (T01), fps", "fps is required"),
        ([TRIAL_ROW.rsplit(",", 1)[0] + ",held_out"], "role", "one or more to fit"),
        (["T01,k.csv,100,30,0.12,0,,,,"], "row 2 (T01), fps", "greater than or equal to 1"),
        (["T01,k.csv,100,300,0.12,30,,,,"], "row 2 (T01), head_angle_deg", "less than or equal"),
        (["T01,k.csv,100,30"], "row 2 (T01), number of cells", "10, as in the header"),
        ([TRIAL_ROW, "", TRIAL_ROW.replace("T01,", "t01,", 1)], "trial_id", "each trial_id once"),
        (["", "", "T09,k.csv,x,30,0.12,30,,,,"], "row 4 (T09), power_pct", "a number"),
        ([], "", "a header and a row a trial"),
    ],
)
def test_a_wrong_row_is_named_with_its_line(tmp_path, rows, where, expected):
    finding = findings_of(write_study(tmp_path / "s", rows=rows))[0]
    assert finding.file.endswith("trials.csv")
    assert finding.where == where
    assert expected in str(finding)


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        (HEADER.replace("head_length_m", "head_lenght_m"), "Did you mean 'head_length_m'?"),
        (HEADER.replace(",power_pct", ""), "no column 'power_pct'"),
        (HEADER + ",role", "column 'role' twice"),
        (HEADER.replace(",", ";"), "columns separated by commas"),
    ],
)
def test_a_wrong_header_is_named(tmp_path, header, expected):
    found = findings_of(write_study(tmp_path / "s", header=header))
    assert any(expected in str(finding) for finding in found)
    assert found[0].where == "row 1"


def test_an_empty_or_missing_trials_file(tmp_path):
    folder = write_study(tmp_path / "s")
    (folder / "trials.csv").write_text("")
    assert "an empty file" in str(only_finding(folder))
    (folder / "trials.csv").write_bytes(b"\xff\xfe\x00trial_id")
    assert "no readable csv (byte 1 is not UTF-8)" in str(only_finding(folder))
    (folder / "trials.csv").unlink()
    assert "no such file" in str(only_finding(folder))
    assert "no such folder" in str(only_finding(tmp_path / "nowhere"))
    assert "found a file" in str(only_finding(folder / "study.yaml"))


def test_missing_files_are_named_by_trial(tmp_path):
    study = load_study(write_study(tmp_path / "s"))
    (finding,) = missing_files(study)
    assert finding.where == "trial T01"
    assert "keypoints/T01.csv" in finding.found
    (study.root / "keypoints").mkdir()
    (study.root / "keypoints/T01.csv").touch()
    assert missing_files(study) == []


def test_an_unknown_trial_names_the_nearest(tmp_path):
    study = load_study(write_study(tmp_path / "s"))
    with pytest.raises(InputError, match="Did you mean 'T01'"):
        study.trial("T1")


def test_chapters_are_split_at_semicolons():
    trial = Trial(
        trial_id="T01",
        source="videos/GX010042.MP4; videos/GX020042.MP4",
        power_pct=50,
        head_angle_deg=0,
        head_length_m=0.12,
    )
    assert trial.sources == ("videos/GX010042.MP4", "videos/GX020042.MP4")
    assert not trial.reads_keypoints


def test_corners_in_any_rotation_of_the_right_order_pass():
    corners = SETUP["camera"]["pool_corners_px"]
    for k in range(4):
        assert Camera(pool_corners_px=corners[k:] + corners[:k]).matrix is None


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(yaml_bytes=st.binary(max_size=200), csv_bytes=st.binary(max_size=200))
def test_any_bytes_are_a_fault_and_never_another_error(tmp_path, yaml_bytes, csv_bytes):
    (tmp_path / "study.yaml").write_bytes(yaml_bytes)
    (tmp_path / "trials.csv").write_bytes(csv_bytes)
    with pytest.raises(InputError):
        load_study(tmp_path)


JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner),
    max_leaves=6,
)


@settings(
    max_examples=100,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize="BLUEKOI_FUZZ" not in os.environ,
)
@given(section=st.sampled_from(["pool", "water", "robot", "camera", "bodyparts"]), data=st.data())
def test_any_value_under_any_key_is_read_or_a_fault(tmp_path, section, data):
    content = changed_setup()
    fields = {"water": {"density_kg_m3": 1.0}, "bodyparts": {"hinge": "h"}, **content}[section]
    key = data.draw(st.sampled_from(sorted(fields)))
    content.setdefault(section, {})[key] = data.draw(JSON_VALUES)
    write_study(tmp_path, yaml.safe_dump(content, allow_unicode=True))
    try:
        sound = load_study(tmp_path).setup.robot.mass_kg > 0
    except InputError as caught:
        places = (section, "robot.") if section in ("pool", "water") else (section,)
        sound = all(f.where.startswith(places) or not f.where for f in caught.findings)
    assert sound


@pytest.mark.parametrize(
    ("section", "key"),
    [("robot", "body_length_m"), ("robot", "tail_length_m"), ("pool", "length_m")],
)
@pytest.mark.parametrize("value", [1e200, 1e300])
def test_a_length_whose_powers_are_no_numbers_is_refused(tmp_path, section, key, value):
    content = changed_setup()
    content.setdefault(section, {})[key] = value
    write_study(tmp_path, yaml.safe_dump(content, allow_unicode=True))
    with pytest.raises(
        InputError, match=rf"{section}\.{key}: found 1e\+[23]00; expected less than"
    ):
        load_study(tmp_path)


def test_one_trial_is_read_without_checking_the_others(tmp_path):
    study = write_study(tmp_path / "s", rows=(TRIAL_ROW, "T02,x.csv,full,30,0.12,29.97,,,,"))
    assert [t.trial_id for t in load_study(study, only="T01").trials] == ["T01"]
    with pytest.raises(InputError, match=r"row 3 \(T02\), power_pct"):
        load_study(study, only="T02")
    with pytest.raises(InputError, match=r"row 3 \(T02\), power_pct"):
        load_study(study, only="T99")  # none of that name: all is looked at


def test_one_trial_named_twice_is_reported_where_it_alone_is_read(tmp_path):
    study = write_study(tmp_path / "s", rows=(TRIAL_ROW, TRIAL_ROW))
    with pytest.raises(InputError, match=r"'T01' 2 times \(rows 2, 3\)"):
        load_study(study, only="T01")


def test_hundred_thousand_unknown_columns_are_a_few_lines(tmp_path):
    header = HEADER + "," + ",".join(f"c{k}" for k in range(100_000))
    with pytest.raises(InputError) as refused:
        load_study(write_study(tmp_path, rows=(TRIAL_ROW,), header=header))
    text = str(refused.value)
    assert "unknown column 'c0'" in text
    assert "99995 further unknown columns" in text
    assert len(text.splitlines()) < 10


@pytest.mark.parametrize("column", [
    "power_pct", "head_angle_deg", "head_length_m", "fps", "start_s", "end_s", "flap_hz",
    "start_x_px", "start_y_px",
])  # fmt: skip
def test_a_number_with_an_underscore_is_refused(tmp_path, column):
    cells = {"trial_id": "T01", "source": "k.csv", "power_pct": "100", "head_angle_deg": "30",
             "head_length_m": "0.12", "fps": "25", column: "2_5"}  # fmt: skip
    study = write_study(tmp_path, header=",".join(cells), rows=(",".join(cells.values()),))
    with pytest.raises(
        InputError, match=rf"{column}: found '2_5'; expected a number without underscores"
    ):
        load_study(study)


def test_a_study_yml_is_to_be_renamed(tmp_path):
    study = write_study(tmp_path)
    (study / "study.yaml").rename(study / "study.yml")
    with pytest.raises(InputError, match=r"Rename study\.yml to study\.yaml"):
        load_study(study)


def test_two_parts_with_one_name_in_the_file_are_refused(tmp_path):
    content = changed_setup() | {"bodyparts": {"head_tip": "nose", "hinge": "nose"}}
    write_study(tmp_path, yaml.safe_dump(content))
    with pytest.raises(InputError, match="name 'nose' for head_tip and hinge"):
        load_study(tmp_path)


def test_exchanged_names_of_two_parts_are_read(tmp_path):
    content = changed_setup() | {"bodyparts": {"head_tip": "hinge", "hinge": "head_tip"}}
    write_study(tmp_path, yaml.safe_dump(content))
    assert load_study(tmp_path).setup.bodyparts["hinge"] == "head_tip"


def test_a_remedy_of_many_findings_is_read_once():
    """Fifteen trials with the wrong sign have one remedy."""
    cure = "Change the sign. Is it 1.5?"
    three = [InputIssue("trials.csv", f"trial T{i}", "-30", f"{i}.5 degrees", cure) for i in (1, 2)]
    other = InputIssue("trials.csv", "trial T3", "x", "a number", "Write 3.")
    assert str(InputError([*three, other])).splitlines() == [
        f"trials.csv: trial T1: found -30; expected 1.5 degrees. {cure}",
        "trials.csv: trial T2: found -30; expected 2.5 degrees.",
        "trials.csv: trial T3: found x; expected a number. Write 3.",
    ]


def test_the_failed_trials_of_a_run_show_a_remedy_once():
    remedy = "Change the sign."
    failed = {name: {"ok": False, "message": f"{name}.mp4: found -30; expected 30. {remedy}",
                     "remedy": remedy} for name in ("T1", "T2")}  # fmt: skip
    good, cut = {"ok": True}, {"ok": True, "cut_short": "half of it is missing"}
    assert failed_trial_lines({"T0": good, **failed, "T3": cut}) == [
        "T1: T1.mp4: found -30; expected 30. Change the sign.",
        "T2: T2.mp4: found -30; expected 30.",
        "T3: half of it is missing",
    ]
