"""Properties of a study's files: duration, rate and size of recordings, frequency of motor logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..footage import open_recording
from ..motor import flapping_from_log
from ..study import VIDEO_SUFFIXES


@dataclass(frozen=True)
class FileProperties:
    """Properties of the files that one row of trials.csv names.

    text: duration, frame rate, picture size and motor frequency in words, or why a file cannot be
    read. size_px: (width, height) of a video's frames.
    """

    trial_id: str
    source: str
    text: str
    size_px: tuple[int, int] | None = None


def file_properties(folder: Path, rows: Sequence[Mapping[str, str]]) -> list[FileProperties]:
    """Properties of each row of `prefill.prefilled_trial_rows`, paths relative to `folder`."""
    return [_properties_of_row(folder, row) for row in rows]


def _properties_of_row(folder: Path, row: Mapping[str, str]) -> FileProperties:
    name, source = row["trial_id"], row["source"]
    parts: list[str] = []
    size = None
    try:
        if Path(source.split(";")[0]).suffix.lower() in VIDEO_SUFFIXES:
            film = open_recording([folder / part for part in source.split(";")])
            size = film.size_px
            seconds = film.frames_present / film.nominal_fps
            parts.append(f"{seconds:.1f} s, {film.nominal_fps:.5g} frames/s, {size[0]} x {size[1]}")
        else:
            parts.append("keypoints; fps is to be filled in")
        if log := row.get("motor_log"):
            parts.append(f"{log}: {flapping_from_log(folder / log).flap_hz:.3g} Hz")
    except InputError as error:
        return FileProperties(name, source, f"cannot be used: {error.findings[0].found}")
    return FileProperties(name, source, "; ".join(parts), size)


def with_recording_property_comments(study_yaml: str, found: Sequence[FileProperties]) -> str:
    """study.yaml with the properties as comments on top and, where all agree, the image size."""
    lines = ["# Recordings found:", *(f"#   {f.trial_id}: {f.source}: {f.text}" for f in found)]
    sizes = {f.size_px for f in found if f.size_px}
    if len(sizes) == 1:
        width, height = sizes.pop() or (0, 0)
        study_yaml = study_yaml.replace(
            "  # image_size_px:", f"  image_size_px: [{width}, {height}]"
        )
    comment = ["".join(c if c.isprintable() else "?" for c in line) for line in lines]
    return "\n".join([*comment, "#", study_yaml])
