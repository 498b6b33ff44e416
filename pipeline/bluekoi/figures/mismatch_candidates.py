"""Evidence for each candidate cause: its probability, or its gain in predictive likelihood."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ..campaign import Campaign
from .drawing.style import AFTER, panel_letter, placeholder

TITLE = "Evidence for each candidate cause"
PROBABILITIES = (
    "Probability that a candidate belongs to the model, given these data, for each candidate of "
    "the search. Blue: named as a cause. Probabilities need not add up to 1: several causes may "
    "act at once. Candidates that the data cannot distinguish share the probability between them."
)
CAPTION = (
    "Increase in the log likelihood of held-out trials when one candidate is added and all "
    "coefficients are refitted; one panel per step of the search, each starting from the causes "
    "selected before. Filled: refitted; hollow: estimated without a refit and not pursued. Blue: "
    "selected. A negative value means that the candidate worsens the prediction of new trials."
)
NEEDS = ("mismatch",)
MOST_STEPS = 3
MOST_BARS = 16
OTHER = "#9aa5af"
Bar = tuple[str, float, bool]
"""Name, value, and whether the bar is filled."""


def title_and_caption(campaign: Campaign) -> tuple[str, str]:
    """Title, and the caption of probabilities where the search reports them."""
    return TITLE, PROBABILITIES if (campaign.mismatch or {}).get("probabilities") else CAPTION


def draw(campaign: Campaign) -> Figure:
    """Horizontal bars, the largest on top."""
    found = campaign.mismatch or {}
    selected = {str(cause["name"]) for cause in found.get("causes") or []}
    if given := found.get("probabilities"):
        panels = [_largest([(str(k), float(v), True) for k, v in given.items()])]
        label, titles, filled = "probability of inclusion", [""], "not selected"
    else:
        panels = _steps(campaign.mismatch_detail or {})[:MOST_STEPS]
        titles = [f"step {i + 1}" for i in range(len(panels))]
        label, filled = "gain in held-out log likelihood (nats)", "refitted"
    height = 0.9 + 0.24 * max((len(bars) for bars in panels), default=4)
    figure = Figure(figsize=(max(6.0, 4.2 * len(panels)), height), layout="constrained")
    every = figure.subplots(1, max(1, len(panels)), squeeze=False)[0]
    if not panels:
        placeholder(every[0], "this search reports no candidates")
        return figure
    for i, (axes, bars) in enumerate(zip(every, panels, strict=True)):
        panel_letter(axes, "ABC"[i])
        _bars(axes, bars, selected)
        axes.set_xlabel(label)
        axes.set_title(titles[i])
    shown = [bar for bars in panels for bar in bars]
    looks = (
        (any(name in selected for name, _, _ in shown), Patch(color=AFTER, label="selected")),
        (any(full for _, _, full in shown), Patch(color=OTHER, label=filled)),
        (not all(full for _, _, full in shown),
         Patch(fc="white", ec=OTHER, label="estimated without a refit")),
    )  # fmt: skip
    handles = [patch for there, patch in looks if there]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _largest(bars: list[Bar]) -> list[Bar]:
    return sorted(bars, key=lambda bar: (not bar[2], -bar[1]))[:MOST_BARS]


def _steps(detail: Any) -> list[list[Bar]]:
    """Candidates of each step of the search: refitted ones, then those only estimated."""
    tried = detail.get("candidates") or []
    estimated = detail.get("foretold") or []
    out = []
    for number in range(1, max((int(row.get("round", 1)) for row in tried), default=0) + 1):
        bars = {
            str(row["name"]): (float(row.get("held_out_gain") or 0.0), True)
            for row in tried
            if int(row.get("round", 1)) == number
        }
        for name, gain in (estimated[number - 1] if number <= len(estimated) else {}).items():
            bars.setdefault(name, (float(gain or 0.0), False))
        out.append(_largest([(name, *bar) for name, bar in bars.items()]))
    return out


def _bars(axes: Axes, bars: list[Bar], selected: set[str]) -> None:
    for place, (name, value, filled) in enumerate(bars):
        colour = AFTER if name in selected else OTHER
        axes.barh(place, value, color=colour if filled else "white", edgecolor=colour, height=0.7)
        text = f"{value:.2f}" if value < 1 else f"{value:.1f}"
        axes.annotate(text, (max(value, 0), place), xytext=(3, 0), textcoords="offset points",
                      va="center", fontsize=7)  # fmt: skip
    axes.set_yticks(range(len(bars)), [name.replace("_", " ") for name, _, _ in bars])
    axes.invert_yaxis()
    axes.axvline(0, color="0.3", lw=0.8)
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.14)
