"""What every candidate would have bought."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ..campaign import Campaign
from .drawing.look import AFTER, letter

TITLE = "What each candidate would have bought"
CAPTION = (
    "Gain in the log likelihood of trials held out, by adding one candidate and refitting all "
    "coefficients; one panel a round, the next beside those already chosen. Full bars: refitted; "
    "hollow: foretold without a refit and not tried further. Blue: chosen. Below 0 an addition "
    "makes the prediction of new trials worse."
)
NEEDS = ("mismatch_detail",)
MOST_ROUNDS = 3
MOST_BARS = 16
OTHER = "#9aa5af"


def draw(campaign: Campaign) -> Figure:
    """Bars by round, the best on top."""
    detail = campaign.mismatch_detail or {}
    rounds = _rounds(detail)[:MOST_ROUNDS]
    chosen = {str(cause["name"]) for cause in (campaign.mismatch or {}).get("causes", [])}
    height = 0.9 + 0.24 * max((len(bars) for bars in rounds), default=4)
    figure = Figure(figsize=(max(6.0, 4.2 * len(rounds)), height), layout="constrained")
    panels = figure.subplots(1, max(1, len(rounds)), squeeze=False)[0]
    for i, (axes, bars) in enumerate(zip(panels, rounds, strict=False)):
        letter(axes, "ABC"[i])
        _bars(axes, bars, chosen)
        axes.set_title(f"round {i + 1}")
    shown = [bar for bars in rounds for bar in bars]
    looks = (
        (any(name in chosen for name, _, _ in shown), Patch(color=AFTER, label="chosen")),
        (any(tried for _, _, tried in shown), Patch(color=OTHER, label="refitted")),
        (not all(tried for _, _, tried in shown),
         Patch(fc="white", ec=OTHER, label="foretold only")),
    )  # fmt: skip
    key = [patch for there, patch in looks if there]
    figure.legend(handles=key, loc="outside lower center", ncols=3)
    return figure


def _rounds(detail: Any) -> list[list[tuple[str, float, bool]]]:
    """For every round: name, gain, and whether it was refitted; the best first."""
    tried = detail.get("candidates", [])
    count = max((int(row.get("round", 1)) for row in tried), default=0)
    screens = detail.get("foretold") or []
    out = []
    for number in range(1, count + 1):
        bars = {
            str(row["name"]): (float(row["held_out_gain"]), True)
            for row in tried
            if int(row.get("round", 1)) == number
        }
        screen = screens[number - 1] if number <= len(screens) else {}
        for name, gain in screen.items():
            bars.setdefault(name, (float(gain or 0.0), False))
        rows = [(name, *bar) for name, bar in bars.items()]
        out.append(sorted(rows, key=lambda row: (not row[2], -row[1]))[:MOST_BARS])
    return out


def _bars(axes: Axes, bars: list[tuple[str, float, bool]], chosen: set[str]) -> None:
    for place, (name, gain, refitted) in enumerate(bars):
        colour = AFTER if name in chosen else OTHER
        axes.barh(place, gain, color=colour if refitted else "white", edgecolor=colour, height=0.7)
        axes.annotate(
            f"{gain:.1f}",
            (max(gain, 0), place),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
        )
    axes.set_yticks(range(len(bars)), [name.replace("_", " ") for name, _, _ in bars])
    axes.invert_yaxis()
    axes.axvline(0, color="0.3", lw=0.8)
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.14)
    axes.set_xlabel("gain in held-out log likelihood (nats)")
