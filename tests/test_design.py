"""The design space: steady states in batches, fronts, ranges, manoeuvres, and their commands."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi import design_space
from bluekoi.cli import main
from bluekoi.design_space import (
    MANOEUVRES,
    FittedRobot,
    OperatingCondition,
    RobotDesign,
    evaluate_designs,
    is_pareto_optimal,
    load_fitted_robot,
    read_schedule,
    steady_states,
    tightest_turn_design,
)
from bluekoi.errors import InputError
from bluekoi.model import (
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    simulate_at_times,
    steady_speed_and_radius,
    two_plate_system,
)
from bluekoi.study import load_study
from paper_robot import PAPER_SETUP
from small_studies import small_study


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_study(tmp_path_factory.mktemp("design") / "study")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder with Table I at 75 % as the joint fit, known to 2 %."""
    folder = tmp_path_factory.mktemp("results")
    rng = np.random.default_rng(0)
    names, best = (
        list(TABLE_1[75]),
        np.array(list(TABLE_1[75].values())),
    )
    draws = best * (1 + 0.02 * rng.standard_normal((200, 6)))
    content = {
        "paper_steps": {str(p): {"flap_hz": hz} for p, hz in PUBLISHED_FLAP_HZ.items()},
        "joint": {
            "coefficients": {n: {"value": v} for n, v in TABLE_1[75].items()},
            "ensemble": {"names": names, "values": draws.tolist()},
        },
    }
    (folder / "coefficients.json").write_text(json.dumps(content))
    return folder


def test_batches_agree_with_one_at_a_time_and_with_other_robots() -> None:
    values = np.stack([two_plate_system().parameter_vector(TABLE_1[p]) for p in (50, 75, 100)])
    heavy = PAPER_SETUP.model_copy(
        update={"robot": PAPER_SETUP.robot.model_copy(update={"mass_kg": 0.9})}
    )
    conditions = [
        OperatingCondition(4.02, math.radians(45), 0.12, PAPER_SETUP),
        OperatingCondition(2.37, math.radians(-30), 0.175, PAPER_SETUP),
        OperatingCondition(5.82, 0.0, 0.12, heavy),
    ]
    found = steady_states(conditions, values)
    for i, c in enumerate(conditions):
        for k, power in enumerate((50, 75, 100)):
            speed, radius = steady_speed_and_radius(
                TABLE_1[power], setup=c.setup, head_length_m=c.head_length_m,
                head_angle_rad=c.head_angle_rad, flap_hz=c.flap_hz,
            )  # fmt: skip
            assert found.speed_m_s[i, k] == pytest.approx(speed, rel=1e-3)
            assert found.radius_m[i, k] == pytest.approx(radius, rel=2e-3)


def test_what_does_not_settle_is_not_given_a_radius() -> None:
    values = two_plate_system().parameter_vector(TABLE_1[75], {"battery_sag": {"loss_rate": 0.05}})
    slots = two_plate_system().effect_parameter_indices("battery_sag")
    assert values[slots[0]] == 0.05
    found = steady_states([OperatingCondition(4.02, 0.7, 0.12, PAPER_SETUP)], values[None])
    assert np.isnan(found.radius_m[0, 0])


def make_design(speed: float, radius: float, extrapolated: tuple[str, ...] = ()) -> RobotDesign:
    return RobotDesign(
        100, 5.8, 45, 0.12, (speed, speed, speed), (radius, radius, radius), extrapolated
    )


def test_the_front_holds_those_that_no_other_beats() -> None:
    some = [
        make_design(0.5, 0.8),
        make_design(0.4, 0.5),
        make_design(0.3, 0.6),
        make_design(0.2, 0.4),
        make_design(np.nan, 0.1),
        make_design(0.6, np.nan),
        make_design(0.45, 0.9),
    ]
    assert is_pareto_optimal(some).tolist() == [True, True, False, True, False, False, False]


def test_the_smallest_radius_at_a_speed_and_within_what_was_tested() -> None:
    some = [make_design(0.5, 0.8), make_design(0.4, 0.5, ("power",)), make_design(0.2, 0.3)]
    assert tightest_turn_design(some) is some[2]
    assert tightest_turn_design(some, min_speed_m_s=0.3) is some[1]
    assert tightest_turn_design(some, min_speed_m_s=0.3, tested_only=True) is some[0]
    assert tightest_turn_design(some, min_speed_m_s=0.9) is None


