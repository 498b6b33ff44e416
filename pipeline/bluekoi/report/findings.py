"""Verdict, causes and evidence of mismatch.json as text and tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..camera.homography_camera import NO_MATRIX_REMARK
from ..campaign import Campaign
from ..figures.drawing.held_out import evaluated_on_fitted_trials
from ..figures.drawing.missing_force import FORCE_NAMES, VARIABLE_LABELS
from ..trial_warnings import warnings_after_run
from .numbers import (
    format_number,
    format_probability,
    format_unit,
    parameter_units,
    parameter_with_interval,
    readable_name,
    with_readable_names,
)
from .template import VERDICT_HEADINGS, verdict_heading


@dataclass(frozen=True)
class CauseText:
    """One cause as text. Of a cause that was measured directly, `measured` states how far from 0;
    it acts on what was measured instead of on forces, and has no probability.
    """

    name: str
    sentence: str
    regime: str
    channels: str
    weight: str
    measured: str
    parameters: tuple[str, ...]
    credible_set: str


@dataclass(frozen=True)
class TableRow:
    """One line of a table: a name and its cells."""

    name: str
    cells: tuple[str, ...]
    marked: bool = False


def study_summary_sentence(campaign: Campaign) -> str:
    """What was analysed, in one sentence."""
    trials, done = campaign.study.trials, campaign.analysed
    powers = sorted({trial.power_pct for trial in trials})
    angles = sorted({abs(trial.head_angle_deg) for trial in trials})
    heads = sorted({trial.head_length_m for trial in trials})
    return (
        f"{len(done)} of {len(trials)} trials analysed: {_joined_list(powers)} % power, head "
        f"angles of {_joined_list(angles)} degrees, head lengths of {_joined_list(heads)} m."
    )


def verdict_texts(campaign: Campaign) -> dict[str, str]:
    """Kind of verdict (sets the colour), heading and sentence."""
    found = campaign.mismatch
    if not found:
        return {
            "kind": "missing",
            "heading": "No search for causes",
            "sentence": "This run did not search for causes of a mismatch.",
        }
    kind = str(found.get("verdict", "missing"))
    heading = verdict_heading(kind, str(found.get("sentence") or ""))
    causes = [(str(c.get("kind", kind)), readable_name(str(c["name"])))
              for c in found.get("causes") or []]  # fmt: skip
    listed = [c for c in causes if c[1] != "unexplained"]
    if kind in ("physics", "measurement") and causes:
        heading = verdict_heading_with_causes(kind, causes)
    elif kind == "unexplained" and listed:
        heading = verdict_heading_with_causes(listed[0][0], listed)
        heading += "; and a force that no known cause explains"
    sentence = with_readable_names(str(found.get("sentence") or heading), _candidate_cause_names())
    return {"kind": kind, "heading": heading, "sentence": sentence}


def verdict_heading_with_causes(kind: str, causes: Sequence[tuple[str, str]]) -> str:
    """Heading with the causes, (kind, name) each, below the words for their kind; the verdict's
    kind stands first.
    """
    kinds = dict.fromkeys((kind, *(own for own, _ in causes)))
    parts = [
        (VERDICT_HEADINGS[k], " and ".join(name for own, name in causes if own == k)) for k in kinds
    ]
    return "; ".join(f"{words}: {names}" for words, names in parts if names)


def campaign_warnings(campaign: Campaign) -> list[str]:
    """Warnings on the robot, clocks, speeds, powers and lengths, on a camera without calibration,
    of the search, and one if no coefficient is determined.
    """
    found = warnings_after_run(
        campaign.study, campaign.statuses, campaign.geometry, campaign.mismatch
    )
    found += _missing_camera_matrix_remark(campaign)
    found += [
        _with_readable_cause_names(text) for text in (campaign.mismatch or {}).get("warnings") or []
    ]
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    if campaign.mismatch and cells and not any(c.get("determined", True) for c in cells.values()):
        found.append(
            "These recordings determine none of the model's coefficients, so the verdict is not "
            "reliable. Look for a trial with wrong data, and see the section Coefficients."
        )
    return found


def _missing_camera_matrix_remark(campaign: Campaign) -> list[str]:
    """The remark of the trials that were mapped without a camera matrix, once."""
    remarks = {text for one in campaign.statuses.values() for text in one.get("remarks") or []}
    found = sorted(text for text in remarks if text.startswith(NO_MATRIX_REMARK))
    return [_with_readable_cause_names(text) for text in found[-1:]]


def _candidate_cause_names() -> set[str]:
    return {name.split(".")[0] for name in parameter_units() if "." in name}


def headline_values(campaign: Campaign) -> list[tuple[str, str]]:
    """A few values with their meaning."""
    rows = [campaign.steady[trial.trial_id] for trial in campaign.analysed]
    fastest = max((r for r in rows if r.speed_m_s > 0), key=lambda r: r.speed_m_s, default=None)
    body = campaign.study.setup.robot.body_length_m
    tightest = min((r for r in rows if r.quality == "good"), key=lambda r: r.radius_m, default=None)
    out = [(f"{len(campaign.analysed)}/{len(campaign.study.trials)}", "trials analysed")]
    if fastest:
        lengths = f"{fastest.speed_m_s / body:.2f} body lengths/s"
        wrong = (campaign.mismatch or {}).get("clock_factor")
        clock = "; in the stated frame rate, which is wrong" if wrong else ""
        out.append((f"{fastest.speed_m_s:.3f} m/s", f"highest steady speed, {lengths}{clock}"))
    if tightest:
        lengths = f"{tightest.radius_m / body:.2f} body lengths"
        out.append((f"{tightest.radius_m:.3f} m", f"smallest steady turn radius, {lengths}"))
    errors = [1000 * campaign.held_out_error(k, "path_rmse_m") for k in campaign.held_out_models]
    if all(math.isfinite(value) for value in errors):
        which = "the fitted trials" if evaluated_on_fitted_trials(campaign) else "held-out trials"
        models = ": baseline → with identified causes" if campaign.has_additions else ""
        text = " → ".join(f"{value:.1f}" for value in errors)
        out.append((f"{text} mm", f"rms path error on {which}{models}"))
    return out


def cause_texts(campaign: Campaign) -> list[CauseText]:
    """Causes of the verdict, the one that explains most first."""
    return [_cause_text(entry) for entry in (campaign.mismatch or {}).get("causes") or []]


def missing_force_dependence_rows(campaign: Campaign) -> list[TableRow]:
    """Variables that explain the missing force, with the explained share."""
    return [
        TableRow(
            FORCE_NAMES.get(str(r["channel"]), str(r["channel"])),
            (
                VARIABLE_LABELS.get(str(r["variable"]), readable_name(str(r["variable"]))),
                format_probability(r.get("share")),
                ", ".join(r.get("trials") or []),
            ),
        )
        for r in (campaign.mismatch or {}).get("where") or []
    ]


def probability_table_rows(campaign: Campaign) -> list[TableRow]:
    """Inclusion probability of every candidate, the largest first."""
    found = campaign.mismatch or {}
    selected = {str(cause["name"]) for cause in found.get("causes") or []}
    given = {str(k): float(v) for k, v in (found.get("probabilities") or {}).items()}
    return [
        TableRow(readable_name(name), (f"{value:.3f}",), name in selected)
        for name, value in sorted(given.items(), key=lambda item: (-item[1], item[0]))
    ]


def rival_cause_texts(campaign: Campaign) -> list[TableRow]:
    """Causes that the data do not exclude, and how to distinguish them."""
    return [
        TableRow(
            readable_name(str(r["name"])),
            (
                format_probability(r.get("weight")),
                _with_readable_cause_names(r.get("how_to_tell_apart")),
            ),
        )
        for r in (campaign.mismatch or {}).get("rivals") or []
    ]


def next_trial_sentence(campaign: Campaign) -> str:
    """The most informative next trial, in a sentence; empty if none is proposed."""
    found = (campaign.mismatch or {}).get("next_trial")
    if not found:
        return ""
    if found.get("above_noise") is False:
        why = _with_readable_cause_names(found.get("why"))
        return why[:1].upper() + why[1:]
    parts = [f"{format_number(found['power_pct'])} % power"] if "power_pct" in found else []
    if "head_angle_deg" in found:
        parts.append(f"{float(found['head_angle_deg']):g} degrees head angle")
    if "head_length_m" in found:
        parts.append(f"{float(found['head_length_m']):g} m head")
    return ", ".join(parts) + f": {_with_readable_cause_names(found.get('why'))}"


def _cause_text(entry: dict[str, Any]) -> CauseText:
    parameters = [
        f"{name} = "
        + parameter_with_interval(
            f"{entry['name']}.{name}", cell, format_unit(str(cell.get("unit", ""))).strip("–")
        )
        + (f": {cell['meaning']}" if cell.get("meaning") else "")
        for name, cell in (entry.get("parameters") or {}).items()
    ]
    others, sigmas = entry.get("credible_set") or [], entry.get("measured_standard_errors")
    channels = () if sigmas else entry.get("channels") or ()
    return CauseText(
        name=readable_name(str(entry["name"])),
        sentence=str(entry.get("sentence") or ""),
        regime=str(entry.get("regime") or ""),
        channels=", ".join(FORCE_NAMES.get(name, name) for name in channels),
        weight="" if sigmas else format_probability(entry.get("weight")),
        measured=f"{sigmas:.0f} standard errors from 0" if sigmas else "",
        parameters=tuple(parameters),
        credible_set=", ".join(readable_name(str(name)) for name in others)
        if len(others) > 1
        else "",
    )


def _with_readable_cause_names(text: Any) -> str:
    return with_readable_names(str(text or ""), _candidate_cause_names())


def _joined_list(values: list[float]) -> str:
    texts = [f"{value:g}" for value in values]
    return texts[0] if len(texts) == 1 else ", ".join(texts[:-1]) + " and " + texts[-1]
