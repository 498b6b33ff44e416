"""Evenly spaced frames of a film whose length is known only at its end."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .types import Frame


def sample_evenly(film: Iterable[Frame], count: int) -> list[Frame]:
    """About `count` frames spread over a film that is run through once, their luma copied.

    Every k-th frame is kept, and k doubled when there are too many.
    """
    kept: list[Frame] = []
    step = 1
    for i, frame in enumerate(film):
        if i % step:
            continue
        kept.append(with_copied_luma(frame))
        if len(kept) > 2 * count:
            kept, step = kept[::2], step * 2
    places = np.unique(np.linspace(0, len(kept) - 1, min(count, len(kept))).round().astype(int))
    return [kept[i] for i in places] if kept else []


def with_copied_luma(frame: Frame) -> Frame:
    """The frame with a copy of its luma, which remains valid after the next frame is decoded."""
    return Frame(frame.index, frame.time_s, np.array(frame.luma))