def test_designs_outside_the_tested_range_are_marked_and_bands_follow_the_draws(
    study: Path, results: Path
) -> None:
    loaded = load_study(study)
    tested = design_space.tested_range(loaded)
    found = evaluate_designs(
        load_fitted_robot(results),
        loaded.setup,
        tested,
        powers=(100, 150),
        angles_deg=(45, 60),
        lengths_m=(0.12,),
        other={"mass_kg": (0.68, 0.8)},
    )
    assert len(found) == 8
    assert found[0].extrapolated == ()
    assert found[-1].extrapolated == ("power", "head angle", "mass_kg")
    assert found[0].flap_hz == pytest.approx(5.82)
    assert found[-1].flap_hz > 7
    best, low, high = found[0].radius_m
    assert low < best < high
    assert 0.005 < math.log(high / best) / 1.96 < 0.05
    with pytest.raises(InputError, match="mass_kg"):
        evaluate_designs(
            load_fitted_robot(results),
            loaded.setup,
            tested,
            powers=(100,),
            angles_deg=(45,),
            lengths_m=(0.12,),
            other={"mass": (1.0,)},
        )


def test_an_extended_model_is_asked_for_only_where_there_is_one(results: Path) -> None:
    assert load_fitted_robot(results).model == "joint"
    with pytest.raises(InputError, match="mismatch_detail"):
        load_fitted_robot(results, model="extended")


def test_frequency_between_tested_powers_and_beyond() -> None:
    fit = FittedRobot(np.zeros((1, 1)), {50.0: 2.0, 100.0: 6.0}, "joint")
    assert fit.flap_hz_at_power(75) == pytest.approx(4.0)
    assert fit.flap_hz_at_power(150) == pytest.approx(10.0)
    assert FittedRobot(np.zeros((1, 1)), {50.0: 2.0}, "joint").flap_hz_at_power(
        25
    ) == pytest.approx(1.0)


def simulated_path(schedule, seconds: float = 8.0):
    times = np.arange(round(seconds * 60) + 1) / 60
    hz, angle = schedule.at(times)
    constants = constants_of_robot_trial(PAPER_SETUP, 0.12)
    values, inputs = (
        two_plate_system().parameter_vector(TABLE_1[75]),
        np.column_stack([angle, hz]),
    )
    return simulate_at_times(values, times, inputs, constants, np.zeros(6))


def test_an_s_turn_turns_one_way_then_the_other() -> None:
    run = simulated_path(MANOEUVRES["s-turn"](4.0, math.radians(40), 8.0))
    rate = run.state[:, 5]
    assert rate[200] < -0.1
    assert rate[-1] > 0.1


def test_an_underpowered_turn_slows_down_and_turns_on_what_speed_is_left() -> None:
    run = simulated_path(MANOEUVRES["underpowered-turn"](4.0, math.radians(45), 8.0))
    before = round(0.6 * 8 * 60)
    assert run.state[before, 5] == pytest.approx(0.0, abs=1e-9)
    assert run.speed_m_s[-1] < 0.6 * run.speed_m_s[before]
    assert abs(run.heading_rad[-1] - run.heading_rad[before]) > math.radians(20)


def test_start_stop_slows_down_and_speeds_up_again() -> None:
    run = simulated_path(MANOEUVRES["start-stop"](5.0, 0.0, 10.0), 10.0)
    v = run.speed_m_s
    assert v[420] < 0.7 * v[240]
    assert v[-1] > 1.2 * v[420]


