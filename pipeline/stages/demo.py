"""The demo study: footage of a robot whose laws are known, rendered trial by trial."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ..files import write_text
from ..synthetic.campaign import render_trial, write_study_files
from ..synthetic.design import demo_design

STUDY_FILES = ("study.yaml", "trials.csv")


def lay_out(study: Path) -> None:
    """Write study.yaml and trials.csv of the demo study, where they are not there as they should.

    Files that stand already are left alone, so that nothing runs again for their date.
    """
    with tempfile.TemporaryDirectory() as name:
        write_study_files(demo_design(), Path(name), source="videos/{}.mp4", fps=None)
        texts = {file: (Path(name) / file).read_text(encoding="utf-8") for file in STUDY_FILES}
    for file, text in texts.items():
        target = study / file
        if not target.is_file() or target.read_text(encoding="utf-8") != text:
            write_text(target, text)


def demo(study: Path, results: Path, trial_id: str, *, threads: int = 1) -> None:
    """Write videos/ID.mp4 and motor/ID.csv of one demo trial; its truth beside the study folder."""
    del results
    truth = study.with_name(f"{study.name}-truth")
    render_trial(demo_design(), trial_id, study, truth, threads=threads)
