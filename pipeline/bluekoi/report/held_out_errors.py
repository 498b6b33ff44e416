"""Errors of the models before and after on held-out trials, as a table with its text."""

from __future__ import annotations

import math

from ..campaign import Campaign
from ..figures.drawing.held_out import evaluated_on_fitted_trials, evaluated_trials, noise_floor_m
from ..figures.drawing.style import BASELINE_NAME, EXTENDED_NAME
from .findings import Row
from .numbers import format_number

ERROR_ROW_DEFINITIONS = (
    ("path, rms (mm)", "path_rmse_m", 1000.0),
    ("turn radius (%)", "radius_error_pct", 1.0),
    ("steady speed (%)", "speed_error_pct", 1.0),
)
"""Label of a row, key of mismatch.json, factor to the unit of the label."""
CRITERION_SENTENCES = {
    "prediction errors": "The baseline was fitted to one-step prediction errors.",
    "trajectories": "The baseline was fitted to whole trajectories, the strongest baseline for "
    "these errors.",
}


def column_headings(campaign: Campaign) -> list[str]:
    """Column headings of the table `error_rows`."""
    both = [BASELINE_NAME, EXTENDED_NAME]
    return ["error", *(both if campaign.has_additions else ["model"]), "noise floor"]


def error_rows(campaign: Campaign) -> list[Row]:
    """Errors of each model on held-out trials, and the noise floor."""
    if not (campaign.mismatch or {}).get("held_out"):
        return []
    rows = []
    for label, key, factor in ERROR_ROW_DEFINITIONS:
        errors = [campaign.held_out_error(model, key) for model in campaign.held_out_models]
        floor = _noise_floor_text(campaign) if key == "path_rmse_m" else ""
        rows.append(Row(label, (*(_scaled_text(error, factor) for error in errors), floor)))
    return rows


def _noise_floor_text(campaign: Campaign) -> str:
    floor = noise_floor_m(campaign)
    return "–" if floor is None else format_number(1000 * floor)


def held_out_table_text(campaign: Campaign) -> dict[str, str]:
    """Heading, caption and sentences for the table, by which trials were evaluated."""
    names = ", ".join(evaluated_trials(campaign))
    found = (campaign.mismatch or {}).get("held_out") or {}
    stretch = found.get("stretch_s")
    common = {
        "stretch": f" over segments of {float(stretch):.1f} s" if stretch else "",
        "baseline": CRITERION_SENTENCES.get(str(found.get("baseline_fitted_to")), ""),
    }
    if evaluated_on_fitted_trials(campaign):
        return common | {
            "heading": "Errors on the fitted trials",
            "sentence": f"No trial was held out because the study is too small: {names} were also "
            "fitted, so smaller errors do not confirm the causes.",
        }
    return common | {"heading": "Errors on held-out trials", "sentence": f"Held out: {names}."}


def _scaled_text(value: float, factor: float) -> str:
    return "diverges" if math.isinf(value) else format_number(factor * value)
