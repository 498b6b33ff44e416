"""`bluekoi check`: finds the errors in the files of a study without running it."""

from __future__ import annotations

from pathlib import Path

import click

from .parameter_types import StudyName
from .progress_notice import progress_notice


def _explain_key(ctx: click.Context, _param: click.Parameter, key: str | None) -> None:
    """Show what a key of study.yaml or trials.csv means, and end."""
    if key is not None and not ctx.resilient_parsing:
        from ..study.key_reference import explain_key  # noqa: PLC0415

        click.echo(explain_key(key))
        ctx.exit()


NOT_CHECKED_NOTE_KEYPOINT_STUDY = (
    "Not checked here: what only the motion in all trials shows, such as errors of the lens and "
    "of the place of the camera. A run compares it with the files and names what does not agree."
)
NOT_CHECKED_NOTE_VIDEO_STUDY = (
    "Not checked here: what only the motion in the videos shows, such as the frame rate, the sign "
    "of the head angles, the lens and the place of the camera. A run compares these with the "
    "files and names what does not agree."
)


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.option(
    "--explain",
    metavar="KEY",
    is_eager=True,
    expose_value=False,
    callback=_explain_key,
    help="Show meaning, unit and default of a key of study.yaml or a column of trials.csv.",
)
def check(study: Path) -> None:
    """List errors and warnings on the files of STUDY, a folder with study.yaml and trials.csv."""
    from ..errors import InputError  # noqa: PLC0415
    from ..preparation.input_check import (  # noqa: PLC0415
        check_files,
        recording_warnings,
        setup_findings,
    )
    from ..study import load_study, missing_files  # noqa: PLC0415
    from ..trial_warnings import trial_warnings, unchecked_frame_rate_notes  # noqa: PLC0415
    from ..workflow.plan import check_results_name  # noqa: PLC0415

    loaded = load_study(study)
    check_results_name(Path("results") / study.resolve().name)
    if missing := missing_files(loaded):
        raise InputError(missing)
    wrong, remarks = setup_findings(loaded.setup, study)
    if wrong:
        raise InputError(wrong)
    with progress_notice(f"opening the files of {len(loaded.trials)} trials") as wait:

        def progress(share: float) -> None:
            wait.share = share

        unreadable, statuses, recording_remarks = check_files(loaded, progress)
    warnings = [*recording_warnings(loaded, recording_remarks), *trial_warnings(loaded, statuses)]
    for remark in remarks:
        click.echo(f"{study / 'study.yaml'}: {remark}")
    for warning in warnings:
        click.echo(f"Warning: {warning}")
    if unreadable:
        raise InputError(unreadable)
    filmed = sum(not trial.reads_keypoints for trial in loaded.trials)
    conditions = len({trial.condition for trial in loaded.trials})
    more = "other " if remarks or warnings else ""
    click.echo(
        f"{study}: {len(loaded.trials)} trials ({filmed} filmed, {len(loaded.trials) - filmed} "
        f"keypoint files) in {conditions} conditions; no {more}error found in the files."
    )
    click.echo(NOT_CHECKED_NOTE_VIDEO_STUDY if filmed else NOT_CHECKED_NOTE_KEYPOINT_STUDY)
    for note in unchecked_frame_rate_notes(loaded, statuses):
        click.echo(note)
