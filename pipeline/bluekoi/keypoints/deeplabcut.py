"""Keypoints from DeepLabCut files (csv, h5; one animal or several), and ours in its layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from pathlib import Path

import numpy as np

from ..data import MIN_KEYPOINT_LIKELIHOOD, Float, Keypoints, read_columns, write_columns
from ..errors import InputError, input_error
from ..files import atomic_write
from ..study import Trial
from .files.dlc_csv import read_dlc_csv
from .files.dlc_h5 import read_h5
from .files.table import Table, to_keypoints
from .sleap import is_sleap, read_slp
from .sleap import read_table as read_sleap

SCORER = "bluekoi"
"""Scorer in the files of our own detectors, followed by a dot and the detector's name."""
TRIALS_FILE = "trials.csv"
WHOLE_LENGTH_COLUMN = "whole_length_m"
COVARIANCE_ENTRIES = (("xx", 0, 0), ("xy", 0, 1), ("yy", 1, 1))


def read_keypoints_of_trial(
    path: Path, trial: Trial, bodyparts: Mapping[str, str] | None = None, *,
    stated_length_m: float | None = None,
) -> Keypoints:  # fmt: skip
    """Keypoints of a trial from a csv or h5 file, times = frame / trial.fps.

    A sidecar `<name>.cov.csv` beside the file, as `write_keypoints_csv` makes it, gives true times,
    covariances and the whole lengths seen; without it the covariance is the noise of the positions
    themselves. In files of others a likelihood of 0.1 is enough where most points of a part have
    less than 0.6. stated_length_m: whole length of the body in this trial, with which the lengths
    seen are compared; without, they are not read.

    Raises: InputError where the file is missing, is not DeepLabCut's (or SLEAP's) layout, is empty
    or damaged, or lacks the parts that a head direction and a core centre need.
    """
    table = read_table(Path(path))
    fps = trial.fps or 30.0
    part_s = (trial.start_s, trial.end_s)
    limit = {"min_likelihood": MIN_KEYPOINT_LIKELIHOOD} if is_written_by_bluekoi(Path(path)) else {}
    found = to_keypoints(table, Path(path), fps=fps, bodyparts=bodyparts, part_s=part_s, **limit)
    if len(found.time_s) == 0:
        raise _no_frame_in_time_range_error(Path(path), trial, table.frame / fps)
    sidecar = covariance_path(path)
    if not sidecar.is_file():
        return found
    return _with_stored_covariance(found, sidecar, stated_length_m)


def _no_frame_in_time_range_error(path: Path, trial: Trial, time_s: Float) -> InputError:
    """Error for a file without a frame from start_s to end_s; time_s: of its frames, (frames,)."""
    if len(time_s) == 0:
        return input_error(path, "", "no frame", "a row a frame")
    asked = {"start_s": trial.start_s, "end_s": trial.end_s}
    given = {key: value for key, value in asked.items() if value is not None}
    return input_error(
        TRIALS_FILE, f"trial {trial.trial_id}, {', '.join(given)}",
        " to ".join(f"{value:g} s" for value in given.values()),
        f"a part of {trial.source}, whose frames are from {time_s[0]:.4g} to {time_s[-1]:.4g} s",
    )  # fmt: skip


def is_written_by_bluekoi(path: Path) -> bool:
    """Whether `write_keypoints_csv` wrote a file, with covariances beside it: its likelihoods are
    those of our detectors, of which less than 0.6 means not seen.
    """
    own = _scorer(path).partition(".")[0] == SCORER
    return own and covariance_path(path).is_file()


def detector_of_file(path: Path) -> str:
    """Which of our detectors found the keypoints of a file; empty for files of others."""
    scorer, _, detector = _scorer(path).partition(".")
    return detector if scorer == SCORER else ""


def _scorer(path: Path) -> str:
    """Scorer of the first column of a csv file; empty for other files."""
    if path.suffix.lower() != ".csv":
        return ""
    with path.open("rb") as content:
        first, _, rest = content.readline(64).decode("utf-8-sig", "replace").partition(",")
    return rest.partition(",")[0].strip() if first == "scorer" else ""


