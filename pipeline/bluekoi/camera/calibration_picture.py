"""The picture of a calibration: where the corners lay and what error they left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ..files import atomic_write
from .image_circle import ImageCircle
from .lens_bundle_adjustment import rms_px
from .lens_selection import LensCandidate, board_tilts_deg

LONGEST_ARROW_SHARE_OF_WIDTH = 0.04
"""Length of the longest residual arrow over the width of the picture."""


def draw_calibration(
    path: str | Path, best: LensCandidate, candidates: list[LensCandidate],
    circle: ImageCircle | None = None,
) -> None:  # fmt: skip
    """Write a png: coverage and residual arrows, residual over radius, views, models compared."""
    figure = Figure(figsize=(13, 8), layout="constrained")
    axes = figure.subplots(2, 2, width_ratios=[1.6, 1])
    _draw_corners(axes[0, 0], best, circle)
    _draw_error_over_radius(axes[0, 1], best)
    _draw_error_by_view(axes[1, 0], best)
    _draw_model_comparison(axes[1, 1], candidates)
    figure.suptitle(
        f"{best.label}: {best.fit.rms_px:.3f} px rms, {best.held_out_px:.3f} px on held-out views"
    )
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=110, format="png")


def _draw_corners(axes: Axes, best: LensCandidate, circle: ImageCircle | None) -> None:
    points = np.concatenate([view.image_px for view in best.views])
    residuals = np.concatenate(best.fit.residuals)
    size = np.linalg.norm(residuals, axis=1)
    width, height = best.fit.lens.size_px
    gain = LONGEST_ARROW_SHARE_OF_WIDTH * width / max(1e-9, float(np.quantile(size, 0.99)))
    drawn = axes.quiver(
        *points.T, *(residuals.T * gain), size, angles="xy", scale_units="xy", scale=1, width=0.0015
    )
    axes.figure.colorbar(drawn, ax=axes, label="corner error, px")
    axes.plot(*best.fit.lens.matrix[:2, 2], "r+", markersize=12)
    if circle:
        axes.add_patch(Circle(circle.center_px, circle.radius_px, fill=False, color="grey"))
    axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", xlabel="u, px", ylabel="v, px")
    axes.set_title(f"corners found; arrows are errors times {gain:.0f}; cross: optical centre")


def _draw_error_over_radius(axes: Axes, best: LensCandidate) -> None:
    points = np.concatenate([view.image_px for view in best.views])
    residuals = np.concatenate(best.fit.residuals)
    outward = points - best.fit.lens.matrix[:2, 2]
    radius = np.linalg.norm(outward, axis=1)
    radial = np.sum(residuals * outward, axis=1) / np.maximum(radius, 1e-9)
    axes.plot(radius, radial, ".", markersize=2, alpha=0.4)
    edges = np.quantile(radius, np.linspace(0, 1, 13))
    bins = np.clip(np.searchsorted(edges, radius) - 1, 0, 11)
    means = [float(np.mean(radial[bins == i])) for i in range(12) if np.any(bins == i)]
    middles = [float(np.mean(radius[bins == i])) for i in range(12) if np.any(bins == i)]
    axes.plot(middles, means, "k-o", markersize=4)
    axes.axhline(0, color="grey", linewidth=0.8)
    axes.set(xlabel="distance from optical centre, px", ylabel="outward error, px")
    axes.set_title("residual of the lens model")


def _draw_error_by_view(axes: Axes, best: LensCandidate) -> None:
    errors = [rms_px([r]) for r in best.fit.residuals]
    places = np.arange(len(errors))
    axes.bar(places, errors)
    for place, tilt in zip(places, board_tilts_deg(best.fit.poses), strict=True):
        axes.text(float(place), 0, f"{tilt:.0f}°", ha="center", va="bottom", color="w", fontsize=6)
    axes.set_xticks(places, [view.name[-16:] for view in best.views], rotation=90, fontsize=6)
    axes.set(ylabel="error, px rms", title="views, with the board's tilt")


def _draw_model_comparison(axes: Axes, candidates: list[LensCandidate]) -> None:
    labels = [c.label + (" (refused)" if c.implausibilities else "") for c in candidates]
    places = np.arange(len(labels))
    finite = [c.held_out_px if np.isfinite(c.held_out_px) else 0.0 for c in candidates]
    axes.barh(places + 0.2, [c.fit.rms_px for c in candidates], height=0.4, label="used")
    axes.barh(places - 0.2, finite, height=0.4, label="held out")
    axes.set_yticks(places, labels, fontsize=8)
    axes.set(xlabel="corner error, px rms", title="models compared")
    axes.legend()
