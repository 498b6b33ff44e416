"""What a person wants to know first: the verdict, why, and what it bought."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..campaign import Campaign
from ..figures.drawing.held_out import none_held_out
from ..figures.drawing.lacking import LABELS
from .numbers import in_words, measured, number, unit, units, words

KINDS = {
    "none": "Nothing beyond the noise",
    "physics": "Physics left out",
    "measurement": "The measurement is at fault",
    "unexplained": "Something is missing that no known cause explains",
}
CHANNELS = {"surge": "surge force", "sway": "sway force", "yaw": "yaw moment"}


@dataclass(frozen=True)
class Cause:
    """One cause in words."""

    name: str
    sentence: str
    regime: str
    channels: str
    weight: str
    parameters: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """One line of a table: a name and its cells."""

    name: str
    cells: tuple[str, ...]
    marked: bool = False


def summary(campaign: Campaign) -> str:
    """What was analysed, in one sentence."""
    trials, done = campaign.study.trials, campaign.analysed
    powers = sorted({trial.power_pct for trial in trials})
    angles = sorted({abs(trial.head_angle_deg) for trial in trials})
    heads = sorted({trial.head_length_m for trial in trials})
    return (
        f"{len(done)} of {len(trials)} trials analysed: {_listed(powers)} % power, head angles of "
        f"{_listed(angles)} degrees, head lengths of {_listed(heads)} m."
    )


def verdict(campaign: Campaign) -> dict[str, str]:
    """Kind of verdict (for its colour), heading and sentence."""
    found = campaign.mismatch
    if not found:
        return {
            "kind": "missing",
            "heading": "Not searched",
            "sentence": "The search for what the model leaves out was not part of this run.",
        }
    kind = str(found.get("verdict", "missing"))
    heading = KINDS.get(kind, kind)
    names = [words(str(cause["name"])) for cause in found.get("causes") or []]
    if kind in ("physics", "measurement") and names:
        heading += ": " + " and ".join(names)
    sentence = in_words(str(found.get("sentence") or heading), _causes_known())
    return {"kind": kind, "heading": heading, "sentence": f"{sentence}{_caution(campaign)}"}


def _caution(campaign: Campaign) -> str:
    """What to say where the fit under the verdict tells next to nothing."""
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    if not cells or any(cell.get("determined", True) for cell in cells.values()):
        return ""
    return (
        " But these recordings determine none of the model's coefficients: the verdict says little "
        "before they do. Look for a trial that does not belong, and see the coefficients."
    )


def _causes_known() -> set[str]:
    return {name.split(".")[0] for name in units() if "." in name}


def numbers(campaign: Campaign) -> list[tuple[str, str]]:
    """A few numbers worth a glance: number and what it is."""
    rows = [campaign.steady[trial.trial_id] for trial in campaign.analysed]
    fastest = max((r for r in rows if r.speed_m_s > 0), key=lambda r: r.speed_m_s, default=None)
    body = campaign.study.setup.robot.body_length_m
    good = [r for r in rows if r.quality == "good"]
    tightest = min(good, key=lambda r: r.radius_m, default=None)
    out = [(f"{len(campaign.analysed)}/{len(campaign.study.trials)}", "trials analysed")]
    if fastest:
        lengths = fastest.speed_m_s / body
        out.append((f"{fastest.speed_m_s:.3f} m/s", f"fastest steady speed, {lengths:.2f} BL/s"))
    if tightest:
        lengths = tightest.radius_m / body
        out.append((f"{tightest.radius_m:.3f} m", f"tightest steady turn, {lengths:.2f} BL"))
    when = ", before and after" if campaign.has_additions else ""
    known = [1000 * campaign.held_out_error(k, "path_rmse_m") for k in campaign.held_out_models]
    if all(math.isfinite(value) for value in known):
        which = "the fitted trials" if none_held_out(campaign) else "held-out trials"
        text = " → ".join(f"{value:.1f}" for value in known)
        out.append((f"{text} mm", f"path error on {which}{when}"))
    return out


def causes(campaign: Campaign) -> list[Cause]:
    """Causes of the verdict, the one that explains most first."""
    return [_cause(entry) for entry in (campaign.mismatch or {}).get("causes") or []]


def where(campaign: Campaign) -> list[Row]:
    """Channels and variables that foretell the missing force."""
    return [
        Row(
            CHANNELS.get(str(r["channel"]), str(r["channel"])),
            (
                LABELS.get(str(r["variable"]), words(str(r["variable"]))),
                _share(r.get("share")),
                ", ".join(r.get("trials") or []),
            ),
        )
        for r in (campaign.mismatch or {}).get("where") or []
    ]


def rivals(campaign: Campaign) -> list[Row]:
    """Causes that the data cannot quite exclude, and how to tell them apart."""
    rows = (campaign.mismatch or {}).get("rivals") or []
    return [
        Row(words(str(r["name"])), (_share(r.get("weight")), _told(r.get("how_to_tell_apart"))))
        for r in rows
    ]


def next_trial(campaign: Campaign) -> str:
    """The trial that would tell most, in a sentence; empty where none is named."""
    found = (campaign.mismatch or {}).get("next_trial")
    if not found:
        return ""
    parts = [f"{number(found['power_pct'])} % power"] if "power_pct" in found else []
    if "head_angle_deg" in found:
        parts.append(f"{float(found['head_angle_deg']):g} degrees head angle")
    if "head_length_m" in found:
        parts.append(f"{float(found['head_length_m']):g} m head")
    return ", ".join(parts) + f": {_told(found.get('why'))}"


def candidates(campaign: Campaign) -> list[Row]:
    """All candidates that were refitted: round, gain, how many trials it helped, outcome."""
    chosen = {str(c["name"]) for c in (campaign.mismatch or {}).get("causes") or []}
    rows = (campaign.mismatch_detail or {}).get("candidates") or []
    return [
        Row(
            words(str(r["name"])),
            (
                str(r.get("round", 1)),
                number(r.get("held_out_gain")),
                f"{r.get('trials_better', '–')} of {r.get('trials', '–')}",
                ", ".join(f"{k} = {number(v)}" for k, v in (r.get("parameters") or {}).items()),
                str(r.get("outcome") or ""),
            ),
            str(r["name"]) in chosen,
        )
        for r in rows
    ]


def _cause(entry: dict[str, Any]) -> Cause:
    parameters = [
        f"{name} = {measured(cell.get('value'), cell.get('std'), unit(str(cell.get('unit', ''))))}"
        for name, cell in (entry.get("parameters") or {}).items()
    ]
    channels = [CHANNELS.get(name, name) for name in entry.get("channels") or []]
    return Cause(
        name=words(str(entry["name"])),
        sentence=str(entry.get("sentence") or ""),
        regime=str(entry.get("regime") or ""),
        channels=", ".join(channels),
        weight=_share(entry.get("weight")),
        parameters=tuple(parameters),
    )


def _told(sentence: Any) -> str:
    return in_words(str(sentence or ""), _causes_known())


def _share(weight: Any) -> str:
    return "–" if weight is None else f"{100 * float(weight):.0f} %"


def _listed(values: list[float]) -> str:
    texts = [f"{value:g}" for value in values]
    return texts[0] if len(texts) == 1 else ", ".join(texts[:-1]) + " and " + texts[-1]
