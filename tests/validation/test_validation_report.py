"""Results of validation runs: their files, their scores and the page made of them."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from validation import report
from validation.scoring import ScoredStudy, calibration_bins, credible_set_coverage


def study_record(study, generator, true, said, group="clear", **other):
    values = {
        "fin": False, "trials": 24, "alternatives": {}, "probabilities": {},
        "verdict": "physics", "cpu_s": 10.0, "where": (), "unlisted": None, "failure": "",
        "held_out": {"baseline": {"path_rmse_m": 0.01}, "extended": {"path_rmse_m": 0.0012},
                     "noise_floor_path_rmse_m": 0.001},
    } | other  # fmt: skip
    return ScoredStudy(study=study, generator=generator, group=group, true=tuple(true), said=said,
                  **values)  # fmt: skip


STUDIES = [
    study_record("000", "kirchhoff", ["stall"], {"stall": 0.97}),
    study_record("001", "kirchhoff", ["stall"], {"stall": 0.91, "lift_lag": 0.62}),
    study_record("002", "kirchhoff", [], {}, group="null"),
    study_record("000", "unseen_water", ["sinking"], {"wave_drag": 0.55}, trials=9),
    study_record("001", "unseen_water", ["unexplained"], {"unexplained": 1.0}, group="unlisted"),
    study_record("002", "unseen_water", [], {"clock_error": 0.58}, group="null", failure="boom"),
]


@pytest.fixture
def runs(tmp_path):
    content = report.record(STUDIES, finder="new", commit="abc1234", date="2026-11-23")
    report.write_results(content, tmp_path)
    return report.load_runs(tmp_path)


def table_row(text, label):
    cells = next(line for line in text.splitlines() if line.startswith(f"| {label} |"))
    return [cell.strip() for cell in cells.strip("|").split("|")][1:]


def test_a_file_for_each_generator_comes_back_as_it_was_written(runs):
    assert [r.generator for r in runs] == ["unseen_water", "kirchhoff"]
    assert [r.development for r in runs] == [False, True]
    assert runs[1].studies[1]["named"] == {"stall": 0.91, "lift_lag": 0.62}
    assert [s["strict"] for s in runs[1].studies] == [True, False, True]


def test_generators_that_were_not_used_in_development_stand_first(runs):
    text = report.result_tables(runs)
    assert text.index("unknown generators") < text.index("`kirchhoff`")


def test_scores_by_generator_have_their_intervals(runs):
    text = report.result_tables(runs)
    assert table_row(text, "`kirchhoff`") == [
        "3",
        "2 of 3: 67 % (9 to 99)",
        "3 of 3: 100 % (29 to 100)",
        "1 of 1: 100 % (3 to 100)",
        "1 of 3: 33 % (1 to 91)",
        "",
    ]
    assert table_row(text, "`unseen_water`")[5].startswith("1 of 1")
    assert table_row(text, "nine trials or fewer")[1].startswith("0 of 1")


def test_reliability_counts_true_names_in_bins_of_a_tenth(runs):
    studies = [s for run in runs for s in run.studies]
    found = {round(b["from"], 1): (b["true"], b["count"]) for b in report.reliability_bins(studies)}
    assert found == {0.5: (0, 2), 0.6: (0, 1), 0.9: (3, 3)}


def test_errors_and_failures_are_stated(runs):
    text = report.result_tables(runs)
    assert "10.0 mm without and 1.2 mm with the named causes" in text
    assert "at most 1.3 times the noise floor in 3 of 3" in text
    assert "failed in 1 of 3" in text


def test_another_finder_is_compared_on_the_generators_that_both_were_run_on(runs, tmp_path):
    old = report.record(STUDIES[:3], finder="old", commit="0000000", date="2026-11-01")
    report.write_results(old, tmp_path)
    text = report.result_tables(report.load_runs(tmp_path))
    assert "Version `new` of the finder" in text
    assert table_row(text, "`old`")[0] == table_row(text, "`new`")[0] == "3"


def test_each_wrong_verdict_has_a_row_with_hidden_and_named_causes(runs):
    rows = report.result_tables(runs).split("### Wrong verdicts")[1]
    assert "| kirchhoff 001 | `stall` | `stall` 0.91, `lift_lag` 0.62 |" in rows
    assert "| unseen_water 002 | none | `clock_error` 0.58 |" in rows
    assert "kirchhoff 000" not in rows


def test_a_file_without_a_required_key_is_refused_by_name(tmp_path):
    content = {"finder": "x", "commit": "c", "generator": "g", "studies": [{"study": "1"}]}
    (tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=r"x\.json: missing .*studies\[\]\.truth"):
        report.load_runs(tmp_path)


def test_the_plot_is_the_same_for_the_same_results(runs, tmp_path):
    for name in ("a.svg", "b.svg"):
        report.draw_calibration_plot(runs, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert "stated probability" in (tmp_path / "a.svg").read_text()


def test_the_page_of_evidence_is_current():
    text = report.EVIDENCE_PAGE.read_text(encoding="utf-8")
    again = "docs/evidence.md is not current: run python -m validation report"
    assert report.updated_page(text, report.load_runs()) == text, again


def test_the_plot_of_evidence_is_drawn_from_the_recorded_results():
    runs = report.load_runs()
    drawn = (
        report.CALIBRATION_PLOT.read_text(encoding="utf-8")
        if report.CALIBRATION_PLOT.is_file()
        else ""
    )
    assert not runs or report.results_hash(runs) in drawn, "run python -m validation report"


def test_a_certain_cause_stands_in_the_last_bin_although_rounded_above_one():
    """Sums of probabilities may exceed 1 by rounding."""
    study = study_record("009", "unseen_water", ["stall"], {"stall": 1.0 + 4e-16})
    assert [(b["from"], b["count"]) for b in calibration_bins([study])] == [(pytest.approx(0.9), 1)]


def test_credible_sets_are_counted_that_hold_a_hidden_cause():
    one = study_record("000", "kirchhoff", ["stall", "sinking"], {}, credible_sets=(
        ("lift_lag", "stall"), ("sinking",), ("clock_error", "scale_error")))  # fmt: skip
    found = credible_set_coverage([one, study_record("001", "kirchhoff", [], {})])
    assert (found["hits"], found["count"]) == (2, 3)
    assert found["interval_95"] == pytest.approx((0.094, 0.992), abs=0.001)
