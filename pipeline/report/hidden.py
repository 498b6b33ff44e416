"""What was hidden in a made study, beside what was found without knowing it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..campaign import Campaign
from ..data import Steady
from ..study.seal import Seal
from .numbers import BAND, estimate, measured, number, percent, units, words
from .story import Row
from .truth import READ, put_in, true_coefficients, true_steady, true_trials

LONGEST_CELL = 200
MOST_ROWS = 300


@dataclass(frozen=True)
class Hidden:
    """The section's parts: a sentence on the seal, and tables that stay empty without a truth."""

    sha256: str
    sentence: str
    broken: bool
    causes: list[Row]
    coefficients: list[Row]
    trials: list[Row]
    further: list[tuple[str, str]]


def hidden(campaign: Campaign, seal: Seal | None) -> Hidden | None:
    """What the page shows of a study's seal; None for a study without one.

    The truth may hold `hidden` (cause -> parameters) or `causes` (as in mismatch.json),
    `coefficients` (name -> value, or power -> name -> value) and `trials` (list with `trial_id`,
    `flap_hz`, `speed_m_s`, `radius_m` and, to compare over the very stretch that was measured,
    `mean_path`); anything else is listed as it stands.
    """
    if seal is None:
        return None
    truth = seal.truth
    return Hidden(
        sha256=seal.sha256,
        sentence=_sentence(seal),
        broken=seal.broken,
        causes=_causes(campaign, truth),
        coefficients=_coefficients(campaign, truth),
        trials=_trials(campaign, truth),
        further=list(_further(truth)),
    )


def _sentence(seal: Seal) -> str:
    if seal.broken:
        return f"The seal does not hold: {seal.trouble}. Nothing of it is shown."
    if seal.trouble:
        return (
            f"The truth of this study is under seal: {seal.trouble}. When its maker hands it out, "
            "put it there and run again: it is shown here if it has the hash published before."
        )
    return (
        "This study was made, and what it was made from lay under seal while it was analysed: no "
        "stage before this page reads it. It has the hash that was published with the study."
    )


def _causes(campaign: Campaign, truth: Mapping[str, Any]) -> list[Row]:
    """Each hidden cause and each cause named: its parameters, and whether the two agree."""
    true = put_in(truth)
    if true is None:
        return []
    told = campaign.mismatch or {}
    named = {str(c["name"]): c for c in told.get("causes") or []}
    rivals = {str(r["name"]) for r in told.get("rivals") or []}
    if not true and not named:
        agreed = "found: nothing" if told.get("verdict") == "none" else str(told.get("verdict", ""))
        return [Row("nothing", ("–", "–", agreed))]
    return [
        Row(
            words(name),
            (
                _parameters(name, true.get(name)),
                _fitted(name, named.get(name)),
                _agreement(name in true, name in named, name in rivals),
            ),
            (name in true) != (name in named),
        )
        for name in dict.fromkeys([*true, *named])
    ]


def _agreement(true: bool, named: bool, rival: bool) -> str:
    if true and named:
        return "found"
    if true:
        return "not named; among the rivals" if rival else "missed"
    return "named, but not in what was hidden"


def _parameters(cause: str, values: Any) -> str:
    if not isinstance(values, Mapping):
        return "–"
    told = [f"{k} = {_text(v)} {units().get(f'{cause}.{k}', '')}" for k, v in values.items()]
    return ", ".join(text.strip() for text in told) or "–"


def _fitted(cause: str, found: Mapping[str, Any] | None) -> str:
    cells = (found or {}).get("parameters") or {}
    told = [
        f"{k} = {measured(c.get('value'), c.get('std'), units().get(f'{cause}.{k}', ''))}"
        for k, c in cells.items()
    ]
    return ", ".join(told)


