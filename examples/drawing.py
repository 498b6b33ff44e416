"""Figures of the recordings: one look, written whole."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bluekoi.figures.drawing.style import AFTER, BEFORE, COLOURS, MEASURED, RC_PARAMS
from bluekoi.files import whole_file

__all__ = ["AFTER", "BEFORE", "COLOURS", "MEASURED", "write"]


def write(path: Path, draw: Callable[[], Figure]) -> None:
    """The figure that `draw` makes, as png."""
    with matplotlib.rc_context(RC_PARAMS):
        figure = draw()
        FigureCanvasAgg(figure)
        with whole_file(path) as temporary:
            figure.savefig(temporary, format="png", dpi=130, metadata={"Software": None})
