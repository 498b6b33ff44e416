"""The challenge: dealt fairly, sealed, kept from the finder by the kernel, scored as it should."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.challenge.make import make_one, sealed_folder
from bluekoi.challenge.plan import SHARES, deal, recipe_of
from bluekoi.challenge.rivals import sparse, stlsq
from bluekoi.challenge.score import Judged, judge, opened
from bluekoi.challenge.table import lines, summary, told
from bluekoi.cli import main
from bluekoi.errors import InputError
from bluekoi.files import write_json
from bluekoi.study import load_study
from bluekoi.synthetic.concealed.effects import OUTSIDE, PHYSICS
from bluekoi.synthetic.concealed.faults import FAULTS


def test_kinds_come_by_their_shares_and_effects_come_round_evenly():
    dealt = deal(5, 200)
    for kind, share in SHARES.items():
        assert abs(sum(e.kind == kind for e in dealt) - 200 * share) < 1
    singles = [e.effects[0] for e in dealt if e.kind == "single"]
    counts = [singles.count(name) for name in PHYSICS]
    assert max(counts) - min(counts) <= 1
    assert {e.level for e in dealt if e.kind == "single"} == {"clear", "faint"}
    assert {e.effects[0] for e in dealt if e.kind == "outside"} == set(OUTSIDE)
    assert {e.effects[0] for e in dealt if e.kind == "measurement"} == set(FAULTS)
    assert sum(e.trials == 9 for e in dealt) == 40


def test_a_deal_follows_its_seed_alone():
    assert deal(5, 30) == deal(5, 30)
    assert deal(5, 30) != deal(6, 30)
    assert sum(e.footage for e in deal(5, 30, footage=8)) == 8


def test_half_of_the_robots_swim_straight_and_half_are_of_other_size():
    recipes = [recipe_of(e, 3) for e in deal(3, 150)]
    free = [r for r in recipes if not any(c.name == "tail_fin_lift" for c in r.chosen)]
    assert 0.38 < np.mean([r.has_fin for r in free]) < 0.62
    assert 0.38 < np.mean([r.robot.mass_kg == 0.68 for r in recipes]) < 0.62
    assert all(r.water_rms_m_s > 0 for r in recipes)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A challenge of one study of nine trials with drag concealed, not analysed."""
    folder = tmp_path_factory.mktemp("made") / "challenge"
    entry = replace(deal(9, 12)[0], name="S001", kind="single", effects=("viscous_drag",),
                    level="clear", trials=9)  # fmt: skip
    one = make_one(entry, 9, folder)
    published = {"S001": {"folder": "studies/S001", "truth_sha256": one.sha256}}
    write_json(folder / "challenge.json", {"made": "now", "studies": published})
    return folder, one, entry


def test_a_study_is_whole_and_says_nothing_of_its_truth(made):
    folder, one, _ = made
    study = folder / "studies" / "S001"
    assert len(load_study(study).trials) == 9
    text = " ".join(p.read_text() for p in study.rglob("*") if p.suffix in (".yaml", ".csv"))
    assert not re.search("seed|hidden|viscous|" + "|".join([*PHYSICS, *OUTSIDE, *FAULTS]), text)
    assert (study / "truth.sha256").read_text().strip() == one.sha256
    assert one.reached == pytest.approx(1.0, abs=0.15)


def test_the_same_seed_makes_the_same_truth_and_the_same_files(made, tmp_path):
    folder, one, entry = made
    again = make_one(entry, 9, tmp_path / "challenge")
    assert again == one
    for path in (folder / "studies" / "S001" / "keypoints").glob("*.csv"):
        twin = tmp_path / "challenge" / path.relative_to(folder)
        assert twin.read_bytes() == path.read_bytes()


def test_a_changed_seal_is_refused(made, tmp_path):
    folder, _, _ = made
    truth = opened(folder, "S001")
    assert truth["causes"][-1]["name"] == "viscous_drag"
    copy = tmp_path / "c"
    write_json(copy / "challenge.json", json.loads((folder / "challenge.json").read_text()))
    forged = json.dumps({**truth, "kind": "null"})
    sealed_folder(copy).mkdir()
    (sealed_folder(copy) / "S001.json").write_text(forged)
    with pytest.raises(InputError, match="as published"):
        opened(copy, "S001")


def test_the_finders_process_and_its_children_cannot_read_the_seals(made):
    folder, _, _ = made
    code = (
        "import subprocess, sys; from pathlib import Path\n"
        "from bluekoi.challenge.guard import shut_out\n"
        "sealed = Path(sys.argv[1]); print(shut_out(sealed))\n"
        "try:\n    (sealed / 'S001.json').read_text(); print('read')\n"
        "except PermissionError: print('refused')\n"
        "cat = ['cat', str(sealed / 'S001.json')]\n"
        "print(subprocess.run(cat, capture_output=True).returncode)\n"
        "print(len((sealed.parent / 'challenge/studies/S001/trials.csv').read_text()) > 0)\n"
    )
    command = [sys.executable, "-c", code, str(sealed_folder(folder))]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert said[1] == "refused"
    assert said[3] == "True"
    if said[0] == "kernel":
        assert said[2] != "0"


