"""Figures of the recordings: one look, written whole."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pipeline.figures.drawing.look import AFTER, BEFORE, COLOURS, LOOK, MEASURED
from pipeline.files import whole_file

__all__ = ["AFTER", "BEFORE", "COLOURS", "MEASURED", "write"]


def write(path: Path, draw: Callable[[], Figure]) -> None:
    """The figure that `draw` makes, as png."""
    with matplotlib.rc_context(LOOK):
        figure = draw()
        FigureCanvasAgg(figure)
        with whole_file(path) as temporary:
            figure.savefig(temporary, format="png", dpi=130, metadata={"Software": None})
