"""Coefficients and the paper's two tables, this study's beside the paper's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..campaign import Campaign
from ..model import COEFFICIENTS, FLAP_HZ, TABLE_1, TABLE_2_PCT
from .numbers import BAND, estimate, measured, number, percent, unit, units, words
from .story import Row

COLUMNS = tuple((p.name, unit(p.unit), p.meaning) for p in COEFFICIENTS)
"""Name, unit and meaning of each coefficient."""


def joint(campaign: Campaign) -> list[Row]:
    """The joint fit: value with 95 % interval, unit, and whether the data determine it."""
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    return [
        Row(
            name,
            (
                estimate(cell),
                _naive(cell),
                unit(str(cell.get("unit", ""))),
                _determined(cell),
            ),
            not cell.get("determined", True),
        )
        for name, cell in cells.items()
    ]


def _naive(cell: Mapping[str, Any]) -> str:
    """Half of the 95 % interval by the fit's own covariance."""
    std = cell.get("naive_std")
    return "–" if std is None else number(BAND * std, 2)


def joint_words(campaign: Campaign) -> list[str]:
    """What the joint fit leaves open, and whether the fitted model swims straight."""
    found = campaign.coefficients.get("joint") or {}
    out = [
        f"{row.get('sentence', '')} ({row.get('combination', '')}). "
        f"A trial that helps: {row.get('trial', '')}."
        for row in found.get("undetermined") or []
    ]
    straight = (found.get("straight_swimming") or {}).get("sentence")
    reading = campaign.coefficients.get("unit_reading")
    told = [str(text).rstrip(".") + "." for text in (straight, reading) if text]
    return [*out, *told]


def table_1(campaign: Campaign) -> list[dict[str, Any]]:
    """Table I: at each power a row of this study and, where there is one, the paper's."""
    return [
        _powers_rows(power, entry)
        for power, entry in (campaign.coefficients.get("paper_steps") or {}).items()
    ]


def _powers_rows(power: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    cells = entry.get("coefficients") or {}
    published = TABLE_1.get(round(float(power)), {})
    mine = [
        (
            estimate(cells.get(p.name) or {}),
            not (cells.get(p.name) or {}).get("determined", False),
            str((cells.get(p.name) or {}).get("why") or ""),
        )
        for p in COEFFICIENTS
    ]
    return {
        "power": f"{float(power):g} %",
        "flap": number(entry.get("flap_hz")),
        "cells": mine,
        "paper_flap": number(FLAP_HZ.get(round(float(power)))),
        "paper": [number(published.get(p.name)) for p in COEFFICIENTS] if published else [],
    }


def table_2(campaign: Campaign) -> list[Row]:
    """Table II: model minus data in turn radius by condition, this study's and the paper's."""
    one_x = campaign.study.setup.robot.head_length_m
    return [
        _comparison(power, entry, one_x)
        for power, steps in (campaign.coefficients.get("paper_steps") or {}).items()
        for entry in (steps.get("steps") or {}).values()
        if entry.get("step") != 1 and entry.get("radius_m") is not None
    ]


def _comparison(power: str, entry: Mapping[str, Any], one_x: float) -> Row:
    ratio = round(float(entry["head_length_m"]) / one_x, 1)
    key = (round(float(entry["head_angle_deg"])), ratio)
    return Row(
        f"{float(power):g} %, {float(entry['head_angle_deg']):g}°, {ratio:g}x head",
        (
            "tuned to" if entry.get("step") == 2 else "predicted",
            number(entry["radius_m"]),
            number(entry.get("model_radius_m")),
            percent(entry.get("radius_difference_pct")),
            percent(TABLE_2_PCT.get(key, {}).get(round(float(power)))),
        ),
        entry.get("step") == 3,
    )


def shifts(campaign: Campaign) -> list[Row]:
    """Coefficients before and after: the baseline's had absorbed part of what was left out."""
    told = (campaign.mismatch_detail or {}).get("coefficients") or {}
    before, after = told.get("before") or {}, told.get("after") or {}
    if (campaign.mismatch or {}).get("verdict") == "none":
        return []
    return [
        Row(
            _named(name),
            (_cell(before.get(name)), _cell(after.get(name)), _moved(before.get(name), cell)),
        )
        for name, cell in after.items()
    ]


def _cell(cell: Mapping[str, Any] | None) -> str:
    return "–" if cell is None else measured(cell.get("value"), cell.get("std"))


def _named(name: str) -> str:
    """`C_T (m²)`, `tail fin lift: S (m²)`."""
    cause, _, parameter = name.rpartition(".")
    of = f" ({units()[name]})" if name in units() else ""
    return (f"{words(cause)}: " if cause else "") + parameter + of


def _moved(before: Mapping[str, Any] | None, after: Mapping[str, Any]) -> str:
    """Change in percent; none of a number that could not be told from 0."""
    if before is None:
        return "new"
    if abs(float(before["value"])) <= BAND * float(before.get("std") or 0.0):
        return "was not told from 0"
    return percent(100 * (float(after["value"]) / float(before["value"]) - 1))


def _determined(cell: Mapping[str, Any]) -> str:
    why = str(cell.get("why") or "")
    if cell.get("determined", True):
        return "determined by the data"
    return "not determined" + (f": {why}" if why else "")
