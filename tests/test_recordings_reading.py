"""Readers of the recordings: made-up files of known content, and what is wrong in real ones."""

from __future__ import annotations

import sys
import zipfile
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from bluekoi.errors import InputError

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
spreadsheet = import_module("examples.spreadsheet")
averaging = import_module("examples.averaging")
pool = import_module("examples.fish_robot_pool.reading")
fish = import_module("examples.robotic_fish.reading")
balls = import_module("examples.ball_drops.reading")
ship = import_module("examples.ship_zigzag.reading")
yaw = import_module("examples.yaw_coastdown.reading")


def workbook(path: Path, cells: dict[str, str], shared: list[str]) -> Path:
    """An Excel file with one sheet; values of the form `s:1` refer to the shared texts."""
    rows = "".join(
        f'<c r="{ref}" t="s"><v>{value[2:]}</v></c>'
        if value.startswith("s:")
        else f'<c r="{ref}"><v>{value}</v></c>'
        for ref, value in cells.items()
    )
    items = "".join(f"<si><t>{text}</t></si>" for text in shared)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xl/workbook.xml", '<sheets><sheet name="A &amp; B" r:id="1"/></sheets>')
        archive.writestr("xl/sharedStrings.xml", f"<sst>{items}</sst>")
        archive.writestr("xl/worksheets/sheet1.xml", f"<row>{rows}</row>")
    return path


def test_cells_come_by_column_and_row_and_rows_with_a_gap_are_left_out(tmp_path):
    cells = {"A1": "s:0", "B1": "s:1", "A2": "1.5", "B2": "-2e-1", "A3": "7", "A4": "2", "B4": "3"}
    found = spreadsheet.sheets(workbook(tmp_path / "a.xlsx", cells, ["time", "x &lt; y"]))
    assert found["A & B"]["B"][1] == "x < y"
    np.testing.assert_allclose(spreadsheet.columns(found["A & B"], "AB"), [[1.5, -0.2], [2, 3]])


def test_what_is_no_workbook_is_named(tmp_path):
    path = tmp_path / "a.xlsx"
    path.write_text("not a zip")
    with pytest.raises(InputError, match=r"a\.xlsx.*expected an Excel 2007"):
        spreadsheet.sheets(path)


def test_means_over_whole_beats_leave_a_line_and_take_a_beat_away():
    times = np.arange(0, 6.005, 0.01)
    line = 0.3 * times[:, None] + 0.1 * np.sin(2 * np.pi * 2.0 * times)[:, None]
    middles, means = averaging.block_means(times, line, 0.5)
    assert len(middles) == 12
    np.testing.assert_allclose(means[:, 0], 0.3 * middles, atol=1e-12)


def test_a_light_mistaken_for_another_is_set_aside_and_the_rest_kept():
    times = np.arange(0, 10, 1 / 16)
    places = np.column_stack([0.3 * times, np.full_like(times, 0.5)])
    places[40:46, 1] += 3.0  # another light for six frames
    places[100] = [4.9, 0.1]
    kept = pool.followed(times, places)
    expected = np.ones(len(times), dtype=bool)
    expected[40:46] = expected[100] = False
    np.testing.assert_array_equal(kept, expected)


def test_only_the_swimming_counts():
    times = np.arange(0, 20, 1 / 16)
    x = np.clip(times - 5.0, 0.0, 8.0) * 0.3  # rests, swims from 5 to 13 s, rests
    first, last = pool.swimming(times, np.column_stack([x, np.zeros_like(x)]))
    assert times[first] == pytest.approx(5.0, abs=0.8)
    assert times[last - 1] == pytest.approx(13.0, abs=0.8)


def fish_folder(root: Path, name: str) -> Path:
    """A trial on a circle of 0.5 m at 0.1 m/s, with its tail beat."""
    t = np.arange(0, 6, 1 / 30)
    psi = 0.2 * t
    x, y = 1.0 + 0.5 * np.sin(psi), 1.0 - 0.5 * np.cos(psi)
    beat = 0.05 * np.sin(2 * np.pi * 2.1 * t)
    x, y = (k + np.random.default_rng(7).normal(0, 2e-4, len(t)) for k in (x, y))
    rows = np.column_stack([t + 1.0, 0 * t + 0.1, 0 * t, 0 * t + 0.2, psi + beat, x, y])
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, rows)
    return path


