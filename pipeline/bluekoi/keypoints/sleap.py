"""Keypoints from SLEAP: its analysis h5 with tracks (tracks, 2, nodes, frames), node_names and
scores; its own .slp through sleap-io, where that is installed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from ..data import Keypoints
from ..errors import InputError, input_error
from ..study import Trial
from .files.safe_h5 import h5_member_without_links, open_h5, read_h5_strings
from .files.table import Table, build_table, to_keypoints

EXPORT_REMEDY = (
    "Install SLEAP's reader (pip install sleap-io), or export the file in SLEAP (File, Export "
    "Analysis HDF5; or sleap-convert --format analysis) and give the .h5 file."
)


def is_sleap(path: Path) -> bool:
    """Whether a file is a SLEAP analysis h5."""
    try:
        with h5py.File(path, "r") as file:
            return "tracks" in file and "node_names" in file
    except (OSError, RuntimeError, ValueError):
        return False


def read_keypoints_of_trial(
    path: Path, trial: Trial, bodyparts: Mapping[str, str] | None = None
) -> Keypoints:
    """Keypoints of a trial from a SLEAP analysis h5, times = frame / trial.fps.

    Raises: InputError where the file is no such h5, is damaged, or lacks parts.
    """
    fps = trial.fps or 30.0
    part_s = (trial.start_s, trial.end_s)
    return to_keypoints(read_table(path), path, fps=fps, bodyparts=bodyparts, part_s=part_s)


def read_table(path: Path) -> Table:
    """Table of a SLEAP analysis h5, each track an individual."""
    with open_h5(path) as file:
        tracks, nodes = (
            h5_member_without_links(file, "tracks"),
            h5_member_without_links(file, "node_names"),
        )
        if tracks is None or nodes is None:
            raise input_error(path, "", "no tracks and node_names", "a SLEAP analysis h5")
        names = read_h5_strings(nodes)
        if tracks.ndim != 4 or tracks.shape[1] != 2 or tracks.shape[2] != len(names):
            found = f"tracks of shape {tracks.shape} for {len(names)} nodes"
            raise input_error(path, "tracks", found, "(tracks, 2, nodes, frames)")
        values = np.asarray(tracks[()], dtype=float)
        scores = _scores_in_file_or_ones(h5_member_without_links(file, "point_scores"), values)
        who = _track_names(file, values.shape[0])
    if values.shape[3] == 0:
        raise input_error(path, "tracks", "no frames", "a frame at least")
    return _table_of_array(path, names, who, np.concatenate([values, scores[:, None]], axis=1))


def read_slp(path: Path) -> Table:
    """Table of a .slp file of one video, each track an individual.

    Raises: InputError where sleap-io is not installed, the file cannot be read, or it labels
    several videos.
    """
    try:
        import sleap_io  # noqa: PLC0415  an optional dependency
    except ImportError as error:
        raise input_error(path, "", "a SLEAP project", "a reader for it", EXPORT_REMEDY) from error
    try:
        labels = sleap_io.load_slp(str(path), open_videos=False)
        videos, names = labels.videos, [str(name) for name in labels.skeleton.node_names]
        if len(videos) != 1:
            raise input_error(
                path, "videos", f"{len(videos)} videos", "one video a file", EXPORT_REMEDY
            )
        values = np.asarray(labels.numpy(video=videos[0], return_confidence=True), dtype=float)
        who = [track.name or f"track_{i}" for i, track in enumerate(labels.tracks)]
    except InputError:
        raise
    except Exception as error:  # whatever a foreign reader raises on a damaged file
        raise input_error(path, "", f"no readable SLEAP project ({error})", "a .slp file",
                          EXPORT_REMEDY) from error  # fmt: skip
    if values.shape[0] == 0:
        raise input_error(path, "", "no frames", "a frame at least")
    if len(who) != values.shape[1] or len(set(who)) < len(who):
        who = [f"track_{i}" for i in range(values.shape[1])]
    values[..., 2] = np.where(np.isfinite(values[..., 0]), _scores_or_ones(values[..., 2]), 0.0)
    return _table_of_array(path, names, who, values.transpose(1, 3, 2, 0))


def _scores_or_ones(scores: np.ndarray) -> np.ndarray:
    """Scores of points; 1 for those that a person placed, which have none."""
    return np.where(np.isfinite(scores), scores, 1.0)


def _scores_in_file_or_ones(scores: object, values: np.ndarray) -> np.ndarray:
    shape = (values.shape[0], values.shape[2], values.shape[3])
    if scores is None or getattr(scores, "shape", None) != shape:
        return np.ones(shape)
    return np.asarray(scores[()], dtype=float)  # type: ignore[index]


def _track_names(file: object, count: int) -> list[str]:
    names = h5_member_without_links(file, "track_names")
    found = read_h5_strings(names) if names is not None else []
    return found if len(set(found)) == count else [f"track_{i}" for i in range(count)]


def _table_of_array(path: Path, names: list[str], who: list[str], values: np.ndarray) -> Table:
    owners = [""] if len(who) == 1 else who
    coords = ("x", "y", "likelihood")
    labels = [(o, n, c) for o in owners for n in names for c in coords]
    columns = values.transpose(3, 0, 2, 1).reshape(values.shape[3], -1)
    return build_table(path, labels, columns, np.arange(len(columns), dtype=float))
