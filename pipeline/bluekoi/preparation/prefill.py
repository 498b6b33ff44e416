"""Rows of trials.csv and a study.yaml, pre-filled from the files of a folder."""

from __future__ import annotations

import csv
import io
import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..footage.gopro_chapters import gopro_chapter
from ..study import VIDEO_SUFFIXES, Trial
from ..study.image_files import IMAGE_SUFFIXES, natural_sort_key
from ..study.key_reference import setting_keys

MAX_HEADER_BYTES = 4096
MAX_FILES = 100_000
MIN_PICTURES_OF_RECORDING = 50
"""A folder with fewer pictures is one of calibration boards rather than a recording."""
REQUIRED_COLUMNS = tuple(name for name, info in Trial.model_fields.items() if info.is_required())
POWER_PATTERN = re.compile(r"(?i)(?:^|[_\-. ])(?:power|pwr|p)[_-]?(\d{1,3})(?=$|[_\-. %])")
"""Power and head angle in the name of a file: p50, 70pct, phi-20."""
PERCENT_PATTERN = re.compile(r"(?i)(\d{1,3})(?:pct|percent|%)")
ANGLE_PATTERN = re.compile(
    r"(?i)(?:^|[_\-. ])(?:head[_-]?angle|angle|phi|a)_?(m|minus|-|\+)?(\d{1,3}(?:\.\d+)?)"
    r"(?:deg)?(?=$|[_\-. ])"
)
MAX_CONDITION_VALUES_IN_FILE_NAMES = {"power_pct": 300.0, "head_angle_deg": 120.0}
"""Largest values of trials.csv: a larger number in a name is something else, such as a date."""
MOTOR_LOG_NAME_PATTERN = re.compile(r"(?i)^(motor|log|angle|shaft|encoder)[_\-. ]|"
                       r"[_\-. ](motor|log|angle|shaft|encoder)s?$")  # fmt: skip
"""Words that the name of a motor log may have beside that of its recording."""
KEYS_COMMENTED_OUT = {"camera": ("matrix", "distortion"), "robot": ("keypoint_depth_m",)}
"""Section -> keys that a new study.yaml shows as comments."""


@dataclass(frozen=True)
class StudyFiles:
    """Files of a folder that a study can be made of, as paths relative to it, in natural order.

    pictures: folders with at least `MIN_PICTURES_OF_RECORDING` pictures, with a slash at the end.
    """

    videos: tuple[str, ...]
    keypoints: tuple[str, ...]
    motor_logs: tuple[str, ...]
    pictures: tuple[str, ...] = ()

    @property
    def recordings(self) -> tuple[str, ...]:
        """Videos, else folders of pictures, else keypoint files: one kind makes the trials."""
        return self.videos or self.pictures or self.keypoints


def study_files(folder: Path) -> StudyFiles:
    """Videos, keypoint files and motor logs of a folder and the folders in it, links followed.

    Hidden folders are left out, and folders with a report.html, which are results of a run.
    """
    videos, points, logs = [], [], []
    pictures: Counter[str] = Counter()
    for path in _list_files(folder):
        name, suffix = path.relative_to(folder).as_posix(), path.suffix.lower()
        if suffix in VIDEO_SUFFIXES:
            videos.append(name)
        elif suffix in IMAGE_SUFFIXES:
            pictures[path.parent.relative_to(folder).as_posix() + "/"] += 1
        elif suffix in (".h5", ".hdf5", ".slp") or (
            suffix == ".csv" and _has_deeplabcut_header(path)
        ):
            points.append(name)
        elif suffix == ".csv" and _header_cells(path)[:2] == ["time_s", "angle_deg"]:
            logs.append(name)
    films = [name for name, count in pictures.items() if count >= MIN_PICTURES_OF_RECORDING]
    found = (tuple(sorted(some, key=natural_sort_key)) for some in (videos, points, logs, films))
    return StudyFiles(*found)


def usable_study_files(folder: Path) -> tuple[StudyFiles, tuple[str, ...]]:
    """Files of a folder that trials.csv can name, and a sentence on each recording that it cannot.

    `;` separates the files of one recording in trials.csv, and its cells have no line break, tab or
    double blank.
    """
    files = study_files(folder)
    kept, notes = {}, []
    for kind in ("videos", "keypoints", "pictures", "motor_logs"):
        names = getattr(files, kind)
        why = {name: _why_unusable(name, is_log=kind == "motor_logs") for name in names}
        kept[kind] = tuple(name for name in names if not why[name])
        notes += [f"{' '.join(name.split())} is left out: {text}. Rename it."
                  for name, text in why.items() if text]  # fmt: skip
    return replace(files, **kept), tuple(notes)


def _why_unusable(name: str, *, is_log: bool) -> str:
    """Why trials.csv cannot name a file; empty for others."""
    if ";" in name and not is_log:
        return "';' separates the files of one recording in trials.csv"
    blank = "a name in trials.csv has no line break, tab or double blank"
    return "" if name == " ".join(name.split()) else blank


