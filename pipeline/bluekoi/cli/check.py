"""`bluekoi check`: a study looked at without running it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .named import Named
from .waiting import waiting

if TYPE_CHECKING:
    from ..data import Keypoints
    from ..errors import Finding
    from ..study import Study, Trial

LEAST_FRAMES = 2


def _in(study: Path, finding: Finding) -> Finding:
    """The finding with the study's folder before the bare name of its file."""
    bare = finding.file == Path(finding.file).name
    return replace(finding, file=str(study / finding.file)) if bare else finding


def _unreadable(study: Study) -> list[Finding]:
    """A finding for each source and motor log that a run could not read, and for shared sources."""
    from ..errors import InputError  # noqa: PLC0415

    found = _shared(study)
    with waiting(f"opening the files of {len(study.trials)} trials") as wait:
        for done, trial in enumerate(study.trials, 1):
            try:
                _read(study, trial)
            except InputError as error:
                found += error.findings
            wait.share = done / len(study.trials)
    return found


def _shared(study: Study) -> list[Finding]:
    """A finding for each file that two trials take whole."""
    from ..errors import Finding  # noqa: PLC0415

    found: list[Finding] = []
    owner: dict[Path, str] = {}
    whole = [t for t in study.trials if t.start_s is None and t.end_s is None]
    for trial, path in ((t, p) for t in whole for p in study.paths(t)):
        if (first := owner.setdefault(path, trial.trial_id)) != trial.trial_id:
            name = f"{path.name}, whole, as trial {first} has it"
            found.append(
                Finding(
                    str(study.root / "trials.csv"), f"trial {trial.trial_id}", name,
                    "a file of its own, or a part of one by start_s and end_s",
                )
            )  # fmt: skip
    return found


def _read(study: Study, trial: Trial) -> None:
    """Raises: InputError where a trial's motor log, keypoints or film cannot be read."""
    if (log := study.motor_path(trial)) is not None:
        from ..motor import flapping_from_log  # noqa: PLC0415

        flapping_from_log(log)
    if trial.reads_keypoints:
        from ..keypoints import source  # noqa: PLC0415

        path = study.paths(trial)[0]
        _seen(path, source("deeplabcut").read(path, trial, study.setup.bodyparts))
    else:
        from ..footage import open_recording  # noqa: PLC0415
        from ..study.filmed import as_filmed  # noqa: PLC0415

        film = open_recording(
            study.paths(trial), fps=trial.fps, start_s=trial.start_s, end_s=trial.end_s
        )
        as_filmed(study.setup, film.size_px, f"{trial.source} (trial {trial.trial_id})")


def _seen(path: Path, found: Keypoints) -> None:
    """Raises: InputError where fewer than `LEAST_FRAMES` frames show a head direction and a
    core.
    """
    import numpy as np  # noqa: PLC0415

    from ..data import CONFIDENT, confident  # noqa: PLC0415
    from ..errors import input_error  # noqa: PLC0415
    from ..pose.body import RIGID  # noqa: PLC0415
    from ..pose.fit import enough  # noqa: PLC0415

    sure = dict(zip(found.names, confident(found.likelihood.T), strict=True))
    never = np.zeros(len(found.time_s), dtype=bool)
    frames = int(enough(np.column_stack([sure.get(name, never) for name in RIGID])).sum())
    if frames < LEAST_FRAMES:
        raise input_error(
            path, "", f"{frames} of {len(found.time_s)} frames with head_tip and two of "
            f"{', '.join(RIGID[1:])} at likelihood {CONFIDENT} or more", f"{LEAST_FRAMES} at least",
            "Are the likelihoods there, and are the names under bodyparts: the right ones?",
        )  # fmt: skip


def _explain(ctx: click.Context, _param: click.Parameter, key: str | None) -> None:
    """Show what a key of study.yaml or trials.csv means, and end."""
    if key is not None and not ctx.resilient_parsing:
        from ..study.keys import explain_key  # noqa: PLC0415

        click.echo(explain_key(key))
        ctx.exit()


@click.command()
@click.argument("study", type=Named(path_type=Path))
@click.option(
    "--explain",
    metavar="KEY",
    is_eager=True,
    expose_value=False,
    callback=_explain,
    help="Show meaning, unit and default of a key of study.yaml or a column of trials.csv.",
)
def check(study: Path) -> None:
    """List all that is wrong in the files of STUDY, a folder with study.yaml and trials.csv."""
    from ..camera import pool_camera  # noqa: PLC0415
    from ..errors import InputError  # noqa: PLC0415
    from ..keypoints import source  # noqa: PLC0415
    from ..study import load_study, missing_files  # noqa: PLC0415
    from ..workflow.plan import check_results_name  # noqa: PLC0415

    loaded = load_study(study)
    check_results_name(Path("results") / study.resolve().name)
    if missing := missing_files(loaded):
        raise InputError(missing)
    try:
        source(loaded.setup.detection.source)
        remarks = pool_camera(loaded.setup).remarks
    except InputError as found:
        raise InputError(_in(study, finding) for finding in found.findings) from found
    if unreadable := _unreadable(loaded):
        raise InputError(unreadable)
    filmed = sum(not trial.reads_keypoints for trial in loaded.trials)
    conditions = len({trial.condition for trial in loaded.trials})
    for remark in remarks:
        click.echo(f"{study / 'study.yaml'}: {remark}")
    click.echo(
        f"{study}: {len(loaded.trials)} trials ({filmed} filmed, {len(loaded.trials) - filmed} "
        f"keypoint files) in {conditions} conditions; nothing {'else ' if remarks else ''}wrong."
    )
