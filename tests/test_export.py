"""Tracks as netCDF in movement's layout, coefficients as csv; what is lacking is said."""

from __future__ import annotations

import csv
import importlib.util
from importlib.metadata import version

import numpy as np
import pytest
from click.testing import CliRunner
from exact_campaign import exact_campaign
from scipy.io import netcdf_file

from bluekoi.cli import main
from bluekoi.cli.export import _coefficient_rows, write_netcdf
from bluekoi.data import write_track
from small_studies import small_study

HAS_MOVEMENT = importlib.util.find_spec("movement") is not None
HAS_SINGULAR_DIMENSION_NAMES = not HAS_MOVEMENT or tuple(
    map(int, version("movement").split(".")[:2])
) >= (0, 17)
"""Before 0.17 movement called its dimensions keypoints and individuals."""


def test_what_is_written_can_be_read_without_xarray(tmp_path):
    made = exact_campaign()
    name = next(iter(made.tracks))
    write_netcdf(made, name, tmp_path / "one.nc")
    with netcdf_file(tmp_path / "one.nc", mmap=False) as read:
        assert read.variables["position"].dimensions == ("time", "space", "keypoint", "individual")
        assert read.variables["position"].units == b"m"
        labels = [b"".join(row).rstrip(b"\0") for row in read.variables["keypoint"][:]]
        assert labels == [b"head_tip", b"hinge", b"core_center", b"tail_base"]
        center = read.variables["position"][:, :, 2, 0]
        track = made.tracks[name]
        assert center == pytest.approx(np.column_stack([track.x_m, track.y_m]))


def test_a_run_without_tracks_is_a_fault(tmp_path):
    study = small_study(tmp_path / "study")
    found = CliRunner().invoke(main, ["export", str(study), "--results", str(tmp_path / "none")])
    assert found.exit_code == 1
    assert "bluekoi run STUDY" in found.output


def test_coefficients_come_with_units_and_whether_they_are_known():
    one = {"value": 0.0045, "std": 1e-5, "unit": "m2", "determined": True}
    other = {"value": 0.5, "std": None, "unit": "1", "determined": False}
    content = {
        "paper_steps": {"50": {"coefficients": {"C_T": one}}},
        "joint": {"coefficients": {"C_D0": other}},
    }
    rows = list(csv.reader(_coefficient_rows(content)))
    assert rows[0] == ["paper_50_pct", "C_T", "0.0045", "1e-05", "m2", "True"]
    assert rows[1] == ["joint", "C_D0", "0.5", "", "1", "False"]


def test_what_is_written_has_the_layout_of_movement(tmp_path):
    xarray = pytest.importorskip("xarray")
    made = exact_campaign()
    name = next(iter(made.tracks))
    write_netcdf(made, name, tmp_path / "one.nc")
    with xarray.open_dataset(tmp_path / "one.nc") as read:
        assert read.position.dims == ("time", "space", "keypoint", "individual")
        assert read.confidence.dims == ("time", "keypoint", "individual")
        assert list(read.keypoint.values.astype(str)) == [
            "head_tip",
            "hinge",
            "core_center",
            "tail_base",
        ]
        assert read.attrs["ds_type"] == "poses"
        assert read.attrs["time_unit"] == "seconds"
        track = made.tracks[name]
        assert read.time.values == pytest.approx(track.time_s)
        core = read.position.sel(keypoint="core_center", individual="robot").values
        assert core == pytest.approx(np.column_stack([track.x_m, track.y_m]))
        lengths = np.linalg.norm(
            read.position.sel(keypoint="head_tip").values
            - read.position.sel(keypoint="hinge").values,
            axis=1,
        )
        assert lengths == pytest.approx(made.study.trial(name).head_length_m)
        assert read.speed_m_s.values == pytest.approx(track.speed_m_s)


@pytest.mark.skipif(not HAS_MOVEMENT, reason="movement is not installed")
def test_movement_reads_it_and_agrees_about_the_velocity(tmp_path):
    xarray = pytest.importorskip("xarray")
    from movement.kinematics import compute_velocity
    from movement.validators.datasets import ValidPosesInputs

    made = exact_campaign()
    name = next(iter(made.tracks))
    write_netcdf(made, name, tmp_path / "one.nc")
    with xarray.open_dataset(tmp_path / "one.nc") as written:
        parts, animals = (
            ("keypoint", "individual")
            if HAS_SINGULAR_DIMENSION_NAMES
            else ("keypoints", "individuals")
        )
        read = (
            written.rename(keypoint=parts, individual=animals)
            if not HAS_SINGULAR_DIMENSION_NAMES
            else written
        )
        ValidPosesInputs.validate(read)
        velocity = compute_velocity(read.position).sel({parts: "core_center"})
        speed = np.linalg.norm(velocity.values[2:-2, :, 0], axis=1)
    assert speed == pytest.approx(made.tracks[name].speed_m_s[2:-2], abs=2e-3)


def test_the_command_writes_chosen_trials(tmp_path):
    made = exact_campaign()
    study = small_study(tmp_path / "study")
    track = next(iter(made.tracks.values()))
    for name in ("T09", "T10"):
        write_track(tmp_path / f"results/tracks/{name}.csv", track)
    words = ["export", str(study), "--results", str(tmp_path / "results"), "--trial", "T10"]
    found = CliRunner().invoke(main, words)
    assert found.exit_code == 0, found.output
    assert [path.name for path in (tmp_path / "results/export").glob("*.nc")] == ["T10.nc"]
    wrong = CliRunner().invoke(main, [*words, "--trial", "T99"])
    assert wrong.exit_code == 1
    assert "'T99'" in wrong.output
    failed = CliRunner().invoke(main, [*words, "--trial", "T11"])
    assert "says why this trial has none" in failed.output
    every = CliRunner().invoke(main, words[:4])
    assert "2 trials written" in every.output
    assert "Without a track, not written: T11." in every.output
