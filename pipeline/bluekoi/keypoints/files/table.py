"""One keypoint file as a table, and what of it makes the keypoints of a trial."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...data import (
    BODY_PART_NAMES,
    MIN_KEYPOINT_LIKELIHOOD,
    BoolNDArray,
    Float,
    Keypoints,
    is_confident,
)
from ...errors import did_you_mean, input_error
from .noise import frame_to_frame_noise_std_px

IndividualAndPart = tuple[str, str]
MAX_COORDINATE_PX = 1e6
MAX_LIKELIHOOD = 2.0  # scores of some networks reach a little over 1
UNSEEN_BELOW_LIKELIHOOD = 0.1
"""Likelihood below which a point of a file was not seen."""
MAX_LOW_LIKELIHOOD_SHARE = 0.1
"""Share of the points left out for their low likelihood above which the trial carries a remark."""
LOW_LIKELIHOOD_POINTS_REMARK = (
    "{:.0f} % of the points are left out: their likelihood is from 0.1 to 0.6, while that of most "
    "points of the same part is higher"
)
MAX_GAP_FRAMES = 20_000
"""Frames that may be missing in one go: more than five minutes at 60 frames a second."""
RIGID_CORE_KEYPOINTS = ("hinge", "core_center", "tail_base")


@dataclass(frozen=True)
class Table:
    """Columns (individual, part), `individual` empty in files of one animal.

    frame: (rows,) frame numbers, increasing. xy_px: (rows, columns, 2), NaN where not seen.
    likelihood: (rows, columns).
    """

    columns: tuple[IndividualAndPart, ...]
    frame: Float
    xy_px: Float
    likelihood: Float
    remarks: tuple[str, ...] = ()


def build_table(
    path: Path,
    labels: Sequence[tuple[str, ...]],
    values: Float,
    frame: Float,
    lines: Sequence[int] | None = None,
) -> Table:
    """Table of raw columns: each label (individual, part, coordinate), values (rows, columns).

    lines: line number of each row in a file of text.

    Positions are taken by name, in whatever order the columns stand. A position that is missing,
    infinite, or 0, 0 is not seen, whatever likelihood the file gives it; a single 0, 0 of a part
    counts if it has a likelihood.

    Raises: InputError where a coordinate is missing or doubled, pixels are absurd, or likelihoods
    are percentages.
    """
    place = {label: i for i, label in enumerate(labels)}
    if len(place) < len(labels):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise input_error(
            path, "header", f"column {' '.join(twice).strip()} twice", "each column once"
        )
    columns = tuple(dict.fromkeys((who, part) for who, part, _ in labels))
    if not columns:
        raise input_error(path, "", "no tracked animal", "keypoints of the robot")
    for who, part in columns:
        if (who, part, "x") not in place or (who, part, "y") not in place:
            raise input_error(
                path, "header", f"part '{part}' without x or y", "columns x and y a part"
            )
    xy = np.stack([values[:, [place[(*c, "x")], place[(*c, "y")]]] for c in columns], axis=1)
    likelihood = np.ones(xy.shape[:2])
    for i, column in enumerate(columns):
        if (*column, "likelihood") in place:
            likelihood[:, i] = values[:, place[(*column, "likelihood")]]
    _check_coordinate_size(path, xy, lines)
    _check_likelihood(path, likelihood, lines)
    return Table(columns, frame, *_unseen_points_as_nan(xy, likelihood))


def _row_location(k: int, lines: Sequence[int] | None) -> str:
    """Where the k-th row stands: its line in a file of text, else its place among the rows."""
    return f"row {k + 1} of the table" if lines is None else f"row {lines[k]}"


def _check_coordinate_size(path: Path, xy: Float, lines: Sequence[int] | None) -> None:
    rows = np.nonzero(
        np.any(np.abs(xy) > MAX_COORDINATE_PX, axis=(1, 2)) & np.isfinite(xy).all((1, 2))
    )[0]
    if len(rows):
        k = int(rows[0])
        raise input_error(path, _row_location(k, lines), f"{np.abs(xy[k]).max():g}", "pixels")


def _check_likelihood(path: Path, likelihood: Float, lines: Sequence[int] | None) -> None:
    rows = np.nonzero(np.nan_to_num(likelihood, posinf=0.0).max(axis=1) > MAX_LIKELIHOOD)[0]
    if len(rows):
        k = int(rows[0])
        found = f"a likelihood of {np.nanmax(likelihood[k]):g}"
        raise input_error(
            path, _row_location(k, lines), found, "0 to 1", "Divide percentages by 100."
        )


def _unseen_points_as_nan(xy: Float, likelihood: Float) -> tuple[Float, Float]:
    zero = np.all(xy == 0.0, axis=2)
    empty = zero & ((likelihood == 0.0) | (zero.sum(axis=0) > 1))
    seen = np.isfinite(xy).all(axis=2) & ~empty
    xy = np.where(seen[..., None], xy, np.nan)
    certain = np.clip(np.nan_to_num(likelihood, nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
    return xy, np.where(seen, certain, 0.0)


def frame_numbers(index: Sequence[str], path: Path, lines: Sequence[int] | None = None) -> Float:
    """Frame numbers of an index of numbers or of picture paths; the row's place where neither.

    Picture paths count by the last number in their name, if that number grows from row to row.
    lines: see `build_table`.

    Raises: InputError where plain numbers do not grow (rows doubled, or in another order), are no
    whole numbers, or leave a gap that no recording has.
    """
    try:
        numbers = np.array([float(text) for text in index])
    except ValueError:
        found = [re.findall(r"\d+", re.split(r"[\\/]", text)[-1]) for text in index]
        numbers = np.array([float(f[-1]) if f else np.nan for f in found])
    else:
        _check_frame_numbers(path, numbers, lines)
    if len(numbers) and np.all(np.isfinite(numbers)) and np.all(np.diff(numbers) > 0):
        return numbers
    return np.arange(len(index), dtype=float)


def _check_frame_numbers(path: Path, numbers: Float, lines: Sequence[int] | None) -> None:
    odd = np.flatnonzero((numbers < 0) | (numbers != np.round(numbers)))
    if len(odd):
        k = int(odd[0])
        raise input_error(path, _row_location(k, lines), f"frame {numbers[k]:g}",
                    "whole numbers from 0 on in the first column")  # fmt: skip
    wide = np.flatnonzero(np.diff(numbers) > MAX_GAP_FRAMES)
    if len(wide):
        k = int(wide[0])
        raise input_error(
            path, _row_location(k + 1, lines),
            f"frame {numbers[k + 1]:.0f} after {numbers[k]:.0f}",
            f"frames of one trial, at most {MAX_GAP_FRAMES} missing between two of them",
            "Is the frame number a slip of the pen?",
        )  # fmt: skip
    back = np.flatnonzero(np.diff(numbers) <= 0)
    if len(back):
        k = int(back[0])
        raise input_error(
            path, _row_location(k + 1, lines), f"frame {numbers[k + 1]:g} after {numbers[k]:g}",
            "frame numbers that grow from row to row",
            "Sort the rows by their first column and leave each frame once.",
        )  # fmt: skip


def to_keypoints(
    table: Table,
    path: Path,
    *,
    fps: float,
    bodyparts: Mapping[str, str] | None = None,
    part_s: tuple[float | None, float | None] = (None, None),
    min_likelihood: float = UNSEEN_BELOW_LIKELIHOOD,
) -> Keypoints:
    """Keypoints of the robot in a table, under our names, times = frame / fps.

    `bodyparts` maps our part to the file's name (`individual/part` where several animals are
    meant). Covariances are the white noise of the positions themselves (`noise.py`). Points of
    `min_likelihood` or more that are not confident count at the limit of confidence where most
    points of a part are such ones: its network gives low values. Elsewhere they are left out, since
    a network gives such values to points that it confuses.

    Raises: InputError where head direction or core centre cannot be had from the parts there are.
    """
    wanted = {part: (bodyparts or {}).get(part, part) for part in BODY_PART_NAMES}
    who, remarks = _most_seen_individual(table, wanted)
    found = ((part, _column_index(table, who, name)) for part, name in wanted.items())
    chosen = {part: i for part, i in found if i is not None}
    _check_required_parts(path, table, chosen, wanted)
    time_s = table.frame / fps
    start, end = part_s
    inside = (time_s >= (start or 0.0) - 1e-9) & (time_s <= (np.inf if end is None else end) + 1e-9)
    order = list(chosen.values())
    xy, likelihood = table.xy_px[inside][:, order], table.likelihood[inside][:, order]
    likelihood = np.where(
        _accepted_low_likelihood_points(likelihood, min_likelihood),
        MIN_KEYPOINT_LIKELIHOOD,
        likelihood,
    )
    variance = np.array(
        [frame_to_frame_noise_std_px(xy[:, i], likelihood[:, i]) ** 2 for i in range(len(order))]
    )
    cov = np.where(np.isfinite(xy[..., :1, None]), variance[:, None, None] * np.eye(2), np.nan)
    left_out = (likelihood >= min_likelihood) & ~is_confident(likelihood)
    if left_out.sum() > MAX_LOW_LIKELIHOOD_SHARE * left_out.size:
        remarks = (*remarks, LOW_LIKELIHOOD_POINTS_REMARK.format(100 * left_out.mean()))
    remarks = (*table.remarks, *remarks)
    return Keypoints(time_s[inside], tuple(chosen), xy, likelihood, cov, remarks)


def _accepted_low_likelihood_points(likelihood: Float, min_likelihood: float) -> BoolNDArray:
    """Where points (frames, parts) count although they are not confident."""
    uncertain = (likelihood >= min_likelihood) & ~is_confident(likelihood)
    most = 2 * uncertain.sum(axis=0) > (likelihood >= min_likelihood).sum(axis=0)
    return np.asarray(uncertain & most)


def _most_seen_individual(table: Table, wanted: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """The animal that carries the wanted parts and is seen most, and a remark on the others."""
    score: dict[str, int] = {}
    for i, (who, part) in enumerate(table.columns):
        if part in wanted.values() or f"{who}/{part}" in wanted.values():
            score[who] = score.get(who, 0) + int(np.isfinite(table.xy_px[:, i, 0]).sum())
    if not score:
        return "", ()
    best = max(score, key=lambda who: score[who])
    others = sorted(who for who in score if who != best and score[who] > 0)
    if not others:
        return best, ()
    return best, (f"'{best}' is taken as the robot; not used: {', '.join(others)}",)


def _column_index(table: Table, who: str, name: str) -> int | None:
    for i, (owner, part) in enumerate(table.columns):
        if f"{owner}/{part}" == name or (part == name and owner in (who, "", "single")):
            return i
    return None


def _check_required_parts(
    path: Path, table: Table, chosen: Mapping[str, object], wanted: Mapping[str, str]
) -> None:
    core = [part for part in RIGID_CORE_KEYPOINTS if part in chosen]
    if "head_tip" in chosen and len(core) >= 2:
        return
    names = sorted({part for _, part in table.columns})
    missing = [wanted[part] for part in ("head_tip", *RIGID_CORE_KEYPOINTS) if part not in chosen]
    raise input_error(
        path,
        "bodyparts",
        f"no {', '.join(missing)} among {', '.join(names)}"[:400],
        "head_tip and two of hinge, core_center, tail_base",
        f"{did_you_mean(missing[0], names)} Map our names to the file's under bodyparts: in "
        f"study.yaml.",
    )