def test_schedules_are_read_and_their_faults_reported(tmp_path: Path) -> None:
    file = tmp_path / "s.csv"
    file.write_text("time_s,power_pct,head_angle_deg\n0,100,0\n2,100,0\n2,0,30\n5,0,-30\n")
    reported = read_schedule(file, lambda power: 0.05 * power)
    hz, angle = reported.at(np.array([1.0, 3.5, 9.0]))
    assert hz == pytest.approx([5.0, 0.0, 0.0])
    assert np.degrees(angle) == pytest.approx([0.0, 0.0, -30.0])
    for text, message in (
        ("time_s,power,head_angle_deg\n0,1,2\n", "Did you mean 'power_pct'"),
        ("time_s,head_angle_deg\n0,1\n", "both or neither"),
        ("time_s,power_pct,head_angle_deg\n0,1,2\n3,1,2\n1,1,2\n", "row 4.*run backwards"),
        ("time_s,power_pct,head_angle_deg\n0,,2\n", "row 2.*power_pct nan"),
        ("time_s,flap_hz,head_angle_deg\n0,-2,2\n", "row 2.*flap_hz -2"),
        ("time_s,power_pct,head_angle_deg\n0,50,2\n1,1e9,2\n", "row 3.*1e.09.*from 0 to 300"),
        ("time_s,flap_hz,head_angle_deg\n", "no row"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=message):
            read_schedule(file, float)


def test_bluekoi_design_answers_and_writes(study: Path, results: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(main, [
        "design", str(study), "--results", str(results), "--out", str(tmp_path / "d"),
        "--powers", "50,100", "--angles-deg", "15:45:15", "--lengths-m", "0.12", "--speed-m-s",
        "0.3"])  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "tightest turn at 0.3 m/s or more: radius 0." in done.output
    rows = list(csv.DictReader((tmp_path / "d/designs.csv").open()))
    assert len(rows) == 6
    assert {r["extrapolated"] for r in rows} > {""}
    assert (tmp_path / "d/designs.png").stat().st_size > 10_000
    wrong = CliRunner().invoke(main, ["design", str(study), "--powers", "50:40:5"])
    assert wrong.exit_code == 2
    assert "from, to, step" in wrong.output


def test_simulate_says_where_it_extrapolates_and_whose_coefficients_it_uses(tmp_path):
    study = small_study(tmp_path / "study")
    words = ["simulate", str(study), "--seconds", "1", "--flap-hz"]
    done = CliRunner().invoke(main, [*words, "5.82", "--head-angle-deg", "-45"])
    assert done.stderr.count("Warning") == 1
    assert "the coefficients are those of the paper" in done.stderr
    far = ["9", "--head-angle-deg", "80", "--head-length-m", "0.3"]
    said = CliRunner().invoke(main, [*words, *far]).stderr
    for text in ("flapping frequency of 9 Hz", "head angle of 80 degrees", "head of 0.3 m"):
        assert f"a {text} lies outside the tested" in said


def test_a_command_that_needs_results_says_to_run_the_study_first(tmp_path):
    study, empty = small_study(tmp_path / "study"), tmp_path / "empty"
    empty.mkdir()
    for name in ("design", "simulate"):
        more = ["--flap-hz", "4"] if name == "simulate" else []
        done = CliRunner().invoke(main, [name, str(study), "--results", str(empty), *more])
        assert "no coefficients.json" in str(done.exception) + done.output


def test_a_trial_that_failed_is_named_by_commands_that_use_the_fit(
    study: Path, results: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    name = load_study(study).trials[0].trial_id
    path = copy / "status" / f"{name}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"ok": False, "message": "no frame could be read"}))
    for command, more in (("simulate", ["--flap-hz", "4"]), ("design", ["--powers", "100"])):
        words = [command, str(study), "--results", str(copy), *more]
        said = CliRunner().invoke(main, words).stderr
        assert f"Warning: {name}: no frame could be read" in said


def test_bluekoi_simulate_runs_manoeuvres_and_schedules(
    study: Path, results: Path, tmp_path: Path
) -> None:
    out, picture, file = tmp_path / "run.csv", tmp_path / "run.png", tmp_path / "s.csv"
    done = CliRunner().invoke(main, [
        "simulate", str(study), "--power-pct", "100", "--head-angle-deg", "45", "--manoeuvre",
        "s-turn", "--seconds", "4", "--results", str(results), "--out", str(out), "--picture",
        str(picture)])  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "after 4 s" in done.output
    rows = list(csv.DictReader(out.open()))
    assert float(rows[0]["head_angle_deg"]) == 45
    assert float(rows[-1]["head_angle_deg"]) == -45
    assert float(rows[1]["flap_hz"]) == pytest.approx(5.82)
    assert picture.stat().st_size > 10_000
    file.write_text("time_s,flap_hz,head_angle_deg\n0,5,0\n2,5,30\n")
    again = CliRunner().invoke(main, ["simulate", str(study), "--schedule", str(file),
                                      "--seconds", "3"])  # fmt: skip
    assert again.exit_code == 0, again.output
    neither = CliRunner().invoke(main, ["simulate", str(study)])
    assert neither.exit_code == 2


def broken(results: Path, folder: Path, change) -> Path:
    """A copy of results whose coefficients.json was changed."""
    content = json.loads((results / "coefficients.json").read_text())
    change(content)
    folder.mkdir(exist_ok=True)
    (folder / "coefficients.json").write_text(json.dumps(content))
    return folder


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.pop("joint"), "KeyError: 'joint'"),
        (lambda c: c.pop("paper_steps"), "KeyError: 'paper_steps'"),
        (lambda c: c["paper_steps"].clear(), "without a power"),
        (lambda c: c["paper_steps"].update(full={"flap_hz": 3}), "'full'"),
        (lambda c: c["joint"]["coefficients"].pop("C_La"), "'C_La'"),
        (lambda c: c["joint"]["coefficients"]["C_T"].update(value=None), "NoneType"),
        (lambda c: c["joint"]["ensemble"].update(values=[]), "incomplete content"),
        (lambda c: c.update(joint=[]), "incomplete content"),
    ],
)
def test_incomplete_results_are_reported_with_their_file(
    results: Path, tmp_path: Path, change, words: str
) -> None:
    with pytest.raises(InputError, match=words) as reported:
        load_fitted_robot(broken(results, tmp_path / "r", change))
    assert str(tmp_path / "r/coefficients.json") in str(reported.value)
    assert "Run the analysis again" in str(reported.value)


