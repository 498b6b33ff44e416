"""Missing force over the variables that explain it, with the force of the identified effects."""

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
from .drawing.missing_force import (
    FORCE_CHANNELS,
    FORCE_NAMES,
    FORCE_UNITS,
    VARIABLE_LABELS,
    MissingForceSeries,
    force_of_effects,
    missing_forces,
    variable_along_trial,
)
from .drawing.style import AFTER_COLOUR, PowerStyle, panel_letter, placeholder, power_styles

FIGURE_TITLE = "Variables that explain the missing force"
FIGURE_CAPTION = (
    "Force missing from the baseline model over the variables that explain most of it in "
    "conditions left out of the regression; percentages: share of all missing force, of the three "
    "channels together. Small dots: frames, by power; black: means with "
    "standard deviations over trials; blue diamonds: means of the force of the identified causes, "
    "if any, in the same motion, not joined, since it may depend on other variables as well. The "
    "first second of each trial, where the smoother has no resolution, is omitted. Without a "
    "significant dependence, each force is shown over the variable of the commonest cause."
)
REQUIRED_RESULTS = ("tracks", "steady", "mismatch_detail")
DEFAULT_CHANNEL_VARIABLE_PAIRS = (
    ("surge", "speed_m_s"),
    ("sway", "sway_speed_m_s"),
    ("yaw", "yaw_rate_rad_s"),
)
"""Channel and variable drawn where nothing explains the force."""
PANEL_COUNT = 3
MAX_BINS = 12
"""Bins of a variable over which the force is averaged, at most."""
MAX_FRAMES_DRAWN = 60
"""Frames of a trial that are drawn as points, at most."""
SKIPPED_START_S = 1.0
"""Start of a trial that is not drawn: the force is uncertain there."""


def render_figure(campaign: Campaign) -> Figure:
    """Up to three panels, the largest explained share first."""
    pieces = [(one, force_of_effects(campaign, one)) for one in missing_forces(campaign).values()]
    shown, shares = _channel_variable_pairs(campaign)
    styles = power_styles(groups.motor_powers_pct(campaign))
    figure = Figure(figsize=(12, 4.0), layout="constrained")
    for i, axes in enumerate(figure.subplots(1, PANEL_COUNT)):
        panel_letter(axes, "ABC"[i])
        if i >= len(shown) or not pieces:
            placeholder(axes, "no further dependence")
            continue
        channel, name = shown[i]
        _draw_dependence_panel(axes, campaign, (channel, name), pieces, styles)
        share = shares.get((channel, name))
        axes.set_title(
            f"{FORCE_NAMES[channel]}: explains {100 * share:.0f} % (held out)"
            if share
            else FORCE_NAMES[channel]
        )
    handles, labels = figure.axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(
            handles, labels, loc="outside upper center", ncols=len(labels), markerscale=1.4
        )
    return figure


def _channel_variable_pairs(
    campaign: Campaign,
) -> tuple[list[tuple[str, str]], dict[tuple[str, str], float]]:
    """Channel and variable of each panel, and their explained shares.

    The last panel is reserved for the default variable of the first cause's channel.
    """
    mismatch = campaign.mismatch or {}
    shares = {
        (str(row["channel"]), str(row["variable"])): float(row.get("share") or 0.0)
        for row in mismatch.get("where") or []
        if row.get("channel") in FORCE_CHANNELS
    }
    causes = mismatch.get("causes") or []
    channels = [channel for cause in causes[:1] for channel in cause.get("channels", [])]
    default = [
        pair
        for pair in DEFAULT_CHANNEL_VARIABLE_PAIRS
        if pair[0] in channels and pair not in list(shares)[:PANEL_COUNT]
    ]
    first = list(shares)[: PANEL_COUNT - len(default[:1])]
    return first + default[:1] if first else list(DEFAULT_CHANNEL_VARIABLE_PAIRS), shares


