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
    from ..faults import Finding
    from ..study import Study, Trial

LEAST_FRAMES = 2


def _in(study: Path, finding: Finding) -> Finding:
    """The finding with the study's folder before the bare name of its file."""
    bare = finding.file == Path(finding.file).name
    return replace(finding, file=str(study / finding.file)) if bare else finding


def _unreadable(study: Study) -> list[Finding]:
    """A finding for each source and motor log that a run could not read, and for shared sources."""
    from ..faults import Fault  # noqa: PLC0415

    found = _shared(study)
    with waiting(f"opening the files of {len(study.trials)} trials") as wait:
        for done, trial in enumerate(study.trials, 1):
            try:
                _read(study, trial)
            except Fault as fault:
                found += fault.findings
            wait.share = done / len(study.trials)
    return found


def _shared(study: Study) -> list[Finding]:
    """A finding for each file that two trials take whole."""
    from ..faults import Finding  # noqa: PLC0415

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
    """Raises: Fault where a trial's motor log, keypoints or film cannot be read."""
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
    """Raises: Fault where fewer than `LEAST_FRAMES` frames show a head direction and a core."""
    import numpy as np  # noqa: PLC0415

    from ..faults import fault  # noqa: PLC0415
    from ..pose.body import CONFIDENT, RIGID  # noqa: PLC0415
    from ..pose.fit import enough  # noqa: PLC0415

    sure = dict(zip(found.names, found.likelihood.T >= CONFIDENT, strict=True))
    never = np.zeros(len(found.time_s), dtype=bool)
    frames = int(enough(np.column_stack([sure.get(name, never) for name in RIGID])).sum())
    if frames < LEAST_FRAMES:
        raise fault(
            path, "", f"{frames} of {len(found.time_s)} frames with head_tip and two of "
            f"{', '.join(RIGID[1:])} at likelihood {CONFIDENT} or more", f"{LEAST_FRAMES} at least",
            "Are the likelihoods there, and are the names under bodyparts: the right ones?",
        )  # fmt: skip


@click.command()
@click.argument("study", type=Named(path_type=Path))
def check(study: Path) -> None:
    """Tell all that is wrong in the files of STUDY, a folder with study.yaml and trials.csv."""
    from ..camera import pool_camera  # noqa: PLC0415
    from ..faults import Fault  # noqa: PLC0415
    from ..keypoints import source  # noqa: PLC0415
    from ..study import load_study, missing_files  # noqa: PLC0415

    loaded = load_study(study)
    if missing := missing_files(loaded):
        raise Fault(missing)
    try:
        source(loaded.setup.detection.source)
        remarks = pool_camera(loaded.setup).remarks
    except Fault as found:
        raise Fault(_in(study, finding) for finding in found.findings) from found
    if unreadable := _unreadable(loaded):
        raise Fault(unreadable)
    filmed = sum(not trial.reads_keypoints for trial in loaded.trials)
    conditions = len({trial.condition for trial in loaded.trials})
    for remark in remarks:
        click.echo(f"{study / 'study.yaml'}: {remark}")
    click.echo(
        f"{study}: {len(loaded.trials)} trials ({filmed} filmed, {len(loaded.trials) - filmed} "
        f"keypoint files) in {conditions} conditions; nothing {'else ' if remarks else ''}wrong."
    )
