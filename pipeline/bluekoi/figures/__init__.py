"""Figures of a campaign, one file each; the folder is the registry.

A figure module has FIGURE_TITLE, FIGURE_CAPTION (text for the report), REQUIRED_RESULTS (fields of
`Campaign` without which nothing can be drawn) and `render_figure(campaign) -> Figure`. A module
whose text depends on the campaign also has `title_and_caption(campaign)`; one that may have
nothing to draw also has `reason_unavailable(campaign)`, the reason or an empty string. Code shared
by several figures is in `drawing`.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..errors import did_you_mean, input_error
from ..files import atomic_write, write_rows
from .drawing.figure_data import DrawnPoint, extract_points
from .drawing.style import RC_PARAMS, placeholder_figure

if TYPE_CHECKING:
    from ..campaign import Campaign

__all__ = [
    "draw",
    "figure_caption",
    "figure_names",
    "figure_title",
    "missing_results",
    "write_figure_files",
]

RESULT_DESCRIPTIONS = {
    "tracks": "tracks of the trials",
    "steady": "steady speeds and radii",
    "coefficients": "fitted coefficients",
    "simulations": "simulated paths",
    "geometry": "geometry check (geometry.json)",
    "mismatch": "search for causes of the mismatch (mismatch.json)",
    "mismatch_detail": "details of the search for causes (mismatch_detail.json)",
}
"""Result that a figure may need -> its name in a message."""
PNG_DPI = 150
LAYOUT_DECIMALS = 9
"""Decimals of the positions of axes, in widths and heights of the figure."""
PNG_METADATA: Mapping[str, Any] = {"Software": None}
"""Metadata of a file, without dates: the same results give the same bytes."""
PDF_METADATA: Mapping[str, Any] = {
    "CreationDate": None,
    "ModDate": None,
    "Creator": None,
    "Producer": None,
}


def figure_names() -> tuple[str, ...]:
    """Names of all figures: the modules of this folder, in alphabetical order."""
    found = (m.name for m in pkgutil.iter_modules(__path__) if not m.ispkg)
    return tuple(sorted(found))


def figure_title(name: str, campaign: Campaign | None = None) -> str:
    """Title of a figure, adapted to the campaign if one is given."""
    return _title_and_caption(name, campaign)[0]


def figure_caption(name: str, campaign: Campaign | None = None) -> str:
    """Caption of a figure, adapted to the campaign if one is given."""
    return _title_and_caption(name, campaign)[1]


def _title_and_caption(name: str, campaign: Campaign | None) -> tuple[str, str]:
    module = _figure_module(name)
    if campaign is not None and hasattr(module, "title_and_caption"):
        heading, text = module.title_and_caption(campaign)
        return str(heading), str(text)
    return str(module.FIGURE_TITLE), str(module.FIGURE_CAPTION)


def missing_results(name: str, campaign: Campaign) -> tuple[str, ...]:
    """Descriptions of the results that the figure needs and the campaign lacks."""
    needs = _figure_module(name).REQUIRED_RESULTS
    return tuple(RESULT_DESCRIPTIONS[need] for need in needs if not getattr(campaign, need))


def draw(name: str, campaign: Campaign) -> Figure:
    """The figure, or a placeholder that names the missing results."""
    with matplotlib.rc_context(RC_PARAMS):
        if reason := _missing_results_text(name, campaign):
            return placeholder_figure(figure_title(name, campaign), f"Not drawn: {reason}")
        figure: Figure = _figure_module(name).render_figure(campaign)
        return figure


def write_figure_files(
    name: str, campaign: Campaign, path_png: str | Path, path_pdf: str | Path
) -> None:
    """Write a figure as png, vector pdf and csv (beside the png); deterministic.

    The png carries title and caption as metadata, and in `Comment` the results that were missing.
    """
    figure = draw(name, campaign)
    metadata = {
        "Title": figure_title(name, campaign),
        "Description": figure_caption(name, campaign),
    }
    if reason := _missing_results_text(name, campaign):
        metadata["Comment"] = reason
    with matplotlib.rc_context(RC_PARAMS):
        _save_figure(figure, Path(path_png), Path(path_pdf), metadata)
    write_rows(Path(path_png).with_suffix(".csv"), [DrawnPoint._fields, *extract_points(figure)])


def _save_figure(
    figure: Figure, path_png: Path, path_pdf: Path, metadata: Mapping[str, str]
) -> None:
    """Write a figure as png and pdf, laid out once.

    `Figure.savefig` lays out and draws twice for each file, which takes twice as long.
    """
    from matplotlib.backends.backend_pdf import FigureCanvasPdf  # noqa: PLC0415  no png needs it

    figure.set_dpi(PNG_DPI)
    _lay_out(figure)
    with atomic_write(path_png) as temporary:
        FigureCanvasAgg(figure).print_png(temporary, metadata={**PNG_METADATA, **metadata})
    with atomic_write(path_pdf) as temporary:
        FigureCanvasPdf(figure).print_pdf(temporary, metadata=dict(PDF_METADATA))


def _lay_out(figure: Figure) -> None:
    """Lay out the figure once, with the positions of its axes rounded to `LAYOUT_DECIMALS`.

    The order in which the layout's equations are solved depends on addresses in memory, and with it
    the last digit of the positions.
    """
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, LAYOUT_DECIMALS))


def _missing_results_text(name: str, campaign: Campaign) -> str:
    """Why the figure cannot be drawn; empty if it can."""
    if lacking := missing_results(name, campaign):
        return "this run has no " + " and no ".join(lacking)
    module = _figure_module(name)
    return str(module.reason_unavailable(campaign)) if hasattr(module, "reason_unavailable") else ""


def _figure_module(name: str) -> ModuleType:
    if name not in figure_names():
        raise input_error(
            "figures", "", f"'{name}'", "the name of a figure", did_you_mean(name, figure_names())
        )
    return import_module(f"{__name__}.{name}")
