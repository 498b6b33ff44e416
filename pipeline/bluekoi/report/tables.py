"""Coefficients, and the paper's two tables for this study beside the published values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..campaign import Campaign
from ..model import (
    HYDRODYNAMIC_COEFFICIENTS,
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    TABLE_2_ERRORS_PCT,
)
from .findings import TableRow
from .identifiability import as_power_product
from .numbers import (
    Z_95,
    coefficient_with_interval,
    format_number,
    format_percent,
    format_unit,
    parameter_units,
    parameter_with_interval,
    readable_name,
)

COEFFICIENT_COLUMNS = tuple(
    (p.name, format_unit(p.unit), p.meaning) for p in HYDRODYNAMIC_COEFFICIENTS
)
"""Name, unit and meaning of each coefficient."""


def joint_fit_rows(campaign: Campaign) -> list[TableRow]:
    """Joint fit: value with 95 % interval, unit, and whether the data determine it."""
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    return [
        TableRow(
            name,
            (
                coefficient_with_interval(cell),
                _hessian_half_width(cell),
                format_unit(str(cell.get("unit", ""))),
                _determined_text(cell),
            ),
            not cell.get("determined", True),
        )
        for name, cell in cells.items()
    ]


def _hessian_half_width(cell: Mapping[str, Any]) -> str:
    """Half of the 95 % interval from the inverse Hessian, which ignores correlated residuals."""
    std = cell.get("naive_std")
    return "–" if std is None else format_number(Z_95 * std, 2)


def joint_fit_notes(campaign: Campaign) -> list[str]:
    """Undetermined combinations of coefficients, and stability of straight swimming."""
    found = campaign.coefficients.get("joint") or {}
    out = [
        f"Not determined: {as_power_product(str(row.get('combination', '')))}. "
        f"{row.get('sentence', '')}. A trial that would help: {row.get('trial', '')}."
        for row in found.get("undetermined") or []
    ]
    straight = (found.get("straight_swimming") or {}).get("sentence")
    reading = campaign.coefficients.get("unit_reading")
    notes = [str(text).rstrip(".") + "." for text in (straight, reading) if text]
    return [*out, *notes]


def coefficients_per_power_table(campaign: Campaign) -> list[dict[str, Any]]:
    """Table I: a row per power for this study, and the published row if there is one."""
    return [
        _coefficients_per_power_row(power, entry)
        for power, entry in (campaign.coefficients.get("paper_steps") or {}).items()
    ]


def _coefficients_per_power_row(power: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    cells = entry.get("coefficients") or {}
    published = TABLE_1.get(round(float(power)), {})
    cells_here = [
        (
            coefficient_with_interval(cells.get(p.name) or {}),
            not (cells.get(p.name) or {}).get("determined", False),
            str((cells.get(p.name) or {}).get("why") or ""),
        )
        for p in HYDRODYNAMIC_COEFFICIENTS
    ]
    return {
        "power": f"{float(power):g} %",
        "flap": format_number(entry.get("flap_hz")),
        "cells": cells_here,
        "paper_flap": format_number(PUBLISHED_FLAP_HZ.get(round(float(power)))),
        "paper": [format_number(published.get(p.name)) for p in HYDRODYNAMIC_COEFFICIENTS]
        if published
        else [],
    }


def turn_radius_error_table(campaign: Campaign) -> list[TableRow]:
    """Table II: relative difference of model and measured turn radius, here and as published."""
    one_x = campaign.study.setup.robot.head_length_m
    return [
        _turn_radius_error_row(power, entry, one_x)
        for power, steps in (campaign.coefficients.get("paper_steps") or {}).items()
        for entry in (steps.get("steps") or {}).values()
        if entry.get("step") != 1 and entry.get("radius_m") is not None
    ]


def _turn_radius_error_row(power: str, entry: Mapping[str, Any], one_x: float) -> TableRow:
    ratio = round(float(entry["head_length_m"]) / one_x, 1)
    key = (round(float(entry["head_angle_deg"])), ratio)
    return TableRow(
        f"{float(power):g} %, {float(entry['head_angle_deg']):g}°, {ratio:g}x head",
        (
            "tuned" if entry.get("step") == 2 else "predicted",
            format_number(entry["radius_m"]),
            format_number(entry.get("model_radius_m")),
            format_percent(entry.get("radius_difference_pct")),
            format_percent(TABLE_2_ERRORS_PCT.get(key, {}).get(round(float(power)))),
        ),
        entry.get("step") == 3,
    )


def coefficient_changes(campaign: Campaign) -> list[TableRow]:
    """Coefficients of the baseline and of the model with the identified causes."""
    fits = (campaign.mismatch_detail or {}).get("coefficients") or {}
    before, after = fits.get("before") or {}, fits.get("after") or {}
    if (campaign.mismatch or {}).get("verdict") == "none":
        return []
    return [
        TableRow(
            _parameter_label(name),
            (
                _cell_text(name, before.get(name)),
                _cell_text(name, after.get(name)),
                _relative_change(before.get(name), cell),
            ),
        )
        for name, cell in after.items()
    ]


def _cell_text(name: str, cell: Mapping[str, Any] | None) -> str:
    return "–" if cell is None else parameter_with_interval(name, cell)


def _parameter_label(name: str) -> str:
    """`C_T (m²)`, `tail fin lift: S (m²)`."""
    cause, _, parameter = name.rpartition(".")
    of = f" ({parameter_units()[name]})" if name in parameter_units() else ""
    return (f"{readable_name(cause)}: " if cause else "") + parameter + of


def _relative_change(before: Mapping[str, Any] | None, after: Mapping[str, Any]) -> str:
    """Change in percent, unless the 95 % interval before contains 0."""
    if before is None:
        return "new"
    if abs(float(before["value"])) <= Z_95 * float(before.get("std") or 0.0):
        return "interval contained 0"
    return format_percent(100 * (float(after["value"]) / float(before["value"]) - 1))


def _determined_text(cell: Mapping[str, Any]) -> str:
    why = str(cell.get("why") or "")
    if cell.get("determined", True):
        return "yes"
    return "no" + (f": {why}" if why else "")
