"""The demo study: footage of a robot whose laws are known, rendered trial by trial."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import cv2

from ..files import to_json_types, write_text
from ..synthetic.footage import render_frames
from ..synthetic.study_rendering import render_trial, study_truth, trial_truth, write_study_files
from ..synthetic.synthetic_study_design import demo_design
from ..synthetic.trial import solve_trial

STUDY_FILES = ("study.yaml", "trials.csv")


def write_demo_study(study: Path) -> None:
    """Write study.yaml and trials.csv of the demo study, and its truth in a folder beside it.

    Files that stand already are left alone, so that
    nothing runs again for their date.
    """
    design, truth = demo_design(), ground_truth_folder(study) / "truth.json"
    with tempfile.TemporaryDirectory() as name:
        write_study_files(design, Path(name), source="videos/{}.mp4", fps=None)
        texts = {study / f: (Path(name) / f).read_text(encoding="utf-8") for f in STUDY_FILES}
    trials = [trial_truth(solve_trial(design, plan.trial_id)) for plan in design.plans]
    texts[truth] = (
        json.dumps(to_json_types(study_truth(design, trials)), indent=1, allow_nan=False) + "\n"
    )
    for target, text in texts.items():
        if not target.is_file() or target.read_text(encoding="utf-8") != text:
            write_text(target, text)


def ground_truth_folder(study: Path) -> Path:
    """Where the truth of the demo lies: beside the study folder, not in it."""
    return study.with_name(f"{study.name}-truth")


def demo(study: Path, results: Path, trial_id: str, *, threads: int = 1) -> None:
    """Write videos/ID.mp4 and motor/ID.csv of one demo trial; its truth beside the study folder."""
    del results
    render_trial(demo_design(), trial_id, study, ground_truth_folder(study), threads=threads)


def preload() -> None:
    """Render one frame, so that the pool, which is the same in all videos, is computed once."""
    cv2.setNumThreads(1)  # a process with threads of OpenCV cannot be forked
    design = demo_design()
    next(render_frames(design, solve_trial(design, design.plans[0].trial_id)))
