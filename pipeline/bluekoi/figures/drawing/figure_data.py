"""Data of a drawn figure as a table: the source of csv files and of interactive versions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver

from ...data import Float

NumberOrCategory = float | str
"""A value, or the name of a category."""


class DrawnPoint(NamedTuple):
    """One drawn point.

    kind: line, dashed line, points, band (low to high) or bar; value: colour of a point. trial_id:
    trial that the artist belongs to (its matplotlib gid), else empty.
    """

    panel: int
    title: str
    x_label: str
    y_label: str
    equal_scales: bool
    kind: str
    series: str
    trial_id: str
    colour: str
    artist: int
    x: NumberOrCategory
    y: NumberOrCategory
    low: NumberOrCategory = ""
    high: NumberOrCategory = ""
    value: NumberOrCategory = ""


def extract_points(figure: Figure) -> list[DrawnPoint]:
    """All data points of a figure in drawing order; colour bars and annotations are skipped."""
    names = {
        _line_colour_and_style(handle): str(handle.get_label())
        for legend in figure.legends
        for handle in legend.legend_handles
        if isinstance(handle, Line2D)
    }
    every = [inner for axes in figure.axes for inner in (axes, *axes.child_axes)]
    panels = [a for a in every if isinstance(a, Axes) and a.get_label() != "<colorbar>"]
    return [point for i, axes in enumerate(panels) for point in _points_of_panel(i, axes, names)]


def _points_of_panel(number: int, axes: Axes, names: dict[Any, str]) -> Iterator[DrawnPoint]:
    x_label = _axis_label(axes, axes.get_shared_x_axes().get_siblings(axes), "get_xlabel")
    y_label = _axis_label(axes, axes.get_shared_y_axes().get_siblings(axes), "get_ylabel")
    head = (number, axes.get_title(), x_label, y_label, axes.get_aspect() == 1.0)
    bars = {id(line) for c in axes.containers if isinstance(c, ErrorbarContainer)
            for line in (c.lines[0], *c.lines[1])}  # fmt: skip
    found = [
        *(
            _band_points(c)
            for c in axes.collections
            if isinstance(c, PolyCollection) and not isinstance(c, Quiver)
        ),
        *(_arrow_points(c) for c in axes.collections if isinstance(c, Quiver)),
        *(_coloured_line_points(c) for c in axes.collections if isinstance(c, LineCollection)),
        *(_mesh_points(c) for c in axes.collections if isinstance(c, QuadMesh)),
        *(_line_points(axes, line, names) for line in axes.lines if id(line) not in bars),
        *(_errorbar_points(c) for c in axes.containers if isinstance(c, ErrorbarContainer)),
        *(_bar_points(axes, c) for c in axes.containers if isinstance(c, BarContainer)),
    ]
    for artist, (kind, series, trial_id, colour, rows) in enumerate(found):
        name = "" if series.startswith("_") else series
        for row in rows:
            yield DrawnPoint(
                *head, kind, name, trial_id, colour, artist, *map(_round_to_five_digits, row)
            )


def _axis_label(axes: Axes, siblings: Iterable[Any], get: str) -> str:
    """Label of an axis, of an axis that it is shared with, or of the whole figure."""
    labels = (str(getattr(one, get)()) for one in (axes, *siblings))
    shared = getattr(axes.figure, get.replace("_", "_sup"))()  # supxlabel of the figure
    return next((label for label in labels if label), str(shared))


ArtistPoints = tuple[str, str, str, str, Iterable[Sequence[Any]]]


def _line_points(axes: Axes, line: Line2D, names: dict[Any, str]) -> ArtistPoints:
    x, y = _line_xy(line)
    in_data = line.get_transform().contains_branch_seperately(axes.transData)
    if not in_data[0]:  # axhline: x in fractions of the axis
        low, high = axes.get_xlim()
        x = low + x * (high - low)
    if not in_data[1]:
        low, high = axes.get_ylim()
        y = low + y * (high - low)
    kind = "line" if line.get_linestyle() == "-" else "dashed line"
    if line.get_linestyle() in ("None", "", " ") or len(x) == 1:
        kind = "points"
    label = str(line.get_label())
    label = names.get(_line_colour_and_style(line), label) if label.startswith("_") else label
    return (
        kind,
        label,
        str(line.get_gid() or ""),
        _hex_colour(line.get_color()),
        zip(x, y, strict=True),
    )


def _errorbar_points(bars: ErrorbarContainer) -> ArtistPoints:
    line, _, collections = bars.lines
    x, y = _line_xy(line)
    ends = np.array([np.asarray(s)[:, 1] for c in collections for s in c.get_segments()])
    low, high = ends.T if ends.shape == (len(x), 2) else (np.full(len(x), np.nan),) * 2
    rows = zip(x, y, low, high, strict=True)
    return (
        "points",
        str(bars.get_label()),
        str(line.get_gid() or ""),
        _hex_colour(line.get_color()),
        rows,
    )


def _bar_points(axes: Axes, bars: BarContainer) -> ArtistPoints:
    horizontal = bars.orientation == "horizontal"
    axis = axes.yaxis if horizontal else axes.xaxis
    names = {round(at, 6): text.get_text() for at, text in
             zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)}  # fmt: skip
    rows: list[tuple[NumberOrCategory, NumberOrCategory]] = []
    for bar in bars.patches:
        box = bar.get_bbox()
        at = round(0.5 * (box.y0 + box.y1 if horizontal else box.x0 + box.x1), 6)
        size = box.width if horizontal else box.height
        rows.append(
            (size, names.get(at, str(at))) if horizontal else (names.get(at, str(at)), size)
        )
    return "bar", str(bars.get_label()), "", _hex_colour_of_drawn_bar(bars.patches[0]), rows


def _hex_colour_of_drawn_bar(bar: Rectangle) -> str:
    """Colour of a bar; of a hollow one, that of its edge."""
    face = _hex_colour(bar.get_facecolor())
    return _hex_colour(bar.get_edgecolor()) if face == "#ffffff" else face


def _band_points(shape: PolyCollection) -> ArtistPoints:
    rows = []
    for path in shape.get_paths():
        x, y = np.asarray(path.vertices).T
        at, place = np.unique(x, return_inverse=True)
        for k, one in enumerate(at):
            low, high = float(y[place == k].min()), float(y[place == k].max())
            rows.append((one, 0.5 * (low + high), low, high))
    colours = shape.get_facecolor()
    return "band", str(shape.get_label()), "", _hex_colour(colours[0]), rows


def _arrow_points(arrows: Quiver) -> ArtistPoints:
    """Arrows with angles and scale_units "xy" as lines with gaps between them."""
    start = np.asarray(arrows.XY)
    end = start + np.column_stack([arrows.U, arrows.V]) / float(arrows.scale or 1.0)
    rows = (row for a, b in zip(start, end, strict=True) for row in (a, b, ("", "")))
    return "line", str(arrows.get_label()), "", _hex_colour(arrows.get_facecolor()[0]), rows


def _coloured_line_points(lines: LineCollection) -> ArtistPoints:
    values = lines.get_array()
    segments = [] if values is None else lines.get_segments()  # error bars have no values
    middles = [np.asarray(s).mean(axis=0) for s in segments]
    rows = [
        (*xy, "", "", float(v))
        for xy, v in zip(middles, np.ravel(np.asarray(values)), strict=False)
    ]
    return "points", str(lines.get_label()), str(lines.get_gid() or ""), "", rows


def _mesh_points(mesh: QuadMesh) -> ArtistPoints:
    corners = np.asarray(mesh.get_coordinates())
    centres = 0.25 * (corners[1:, 1:] + corners[:-1, 1:] + corners[1:, :-1] + corners[:-1, :-1])
    values: Float = np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan).ravel()
    rows = [(x, y, "", "", v) for (x, y), v in
            zip(centres.reshape(-1, 2), values, strict=True) if np.isfinite(v)]  # fmt: skip
    return "points", str(mesh.get_label()), "", "", rows


def _line_xy(line: Line2D) -> tuple[Float, Float]:
    x, y = (np.atleast_1d(np.asarray(v, dtype=float)) for v in line.get_data())
    return x, y


def _line_colour_and_style(line: Line2D) -> tuple[str, str]:
    return _hex_colour(line.get_color()), str(line.get_linestyle())


def _hex_colour(colour: Any) -> str:
    return str(to_hex(colour))


def _round_to_five_digits(value: Any) -> NumberOrCategory:
    """Value with five significant digits; empty for NaN."""
    if isinstance(value, str):
        return value
    return float(f"{float(value):.5g}") if np.isfinite(value) else ""
