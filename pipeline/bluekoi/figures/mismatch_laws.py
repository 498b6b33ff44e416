"""Estimated law of each cause over its own variable, with its band."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..campaign import Campaign
from ..data import Float
from .drawing.missing_force import CHANNELS, LABELS, NAMES, missing_forces, variable
from .drawing.style import AFTER, panel_letter

TITLE = "Estimated law of each cause"
CAPTION = (
    "Effect of each identified cause over the variable that it depends on, with its 95 % band. "
    "Dots, where the search reports the missing force: its mean within equal parts of a trial. "
    "They include the forces of all other causes in that channel."
)
NEEDS = ("mismatch",)
COLUMNS = 3
PARTS = 8
"""Parts of a trial that are averaged for the dots."""
FORCE_UNITS = ("N", "N m")


def unavailable(campaign: Campaign) -> str:
    """Why there is nothing to draw; empty if a cause has a law."""
    return "" if laws(campaign) else "the search reports no law of a cause"


def laws(campaign: Campaign) -> dict[str, Mapping[str, Any]]:
    """Name of a cause -> its law, for causes with a complete one."""
    causes = (campaign.mismatch or {}).get("causes") or []
    found = {str(cause["name"]): cause.get("law") or {} for cause in causes}
    return {
        name: law
        for name, law in found.items()
        if law.get("x") and len(law["x"]) == len(law.get("y") or ())
    }


def draw(campaign: Campaign) -> Figure:
    """A panel for each cause with a law."""
    found = laws(campaign)
    rows = -(-len(found) // COLUMNS)
    columns = min(COLUMNS, len(found))
    figure = Figure(figsize=(4.2 * columns + 0.6, 3.4 * rows), layout="constrained")
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for i, (axes, (name, law)) in enumerate(zip(panels, found.items(), strict=False)):
        panel_letter(axes, "ABCDEFGHI"[i % 9])
        _law(axes, campaign, law)
        axes.set_title(name.replace("_", " "))
    for axes in panels[len(found) :]:
        axes.axis("off")
    return figure


def _law(axes: Axes, campaign: Campaign, law: Mapping[str, Any]) -> None:
    name, channel = str(law.get("variable", "")), str(law.get("channel", ""))
    x, y = np.asarray(law["x"], dtype=float), np.asarray(law["y"], dtype=float)
    if law.get("y_unit") in FORCE_UNITS and channel in CHANNELS:
        _dots(axes, campaign, name, CHANNELS.index(channel))
    low, high = (np.asarray(law.get(k) or [], dtype=float) for k in ("low", "high"))
    if len(low) == len(high) == len(x):
        axes.fill_between(x, low, high, color=AFTER, alpha=0.2, lw=0, label="95 % band")
    axes.plot(x, y, color=AFTER, lw=2, label="estimate")
    axes.axhline(0, color="0.4", lw=0.8)
    unit = str(law.get("unit") or "")
    axes.set_xlabel(LABELS.get(name, name.replace("_", " ") + (f" ({unit})" if unit else "")))
    axes.set_ylabel(f"{NAMES.get(channel, channel)} ({law.get('y_unit') or '-'})")
    axes.legend(loc="best")


def _dots(axes: Axes, campaign: Campaign, name: str, channel: int) -> None:
    label: str | None = "missing force, parts of trials"
    for one in missing_forces(campaign).values():
        if one.trial_id not in campaign.steady:
            continue
        x = _means(variable(campaign, one, name))
        if not np.isfinite(x).all():
            continue
        axes.plot(x, _means(one.force[:, channel]) / 1000, "o", ms=3, mew=0, color="#5b6570",
                  alpha=0.6, label=label, gid=one.trial_id)  # fmt: skip
        label = None


def _means(values: Float) -> Float:
    return np.array([part.mean() for part in np.array_split(values, min(PARTS, len(values)))])
