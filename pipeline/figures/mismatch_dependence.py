"""What the missing force depends on, with the fitted effect through it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..campaign import Campaign
from ..data import Float
from .drawing import groups
from .drawing.lacking import (
    CHANNELS,
    LABELS,
    UNITS,
    Lacking,
    lacking,
    put_in_its_place,
    variable,
)
from .drawing.look import AFTER, Style, absent, letter, power_styles

TITLE = "What the missing force depends on"
CAPTION = (
    "Force that is missing from the model without its additions, against the variables that "
    "foretell most of it. Small dots: frames, by power; black: averages with deviations over "
    "trials; blue: the force of the additions in the same motion. The "
    "first second of a trial, which the smoother blurs, is left out. Where nothing was found, the "
    "usual suspects are drawn."
)
NEEDS = ("tracks", "steady", "mismatch_detail")
USUAL = (("surge", "speed_m_s"), ("sway", "sway_speed_m_s"), ("yaw", "yaw_rate_rad_s"))
PANELS = 3
BINS = 12
FRAMES = 60
BLURRED_S = 1.0


def draw(campaign: Campaign) -> Figure:
    """Up to three panels, the strongest dependence first."""
    pieces = [(one, put_in_its_place(campaign, one)) for one in lacking(campaign).values()]
    shown, shares = _pairs(campaign)
    styles = power_styles(groups.powers(campaign))
    figure = Figure(figsize=(12, 4.0), layout="constrained")
    for i, axes in enumerate(figure.subplots(1, PANELS)):
        letter(axes, "ABC"[i])
        if i >= len(shown) or not pieces:
            absent(axes, "no further dependence")
            continue
        channel, name = shown[i]
        _panel(axes, campaign, (channel, name), pieces, styles)
        share = shares.get((channel, name))
        axes.set_title(f"{channel}" + (f": foretells {100 * share:.0f} %" if share else ""))
    handles, labels = figure.axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(
            handles, labels, loc="outside upper center", ncols=len(labels), markerscale=2.5
        )
    return figure


def _pairs(
    campaign: Campaign,
) -> tuple[list[tuple[str, str]], dict[tuple[str, str], float]]:
    """Channel and variable of each panel, and their shares.

    The last panel is kept for the usual variable of the first cause's channel.
    """
    mismatch = campaign.mismatch or {}
    shares = {
        (row["channel"], row["variable"]): float(row["share"])
        for row in mismatch.get("where") or []
    }
    causes = mismatch.get("causes") or []
    channels = [channel for cause in causes[:1] for channel in cause.get("channels", [])]
    usual = [pair for pair in USUAL if pair[0] in channels and pair not in list(shares)[:PANELS]]
    first = list(shares)[: PANELS - len(usual[:1])]
    return first + usual[:1] if first else list(USUAL), shares


def _panel(
    axes: Axes,
    campaign: Campaign,
    pair: tuple[str, str],
    pieces: Sequence[tuple[Lacking, Float]],
    styles: dict[float, Style],
) -> None:
    channel, name = pair
    k = CHANNELS.index(channel)
    found = [_clear(one) for one, _ in pieces]
    x = [variable(campaign, one, name)[at] for (one, _), at in zip(pieces, found, strict=True)]
    y = [one.force[at, k] for (one, _), at in zip(pieces, found, strict=True)]
    _dots(axes, campaign, [one for one, _ in pieces], (x, y), styles)
    at, mean, std = _averages(x, y)
    axes.errorbar(at, mean, yerr=std, fmt="o", color="#20262e", ms=4, capsize=2, zorder=5,
                  label="average, deviation over trials")  # fmt: skip
    model = [instead[at, k] for (_, instead), at in zip(pieces, found, strict=True)]
    at, mean, _ = _averages(x, model)
    if np.isfinite(mean).any():
        axes.plot(at, mean, color=AFTER, lw=2.2, zorder=6, label="extended model")
    axes.axhline(0, color="0.4", lw=0.8)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.set_xlabel(LABELS.get(name, name))
    axes.set_ylabel(f"missing {channel} ({UNITS[channel]})")
    top = 1.15 * float(np.quantile(np.abs(np.concatenate(y)), 0.985))
    axes.set_ylim(-top, top)


def _clear(one: Lacking) -> npt.NDArray[np.bool_]:
    """Frames after the start, (n,)."""
    t = one.motion[:, 6] - one.motion[0, 6]
    return np.asarray(t >= min(BLURRED_S, t[-1] / 3))


def _dots(
    axes: Axes,
    campaign: Campaign,
    found: Sequence[Lacking],
    points: tuple[list[Float], list[Float]],
    styles: dict[float, Style],
) -> None:
    told: set[float] = set()
    for one, x, y in zip(found, *points, strict=True):
        power = campaign.study.trial(one.trial_id).power_pct
        some = slice(None, None, max(1, len(x) // FRAMES))
        style, label = styles[power], None if power in told else f"{power:g} %"
        told.add(power)
        axes.plot(x[some], y[some], style.marker, ms=2, mew=0, color=style.colour, alpha=0.55,
                  label=label)  # fmt: skip


def _averages(x: Sequence[Float], y: Sequence[Float]) -> tuple[Float, Float, Float]:
    """Place, mean and deviation over trials of equal bins that at least two trials cross.

    The place of a bin is the mean of what lies in it, not its middle: straight runs all lie at 0.
    """
    every = np.concatenate(list(x))
    every = every[np.isfinite(every)]
    values = np.unique(every)
    if len(values) == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    if len(values) <= BINS:
        edges = np.concatenate(
            [[values[0] - 1], 0.5 * (values[1:] + values[:-1]), [values[-1] + 1]]
        )
    else:
        low, high = np.quantile(every, (0.01, 0.99))
        edges = np.linspace(float(low), float(high), BINS + 1)
    table = np.array([_bin(x, y, edges[i], edges[i + 1]) for i in range(len(edges) - 1)])
    table = table[np.isfinite(table[:, 1])]
    return table[:, 0], table[:, 1], table[:, 2]


def _bin(
    x: Sequence[Float], y: Sequence[Float], low: float, high: float
) -> tuple[float, float, float]:
    found = [(a[at], b[at]) for a, b in zip(x, y, strict=True) for at in [(a >= low) & (a < high)]]
    means = np.array([(a.mean(), b.mean()) for a, b in found if len(a) > 1])
    if len(means) < 2:
        return (float("nan"), float("nan"), 0.0)
    return float(means[:, 0].mean()), float(means[:, 1].mean()), float(means[:, 1].std(ddof=1))