def test_an_incomplete_search_is_reported_with_its_file(results: Path, tmp_path: Path) -> None:
    folder = broken(results, tmp_path / "r", lambda c: None)
    (folder / "mismatch_detail.json").write_text("{}")
    (folder / "mismatch.json").write_text("{}")
    with pytest.raises(InputError, match=r"mismatch\.json: found incomplete content.*'verdict'"):
        load_fitted_robot(folder)
    (folder / "mismatch.json").write_text('{"verdict": "physics"}')
    with pytest.raises(
        InputError, match=r"mismatch_detail\.json: found incomplete.*'coefficients'"
    ):
        load_fitted_robot(folder)


def test_guesses_doubtful_verdicts_and_other_studies_are_warned_of(
    study: Path, results: Path, tmp_path: Path
) -> None:
    loaded = load_study(study)
    assert load_fitted_robot(results).warnings == ()

    def change(content) -> None:
        content["joint"]["coefficients"]["C_Da"]["determined"] = False
        content["joint"]["trials"] = ["T09", "T77"]

    folder = broken(results, tmp_path / "r", change)
    (folder / "mismatch_detail.json").write_text("{}")
    (folder / "mismatch.json").write_text('{"verdict": "measurement"}')
    guess, verdict, other = load_fitted_robot(folder, study=loaded).warnings
    assert "do not determine C_Da" in guess
    assert "'measurement'" in verdict
    assert other.endswith("has no T77, 50 %, 75 %")
    done = CliRunner().invoke(main, ["simulate", str(study), "--flap-hz", "4", "--results",
                                     str(folder)])  # fmt: skip
    assert "Warning: these trials do not determine C_Da" in done.output


