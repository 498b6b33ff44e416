"""What comes out of rendered footage against the truth it was rendered from: `make test-long`.

The demo is brought up to date in results/demo first (at once where `make demo` was run with this
code); BLUEKOI_DEMO_RESULTS names a finished results folder of the demo to be judged instead.
"""

from __future__ import annotations

import csv
import json
import math
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from scipy.stats import t as student

from bluekoi.data import SteadyState
from bluekoi.steady import read_steady
from bluekoi.synthetic.ground_truth_physics import Coefficients
from bluekoi.synthetic.study_rendering import render_study
from bluekoi.synthetic.synthetic_study_design import TrialPlan, demo_design
from bluekoi.synthetic.trial import solve_trial
from small_studies import published_model_design

pytestmark = pytest.mark.long
PLANS = {plan.trial_id: plan for plan in demo_design().plans}
FITTED_POWERS_PCT = (75, 100)


def run_snakemake(target: str, *settings: str) -> None:
    """Bring one result up to date, through the workflow as a person calls it."""
    further = ["--config", *settings] if settings else []
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "all", *further, "--", target],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.fixture(scope="module")
def steady_rows() -> dict[str, SteadyState]:
    """Rows of the demo's steady.csv."""
    given = os.environ.get("BLUEKOI_DEMO_RESULTS")
    if not given:
        run_snakemake("results/demo/steady.csv")
    return dict(read_steady(Path(given or ROOT / "results/demo") / "steady.csv"))


def true_steady_state(plan: TrialPlan, row: SteadyState) -> tuple[float, float, float]:
    """True speed (m/s), radius (m) and flapping frequency (Hz) over the stretch that was used.

    Of the mean motion, the tail-beat recoil left out: the mean of |v|, and the distance gone over
    the change of course. In moving water the radius itself wanders by some percent along the path
    (trial T07: -2.2 % between the last 30 % of its path and the stretch found steady), so both
    sides must look at the same stretch, the one between steady_from_s and steady_to_s. Nothing
    here comes from the circle fit that is being judged.
    """
    trial = solve_trial(demo_design(), plan.trial_id)
    at = np.linspace(row.steady_from_s, row.steady_to_s, 1000)
    vx, vy = trial.motion.state_without_recoil(at)[:, 3:5].T
    course = np.unwrap(np.arctan2(vy, vx))
    speed = float(np.hypot(vx, vy).mean())
    gone = speed * (row.steady_to_s - row.steady_from_s)
    return speed, gone / abs(float(course[-1] - course[0])), trial.run.flap_hz


def test_every_trial_of_the_demo_has_its_row(steady_rows):
    assert list(steady_rows) == list(PLANS)
    for name, plan in PLANS.items():
        assert steady_rows[name].quality == ("straight" if plan.head_angle_deg == 0 else "good")
        assert steady_rows[name].turn == -np.sign(
            plan.head_angle_deg
        )  # positive phi turns clockwise


@pytest.mark.parametrize("name", list(PLANS))
def test_demo_truth(steady_rows, name):
    """Speeds within 1 %, radii within 2 %, flapping frequency within 0.5 %; see `truth`."""
    row = steady_rows[name]
    speed, radius, flap_hz = true_steady_state(PLANS[name], row)
    assert row.speed_m_s == pytest.approx(speed, rel=0.01)
    assert row.flap_hz == pytest.approx(flap_hz, rel=0.005)
    assert abs(row.speed_m_s - speed) < 3 * row.speed_std_m_s
    if PLANS[name].head_angle_deg == 0:
        assert math.isinf(row.radius_m)
        assert radius > 20
    else:
        assert row.radius_m == pytest.approx(radius, rel=0.02)
        assert abs(row.radius_m - radius) < 3 * row.radius_std_m


def test_the_last_stretch_is_where_the_speed_has_settled(steady_rows):
    """Nor may the choice of the stretch hide an error: the true speed over the last 30 % agrees."""
    for name, plan in PLANS.items():
        trial = solve_trial(demo_design(), name)
        end = float(trial.time_s[-1])
        late = replace(steady_rows[name], steady_from_s=0.7 * end, steady_to_s=end)
        assert steady_rows[name].speed_m_s == pytest.approx(
            true_steady_state(plan, late)[0], rel=0.01
        ), name


@pytest.fixture(scope="module")
def published_model_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small study rendered with the paper's bare model: no fin, no recoil, still water."""
    folder = tmp_path_factory.mktemp("bare")
    design = published_model_design()
    plans = tuple(plan for plan in design.plans if plan.power_pct in FITTED_POWERS_PCT)
    render_study(replace(design, plans=plans), folder / "study", folder / "truth", workers=2)
    return folder


def fitted_coefficients(study: Path) -> dict:
    """Content of coefficients.json of a study, from its footage."""
    target = study.with_name(f"{study.name}-results") / "coefficients.json"
    run_snakemake(str(target), f"study={study}", f"results={target.parent}")
    return json.loads(target.read_text())


def test_bare_model_comes_back_from_footage(published_model_study):
    """Coefficients that eight filmed trials determine: within 10 %, and inside the 95 % interval.

    The interval is that of a jackknife over trials: Student's t with one degree less than trials.
    """
    joint = fitted_coefficients(published_model_study / "study")["joint"]
    assert len(joint["trials"]) == 8
    assert set(joint["coefficients"]) == set(Coefficients.__dataclass_fields__)
    reported = {name: cell for name, cell in joint["coefficients"].items() if cell["determined"]}
    assert {"C_T", "C_D0", "C_La", "C_Da", "C_Md"} <= set(reported)
    for name, cell in reported.items():
        true = getattr(Coefficients(), name)
        assert cell["value"] == pytest.approx(true, rel=0.1), name
        assert abs(cell["value"] - true) < student.ppf(0.975, 7) * cell["std"], (name, cell)
    assert joint["straight_swimming"]["stable"] is False


def test_straight_footage_alone_leaves_the_turning_coefficients_open(published_model_study):
    """The same footage without its turns: what it does not determine is said to be undetermined."""
    study = published_model_study / "straight"
    study.mkdir()
    shutil.copy(published_model_study / "study/study.yaml", study)
    with (published_model_study / "study/trials.csv").open(newline="") as lines:
        header, *rows = csv.reader(lines)
    straight = [row for row in rows if float(row[header.index("head_angle_deg")]) == 0]
    for row in straight:
        for name in (row[header.index("source")], row[header.index("motor_log")]):
            (study / name).parent.mkdir(exist_ok=True)
            shutil.copy(published_model_study / "study" / name, study / name)
    with (study / "trials.csv").open("w", newline="") as out:
        csv.writer(out).writerows([header, *straight])
    found = fitted_coefficients(study)
    joint, steps = found["joint"], found["paper_steps"]
    assert len(joint["trials"]) == len(FITTED_POWERS_PCT)
    for name in ("C_Da", "C_La", "C_Ma", "C_Md"):
        assert not joint["coefficients"][name]["determined"], name
        assert joint["coefficients"][name]["why"], name
        for power in FITTED_POWERS_PCT:
            cell = steps[str(power)]["coefficients"][name]
            assert not cell["determined"]
            assert "straight runs hold alpha at 0" in cell["why"]
    assert joint["undetermined"]
