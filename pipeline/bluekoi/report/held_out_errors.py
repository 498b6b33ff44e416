"""Errors of the models before and after on held-out trials, as a table with its text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..campaign import Campaign
from ..figures.drawing.held_out import evaluated_on_fitted_trials, evaluated_trials, noise_floor_m
from ..figures.drawing.style import BASELINE_MODEL_LABEL, EXTENDED_MODEL_LABEL
from ..fitting.paths import PREDICTION_ERRORS, TRAJECTORIES
from .findings import TableRow
from .numbers import format_number

ERROR_ROW_DEFINITIONS = (
    ("path, rms (mm)", "path_rmse_m", 1000.0),
    ("turn radius (%)", "radius_error_pct", 1.0),
    ("steady speed (%)", "speed_error_pct", 1.0),
)
"""Label of a row, key of mismatch.json, factor to the unit of the label."""
FIT_CRITERION_NAMES = {
    PREDICTION_ERRORS: "one-step prediction errors",
    TRAJECTORIES: "whole trajectories",
}


def held_out_column_headings(campaign: Campaign) -> list[str]:
    """Column headings of the table `error_rows`."""
    both = [BASELINE_MODEL_LABEL, EXTENDED_MODEL_LABEL]
    return ["error", *(both if campaign.has_additions else ["model"]), "noise floor"]


def held_out_error_rows(campaign: Campaign) -> list[TableRow]:
    """Errors of each model on held-out trials, and the noise floor."""
    if not (campaign.mismatch or {}).get("held_out"):
        return []
    rows = []
    for label, key, factor in ERROR_ROW_DEFINITIONS:
        errors = [campaign.held_out_error(model, key) for model in campaign.held_out_models]
        floor = _noise_floor_text(campaign) if key == "path_rmse_m" else ""
        rows.append(
            TableRow(label, (*(_error_in_display_unit(error, factor) for error in errors), floor))
        )
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
        "criteria": _fit_criteria_sentence(campaign, found),
    }
    if evaluated_on_fitted_trials(campaign):
        return common | {
            "heading": "Errors on the fitted trials",
            "sentence": f"No trial was held out because the study is too small: {names} were also "
            "fitted, so smaller errors do not confirm the causes.",
        }
    return common | {"heading": "Errors on held-out trials", "sentence": f"Held out: {names}."}


def _fit_criteria_sentence(campaign: Campaign, held_out: Mapping[str, Any]) -> str:
    """To what the compared models were fitted."""
    parts = []
    models = {"baseline": "baseline"}
    models |= {"extended": "model with causes"} if campaign.has_additions else {}
    for model, name in models.items():
        if criterion := FIT_CRITERION_NAMES.get(str(held_out.get(f"{model}_fitted_to"))):
            parts.append(f"the {name} to {criterion}")
    return (
        f"Fitted: {' and '.join(parts)}; of a model that was fitted to both, the fit with the "
        "smaller path error is compared."
        if parts
        else ""
    )


def _error_in_display_unit(value: float, factor: float) -> str:
    return "diverges" if math.isinf(value) else format_number(factor * value)
