"""What a run loads before its jobs ask for it."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from bluekoi.study import load_study
from bluekoi.study.setup import DetectionSettings
from bluekoi.workflow.plan import RunPlan
from bluekoi.workflow.stage_call import stage_names
from small_studies import small_study

COMPILED_FUNCTIONS_SCRIPT = """
import json, sys
from dataclasses import replace
from numba.core.dispatcher import Dispatcher
from bluekoi.data import Frame
from bluekoi.keypoints import silhouette
from bluekoi.stages.compiling_detector import preload
from bluekoi.study import StudySettings, Trial
from bluekoi.synthetic.study_rendering import study_yaml_content
from bluekoi.synthetic.picture_conditions import PictureConditions
from bluekoi.synthetic.synthetic_study_design import demo_design
from bluekoi.synthetic.footage import render_frames
from bluekoi.synthetic.trial import solve_trial

def compiled():
    modules = [m for name, m in sys.modules.items() if name.startswith("bluekoi.keypoints")]
    found = {d.py_func.__qualname__: d for m in modules for d in vars(m).values()
             if isinstance(d, Dispatcher)}
    return {name: len(d.signatures) for name, d in found.items()}

preload()
before = compiled()
design = replace(demo_design(), conditions=PictureConditions(size_px=(640, 360)))
trial = solve_trial(design, "T20")
few = replace(trial, time_s=trial.time_s[::8])
film = [Frame(i, float(few.time_s[i]), p.luma) for i, p in enumerate(render_frames(design, few))]
plan = trial.plan
settings = StudySettings(**study_yaml_content(design), detection={"body": "rigid"})
silhouette.detect_keypoints(lambda: film, settings, Trial(
    trial_id="T20", source="a.mp4", power_pct=plan.power_pct, head_angle_deg=plan.head_angle_deg,
    head_length_m=plan.head_length_m))
print(json.dumps([before, compiled()]))
"""


@pytest.mark.parametrize("stage", stage_names())
def test_what_a_stage_loads_ahead_can_be_loaded(stage):
    """A fault there would only make each job load it again."""
    module = import_module(f"bluekoi.stages.{stage}")
    assert getattr(module, "preload", lambda: None)() is None


def test_what_is_preloaded_is_all_that_the_detector_compiles():
    run = subprocess.run(
        [sys.executable, "-c", COMPILED_FUNCTIONS_SCRIPT],
        capture_output=True,
        text=True,
        check=True,
    )
    before, after = json.loads(run.stdout)
    assert sum(before.values()) >= 10
    assert after == before


@pytest.mark.parametrize(
    ("source", "detection", "expected"),
    [
        ("T10.csv", DetectionSettings(), False),
        ("T10.mp4", DetectionSettings(), True),
        ("T10.mp4", DetectionSettings(body="bending"), False),
        ("T10.mp4", DetectionSettings(source="markers"), False),
    ],
)
def test_the_detector_is_loaded_only_where_it_is_run(tmp_path, source, detection, expected):
    study = load_study(small_study(tmp_path / "study"))
    setup = study.setup.model_copy(update={"detection": detection})
    trials = tuple(trial.model_copy(update={"source": source}) for trial in study.trials)
    changed = study.model_copy(update={"setup": setup, "trials": trials})
    plan = RunPlan(Path("study"), Path("results"), changed, is_demo=False, overlaid="none")
    assert plan.detects_outlines == expected
