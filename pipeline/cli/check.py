"""`bluekoi check`: a study looked at without running it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..faults import Finding


def _in(study: Path, finding: Finding) -> Finding:
    """The finding with the study's folder before the bare name of its file."""
    bare = finding.file == Path(finding.file).name
    return replace(finding, file=str(study / finding.file)) if bare else finding


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
def check(study: Path) -> None:
    """Tell everything that is wrong with STUDY, a folder with study.yaml and trials.csv."""
    from ..camera import pool_camera  # noqa: PLC0415
    from ..faults import Fault  # noqa: PLC0415
    from ..keypoints import source  # noqa: PLC0415
    from ..study import load_study, missing_files  # noqa: PLC0415

    loaded = load_study(study)
    if missing := missing_files(loaded):
        raise Fault(missing)
    try:
        source(loaded.setup.detection.source)
        pool_camera(loaded.setup)
    except Fault as found:
        raise Fault(_in(study, finding) for finding in found.findings) from found
    filmed = sum(not trial.reads_keypoints for trial in loaded.trials)
    conditions = len({trial.condition for trial in loaded.trials})
    click.echo(
        f"{study}: {len(loaded.trials)} trials ({filmed} filmed, {len(loaded.trials) - filmed} "
        f"keypoint files) in {conditions} conditions; nothing wrong."
    )