def _draw_dependence_panel(
    axes: Axes,
    campaign: Campaign,
    pair: tuple[str, str],
    pieces: Sequence[tuple[MissingForceSeries, Float]],
    styles: dict[float, PowerStyle],
) -> None:
    channel, name = pair
    k = FORCE_CHANNELS.index(channel)
    found = [_frames_after_start(one) for one, _ in pieces]
    x = [
        variable_along_trial(campaign, one, name)[at]
        for (one, _), at in zip(pieces, found, strict=True)
    ]
    y = [one.force[at, k] for (one, _), at in zip(pieces, found, strict=True)]
    _draw_force_at_frames(axes, campaign, [one for one, _ in pieces], (x, y), styles)
    at, mean, std = _binned_means(x, y)
    axes.errorbar(at, mean, yerr=std, fmt="o", color="#20262e", ms=4, capsize=2, zorder=5,
                  label="mean and standard deviation over trials")  # fmt: skip
    model = [instead[at, k] for (_, instead), at in zip(pieces, found, strict=True)]
    at, mean, _ = _binned_means(x, model)
    if np.isfinite(mean).any():
        axes.plot(at, mean, "D", color=AFTER_COLOUR, mfc="none", mew=1.4, ms=7, zorder=6,
                  label="identified causes, mean")  # fmt: skip
    axes.axhline(0, color="0.4", lw=0.8)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.set_xlabel(VARIABLE_LABELS.get(name, name))
    axes.set_ylabel(f"missing {FORCE_NAMES[channel]} ({FORCE_UNITS[channel]})")
    top = 1.15 * float(np.quantile(np.abs(np.concatenate(y)), 0.985))
    axes.set_ylim(-top, top)


def _frames_after_start(one: MissingForceSeries) -> npt.NDArray[np.bool_]:
    """Frames after the start, (n,)."""
    t = one.motion[:, 6] - one.motion[0, 6]
    return np.asarray(t >= min(SKIPPED_START_S, t[-1] / 3))


def _draw_force_at_frames(
    axes: Axes,
    campaign: Campaign,
    found: Sequence[MissingForceSeries],
    points: tuple[list[Float], list[Float]],
    styles: dict[float, PowerStyle],
) -> None:
    labelled: set[float] = set()
    for one, x, y in zip(found, *points, strict=True):
        power = campaign.study.trial(one.trial_id).power_pct
        some = slice(None, None, max(1, len(x) // MAX_FRAMES_DRAWN))
        style, label = styles[power], None if power in labelled else f"{power:g} %"
        labelled.add(power)
        axes.plot(x[some], y[some], style.marker, ms=2, mew=0, color=style.colour, alpha=0.55,
                  label=label, gid=one.trial_id)  # fmt: skip


def _binned_means(x: Sequence[Float], y: Sequence[Float]) -> tuple[Float, Float, Float]:
    """Position, mean and standard deviation over trials of bins with at least two trials.

    The position of a bin is the mean of its points, not its middle: straight runs all lie at 0.
    """
    every = np.concatenate(list(x))
    every = every[np.isfinite(every)]
    values = np.unique(every)
    if len(values) == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    if len(values) <= MAX_BINS:
        edges = np.concatenate(
            [[values[0] - 1], 0.5 * (values[1:] + values[:-1]), [values[-1] + 1]]
        )
    else:
        low, high = np.quantile(every, (0.01, 0.99))
        edges = np.linspace(float(low), float(high), MAX_BINS + 1)
    table = np.array(
        [_bin_mean_and_std(x, y, edges[i], edges[i + 1]) for i in range(len(edges) - 1)]
    )
    table = table[np.isfinite(table[:, 1])]
    return table[:, 0], table[:, 1], table[:, 2]


def _bin_mean_and_std(
    x: Sequence[Float], y: Sequence[Float], low: float, high: float
) -> tuple[float, float, float]:
    found = [(a[at], b[at]) for a, b in zip(x, y, strict=True) for at in [(a >= low) & (a < high)]]
    means = np.array([(a.mean(), b.mean()) for a, b in found if len(a) > 1])
    if len(means) < 2:
        return (float("nan"), float("nan"), 0.0)
    return float(means[:, 0].mean()), float(means[:, 1].mean()), float(means[:, 1].std(ddof=1))
