"""The pool without the robot: the median of a few pictures, and where the robot never left it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Frame, SeekableFilm, sample_evenly, with_copied_luma
from ...numba_settings import njit

LumaPicture = npt.NDArray[np.uint8]
ROWS_PER_STRIP = 32


def sample_frames(film: Iterable[Frame], count: int, at_most: int = 0) -> list[Frame]:
    """About `count` frames spread over a film, up to `at_most` where these cost no more; their luma
    copied.

    A `SeekableFilm` decodes those alone; another one is run through once.
    """
    if isinstance(film, SeekableFilm):
        return [with_copied_luma(frame) for frame in film.evenly_spaced(count, at_most)]
    return sample_evenly(film, max(count, at_most))


def median_image(images: Sequence[LumaPicture]) -> LumaPicture:
    """Median (height, width) of pictures, exact; the lower middle of an even number."""
    return grey_level_quantiles(images, 0.5)[0]


def grey_level_quantiles(images: Sequence[LumaPicture], *shares: float) -> npt.NDArray[np.uint8]:
    """Pictures (shares, height, width): the grey level of each pixel that ranks at each share.

    Worked out a strip of rows at a time: a stack of whole pictures would be memory that is new to
    the process, and getting it costs more than the ranking.
    """
    places = np.array([int(share * (len(images) - 1)) for share in shares])
    height, width = images[0].shape
    out = np.empty((len(shares), height, width), np.uint8)
    strip = np.empty((len(images), ROWS_PER_STRIP, width), np.uint8)
    for y in range(0, height, ROWS_PER_STRIP):
        rows = min(ROWS_PER_STRIP, height - y)
        for own, image in zip(strip, images, strict=True):
            own[:rows] = image[y : y + rows]
        out[:, y : y + rows] = _sort_along_first_axis(strip)[places, :rows]
    return out


@njit(cache=True)
def _sort_along_first_axis(stack: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """The stack (n, height, width) itself, sorted along its first axis.

    Odd-even transposition sort of whole rows: nothing but minima and maxima.
    """
    count, height, width = stack.shape
    for y in range(height):
        for turn in range(count):
            for k in range(turn % 2, count - 1, 2):
                low, high = stack[k, y], stack[k + 1, y]
                for x in range(width):
                    a, b = low[x], high[x]
                    low[x], high[x] = min(a, b), max(a, b)
    return stack


def noise_level(images: Sequence[LumaPicture], background: LumaPicture) -> float:
    """Usual deviation of a picture from the background, grey levels (robust, every 7th pixel)."""
    thin = background[::7, ::7].astype(np.int16)
    deviation = [np.median(np.abs(image[::7, ::7] - thin)) for image in images]
    return max(1.0, 1.4826 * float(np.median(deviation)))


def without_static_robot(background: LumaPicture, size_px: float) -> LumaPicture:
    """Background with what is dark or bright and as wide as the robot taken out of it.

    For a robot that hardly moves and so became part of the median: a closing (or opening, where
    that changes more) wider than the robot bridges it with its surroundings.
    """
    shrink = max(1, int(size_px / 12))
    small = cv2.resize(background, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    width = int(2 * round(size_px / shrink) + 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    filled = cv2.morphologyEx(cv2.medianBlur(small, 3), cv2.MORPH_CLOSE, disc)
    full = cv2.resize(filled, background.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.maximum(full, background)