def read_detections(path: Path, trial: Trial) -> Keypoints:
    """Keypoints that `write_keypoints_csv` wrote: of the part to use, under our names."""
    whole = trial.model_copy(update={"start_s": None, "end_s": None, "fps": trial.fps or 30.0})
    return read_keypoints_of_trial(path, whole)


def read_table(path: Path) -> Table:
    """Table of a csv or h5 of DeepLabCut's, or of a SLEAP analysis h5.

    Raises: InputError as `read_keypoints_of_trial`.
    """
    if not path.is_file():
        raise input_error(path, "", "no such file", "a keypoint file")
    if path.stat().st_size == 0:
        raise input_error(path, "", "an empty file (0 bytes)", "a keypoint file")
    table = _read_by_format(path)
    if path.stem.endswith("_filtered"):
        remark = f"{path.name} was filtered already: its noise is no longer independent"
        return replace(table, remarks=(*table.remarks, remark))
    return table


def _read_by_format(path: Path) -> Table:
    if path.suffix.lower() == ".csv":
        return read_dlc_csv(path)
    if path.suffix.lower() == ".slp":
        return read_slp(path)
    return read_sleap(path) if is_sleap(path) else read_h5(path)


def covariance_path(path: str | Path) -> Path:
    """Path of the covariance file beside a keypoint file."""
    return Path(path).with_suffix(".cov.csv")


def write_keypoints_csv(
    path: str | Path, keypoints: Keypoints, detector: str = "", *,
    stated_length_m: float | None = None,
) -> None:  # fmt: skip
    """Write keypoints in DeepLabCut's csv layout and their covariances [px^2] beside it.

    detector: name of ours that found them, written as part of the scorer. stated_length_m: whole
    length of the body; with it, the lengths seen are written as well, in metres.
    """
    scorer = f"{SCORER}.{detector}" if detector else SCORER
    names, n = keypoints.names, len(keypoints.time_s)
    cells = np.concatenate([keypoints.xy_px, keypoints.likelihood[..., None]], axis=2)
    with atomic_write(path) as temporary, temporary.open("w", encoding="utf-8") as out:
        out.write("scorer," + ",".join([scorer] * 3 * len(names)) + "\n")
        out.write("bodyparts," + ",".join(name for name in names for _ in range(3)) + "\n")
        out.write("coords," + ",".join(["x", "y", "likelihood"] * len(names)) + "\n")
        for i, row in enumerate(cells.reshape(n, -1)):
            out.write(",".join([str(i), *(f"{v:.6g}" if isfinite(v) else "" for v in row)]) + "\n")
    _write_covariance(covariance_path(path), keypoints, stated_length_m)


def _write_covariance(path: Path, keypoints: Keypoints, stated_length_m: float | None) -> None:
    columns = {"time_s": keypoints.time_s}
    for k, name in enumerate(keypoints.names):
        columns |= {
            f"{name}_{pair}": keypoints.cov_px2[:, k, i, j] for pair, i, j in COVARIANCE_ENTRIES
        }
    if keypoints.length_seen is not None and stated_length_m is not None:
        columns[WHOLE_LENGTH_COLUMN] = keypoints.length_seen * stated_length_m
    write_columns(path, columns)


def _with_stored_covariance(
    found: Keypoints, path: Path, stated_length_m: float | None
) -> Keypoints:
    """Keypoints with times, covariances and whole lengths of the sidecar, row by row."""
    names = [f"{name}_{pair}" for name in found.names for pair, _, _ in COVARIANCE_ENTRIES]
    columns = read_columns(path, ("time_s", *names))
    if len(columns["time_s"]) != len(found.time_s):
        rows = f"{len(columns['time_s'])} rows"
        raise input_error(path, "", rows, f"{len(found.time_s)} rows, as the keypoints")
    cov = np.empty_like(found.cov_px2)
    for k, name in enumerate(found.names):
        for pair, i, j in COVARIANCE_ENTRIES:
            cov[:, k, i, j] = cov[:, k, j, i] = columns[f"{name}_{pair}"]
    seen_m = columns.get(WHOLE_LENGTH_COLUMN)
    lengths = None if seen_m is None or stated_length_m is None else seen_m / stated_length_m
    return replace(found, time_s=columns["time_s"], cov_px2=cov, length_seen=lengths)
