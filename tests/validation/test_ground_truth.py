"""The truth of a study beside its results; shown only where it has the published hash."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from exact_campaign import campaign_with_damping_found, exact_campaign

from bluekoi.stages.demo import write_demo_study
from bluekoi.synthetic.synthetic_study_design import demo_design
from bluekoi.synthetic.trial import solve_trial, steady_summary, true_path_without_recoil
from validation.ground_truth.comparison import ground_truth
from validation.ground_truth.content import true_steady
from validation.ground_truth.page import comparison_page
from validation.ground_truth.seal import Seal, open_seal, truth_without_hash

TRUTH = {"hidden": {"linear_yaw_damping": {"N_r": 0.02}}, "note": "<b>glass</b>"}


def sealed_truth(
    folder: Path, content: bytes, line: str = "{}\n", name: str = "truth.json"
) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)
    (folder / "truth.sha256").write_text(line.format(hashlib.sha256(content).hexdigest()))
    return folder


def test_a_study_without_a_published_hash_has_no_seal(tmp_path):
    assert open_seal(tmp_path) is None


@pytest.mark.parametrize(
    ("line", "name"),
    [("{}\n", "truth.json"), ("{}  answers.json\n", "answers.json"), ("{} *a b.json", "a b.json")],
)
def test_a_seal_that_fits_is_opened(tmp_path, line, name):
    folder = sealed_truth(tmp_path, json.dumps(TRUTH).encode(), line, name)
    found = open_seal(folder)
    assert found.truth == TRUTH
    assert not found.trouble


def test_a_truth_that_is_not_published_yet_is_reported_with_its_hash(tmp_path):
    folder = sealed_truth(tmp_path, b"{}")
    (folder / "truth.json").unlink()
    found = open_seal(folder)
    assert (found.truth, found.broken) == ({}, False)
    text = comparison_page(exact_campaign(powers=(75,)), found)
    assert "is sealed: truth.json is not there yet" in text
    assert hashlib.sha256(b"{}").hexdigest() in text


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda f: (f / "truth.json").write_bytes(b'{"hidden": {"stall": {}}}'), "has the SHA-256"),
        (lambda f: (f / "truth.sha256").write_text("none"), "does not hold a SHA-256"),
        (lambda f: (f / "truth.sha256").write_bytes(b"\xff\xfe"), "does not hold a SHA-256"),
        (lambda f: sealed_truth(f, b"not json"), "is not a json object"),
        (lambda f: sealed_truth(f, b"[1]"), "is not a json object"),
    ],
)
def test_a_broken_seal_shows_no_truth(tmp_path, change, word):
    folder = sealed_truth(tmp_path, json.dumps(TRUTH).encode())
    change(folder)
    found = open_seal(folder)
    assert found.broken
    assert found.truth == {}
    text = comparison_page(exact_campaign(powers=(75,)), found)
    assert word in text
    assert "The seal is broken" in text
    assert "Injected and identified causes" not in text


def test_the_page_says_what_was_found_and_what_was_missed(tmp_path):
    truth = {
        "hidden": {"linear_yaw_damping": {"N_r": 0.02}, "stall": {"onset_rad": 0.5}},
        "coefficients": {"C_T": 4.5e-3, "C_D0": 0.9},
        "extra": {"a": [1, 2], "b": "<b>glass</b>"},
    }
    base = campaign_with_damping_found(exact_campaign())
    shown = ground_truth(base, Seal("0" * 64, truth))
    rows = {row.name: row for row in shown.causes}
    assert rows["linear yaw damping"].cells[-1] == "identified"
    assert not rows["linear yaw damping"].marked
    assert rows["stall"].cells[-1] == "missed"
    assert rows["stall"].marked
    assert [row.name for row in shown.coefficients] == ["C_T (m²)", "C_D0 (–)"]
    assert ("extra.b", "<b>glass</b>") in shown.further
    text = comparison_page(base, Seal("0" * 64, truth))
    assert "&lt;b&gt;glass&lt;/b&gt;" in text


def test_a_cause_that_was_not_injected_is_a_false_positive():
    shown = ground_truth(
        campaign_with_damping_found(exact_campaign()), Seal("0" * 64, {"hidden": {}})
    )
    assert [row.cells[-1] for row in shown.causes] == ["false positive"]


def test_causes_may_be_listed_as_the_search_lists_them():
    truth = {
        "causes": [{"name": "linear_yaw_damping", "parameters": {"N_r": 0.02}, "law": "linear"}],
        "body": {"C_T": 4.5e-3, "C_D0": 0.5, "mass_kg": 0.68},
        "trials": 24,
    }
    shown = ground_truth(campaign_with_damping_found(exact_campaign()), Seal("0" * 64, truth))
    assert [row.cells[0] for row in shown.causes] == ["N_r = 0.02000 N m s"]
    assert shown.causes[0].cells[-1] == "identified"
    assert [row.name for row in shown.coefficients] == ["C_T (m²)", "C_D0 (–)"]
    assert shown.trials == []


def test_no_injected_and_no_identified_cause_agree():
    base = replace(
        campaign_with_damping_found(exact_campaign()), mismatch={"verdict": "none", "causes": []}
    )
    assert ground_truth(base, Seal("0" * 64, {"hidden": {}})).causes[0].cells[-1] == "correct: none"


def test_a_truth_of_any_form_does_not_break_the_page(tmp_path):
    base = campaign_with_damping_found(exact_campaign())
    name = base.analysed[0].trial_id
    path = {"time_s": "x", "vx_m_s": [1], "vy_m_s": []}
    trials = [3, {"trial_id": None}, {"trial_id": name, "mean_path": path, "speed_m_s": "fast"}]
    odd = {"hidden": [1], "coefficients": "x", "trials": trials, "n": None, "big": 10**400}
    shown = comparison_page(base, Seal("0" * 64, odd))
    assert "ground-truth-heading" in shown
    assert "<td>fast</td>" in shown


def test_truth_over_a_stretch_of_a_circle_is_exact():
    t = np.linspace(0, 4, 81)
    turn, speed = 0.6, 0.3
    path = {"time_s": t, "vx_m_s": speed * np.cos(turn * t), "vy_m_s": speed * np.sin(turn * t)}
    found = true_steady({"mean_path": path, "speed_m_s": 9.0}, 1.0, 3.5)
    np.testing.assert_allclose(found, (speed, speed / turn), rtol=2e-4)
    assert true_steady({"speed_m_s": 9.0}, 1.0, 3.5) == (9.0, None)


def test_the_stored_mean_path_is_sampled_finely_enough():
    trial = solve_trial(demo_design(), "T24")
    end = float(trial.time_s[-1])
    stated = steady_summary(trial)
    found = true_steady(
        {"mean_path": true_path_without_recoil(trial)}, stated["steady_from_s"], end
    )
    np.testing.assert_allclose(found, (stated["speed_m_s"], stated["radius_m"]), rtol=1e-3)


@pytest.mark.long
def test_the_demo_is_laid_out_with_its_truth_in_another_folder(tmp_path):
    study, truth = tmp_path / "demo", tmp_path / "demo-truth/truth.json"
    write_demo_study(study)
    assert sorted(path.name for path in study.iterdir()) == ["study.yaml", "trials.csv"]
    found = truth_without_hash(truth)
    assert set(found.truth["hidden"]) == {"tail_fin_lift", "linear_yaw_damping"}
    assert found.truth["coefficients"]["C_T"] == 4.5e-3
    assert [trial["trial_id"] for trial in found.truth["trials"]] == [
        plan.trial_id for plan in demo_design().plans
    ]
    files = [study / "study.yaml", study / "trials.csv", truth]
    dates = [path.stat().st_mtime_ns for path in files]
    write_demo_study(study)
    assert [path.stat().st_mtime_ns for path in files] == dates
