"""The rivals on the studies of a challenge: named right, held-out path error, processor time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..campaign import Campaign, load_campaign
from ..data import Flapping, Float
from ..files import read_json
from ..fitting import Series, shoot
from ..integrate import Kernel, compiled
from ..mismatch import stretches
from ..model import COEFFICIENTS, plates
from ..study import load_study
from ..tuning import study_series, three_steps
from .accelerations import samples
from .find import results_of
from .rivals import Answer, linear_residual, sparse_regression
from .score import Judged

RUNAWAY_M = 1.0
"""Error charged to a free run that runs away or is not finite."""
Progress = Callable[[str, int, int], None]
RIVALS = ("sparse_regression", "linear_residual", "retuning")


def compare(folder: Path, judged: Sequence[Judged], progress: Progress) -> dict[str, Any]:
    """For each rival: right [n, of], median held-out path error (mm), median seconds a study."""
    rows = []
    for number, one in enumerate(judged, start=1):
        if not one.failure:
            rows.append(_study(folder, one))
        progress(one.name, number, len(judged))
    return {"each": rows, **{name: _figures(rows, name) for name in (*RIVALS, "search")}}


def _figures(rows: Sequence[Mapping[str, Any]], name: str) -> dict[str, Any]:
    hidden = [r for r in rows if r["hidden"]]
    return {
        "right": [sum(r[name]["right"] for r in rows), len(rows)],
        "false_names": [sum(bool(r[name]["false"]) for r in rows), len(rows)],
        "held_out_mm": float(np.median([r[name]["mm"] for r in hidden])) if hidden else None,
        "cpu_s": float(np.median([r[name]["cpu_s"] for r in rows])),
    }


def _study(folder: Path, one: Judged) -> dict[str, Any]:
    """One study through all rivals."""
    results = results_of(folder, one.name)
    study = load_study(folder / "studies" / one.name)
    campaign = load_campaign(results, study)
    held = read_json(results / "mismatch.json")["held_out"]
    series = study_series(study, campaign.poses, campaign.tracks, _flapping(campaign))
    fit = [s for s in series if s.name not in held["trials"]]
    test = [s for s in series if s.name in held["trials"]]
    pieces = [p for s in test for p in stretches(s, held.get("stretch_s") or 60.0)]
    kernel = compiled(plates())
    out: dict[str, Any] = {"name": one.name, "hidden": bool(one.true), "search": _own(one)}
    names = [e.name for e in plates().effects if e.kind in ("physics", "measurement")]
    data = samples(fit, campaign.tracks)
    ways: dict[str, Callable[[], Answer | dict[str, Answer]]] = {
        "sparse_regression": lambda: sparse_regression(kernel, data, names),
        "linear_residual": lambda: linear_residual(kernel, data),
        "retuning": lambda: _retuned(campaign, fit),
    }
    for name, way in ways.items():
        begin = time.process_time()
        answer = way()
        spent = time.process_time() - begin
        out[name] = _rated(kernel, answer, pieces, one.true) | {"cpu_s": spent}
    return out


def _own(one: Judged) -> dict[str, Any]:
    """The search itself, in the same figures; it knows more than one way to be right."""
    after = one.held_out.get("after", float("nan"))
    spent = sum(one.cpu_s.get(k, 0.0) for k in ("mismatch",))
    return {"right": one.right, "false": list(one.false), "mm": after, "cpu_s": spent}


def _rated(
    kernel: Kernel,
    answer: Answer | dict[str, Answer],
    pieces: Sequence[Series],
    true: Sequence[str],
) -> dict[str, Any]:
    """Figures of an answer; numbers beyond the candidates' plausible bounds are set to these."""
    bounds = np.array([(p.lower, p.upper) for p in kernel.system.parameters])
    of = answer if isinstance(answer, dict) else {}
    values = []
    for piece in pieces:
        own = of.get(piece.group, next(iter(of.values()), answer))
        assert isinstance(own, Answer)
        whole = kernel.system.values(own.coefficients, own.effects)
        values.append(np.clip(whole, bounds[:, 0], bounds[:, 1]))
    names = answer.names if isinstance(answer, Answer) else ()
    return {
        "right": set(names) == set(true),
        "names": list(names),
        "false": [n for n in names if n not in true],
        "mm": 1000 * _path_error(kernel, pieces, values),
    }


def _path_error(kernel: Kernel, pieces: Sequence[Series], values: Sequence[Float]) -> float:
    """Root mean square distance of free runs, each from the start that suits it best, m."""
    squares = []
    for piece, shot in zip(pieces, shoot(kernel, pieces, values), strict=True):
        off = np.sum((piece.seen[:, :2] - shot.observed[:, :2]) ** 2, axis=1)
        known = off[np.all(np.isfinite(piece.seen[:, :2]), axis=1)]
        squares.append(np.minimum(np.nan_to_num(known, nan=RUNAWAY_M**2), RUNAWAY_M**2))
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def _retuned(campaign: Campaign, fit: Sequence[Series]) -> dict[str, Answer]:
    """Coefficients at each power by the paper's three steps, from the trials to fit."""
    steps = three_steps(campaign.study, fit, campaign.steady)[0]
    names = [p.name for p in COEFFICIENTS]
    return {
        power: Answer((), {n: float(told["coefficients"][n]["value"]) for n in names}, {})
        for power, told in steps.items()
    }


def _flapping(campaign: Campaign) -> dict[str, Flapping]:
    told = {i: campaign.statuses[i]["flapping"] for i in campaign.tracks}
    return {
        i: Flapping(f["flap_hz"], f["flap_hz_std"] or 0.0, f["source"]) for i, f in told.items()
    }


def compared(figures: Mapping[str, Any]) -> list[str]:
    """The comparison in lines a person can read."""
    out = ["same studies, same trials to fit           right     false names  held out mm  s/study"]
    for name in ("search", *RIVALS):
        f = figures[name]
        right, false = (f"{a} of {b}" for a, b in (f["right"], f["false_names"]))
        mm = "-" if f["held_out_mm"] is None else f"{f['held_out_mm']:.1f}"
        out.append(f"  {name:38s} {right:>10s} {false:>13s} {mm:>12s} {f['cpu_s']:8.1f}")
    return out