def finding(folder: Path, causes: dict[str, float], rivals: dict[str, float], **more) -> Judged:
    """The study of `made` judged for fabricated results."""
    results = folder / "results" / "S001"
    told_causes = [
        {"name": n, "kind": "physics", "channels": ["surge"], "weight": w,
         "parameters": more.get("parameters", {}).get(n, {})}
        for n, w in causes.items()
    ]  # fmt: skip
    write_json(results / "times.json", {"guard": "kernel", "failure": "", "cpu_s": {"mismatch": 1}})
    write_json(results / "mismatch.json", {
        "verdict": "physics" if causes else "none",
        "causes": told_causes,
        "rivals": [{"name": n, "weight": w} for n, w in rivals.items()],
        "where": [{"channel": "surge", "variable": "speed_m_s", "share": 0.5}],
        "held_out": {"trials": ["T02"], "baseline": {"path_rmse_m": 0.02},
                     "extended": {"path_rmse_m": 0.001}, "noise_floor_path_rmse_m": 0.001,
                     "stretch_s": 2.0},
    })  # fmt: skip
    return judge(folder, "S001")


def test_right_is_all_true_names_and_no_other(made):
    folder, _, _ = made
    true = {c["name"]: 1.0 for c in opened(folder, "S001")["causes"]}
    assert finding(folder, true, {}).right
    assert not finding(folder, {}, {}).right
    extra = finding(folder, {**true, "stall": 0.9}, {})
    assert not extra.right
    assert extra.false == ("stall",)
    rest = {n: w for n, w in true.items() if n != "viscous_drag"}
    assert finding(folder, {**rest, "wave_drag": 0.6}, {"viscous_drag": 0.4}).right
    assert not finding(folder, {**rest, "wave_drag": 0.9}, {"viscous_drag": 0.1}).right


def test_the_true_law_comes_as_close_as_the_noise_lets_it(made):
    folder, _, _ = made
    one = finding(folder, {"viscous_drag": 1.0}, {})
    assert one.held_out["floor"] <= one.held_out["true_law"] < 4.0
    assert one.held_out["before"] == pytest.approx(20.0)


def judged(**given) -> Judged:
    usual = {"name": "S", "kind": "single", "level": "clear", "trials": 24, "fin": False,
             "footage": False, "verdict": "physics", "true": ("stall",), "said": ("stall",),
             "together": ("stall",), "laws": ("logistic",), "ratio": 10.0,
             "weights": {"stall": 0.9}, "cpu_s": {"mismatch": 2.0}}  # fmt: skip
    return Judged(**(usual | given))


def test_the_table_counts_what_it_says():
    some = [
        judged(pulls={"stall.k": 1.0}, errors={"stall.k": 0.1}, channels=(1, 1, 2)),
        judged(said=("added_mass",), together=("added_mass",), weights={"added_mass": 0.9}),
        judged(kind="null", true=(), said=(), together=(), weights={}, laws=()),
        judged(kind="null", true=(), weights={"stall": 0.6}, laws=()),
    ]
    figures = summary(some)
    assert figures["named"]["single, clear"] == [1, 2]
    assert figures["false_alarms"]["nulls with a false name"] == [1, 2]
    assert figures["parameters"] == {"median_error_pct": pytest.approx(10), "within_95": [1, 1]}
    high = next(row for row in figures["calibration"] if row["from"] == 0.8)
    assert high["true"] == [1, 2]
    assert figures["localisation"]["channel_F1"] == pytest.approx(2 / 3)
    assert len(lines(some)) == 4
    assert "named right, all: 2 of 4 (50 %)" in "\n".join(told(figures))


def test_sparse_regression_finds_the_terms_of_a_sparse_law():
    from bluekoi.challenge.accelerations import Problem

    rng = np.random.default_rng(2)
    X = rng.standard_normal((600, 12)) * np.geomspace(0.1, 10, 12)
    w = np.zeros(12)
    w[[1, 4, 9]] = 3.0, -2.0, 0.5
    y = X @ w + 0.05 * rng.standard_normal(600)
    found = sparse(Problem(y, X, tuple("abcdefghijkl"), np.arange(600) % 7, np.ones(12)), stlsq)
    assert set(np.flatnonzero(found)) == {1, 4, 9}
    assert found[[1, 4, 9]] == pytest.approx([3.0, -2.0, 0.5], rel=0.05)


def test_challenge_refuses_a_folder_that_holds_one(made):
    folder, _, _ = made
    said = CliRunner().invoke(main, ["challenge", "make", "--seed", "1", str(folder)])
    assert said.exit_code == 1
    assert "a challenge already" in said.output


@pytest.mark.long
def test_a_small_challenge_from_making_to_score(tmp_path):
    """What CI runs: six studies; every one ends in a verdict, the kernel keeps the seals shut."""
    folder, bluekoi = tmp_path / "c", [sys.executable, "-m", "bluekoi", "challenge"]
    for words in (["make", "--seed", "7", "--count", "6"], ["find"], ["score"], ["compare"]):
        subprocess.run([*bluekoi, words[0], str(folder), *words[1:]], check=True)
    score = json.loads((folder / "score.json").read_text())
    assert score["failed"] == []
    assert score["named"]["all"][0] >= 3
    assert score["false_alarms"]["nulls with a false name"][0] == 0
    guards = {json.loads(p.read_text())["guard"] for p in folder.glob("results/*/times.json")}
    assert guards <= {"kernel", "interpreter"}
    compared = json.loads((folder / "compare.json").read_text())
    assert compared["search"]["right"][0] > compared["sparse_regression"]["right"][0]
