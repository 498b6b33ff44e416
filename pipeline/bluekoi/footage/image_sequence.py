"""Pictures in files as a recording at a stated frame rate, numbered as their file names are."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import compress
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from ..data import Frame
from ..errors import input_error
from ..study.image_files import IMAGE_SUFFIXES
from .picture_sizes import picture_size_px, unused_picture_remarks
from .recording import IMAGE_SEQUENCE_CODEC, Recording

RecordedPixels = npt.NDArray[np.uint8]
MIN_SHARE_OF_NUMBERED_FRAMES = 0.5
"""Numbers in file names count frames if so many of the frames between the first and the last are
there; otherwise (times of day, for example) the pictures follow each other."""
MAX_FILE_NUMBER_DIGITS = 12
"""Digits of a number in a file name that are read, its last ones."""


def all_are_images(paths: Sequence[Path]) -> bool:
    """Whether all files of a recording are pictures."""
    return bool(paths) and all(path.suffix.lower() in IMAGE_SUFFIXES for path in paths)


def open_image_sequence(
    paths: Sequence[Path], *, fps: float | None, start_s: float | None, end_s: float | None
) -> Recording:
    """Recording of pictures in the order given, without those of another size than most.

    Only the first one used is decoded; of the others the headers are read.

    Raises: InputError where a file is missing, the first cannot be read, or no rate is stated.
    """
    if missing := [path for path in paths if not path.is_file()]:
        raise input_error(missing[0], "", "no such file", "a picture")
    if fps is None:
        raise input_error(paths[0], "fps", "nothing", "the frame rate of the pictures",
                          "State fps in trials.csv.")  # fmt: skip
    sizes = [picture_size_px(path) for path in paths]
    usable, unused_remarks = unused_picture_remarks(paths, sizes)
    first = _read_image(paths[usable.index(True)], colour=False) if sizes[0] else None
    if first is None:
        raise input_error(paths[0], "", "no readable picture", "png, jpg, tif or bmp",
                          "Check that the copy is complete.")  # fmt: skip
    numbers = frame_numbers_from_file_names(paths)
    count = numbers[-1] + 1
    if start_s is not None and start_s >= count / fps:
        raise input_error(paths[0], "start_s", f"{start_s:g} s in {count / fps:.2f} s",
                          "a start inside the recording")  # fmt: skip
    return Recording(
        paths=tuple(compress(paths, usable)),
        size_px=(first.shape[1], first.shape[0]),
        codec=IMAGE_SEQUENCE_CODEC,
        frames_declared=count,
        frames_present=count,
        nominal_fps=fps,
        offset_s=(0.0,) * sum(usable),
        fps=fps,
        start_s=start_s,
        end_s=end_s,
        remarks=(*_missing_picture_remarks(paths, numbers), *unused_remarks),
        picture_numbers=tuple(compress(numbers, usable)),
    )


def frame_numbers_from_file_names(paths: Sequence[Path]) -> tuple[int, ...]:
    """Number of the frame that each picture is, the first one 0, by the last number in the names.

    A step that all numbers share (every tenth frame) counts as one frame. Names without numbers,
    with another order, or with numbers that leave out more than half of the frames: 0, 1, 2, ...
    """
    in_order = tuple(range(len(paths)))
    found = [re.findall(r"\d+", path.stem) for path in paths]
    if len(paths) < 2 or not all(found):
        return in_order
    steps = np.diff(np.array([int(digits[-1][-MAX_FILE_NUMBER_DIGITS:]) for digits in found]))
    if steps.min() <= 0:
        return in_order
    steps //= np.gcd.reduce(steps)
    if len(paths) < MIN_SHARE_OF_NUMBERED_FRAMES * (steps.sum() + 1):
        return in_order
    return (0, *np.cumsum(steps).tolist())


def _missing_picture_remarks(paths: Sequence[Path], numbers: Sequence[int]) -> tuple[str, ...]:
    """A sentence where pictures are missing between others."""
    missing = numbers[-1] + 1 - len(numbers)
    if not missing:
        return ()
    last = int(np.argmax(np.diff(numbers)))
    return (
        f"{missing} pictures of {numbers[-1] + 1} are missing from the folder, by the numbers in "
        f"their names, most of them between {paths[last].name} and {paths[last + 1].name}; these "
        "frames count as lost",
    )


def image_sequence_frames(
    recording: Recording, *, colour: bool, count: int | None = None,
    bgr_size: tuple[int, int] | None = None,
) -> Iterator[Frame]:  # fmt: skip
    """Frames of the recording's part; `count` of them spread evenly, or all; see `frames`.

    Pictures that cannot be read are left out.
    """
    wanted = [i for i in range(len(recording.paths)) if _lies_in_wanted_part(recording, i)]
    if count is not None and len(wanted) > count:
        wanted = [wanted[i] for i in np.linspace(0, len(wanted) - 1, count).round().astype(int)]
    for frame in _read_image_frames(recording, wanted, colour=colour):
        if frame.bgr is not None and bgr_size:
            small = cv2.resize(frame.bgr, bgr_size, interpolation=cv2.INTER_AREA)
            frame = replace(frame, bgr=np.asarray(small, np.uint8))  # noqa: PLW2901
        yield frame


def _lies_in_wanted_part(recording: Recording, index: int) -> bool:
    time_s = recording.picture_numbers[index] / recording.nominal_fps
    end_s = np.inf if recording.end_s is None else recording.end_s
    return bool((recording.start_s or 0.0) - 1e-6 <= time_s <= end_s + 1e-6)


def _read_image_frames(
    recording: Recording, indexes: Iterable[int], *, colour: bool
) -> Iterator[Frame]:
    width, height = recording.size_px
    for i in indexes:
        picture = _read_image(recording.paths[i], colour=colour)
        if picture is None or picture.shape[:2] != (height, width):
            continue
        luma = (
            np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8) if colour else picture
        )
        number = recording.picture_numbers[i]
        yield Frame(number, number / recording.nominal_fps, luma, picture if colour else None)


def _read_image(path: Path, *, colour: bool) -> RecordedPixels | None:
    """A picture, (height, width) or (height, width, 3) bgr, 8 bit; None where it cannot be read."""
    found = cv2.imread(str(path), cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE)
    return None if found is None else np.asarray(found, dtype=np.uint8)