def test_a_fish_trial_brings_its_tail_beat_and_its_condition(tmp_path):
    one = fish.read(fish_folder(tmp_path, "Amp25Bias-20/STATES1.txt"))
    assert (one.amplitude_deg, one.bias_deg, one.condition) == (25.0, -20.0, "Amp25Bias-20")
    assert one.beat_hz == pytest.approx(2.1, abs=0.01)
    assert one.times[0] == 0.0
    by_beats = fish.by_beats(one)
    assert np.diff(by_beats.times) == pytest.approx(1 / 2.1, abs=0.04)
    commanded = dict(zip(("bias", "amplitude"), np.radians([-20.0, 25.0]), strict=True))
    commanded |= {"beat_hz": one.beat_hz, "recoil": one.recoil_rad}
    assert {name: values[0] for name, values in by_beats.inputs.items()} == pytest.approx(commanded)
    assert one.recoil_rad == pytest.approx(0.05, rel=0.1)  # as `fish_folder` makes it


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("Amp25/STATES1.txt", "1 2 3", "found Amp25"),
        ("Amp25Bias0/STATES1.txt", "1 2 3\n1 2", "seven numbers"),
        ("Amp25Bias0/STATES1.txt", "1 2 3 4 5 6 7\n" * 30, "times that do not increase"),
    ],
)
def test_a_broken_fish_file_is_named(tmp_path, name, text, message):
    path = tmp_path / name
    path.parent.mkdir()
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        fish.read(path)


@pytest.mark.parametrize("module", [balls, fish, pool, ship, yaw])
def test_a_folder_without_recordings_is_named(module, tmp_path):
    with pytest.raises(InputError, match="expected"):
        module.read_folder(tmp_path)


@pytest.mark.recordings
def test_the_ships_u_and_v_are_velocities_in_the_tank(recordings):
    # columns 5 and 6 are named u and v; they are the derivatives of x0 and y0
    path = recordings / "ship_zigzag" / "HSVA_CPMC_KVLCC2_Z_20_10_P.dat"
    lines = path.read_text(encoding="cp1252").splitlines()[4:]
    rows = np.array([[float(w) for w in line.split()] for line in lines if len(line.split()) == 12])
    t, x, y, psi, u, v = rows[:, :6].T
    turned = np.abs(np.radians(psi)) > 0.3
    np.testing.assert_allclose(u[turned], np.gradient(x, t)[turned], atol=0.02)
    np.testing.assert_allclose(v[turned], np.gradient(y, t)[turned], atol=0.02)


@pytest.mark.long
@pytest.mark.recordings
def test_the_fishs_tail_beats_twice_as_fast_as_commanded_and_not_always_the_same(recordings):
    found = fish.read_recordings(recordings / "robotic_fish")
    assert len(found) == 36
    beat = {(r.amplitude_deg, r.bias_deg): r.beat_hz for r in found}
    sure = np.array([r.beat_hz for r in found if r.beat_std_hz < 0.01])
    assert sure.min() > 1.8
    assert sure.max() < 2.3
    assert beat[25.0, 0.0] == pytest.approx(2.0, abs=0.02)
    port, starboard = (np.mean([beat[a, s * 50.0] for a in (15.0, 25.0)]) for s in (1, -1))
    assert port / starboard == pytest.approx(1.16, abs=0.04)


@pytest.mark.recordings
def test_no_light_in_the_pool_moves_too_fast_once_faults_are_set_aside(recordings):
    runs = pool.read_runs(recordings / "fish_robot_pool")
    assert len(runs) == 16
    for run in runs:
        step = np.hypot(*np.diff(run.places, axis=0).T)
        assert np.all(step <= np.diff(run.times) * pool.FASTEST_M_S + 0.02), run.name
    assert sum(run.faults for run in runs) >= 5
    assert max(run.gap_s for run in runs) > 4.0


@pytest.mark.recordings
def test_balls_have_mass_and_size(recordings):
    found = balls.read_folder(recordings / "ball_drops")
    assert len(found) == 22
    golf = next(drop for drop in found if drop.condition == "Golf Ball")
    mass, area = golf.constants["m"], golf.constants["A"]
    assert mass == pytest.approx(0.0459, abs=1e-4)
    assert 2 * np.sqrt(area / np.pi) == pytest.approx(0.0439, abs=1e-4)
