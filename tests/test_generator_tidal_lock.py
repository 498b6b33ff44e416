"""The generator `tidal_lock`: mix of groups, files and truths."""

import json
from collections import Counter

from click.testing import CliRunner

from bluekoi.cli import main as bluekoi
from validation.generators.tidal_lock import generate
from validation.generators.tidal_lock.study import plan

SEED = 1
MIN_SIGMA, MAX_SIGMA = 8, 40


def files_below(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_mix_of_a_block():
    """Twenty studies in a row: four groups, and a fin in half of the robots."""
    drawn = [plan(SEED, index) for index in range(20)]
    assert Counter(group for group, _ in drawn) == {"null": 4, "one": 8, "two": 5, "unlisted": 3}
    assert 9 <= sum(fin for _, fin in drawn) <= 11
    assert drawn != [plan(SEED, index) for index in range(20, 40)]


def test_same_seed_gives_same_files_that_pass_check(tmp_path):
    index = next(i for i in range(20) if plan(SEED, i)[0] == "null")
    names = [generate(SEED, index, tmp_path / part)["study"] for part in ("a", "b")]
    assert names[0] == names[1]
    assert files_below(tmp_path / "a") == files_below(tmp_path / "b")
    found = CliRunner().invoke(bluekoi, ["check", str(tmp_path / "a" / "studies" / names[0])])
    assert found.exit_code == 0, found.output


def test_truth_names_what_is_hidden_and_how_visible_it_is(tmp_path):
    index = next(i for i in range(20) if plan(SEED, i) == ("one", True))
    truth = generate(SEED, index, tmp_path)
    assert json.loads((tmp_path / "truth" / f"{truth['study']}.json").read_text()) == truth
    names = {cause["name"]: cause for cause in truth["causes"]}
    assert "tail_fin_lift" in names
    (hidden,) = (cause for name, cause in names.items() if name != "tail_fin_lift")
    assert MIN_SIGMA <= hidden["sigma"] <= MAX_SIGMA
    assert names["tail_fin_lift"]["sigma"] >= MIN_SIGMA