def _coefficients(campaign: Campaign, truth: Mapping[str, Any]) -> list[Row]:
    """True coefficients beside the joint fit without and with what was left out."""
    joint = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    told = (campaign.mismatch_detail or {}).get("coefficients") or {}
    searched = (campaign.mismatch or {}).get("verdict", "none") != "none"
    after = (told.get("after") or {}) if searched else {}
    steps = campaign.coefficients.get("paper_steps") or {}
    rows = []
    for name, value in sorted(true_coefficients(truth).items(), key=_place):
        if isinstance(value, Mapping):
            cells = (steps.get(name) or {}).get("coefficients") or {}
            pairs = sorted(value.items(), key=_place)
            rows += [_coefficient(k, v, cells.get(k), at=f" at {name} %") for k, v in pairs]
        else:
            rows.append(_coefficient(name, value, joint.get(name), after.get(name)))
    return rows


def _place(entry: tuple[str, Any]) -> tuple[int, str]:
    """The model's coefficients in its order, then others; powers by size."""
    name, order = entry[0], list(units())
    return (order.index(name) if name in order else len(order), name.rjust(4))


def _coefficient(name: str, true: Any, before: Any, after: Any = None, *, at: str = "") -> Row:
    open_ = isinstance(before, Mapping) and not before.get("determined", True)
    return Row(
        f"{name}{at} ({units()[name]})" if name in units() else name + at,
        (
            _text(true),
            _cell(before) + (" (not determined)" if open_ else ""),
            _inside(true, None if open_ else before),
            _cell(after),
            _inside(true, after),
        ),
    )


def _cell(cell: Mapping[str, Any] | None) -> str:
    return "–" if not cell else estimate(cell)


def _inside(true: Any, cell: Mapping[str, Any] | None) -> str:
    """Whether the true value lies in the 95 % interval."""
    if not cell or not _is_number(true) or not cell.get("std"):
        return "–"
    off = abs(float(cell["value"]) - float(true)) / float(cell["std"])
    low, high = cell.get("interval_95") or (None, None)
    inside = off <= BAND if low is None or high is None else low <= float(true) <= high
    return "inside" if inside else f"{off:.1f} deviations off"


def _trials(campaign: Campaign, truth: Mapping[str, Any]) -> list[Row]:
    """Speed, radius and flapping frequency of each trial, true and measured."""
    return [
        _trial(name, campaign.steady[name], entry)
        for name, entry in true_trials(truth).items()
        if name in campaign.steady
    ]


def _trial(name: str, found: Steady, entry: Mapping[str, Any]) -> Row:
    speed, radius = true_steady(entry, found.steady_from_s, found.steady_to_s)
    turning = math.isfinite(found.radius_m)
    cells = [_pair(speed, found.speed_m_s)]
    cells += [_pair(radius, found.radius_m) if turning else ("straight", "straight", "–")]
    cells += [_pair(entry.get("flap_hz"), found.flap_hz, 5)]
    return Row(name, tuple(text for cell in cells for text in cell))


def _pair(true: Any, found: float, digits: int = 4) -> tuple[str, str, str]:
    if not _is_number(true) or not true:
        return _text(true), number(found, digits), "–"
    off = percent(100 * (found / float(true) - 1), 2)
    return number(true, digits), number(found, digits), off


def _further(truth: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What else was sealed, key and value, cut short where it is long."""
    rest = {key: value for key, value in truth.items() if key not in READ}
    rows = list(_flat("", rest)) if rest else []
    yield from rows[:MOST_ROWS]
    if len(rows) > MOST_ROWS:
        yield "...", f"{len(rows) - MOST_ROWS} more entries in the sealed file"


def _flat(prefix: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping) and value:
        for key, entry in value.items():
            yield from _flat(f"{prefix}.{key}".lstrip("."), entry)
    else:
        text = f"{value:g}" if _is_number(value) else _text(value)
        yield prefix, text if len(text) <= LONGEST_CELL else text[:LONGEST_CELL] + " ..."


def _text(value: Any) -> str:
    return number(value, 4) if _is_number(value) else "–" if value is None else str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300
