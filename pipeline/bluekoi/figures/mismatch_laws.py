"""Estimated law of each cause over its own variable, with its band."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..campaign import Campaign
from .drawing.missing_force import FORCE_NAMES, VARIABLE_LABELS
from .drawing.style import AFTER_COLOUR, panel_letter

FIGURE_TITLE = "Estimated law of each cause"
FIGURE_CAPTION = (
    "Force or moment of each identified cause over the variable that it depends on most, averaged "
    "over bins of about equal count, with the 95 % band of its parameters. Dots, one for each "
    "eighth of a trial: partial residuals, that is the force which the model with all causes still "
    "lacks plus the force of this cause. Crosses: the force of the cause in the same parts, which "
    "leaves the line where it also depends on another variable. Where dots leave their crosses "
    "beyond their scatter, the form of the law is wrong."
)
REQUIRED_RESULTS = ("mismatch",)
PANELS_PER_ROW = 3


def reason_unavailable(campaign: Campaign) -> str:
    """Why there is nothing to draw; empty if a cause has a law."""
    return "" if drawable_laws_by_cause(campaign) else "the search reports no law of a cause"


def drawable_laws_by_cause(campaign: Campaign) -> dict[str, Mapping[str, Any]]:
    """Name of a cause -> its law, for causes whose law has as many forces y as values x."""
    causes = (campaign.mismatch or {}).get("causes") or []
    found = {str(cause["name"]): cause.get("law") or {} for cause in causes}
    return {
        name: law
        for name, law in found.items()
        if law.get("x") and len(law["x"]) == len(law.get("y") or ())
    }


def render_figure(campaign: Campaign) -> Figure:
    """A panel for each cause with a law."""
    found = drawable_laws_by_cause(campaign)
    residuals = (campaign.mismatch_detail or {}).get("partial_residuals") or {}
    rows = -(-len(found) // PANELS_PER_ROW)
    columns = min(PANELS_PER_ROW, len(found))
    figure = Figure(figsize=(4.2 * columns + 0.6, 3.4 * rows), layout="constrained")
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for i, (axes, (name, law)) in enumerate(zip(panels, found.items(), strict=False)):
        panel_letter(axes, "ABCDEFGHI"[i % 9])
        _draw_law(axes, law, residuals.get(name) or {})
        axes.set_title(name.replace("_", " "))
    for axes in panels[len(found) :]:
        axes.axis("off")
    return figure


def _draw_law(axes: Axes, law: Mapping[str, Any], points: Mapping[str, Mapping[str, Any]]) -> None:
    name, channel = str(law.get("variable", "")), str(law.get("channel", ""))
    x, y = np.asarray(law["x"], dtype=float), np.asarray(law["y"], dtype=float)
    _draw_partial_residuals(axes, points)
    low, high = (np.asarray(law.get(k) or [], dtype=float) for k in ("low", "high"))
    if len(low) == len(high) == len(x):
        axes.fill_between(x, low, high, color=AFTER_COLOUR, alpha=0.35, lw=0, label="95 % band")
    axes.plot(x, y, color=AFTER_COLOUR, lw=0.8, label="estimate")
    axes.axhline(0, color="0.4", lw=0.8)
    unit = str(law.get("unit") or "")
    axes.set_xlabel(
        VARIABLE_LABELS.get(name, name.replace("_", " ") + (f" ({unit})" if unit else ""))
    )
    axes.set_ylabel(f"{FORCE_NAMES.get(channel, channel)} ({law.get('y_unit') or '-'})")
    axes.legend(loc="best")


def _draw_partial_residuals(axes: Axes, points: Mapping[str, Mapping[str, Any]]) -> None:
    """Partial residuals of a cause and its own force, trial by trial."""
    styles: dict[str, tuple[str, dict[str, Any]]] = {
        "y": ("model's residual + this cause, parts of trials",
              {"marker": "o", "mew": 0, "color": "#5b6570", "alpha": 0.6}),
        "cause_force": ("this cause in the same parts",
                        {"marker": "x", "mew": 0.6, "color": AFTER_COLOUR}),
    }  # fmt: skip
    for key, (label, style) in styles.items():
        shown: str | None = label
        for trial_id, one in points.items():
            x, y = (np.asarray(one.get(k) or [], dtype=float) for k in ("x", key))
            if not len(x) or len(x) != len(y):
                continue
            axes.plot(x, y, ls="", ms=3, label=shown, gid=trial_id, **style)
            shown = None
