"""No corrupted file causes a traceback or a hang: it gives a value or an InputError in seconds.

BLUEKOI_FUZZ sets how many cases each target gets; the long test makes 10,000 in all:
    pytest -m long tests/test_fuzz.py -o addopts=
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import h5py
import numpy as np
import pytest
import yaml
from fuzzing import absurd_numbers, corrupted_bytes, corrupted_table, corrupted_yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bluekoi.errors import InputError
from bluekoi.footage import encode_h264, frames, open_recording
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial
from bluekoi.motor import flapping_from_log
from bluekoi.report.numbers import readable_name
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.tracks import tracks
from bluekoi.study import Trial, load_study, missing_files
from small_studies import edit_trials_csv, small_study

CASES = int(os.environ.get("BLUEKOI_FUZZ", "40"))
TARGET_COUNT = 7
MAX_PROCESSOR_S = 20
"""Of the processor, so that other work on the machine makes no hang."""
MAX_WALL_S = 300
"""By the clock: a case that waits for something for ever."""
checked = settings(
    max_examples=CASES,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
    derandomize="BLUEKOI_FUZZ" not in os.environ,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


@pytest.fixture(scope="module")
def study(folder) -> Path:
    return small_study(folder / "study")


@pytest.fixture(scope="module")
def compiled_study(study, folder) -> Path:
    """The study, once the stages have run through it: compiling them is no hang."""
    results = folder / "sound"
    keypoints(study, results, "T09")
    tracks(study, results, "T09")
    assert json.loads((results / "status/T09.json").read_text())["ok"]
    return study


@contextmanager
def within_time_limit() -> Iterator[None]:
    """A case that takes longer than it may ends in an error that names it a hang."""

    def late(*_: object) -> None:
        raise TimeoutError("a hang")

    kinds = (signal.SIGALRM, signal.SIGPROF)
    before = [signal.signal(kind, late) for kind in kinds]
    signal.setitimer(signal.ITIMER_PROF, MAX_PROCESSOR_S)
    signal.alarm(MAX_WALL_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0)
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def value_or_error_text(work: Callable[[], object]) -> str:
    """What the fault says, or nothing; anything else that is raised fails the test."""
    findings = []
    with within_time_limit():
        try:
            work()
        except InputError as error:
            findings = [*error.findings] or ["an error without findings"]
    assert all(finding.found and finding.expected for finding in findings)
    return "\n".join(map(str, findings))


def load_study_safely(folder: Path) -> None:
    """What the door does with a study; nothing that it lets in may lead out of the folder."""
    loaded = load_study(folder)
    missing_files(loaded)
    for trial in loaded.trials:
        assert set(trial.trial_id) <= set(
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-"
        )
        for path in loaded.paths(trial):
            assert path.resolve().is_relative_to(folder.resolve())


@checked
@given(data=st.data())
def test_study_yaml(data, study, folder):
    whole = (study / "study.yaml").read_bytes()
    spoilt = corrupted_yaml(yaml.safe_load(whole)) | corrupted_bytes(whole)
    other = folder / "yaml"
    other.mkdir(exist_ok=True)
    (other / "trials.csv").write_bytes((study / "trials.csv").read_bytes())
    (other / "study.yaml").write_bytes(data.draw(spoilt))
    said = value_or_error_text(lambda: load_study_safely(other))
    assert not said or "study.yaml" in said or "trials.csv" in said


@checked
@given(data=st.data())
def test_trials_csv(data, study, folder):
    whole = (study / "trials.csv").read_bytes()
    other = folder / "csv"
    other.mkdir(exist_ok=True)
    (other / "study.yaml").write_bytes((study / "study.yaml").read_bytes())
    spoilt = corrupted_table(whole.decode()) | corrupted_bytes(whole)
    (other / "trials.csv").write_bytes(data.draw(spoilt))
    said = value_or_error_text(lambda: load_study_safely(other))
    assert not said or "study.yaml" in said or "trials.csv" in said


def trial(name: str) -> Trial:
    return Trial(
        trial_id="T1", source=name, power_pct=50, head_angle_deg=0, head_length_m=0.12, fps=30
    )


@checked
@given(data=st.data())
def test_deeplabcut_csv(data, study, folder):
    whole = "\n".join((study / "keypoints/T09.csv").read_text().splitlines()[:20])
    path = folder / "dlc.csv"
    path.write_bytes(data.draw(corrupted_table(whole) | corrupted_bytes(whole.encode())))
    said = value_or_error_text(lambda: read_keypoints_of_trial(path, trial("dlc.csv"), {}))
    assert not said or path.name in said


@cache
def h5_bytes(folder: Path) -> bytes:
    """A fixed-format DataFrame as pandas writes it."""
    path = folder / "whole.h5"
    parts, coords = ("head_tip", "hinge", "core_center", "tail_base"), ("x", "y", "likelihood")
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.attrs["pandas_type"], group.attrs["nblocks"] = "frame", 1
        levels = (("s",), parts, coords)
        labels = [(0, i, k) for i in range(len(parts)) for k in range(3)]
        for axis in ("axis0", "block0_items"):
            group.attrs[f"{axis}_nlevels"] = 3
            for k, level in enumerate(levels):
                group[f"{axis}_level{k}"] = np.array(level, dtype="S")
                group[f"{axis}_label{k}"] = np.array([label[k] for label in labels], dtype="i1")
        group["axis1"] = np.arange(12)
        group["block0_values"] = np.random.default_rng(1).uniform(0, 1, (12, 12))
    return path.read_bytes()


@checked
@given(data=st.data())
def test_deeplabcut_h5(data, folder):
    path = folder / "dlc.h5"
    path.write_bytes(data.draw(corrupted_bytes(h5_bytes(folder))))
    said = value_or_error_text(lambda: read_keypoints_of_trial(path, trial("dlc.h5"), {}))
    assert not said or path.name in said


def test_the_h5_that_is_spoilt_is_sound_to_begin_with(folder):
    path = folder / "sound.h5"
    path.write_bytes(h5_bytes(folder))
    assert len(read_keypoints_of_trial(path, trial("sound.h5"), {}).time_s) == 12


@checked
@given(data=st.data())
def test_motor_log(data, study, folder):
    whole = "\n".join((study / "motor/T09.csv").read_text().splitlines()[:200])
    path = folder / "motor.csv"
    path.write_bytes(data.draw(corrupted_table(whole) | corrupted_bytes(whole.encode())))
    said = value_or_error_text(lambda: flapping_from_log(path))
    assert not said or path.name in said


@settings(checked, max_examples=max(CASES // 6, 6))
@given(data=st.data())
def test_stages_find_no_defect_of_ours_in_spoilt_keypoints(data, compiled_study, folder):
    """Through pose, smoothing and steady state: every error is reported as one of the file."""
    other, results = folder / "stages", folder / "results"
    if not other.exists():
        shutil.copytree(compiled_study, other)
    lines = "\n".join((compiled_study / "keypoints/T09.csv").read_text().splitlines()[:60])
    spoilt = (
        absurd_numbers(lines, header=3) | absurd_numbers(lines, header=3) | corrupted_table(lines)
    )
    (other / "keypoints/T09.csv").write_bytes(data.draw(spoilt))
    with within_time_limit():
        keypoints(other, results, "T09")
        tracks(other, results, "T09")
    reported = json.loads((results / "status/T09.json").read_text())
    assert "a defect of this program" not in reported["message"], reported["message"]
    assert reported["ok"] or "T09" in reported["message"]


CELL_VALUES = {
    "fps": ("1e-3", "1", "1000", "1e6"),
    "head_length_m": ("1e-6", "0.001", "5"),
    "head_angle_deg": ("-179", "180", "1e-9"),
    "power_pct": ("1e-6", "1e4"),
    "start_s": ("0", "2.5", "1e6", "-1"),
    "end_s": ("0", "0.05", "3", "1e6"),
    "flap_hz": ("0", "1e-6", "15", "1e6"),
    "motor_log": ("",),
}


@settings(checked, max_examples=max(CASES // 6, 6))
@given(
    cells=st.fixed_dictionaries(
        {}, optional={k: st.sampled_from(v) for k, v in CELL_VALUES.items()}
    )
)
def test_stages_find_no_defect_of_ours_in_odd_rows(cells, compiled_study, folder):
    """Numbers that a row may hold by its types, and that no robot has."""
    other, results = folder / "rows", folder / "rows_results"
    if not other.exists():
        shutil.copytree(compiled_study, other)
    (other / "trials.csv").write_bytes((compiled_study / "trials.csv").read_bytes())
    edit_trials_csv(other, T09=cells)

    def both() -> None:
        keypoints(other, results, "T09")
        tracks(other, results, "T09")
        message = json.loads((results / "status/T09.json").read_text())["message"]
        assert "a defect of this program" not in message, message

    said = value_or_error_text(both)
    assert not said or "trials.csv" in said


@settings(checked, max_examples=max(CASES // 6, 6))
@given(data=st.data())
def test_stages_find_no_defect_of_ours_in_spoilt_studies(data, compiled_study, folder):
    """What the door lets in can be calculated with, or is refused in words."""
    other, results = folder / "odd", folder / "odd_results"
    if not other.exists():
        shutil.copytree(compiled_study, other)
    content = yaml.safe_load((compiled_study / "study.yaml").read_text())
    (other / "study.yaml").write_bytes(data.draw(corrupted_yaml(content)))

    def both() -> None:
        keypoints(other, results, "T09")
        tracks(other, results, "T09")
        message = json.loads((results / "status/T09.json").read_text())["message"]
        assert "a defect of this program" not in message, message

    said = value_or_error_text(both)
    assert not said or str(other) in said


@cache
def mp4_bytes(folder: Path) -> bytes:
    path = folder / "whole.mp4"
    shades = (np.full((48, 64), 10 * i, np.uint8) for i in range(8))
    encode_h264(path, shades, fps=30.0, size=(64, 48))
    return path.read_bytes()


def read_first_frames(path: Path) -> None:
    """Opened, and its first frames decoded."""
    recording = open_recording([path])
    for count, frame in enumerate(frames(recording)):
        assert frame.luma.ndim == 2
        if count >= 20:
            break


@checked
@given(data=st.data())
def test_mp4_header(data, folder):
    whole = mp4_bytes(folder)
    path = folder / "film.mp4"
    path.write_bytes(data.draw(corrupted_bytes(whole, within=1200) | corrupted_bytes(whole)))
    said = value_or_error_text(lambda: read_first_frames(path))
    assert not said or path.name in said


@checked
@given(text=st.text(max_size=40))
def test_words_for_the_page_are_never_an_error(text):
    assert isinstance(readable_name(text), str)


def test_a_yaml_that_would_fill_the_memory_is_refused_in_time(study, folder):
    """Nine levels of nine aliases each: 400 million values if it were unfolded."""
    bomb = ["a0: &a0 [x]"]
    bomb += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)]
    other = folder / "bomb"
    other.mkdir()
    (other / "trials.csv").write_bytes((study / "trials.csv").read_bytes())
    (other / "study.yaml").write_text("\n".join(bomb) + "\npool: *a9\n")
    assert value_or_error_text(lambda: load_study(other))


def test_names_in_a_study_cannot_reach_shell_page_or_other_folders(study, folder):
    other = folder / "names"
    other.mkdir()
    (other / "study.yaml").write_bytes((study / "study.yaml").read_bytes())
    head, row, *_ = (study / "trials.csv").read_text().splitlines()
    for name in ("../T1", "a/b", "$(id)", "<b>", "T 1", "T1\n", "-rf/", ""):
        cells = row.split(",")
        cells[0] = f'"{name}"'
        (other / "trials.csv").write_text(f"{head}\n{','.join(cells)}\n")
        said = value_or_error_text(lambda: load_study(other))
        assert name == "T1\n" or "trial_id" in said or "row" in said


@pytest.mark.long
def test_ten_thousand_cases():
    """Each target in a process of its own, so that a crash of a library is reported too."""
    each = -(-10_000 // TARGET_COUNT)
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__],
        env={**os.environ, "BLUEKOI_FUZZ": str(each)},
        capture_output=True,
        text=True,
        check=False,
        timeout=3600,
    )
    assert run.returncode == 0, run.stdout[-8000:]
