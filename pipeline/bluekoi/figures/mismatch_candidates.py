"""Evidence for each candidate cause: its probability."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ..campaign import Campaign
from .drawing.style import AFTER_COLOUR, placeholder

FIGURE_TITLE = "Evidence for each candidate cause"
FIGURE_CAPTION = (
    "Probability that a candidate acts, given these data, calibrated by how often earlier verdicts "
    "were right: at most 0.94. Blue: named as a cause. Probabilities need not add up to 1: several "
    "causes may act at once. Candidates that the data cannot distinguish share the probability "
    "between them."
)
REQUIRED_RESULTS = ("mismatch",)
MAX_BARS_SHOWN = 16
UNSELECTED_CANDIDATE_COLOUR = "#9aa5af"


def render_figure(campaign: Campaign) -> Figure:
    """Horizontal bars, the largest on top."""
    found = campaign.mismatch or {}
    named = {str(cause["name"]) for cause in found.get("causes") or []}
    given = {str(k): float(v) for k, v in (found.get("probabilities") or {}).items()}
    bars = sorted(given.items(), key=lambda bar: -bar[1])[:MAX_BARS_SHOWN]
    figure = Figure(figsize=(6.0, 0.9 + 0.24 * (len(bars) or 4)), layout="constrained")
    axes = figure.subplots()
    if not bars:
        placeholder(axes, "this search reports no candidates")
        return figure
    _draw_probability_bars(axes, bars, named)
    axes.set_xlabel("probability that the cause acts")
    shown = {name in named for name, _ in bars}
    handles = [Patch(color=AFTER_COLOUR, label="named")] * (True in shown)
    handles += [Patch(color=UNSELECTED_CANDIDATE_COLOUR, label="not named")] * (False in shown)
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _draw_probability_bars(axes: Axes, bars: list[tuple[str, float]], named: set[str]) -> None:
    for place, (name, value) in enumerate(bars):
        axes.barh(
            place,
            value,
            color=AFTER_COLOUR if name in named else UNSELECTED_CANDIDATE_COLOUR,
            height=0.7,
        )
        axes.annotate(f"{value:.2f}", (value, place), xytext=(3, 0), textcoords="offset points",
                      va="center", fontsize=7)  # fmt: skip
    axes.set_yticks(range(len(bars)), [name.replace("_", " ") for name, _ in bars])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.14)