def prefilled_trial_rows(
    files: StudyFiles, head_length_m: float | None = None
) -> list[dict[str, str]]:
    """A row of trials.csv for each recording, else for each keypoint file: column to text.

    Power and head angle are taken from names such as `p50_phi-20`, `50pct`; the motor log is the
    one of the same name, unless recordings in several folders have that name. What is not known is
    left out for the user to fill in. Chapters of one GoPro recording make one row. head_length_m:
    of the 1x head, taken for all trials.
    """
    sources = _recording_sources(files.videos) or list(files.recordings)
    logs = _logs_by_name(files.motor_logs)
    stems = Counter(Path(source.split(";")[0]).stem.casefold() for source in sources)
    rows: list[dict[str, str]] = []
    for source in sources:
        stem = Path(source.split(";")[0]).stem
        row = {
            "trial_id": _unique_trial_id(source, [r["trial_id"] for r in rows]),
            "source": source,
        }
        row |= condition_from_file_name(stem)
        if head_length_m is not None:
            row["head_length_m"] = f"{head_length_m:g}"
        if stems[stem.casefold()] == 1 and (log := logs.get(stem.casefold())):
            row["motor_log"] = log
        rows.append(row)
    return rows


def condition_from_file_name(stem: str) -> dict[str, str]:
    """Power and head angle where the name of a file states them: column to text."""
    found = {}
    if power := PERCENT_PATTERN.search(stem) or POWER_PATTERN.search(stem):
        found["power_pct"] = f"{int(power[1])}"
    if angle := ANGLE_PATTERN.search(stem):
        sign = "-" if (angle[1] or "").lower() in ("m", "minus", "-") else ""
        found["head_angle_deg"] = f"{sign}{float(angle[2]):g}"
    return {
        key: text
        for key, text in found.items()
        if abs(float(text)) <= MAX_CONDITION_VALUES_IN_FILE_NAMES[key]
    }


def trials_csv_text(rows: Sequence[Mapping[str, str]], header: Sequence[str] = ()) -> str:
    """Text of trials.csv: the required columns, those of `header` and those that a row uses."""
    used = {name for row in rows for name, text in row.items() if text.strip()}
    known = [name for name in Trial.model_fields if name in used or name in REQUIRED_COLUMNS]
    first = list(header) or known
    columns = [*first, *(name for name in known if name not in first)]
    columns += sorted(used - set(columns))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([" ".join(row.get(name, "").split()) for name in columns] for row in rows)
    return out.getvalue()


def blank_study_yaml() -> str:
    """A study.yaml with a comment on each key, required values left empty.

    Values with a default stand in it as such, except those of the pool, which has to be measured;
    what most studies leave out is commented out.
    """
    lines = ["# A study: pool, water, robot, camera. Units are SI unless the name says otherwise."]
    for key in setting_keys():
        section, _, name = key.name.partition(".")
        if key.file != "study.yaml" or section not in ("pool", "water", "robot", "camera"):
            continue
        if not name:
            lines += ["", f"# {key.meaning}", f"{section}:"]
            continue
        unit = f" [{key.unit}]" if key.unit else ""
        needed = key.default == "required" or section == "pool"
        value = "" if needed else key.default
        off = "" if needed or value else "# "
        off = "# " if name in KEYS_COMMENTED_OUT.get(section, ()) else off
        lines += [f"  # {key.meaning}{unit}", f"  {off}{name}: {value}".rstrip()]
    return "\n".join(lines) + "\n"


def _list_files(folder: Path) -> Iterator[Path]:
    """Files of a folder, at most `MAX_FILES`; folders of results and hidden ones left out.

    Links to folders are followed, each folder once.
    """
    count, visited = 0, set()
    for root, folders, names in os.walk(folder, followlinks=True):
        if (place := os.path.realpath(root)) in visited:
            folders.clear()
            continue
        visited.add(place)
        folders[:] = sorted(
            name for name in folders
            if not name.startswith(".") and not (Path(root) / name / "report.html").is_file()
        )  # fmt: skip
        for name in names:
            count += 1
            if count > MAX_FILES:
                return
            if not name.startswith("."):
                yield Path(root) / name


def _recording_sources(videos: Sequence[str]) -> list[str]:
    """Sources, chapters of one recording joined by `;`."""
    groups: dict[object, list[str]] = {}
    for name in videos:
        mark = gopro_chapter(Path(name))
        groups.setdefault((Path(name).parent, mark[0]) if mark else name, []).append(name)
    return [";".join(sorted(some, key=lambda n: (gopro_chapter(Path(n)) or ("", 0))[1]))
            for some in groups.values()]  # fmt: skip


def _logs_by_name(logs: Sequence[str]) -> dict[str, str]:
    """Motor logs by the name of the recording that they belong to."""
    found: dict[str, str] = {}
    for name in logs:
        stem = Path(name).stem
        found.setdefault(stem.casefold(), name)
        found.setdefault(MOTOR_LOG_NAME_PATTERN.sub("", stem).casefold(), name)
    return found


def _unique_trial_id(source: str, taken: Sequence[str]) -> str:
    """A trial_id of the file's name, with that of its folder or a number where it is taken."""
    path = Path(source.split(";", maxsplit=1)[0])
    own = _as_valid_id(path.stem)
    names = [
        own,
        _as_valid_id(f"{path.parent.name}_{own}"),
        *(f"{own}_{k}" for k in range(2, MAX_FILES)),
    ]
    lower = {name.casefold() for name in taken}
    return next(name for name in names if name.casefold() not in lower)


def _as_valid_id(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_")[:90] or "trial"


def _header_cells(path: Path) -> list[str]:
    """Cells of the first line of a csv file; nothing where it cannot be read."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            return [cell.strip() for cell in file.readline(MAX_HEADER_BYTES).split(",")]
    except OSError:
        return []


def _has_deeplabcut_header(path: Path) -> bool:
    """Whether a csv file has DeepLabCut's header."""
    return _header_cells(path)[:1] == ["scorer"]
