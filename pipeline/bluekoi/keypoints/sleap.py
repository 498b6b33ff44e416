"""Keypoints from SLEAP's analysis h5: tracks (tracks, 2, nodes, frames), node_names, scores."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from ..data import Keypoints
from ..errors import input_error
from ..study import Trial
from .files.safe_h5 import member, open_h5, strings
from .files.table import Table, assemble, to_keypoints


def is_sleap(path: Path) -> bool:
    """Whether a file is a SLEAP analysis h5."""
    try:
        with h5py.File(path, "r") as file:
            return "tracks" in file and "node_names" in file
    except (OSError, RuntimeError, ValueError):
        return False


def read(path: Path, trial: Trial, bodyparts: Mapping[str, str] | None = None) -> Keypoints:
    """Keypoints of a trial from a SLEAP analysis h5, times = frame / trial.fps.

    Raises: InputError where the file is no such h5, is damaged, or lacks parts.
    """
    fps = trial.fps or 30.0
    part_s = (trial.start_s, trial.end_s)
    return to_keypoints(read_table(path), path, fps=fps, bodyparts=bodyparts, part_s=part_s)


def read_table(path: Path) -> Table:
    """Table of a SLEAP analysis h5, each track an individual."""
    with open_h5(path) as file:
        tracks, nodes = member(file, "tracks"), member(file, "node_names")
        if tracks is None or nodes is None:
            raise input_error(path, "", "no tracks and node_names", "a SLEAP analysis h5")
        names = strings(nodes)
        if tracks.ndim != 4 or tracks.shape[1] != 2 or tracks.shape[2] != len(names):
            found = f"tracks of shape {tracks.shape} for {len(names)} nodes"
            raise input_error(path, "tracks", found, "(tracks, 2, nodes, frames)")
        values = np.asarray(tracks[()], dtype=float)
        scores = _scores(member(file, "point_scores"), values)
        who = _owners(file, values.shape[0])
    if values.shape[3] == 0:
        raise input_error(path, "tracks", "no frames", "a frame at least")
    return _table(path, names, who, np.concatenate([values, scores[:, None]], axis=1))


def _scores(scores: object, values: np.ndarray) -> np.ndarray:
    shape = (values.shape[0], values.shape[2], values.shape[3])
    if scores is None or getattr(scores, "shape", None) != shape:
        return np.ones(shape)
    return np.asarray(scores[()], dtype=float)  # type: ignore[index]


def _owners(file: object, count: int) -> list[str]:
    names = member(file, "track_names")
    found = strings(names) if names is not None else []
    return found if len(set(found)) == count else [f"track_{i}" for i in range(count)]


def _table(path: Path, names: list[str], who: list[str], values: np.ndarray) -> Table:
    owners = [""] if len(who) == 1 else who
    coords = ("x", "y", "likelihood")
    labels = [(o, n, c) for o in owners for n in names for c in coords]
    columns = values.transpose(3, 0, 2, 1).reshape(values.shape[3], -1)
    return assemble(path, labels, columns, np.arange(len(columns), dtype=float))
