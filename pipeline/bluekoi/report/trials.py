"""Every trial: its row in the table, thumbnail of its paths, video and remarks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..campaign import Campaign
from ..data import Float
from ..figures.drawing.held_out import evaluated_on_fitted_trials, evaluated_trials
from ..study import Trial
from .explorer import compressed_trial_time_series
from .media import OverlayClip
from .numbers import format_number, value_with_interval

THUMBNAIL_POINTS = 60
STEADY_STATE_QUALITY_TEXTS = {
    "good": "good",
    "straight": "straight",
    "short_arc": "short arc",
    "not_steady": "not steady",
    "no_data": "no data",
}


@dataclass(frozen=True)
class TableCell:
    """Displayed text and sort key."""

    text: str
    key: str


@dataclass(frozen=True)
class TrialCard:
    """One trial."""

    trial_id: str
    condition: str
    cells: tuple[TableCell, ...]
    quality: str
    reason: str
    remarks: tuple[str, ...]
    lines: tuple[tuple[str, str], ...]
    box: str
    pool: tuple[float, float]
    clip: OverlayClip | None
    series: str
    power: str
    held_out: bool
    analysed: bool


def trial_cards(campaign: Campaign, clips: Mapping[str, OverlayClip]) -> list[TrialCard]:
    """A card for every trial of the study, analysed or not."""
    held_out = set() if evaluated_on_fitted_trials(campaign) else set(evaluated_trials(campaign))
    return [
        _trial_card(campaign, trial, clips.get(trial.trial_id), trial.trial_id in held_out)
        for trial in campaign.study.trials
    ]


def excluded_trials(campaign: Campaign) -> list[tuple[str, str]]:
    """Excluded trials with the reason; files relative to the study folder."""
    folder = f"{campaign.study.root}/"
    return [(trial.trial_id, why.replace(folder, "")) for trial, why in campaign.left_out]


def _trial_card(
    campaign: Campaign, trial: Trial, clip: OverlayClip | None, held_out: bool
) -> TrialCard:
    done = trial.trial_id in {t.trial_id for t in campaign.analysed}
    steady = campaign.steady.get(trial.trial_id) if done else None
    status = campaign.statuses.get(trial.trial_id) or {}
    size = campaign.study.setup.pool
    remarks = [str(remark) for remark in status.get("remarks") or []]
    if status.get("cut_short"):
        remarks.insert(0, str(status["cut_short"]))
    quality = (
        STEADY_STATE_QUALITY_TEXTS.get(steady.quality, steady.quality) if steady else "excluded"
    )
    return TrialCard(
        trial_id=trial.trial_id,
        condition=f"{trial.power_pct:g} % power, head {trial.head_angle_deg:g}°, "
        f"{trial.head_length_m:g} m",
        cells=_table_cells(campaign, trial, done),
        quality=quality,
        reason=steady.reason if steady else dict(excluded_trials(campaign))[trial.trial_id],
        remarks=tuple(remarks),
        lines=_thumbnail_lines(campaign, trial.trial_id),
        box=f"-0.38 -0.05 {size.length_m + 0.43:.3f} {size.width_m + 0.25:.3f}",
        pool=(size.length_m, size.width_m),
        clip=clip,
        series=compressed_trial_time_series(campaign, trial.trial_id),
        power=f"{trial.power_pct:g}",
        held_out=held_out,
        analysed=done,
    )


def _table_cells(campaign: Campaign, trial: Trial, done: bool) -> tuple[TableCell, ...]:
    given = [
        TableCell(f"{value:g}", f"{value}")
        for value in (trial.power_pct, trial.head_angle_deg, trial.head_length_m)
    ]
    models = ("joint", "extended") if campaign.has_additions else ("joint",)
    if not done:
        return (*given, *(TableCell("–", "") for _ in range(4 + len(models))))
    row = campaign.steady[trial.trial_id]
    radius = (
        "straight"
        if math.isinf(row.radius_m)
        else value_with_interval(row.radius_m, row.radius_std_m)
    )
    errors = [1000 * campaign.path_rmse_m(trial.trial_id, model) for model in models]
    return (
        *given,
        TableCell(format_number(row.flap_hz), _sort_key(row.flap_hz)),
        TableCell(value_with_interval(row.speed_m_s, row.speed_std_m_s), _sort_key(row.speed_m_s)),
        TableCell(radius, _sort_key(row.radius_m)),
        TableCell(
            "–" if math.isinf(row.radius_m) else format_number(row.arc_deg), _sort_key(row.arc_deg)
        ),
        *(TableCell(format_number(error), _sort_key(error)) for error in errors),
    )


def _sort_key(value: float) -> str:
    return "" if math.isnan(value) else ("1e99" if math.isinf(value) else f"{value:.9g}")


def _thumbnail_lines(campaign: Campaign, trial_id: str) -> tuple[tuple[str, str], ...]:
    """CSS class and points of each path, in metres, y upwards."""
    width = campaign.study.setup.pool.width_m
    track = campaign.tracks.get(trial_id)
    if track is None:
        return ()
    columns = campaign.model_columns(trial_id)
    found = [("measured", track.x_m, track.y_m)]
    for prefix, name in (("extended", "after"), ("joint", "before")):
        if f"{prefix}_x_m" in columns:
            found.append((name, columns[f"{prefix}_x_m"], columns[f"{prefix}_y_m"]))
    return tuple((name, _thumbnail_svg_points(x, width - y)) for name, x, y in found)


def _thumbnail_svg_points(x: Float, y: Float) -> str:
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    kept = np.unique(np.linspace(0, max(len(x) - 1, 0), THUMBNAIL_POINTS).round().astype(int))
    return " ".join(f"{x[i]:.3f},{y[i]:.3f}" for i in kept if i < len(x))
