"""`bluekoi check`: a study looked at without running it."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
def check(study: Path) -> None:
    """Tell everything that is wrong with STUDY, a folder with study.yaml and trials.csv."""
    from ..faults import Fault  # noqa: PLC0415
    from ..keypoints import source  # noqa: PLC0415
    from ..study import load_study, missing_files  # noqa: PLC0415

    loaded = load_study(study)
    if missing := missing_files(loaded):
        raise Fault(missing)
    if any(not trial.reads_keypoints for trial in loaded.trials):
        source(loaded.setup.detection.source)
    filmed = sum(not trial.reads_keypoints for trial in loaded.trials)
    conditions = len({trial.condition for trial in loaded.trials})
    click.echo(
        f"{study}: {len(loaded.trials)} trials ({filmed} filmed, {len(loaded.trials) - filmed} "
        f"keypoint files) in {conditions} conditions; nothing wrong."
    )
