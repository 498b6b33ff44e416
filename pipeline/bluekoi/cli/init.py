"""`bluekoi init`: a study's files, pre-filled from its recordings."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .number_types import FiniteNumber
from .parameter_types import NonEmptyPath
from .progress_notice import progress_notice

if TYPE_CHECKING:
    from ..preparation.prefill import StudyFiles

HEAD_LENGTH_HELP = "1x head, nose to hinge, m; filled in for every trial."


@click.command()
@click.argument("files", nargs=-1, type=NonEmptyPath(path_type=Path), metavar="[VIDEOS]...")
@click.option("--study", type=NonEmptyPath(path_type=Path), help="Folder of the study.")
@click.option(
    "--head-length-m", type=FiniteNumber(min=0, max=10, min_open=True), help=HEAD_LENGTH_HELP
)
def init(files: tuple[Path, ...], study: Path | None, head_length_m: float | None) -> None:
    """Write study.yaml and trials.csv for VIDEOS: videos, keypoint files, or a folder with them.

    Both files are written into the folder given with --study. Without --study, they are written
    into the folder of VIDEOS, or into the current folder if no VIDEOS are given. Motor logs in the
    folder are matched to the recordings by name. Motor power and head angle are read from file
    names such as p50_phi-20.mp4. Keys whose values cannot be found out from the files are left
    empty, with a comment on their meaning and unit; `bluekoi check` lists these keys. No existing
    file is overwritten.
    """
    from ..errors import input_error  # noqa: PLC0415
    from ..files import write_text  # noqa: PLC0415
    from ..preparation.file_properties import file_properties, with_recording_property_comments  # noqa: PLC0415
    from ..preparation.prefill import (  # noqa: PLC0415
        blank_study_yaml,
        prefilled_trial_rows,
        trials_csv_text,
    )

    folder = _study_folder(files, study)
    for name in ("study.yaml", "trials.csv"):
        if (folder / name).exists():
            raise input_error(folder / name, "", "a file that is there already", "none",
                              "Rename it, or edit it by hand: nothing is overwritten.")  # fmt: skip
    selected = _selected_files(folder, files)
    if odd := [name for name in selected.recordings if ";" in name]:
        raise input_error(folder / odd[0], "", "a name with ';', which joins chapters in "
                          "trials.csv", "a name without it", "Rename the file.")  # fmt: skip
    rows = prefilled_trial_rows(selected, head_length_m)
    if not rows:
        remedy = "Videos: mp4, mov, avi, mkv; keypoints: DeepLabCut's csv or h5."
        raise input_error(folder, "", "no video and no keypoint file", "one or more", remedy)
    with progress_notice(f"opening the files of {len(rows)} trials"):
        found = file_properties(folder, rows)
    write_text(folder / "trials.csv", trials_csv_text(rows))
    write_text(folder / "study.yaml", with_recording_property_comments(blank_study_yaml(), found))
    for one in found:
        click.echo(f"{one.trial_id}: {one.source}: {one.text}")
    click.echo(
        f"Written: {folder / 'study.yaml'} and {folder / 'trials.csv'} ({len(rows)} trials). Fill "
        f"in what is empty; `bluekoi check {folder}` lists it, `bluekoi check --explain KEY` "
        "explains a key."
    )


def _study_folder(files: tuple[Path, ...], study: Path | None) -> Path:
    """Folder of the study.

    Raises: InputError where a file is missing or does not lie in the folder.
    """
    from ..errors import input_error  # noqa: PLC0415

    if missing := [path for path in files if not path.exists()]:
        raise input_error(missing[0], "", "nothing there", "a video, keypoint file or folder")
    if study is None and files:
        folders = [path if path.is_dir() else path.parent for path in files]
        study = Path(os.path.commonpath([path.absolute() for path in folders]))
        study = folders[0] if len(folders) == 1 else study
    folder = study or Path()
    if not folder.is_dir():
        raise input_error(folder, "", "no folder", "the folder with the recordings")
    outside = [path for path in files if not _lies_in(path, folder)]
    if outside:
        remedy = "Move it there, or give its folder as --study."
        raise input_error(
            outside[0], "", "a file outside of the study's folder", f"a file in {folder}", remedy
        )
    return folder


def _lies_in(path: Path, folder: Path) -> bool:
    """Whether a path is a folder or lies in it, with links followed or not."""
    named = Path(os.path.abspath(path)).is_relative_to(os.path.abspath(folder))
    return named or path.resolve().is_relative_to(folder.resolve())


def _selected_files(folder: Path, files: tuple[Path, ...]) -> StudyFiles:
    """The files that were named, or that lie in folders that were named, and all motor logs."""
    from dataclasses import replace  # noqa: PLC0415

    from ..preparation.prefill import study_files  # noqa: PLC0415

    found = study_files(folder)
    wanted = files or (folder,)

    def named(name: str) -> bool:
        return any(_lies_in(folder / name, one) for one in wanted)

    return replace(
        found,
        videos=tuple(filter(named, found.videos)),
        keypoints=tuple(filter(named, found.keypoints)),
    )
