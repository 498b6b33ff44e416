"""The table of a challenge: what was named, located, measured, how sure, and what it brought."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .score import Judged

BINS = ((0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.01))
COVERED = 1.96


def summary(judged: Sequence[Judged]) -> dict[str, Any]:
    """All figures of the table; shares are [right, of]."""
    return {
        "studies": len(judged),
        "failed": [j.name for j in judged if j.failure],
        "named": _named(judged),
        "false_alarms": _false_alarms(judged),
        "localisation": _localisation(judged),
        "parameters": _parameters(judged),
        "calibration": _calibration(judged),
        "held_out_mm": _held_out(judged),
        "cpu_s": _times(judged),
    }


def share(judged: Sequence[Judged], test: Callable[[Judged], bool]) -> list[int]:
    """[how many pass, of how many]."""
    return [sum(map(test, judged)), len(judged)]


def _named(judged: Sequence[Judged]) -> dict[str, list[int]]:
    """Right, by kind, level, size, body and source of the pixels."""
    groups: dict[str, Callable[[Judged], bool]] = {
        "all": lambda j: bool(j.name),
        "null, bare robot": lambda j: j.kind == "null" and not j.fin,
        "null, robot with a fin": lambda j: j.kind == "null" and j.fin,
        "single, clear": lambda j: j.kind == "single" and j.level == "clear" and j.trials > 9,
        "single, faint": lambda j: j.kind == "single" and j.level == "faint" and j.trials > 9,
        "double": lambda j: j.kind == "double",
        "outside the list": lambda j: j.kind == "outside",
        "measurement": lambda j: j.kind == "measurement",
        "nine trials": lambda j: j.trials == 9,
        "from footage": lambda j: j.footage,
    }
    out = {}
    for name, belongs in groups.items():
        group = [j for j in judged if belongs(j)]
        if group:
            out[name] = share(group, lambda j: j.right)
    doubles = [j for j in judged if j.kind == "double"]
    if doubles:
        out["double, both found"] = share(doubles, lambda j: j.found)
    return out


def _false_alarms(judged: Sequence[Judged]) -> dict[str, Any]:
    """Names that are not true: on nulls, and how many a study elsewhere."""
    nulls = [j for j in judged if j.kind == "null" and not j.failure]
    others = [j for j in judged if j.kind != "null" and not j.failure]
    return {
        "nulls with a false name": share(nulls, lambda j: bool(j.false)),
        "other studies with a false name": share(others, lambda j: bool(j.false)),
    }


def _localisation(judged: Sequence[Judged]) -> dict[str, float]:
    """F1 of the channels, and of the channel together with the kind of variable (`KINDS`)."""
    hits, said, true = (sum(j.channels[i] for j in judged) for i in range(3))
    precision, recall = hits / max(said, 1), hits / max(true, 1)
    true_told, told, found, effects = (sum(j.places[i] for j in judged) for i in range(4))
    p, r = true_told / max(told, 1), found / max(effects, 1)
    return {
        "channel_precision": precision,
        "channel_recall": recall,
        "channel_F1": 2 * hits / max(said + true, 1),
        "variable_precision": p,
        "variable_recall": r,
        "variable_F1": 2 * p * r / max(p + r, 1e-9),
    }


def _parameters(judged: Sequence[Judged]) -> dict[str, Any]:
    """Relative errors and coverage of the 95 % intervals, where law and candidate are the same."""
    right = [j for j in judged if j.right]
    errors = [abs(e) for j in right for e in j.errors.values()]
    pulls = [abs(p) for j in right for p in j.pulls.values()]
    return {
        "median_error_pct": 100 * float(np.median(errors)) if errors else None,
        "within_95": [sum(p <= COVERED for p in pulls), len(pulls)],
    }


def _calibration(judged: Sequence[Judged]) -> list[dict[str, Any]]:
    """Of the causes given a weight in each range: how many are true, the mean weight."""
    pairs = [(w, n in j.true) for j in judged for n, w in j.weights.items()]
    out = []
    for low, high in BINS:
        inside = [(w, true) for w, true in pairs if low <= w < high]
        if inside:
            mean = float(np.mean([w for w, _ in inside]))
            count = [sum(true for _, true in inside), len(inside)]
            out.append({"from": low, "to": min(high, 1.0), "mean_weight": mean, "true": count})
    return out


def _held_out(judged: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """Medians by whether the cause was named right, and how many end within 1.3 floors."""
    groups = {
        "named right": [j for j in judged if j.right and j.said and j.held_out],
        "not": [j for j in judged if not j.right and j.held_out],
    }
    out: dict[str, dict[str, Any]] = {}
    for name, group in groups.items():
        if group:
            told: dict[str, Any] = {
                k: float(np.nanmedian([j.held_out[k] for j in group]))
                for k in ("before", "after", "true_law", "floor")
            }
            told["within 1.3 floors"] = share(
                group, lambda j: j.held_out["after"] <= 1.3 * j.held_out["floor"]
            )
            out[name] = told
    return out


def _times(judged: Sequence[Judged]) -> dict[str, float]:
    """Median processor time of each stage, 24-trial studies from keypoints."""
    group = [j for j in judged if j.trials == 24 and not j.footage and not j.failure]
    stages = sorted({s for j in group for s in j.cpu_s})
    return {s: float(np.median([j.cpu_s.get(s, 0.0) for j in group])) for s in stages}


def lines(judged: Sequence[Judged]) -> list[str]:
    """One line a study: truth, verdict with weights, held-out errors, time."""
    return [_line(j) for j in judged]


def _line(j: Judged) -> str:
    mark = "ok " if j.right else "-- "
    said = ", ".join(f"{n} {w:.2f}" for n, w in j.weights.items()) or j.verdict
    near = [n for n in j.together if n not in j.said]
    if near:
        said += f" (or {', '.join(near)})"
    size = f"{j.trials}{'v' if j.footage else ''}{'f' if j.fin else ''}"
    strength = f" x{j.ratio:.1f}" if j.ratio else ""
    truth = ", ".join(f"{n} [{law}]" for n, law in zip(j.true, j.laws, strict=True)) or "nothing"
    error = " ".join(f"{j.held_out[k]:.1f}" for k in j.held_out)
    tail = j.failure or f"{error} mm, {sum(j.cpu_s.values()):.0f} s"
    return f"{mark}{j.name} {j.kind:11s} {size:4s} {j.level}{strength}: {truth} -> {said}; {tail}"


def told(figures: dict[str, Any]) -> list[str]:
    """The summary in lines a person can read."""
    out = [f"{figures['studies']} studies, {len(figures['failed'])} failed"]
    out += [f"  named right, {k}: {_of(v)}" for k, v in figures["named"].items()]
    out += [f"  {k}: {_of(v)}" for k, v in figures["false_alarms"].items()]
    out += [f"  {k}: {v:.2f}" for k, v in figures["localisation"].items()]
    error = figures["parameters"]["median_error_pct"]
    if error is not None:
        out.append(f"  parameters (same law): median error {error:.1f} %, "
                   f"95 % intervals hold {_of(figures['parameters']['within_95'])}")  # fmt: skip
    for row in figures["calibration"]:
        out.append(f"  weight {row['from']:.2f} to {row['to']:.2f} (mean {row['mean_weight']:.2f}):"
                   f" true {_of(row['true'])}")  # fmt: skip
    for name, row in figures["held_out_mm"].items():
        errors = ", ".join(f"{k} {row[k]:.1f}" for k in ("before", "after", "true_law", "floor"))
        out.append(f"  held-out path error (median mm), {name}: {errors}; "
                   f"within 1.3 floors {_of(row['within 1.3 floors'])}")  # fmt: skip
    times = ", ".join(f"{k} {v:.1f}" for k, v in figures["cpu_s"].items())
    return [*out, f"  processor seconds, 24 trials from keypoints (median): {times}"]


def _of(pair: Sequence[int]) -> str:
    return f"{pair[0]} of {pair[1]} ({100 * pair[0] / max(pair[1], 1):.0f} %)"
