"""Ground truth of a synthetic study beside the results obtained without it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from bluekoi.campaign import Campaign
from bluekoi.data import SteadyState
from bluekoi.report.findings import TableRow
from bluekoi.report.numbers import (
    Z_95,
    coefficient_with_interval,
    format_number,
    format_percent,
    parameter_units,
    readable_name,
    value_with_interval,
)
from bluekoi.report.settings import flatten_mapping

from .content import KNOWN_KEYS, injected_causes, true_coefficients, true_steady, true_trials
from .seal import Seal

MAX_CELL_CHARACTERS = 200
MAX_ROWS = 300


@dataclass(frozen=True)
class GroundTruth:
    """Sentence on the seal, and tables (empty if the truth is not available)."""

    sha256: str
    sentence: str
    broken: bool
    causes: list[TableRow]
    coefficients: list[TableRow]
    trials: list[TableRow]
    further: list[tuple[str, str]]


def ground_truth(campaign: Campaign, seal: Seal) -> GroundTruth:
    """Comparison of a study's truth with the results.

    The truth may contain `hidden` (cause -> parameters) or `causes` (as in mismatch.json),
    `coefficients` (name -> value, or power -> name -> value) and `trials` (list with `trial_id`,
    `flap_hz`, `speed_m_s`, `radius_m`, and `true_path_without_recoil` for a comparison over the
    measured interval); anything else is listed unchanged.
    """
    truth = seal.truth
    return GroundTruth(
        sha256=seal.sha256,
        sentence=_seal_sentence(seal),
        broken=seal.broken,
        causes=_cause_rows(campaign, truth),
        coefficients=_coefficient_rows(campaign, truth),
        trials=_trial_rows(campaign, truth),
        further=list(_further_rows(truth)),
    )


def _seal_sentence(seal: Seal) -> str:
    if seal.broken:
        return f"The seal is broken: {seal.trouble}. Its content is not shown."
    if seal.trouble:
        return (
            f"The ground truth of this study is sealed: {seal.trouble}. Once its author publishes "
            "the file, put it there and make this page again."
        )
    return "This study is synthetic. Its ground truth was not read during the analysis."


def _cause_rows(campaign: Campaign, truth: Mapping[str, Any]) -> list[TableRow]:
    """Injected and identified causes with their parameters, and whether they agree."""
    true = injected_causes(truth)
    if true is None:
        return []
    found = campaign.mismatch or {}
    named = {str(c["name"]): c for c in found.get("causes") or []}
    rivals = {str(r["name"]) for r in found.get("rivals") or []}
    if not true and not named:
        outcome = str(found.get("verdict", ""))
        return [TableRow("none", ("–", "–", "correct: none" if outcome == "none" else outcome))]
    return [
        TableRow(
            readable_name(name),
            (
                _parameter_rows(name, true.get(name)),
                _fitted_text(name, named.get(name)),
                _agreement_text(name in true, name in named, name in rivals),
            ),
            (name in true) != (name in named),
        )
        for name in dict.fromkeys([*true, *named])
    ]


def _agreement_text(true: bool, named: bool, rival: bool) -> str:
    if true and named:
        return "identified"
    if true:
        return "missed; listed as an alternative" if rival else "missed"
    return "false positive"


def _parameter_rows(cause: str, values: Any) -> str:
    if not isinstance(values, Mapping):
        return "–"
    cells = [
        f"{k} = {_truncated_text(v)} {parameter_units().get(f'{cause}.{k}', '')}"
        for k, v in values.items()
    ]
    return ", ".join(text.strip() for text in cells) or "–"


def _fitted_text(cause: str, found: Mapping[str, Any] | None) -> str:
    cells = (found or {}).get("parameters") or {}
    texts = [
        f"{k} = "
        + value_with_interval(
            c.get("value"), c.get("std"), parameter_units().get(f"{cause}.{k}", "")
        )
        for k, c in cells.items()
    ]
    return ", ".join(texts)


def _coefficient_rows(campaign: Campaign, truth: Mapping[str, Any]) -> list[TableRow]:
    """True coefficients beside the joint fit without and with the identified causes."""
    joint = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    fits = (campaign.mismatch_detail or {}).get("coefficients") or {}
    searched = (campaign.mismatch or {}).get("verdict", "none") != "none"
    after = (fits.get("after") or {}) if searched else {}
    steps = campaign.coefficients.get("paper_steps") or {}
    rows = []
    for name, value in sorted(true_coefficients(truth).items(), key=_sort_key):
        if isinstance(value, Mapping):
            cells = (steps.get(name) or {}).get("coefficients") or {}
            pairs = sorted(value.items(), key=_sort_key)
            rows += [_coefficient_row(k, v, cells.get(k), at=f" at {name} %") for k, v in pairs]
        else:
            rows.append(_coefficient_row(name, value, joint.get(name), after.get(name)))
    return rows


def _sort_key(entry: tuple[str, Any]) -> tuple[int, str]:
    """Coefficients in the order of the model, then others; powers ascending."""
    name, order = entry[0], list(parameter_units())
    return (order.index(name) if name in order else len(order), name.rjust(4))


def _coefficient_row(
    name: str, true: Any, before: Any, after: Any = None, *, at: str = ""
) -> TableRow:
    undetermined = isinstance(before, Mapping) and not before.get("determined", True)
    return TableRow(
        f"{name}{at} ({parameter_units()[name]})" if name in parameter_units() else name + at,
        (
            _truncated_text(true),
            _cell_text(before) + (" (not determined)" if undetermined else ""),
            _interval_contains(true, None if undetermined else before),
            _cell_text(after),
            _interval_contains(true, after),
        ),
    )


def _cell_text(cell: Mapping[str, Any] | None) -> str:
    return "–" if not cell else coefficient_with_interval(cell)


def _interval_contains(true: Any, cell: Mapping[str, Any] | None) -> str:
    """Whether the true value lies in the 95 % interval."""
    if not cell or not _is_number(true) or not cell.get("std"):
        return "–"
    off = abs(float(cell["value"]) - float(true)) / float(cell["std"])
    low, high = cell.get("interval_95") or (None, None)
    inside = off <= Z_95 if low is None or high is None else low <= float(true) <= high
    return "inside" if inside else f"{off:.1f} standard errors away"


def _trial_rows(campaign: Campaign, truth: Mapping[str, Any]) -> list[TableRow]:
    """True and measured speed, radius and flapping frequency of each trial."""
    return [
        _trial_row(name, campaign.steady[name], entry)
        for name, entry in true_trials(truth).items()
        if name in campaign.steady
    ]


def _trial_row(name: str, found: SteadyState, entry: Mapping[str, Any]) -> TableRow:
    speed, radius = true_steady(entry, found.steady_from_s, found.steady_to_s)
    turning = math.isfinite(found.radius_m)
    cells = [_true_and_found_cells(speed, found.speed_m_s)]
    cells += [
        _true_and_found_cells(radius, found.radius_m) if turning else ("straight", "straight", "–")
    ]
    cells += [_true_and_found_cells(entry.get("flap_hz"), found.flap_hz, 5)]
    return TableRow(name, tuple(text for cell in cells for text in cell))


def _true_and_found_cells(true: Any, found: float, digits: int = 4) -> tuple[str, str, str]:
    if not _is_number(true) or not true:
        return _truncated_text(true), format_number(found, digits), "–"
    off = format_percent(100 * (found / float(true) - 1), 2)
    return format_number(true, digits), format_number(found, digits), off


def _further_rows(truth: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Remaining entries of the truth, key and value, long values truncated."""
    rest = {key: value for key, value in truth.items() if key not in KNOWN_KEYS}
    rows = list(flatten_mapping(rest)) if rest else []
    for key, value in rows[:MAX_ROWS]:
        text = f"{value:g}" if _is_number(value) else _truncated_text(value)
        yield key, text if len(text) <= MAX_CELL_CHARACTERS else text[:MAX_CELL_CHARACTERS] + " ..."
    if len(rows) > MAX_ROWS:
        yield "...", f"{len(rows) - MAX_ROWS} more entries in the sealed file"


def _truncated_text(value: Any) -> str:
    return format_number(value, 4) if _is_number(value) else "–" if value is None else str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300