def test_of_turns_as_tight_the_tested_and_the_faster_one_is_the_answer() -> None:
    some = [
        make_design(0.2, 0.5),
        make_design(0.4, 0.5002),
        make_design(0.6, 0.4999, ("power",)),
        make_design(0.9, 0.502),
    ]
    assert tightest_turn_design(some) is some[1]
    assert tightest_turn_design(some, min_speed_m_s=0.5) is some[2]


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--powers", "1:inf:1"], 2, "from, to, step"),
        (["--powers", "nan"], 2, "nan: each must be a number from 0 to 300"),
        (["--powers=-50"], 2, "-50: each must be a number from 0 to 300"),
        (["--angles-deg", "400"], 2, "from -120 to 120"),
        (["--lengths-m", "0"], 2, "from 0.001 to 10"),
        (["--speed-m-s", "nan"], 2, "not a finite number"),
        (["--robot", "mass_kg"], 2, "--robot 'mass_kg': write mass_kg=0.5,0.7"),
        (["--robot", "mass_kg=.5", "--robot", "mass_kg=.7"], 2, "a second time"),
        (["--robot", "mass_kg=-1"], 1, "--robot: robot.mass_kg: found -1.0"),
        (["--robot", "mass_kg=600"], 1, "--robot: robot.mass_kg: found 600"),
        (["--robot", "body_length_m=0.1"], 1, "smaller than body_length_m"),
        (["--powers", "1:300:1", "--angles-deg", "1:100:1"], 1, "330000 designs (300 x 100 x 11)"),
        (["--speed-m-s", "5"], 0, "no design turns at 5 m/s or more: the fastest does 0."),
        (["--angles-deg", "0"], 0, "no design settles into a turn"),
    ],
)
def test_designs_that_cannot_be_are_refused(
    study: Path, results: Path, tmp_path: Path, options: list[str], code: int, words: str
) -> None:
    few = {"--powers": "75", "--angles-deg": "30", "--lengths-m": "0.12"}
    if code == 1 and "--powers" in options:
        few = {}
    base = [x for k, v in few.items() if not any(o.startswith(k) for o in options) for x in (k, v)]
    done = CliRunner().invoke(main, ["design", str(study), "--results", str(results), "--out",
                                     str(tmp_path), *base, *options])  # fmt: skip
    assert done.exit_code == code, done.output
    assert words in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--flap-hz", "nan"], "nan is not a finite number"),
        (["--flap-hz", "4", "--seconds", "nan"], "nan is not a finite number"),
        (["--flap-hz", "4", "--head-length-m", "inf"], "inf is not in the range"),
        (["--flap-hz", "4", "--model", "extended"], "give both"),
        (["--schedule", "s.csv", "--flap-hz", "9"], "leave out --flap-hz"),
        (["--schedule", "s.csv", "--head-angle-deg", "9", "--manoeuvre", "s-turn"],
         "leave out --head-angle-deg, --manoeuvre"),
        (["--flap-hz", "4", "--out", "p.csv", "--picture", "p.xyz"], ".png, .pdf, .svg"),
        (["--schedule", "s.csv", "--out", "s.csv"], "must be different files"),
    ],
)  # fmt: skip
def test_simulations_that_cannot_be_are_refused_before_anything_is_written(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    schedule = "time_s,flap_hz,head_angle_deg\n0,4,0\n"
    (tmp_path / "s.csv").write_text(schedule)
    done = CliRunner().invoke(main, ["simulate", str(study), *options])
    assert done.exit_code == 2, done.output
    assert words in " ".join(done.output.replace("│", " ").split())
    assert (tmp_path / "s.csv").read_text() == schedule
    assert [path.name for path in tmp_path.iterdir()] == ["s.csv"]


def test_a_schedule_is_run_to_its_end_and_a_cut_is_reported(study: Path, tmp_path: Path) -> None:
    file = tmp_path / "s.csv"
    file.write_text("time_s,flap_hz,head_angle_deg\n0,4,0\n15,4,0\n20,4,45\n")
    whole = CliRunner().invoke(main, ["simulate", str(study), "--schedule", str(file)])
    assert "after 20 s" in whole.output
    assert "the schedule goes on" not in whole.output
    cut = CliRunner().invoke(main, ["simulate", str(study), "--schedule", str(file), "--seconds",
                                    "5"])  # fmt: skip
    assert "the schedule goes on to 20 s, the simulation ends at 5 s" in cut.output


def test_power_beyond_what_was_tested_is_reported(study: Path, results: Path) -> None:
    def said(power: str) -> str:
        return CliRunner().invoke(main, ["simulate", str(study), "--power-pct", power, "--results",
                                         str(results)]).output  # fmt: skip

    assert "300 % power lies outside the tested 50 to 100 %" in said("300")
    assert "outside" not in said("75")
