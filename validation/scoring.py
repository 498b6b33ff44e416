"""Verdicts against truths: who was named, how surely, and how often that was right."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta

from .sealing import open_truth
from .study_runs import study_names, verdict_path

UNEXPLAINED = "unexplained"
PROBABILITY_BIN_EDGES = np.linspace(0.0, 1.0, 11)


@dataclass(frozen=True)
class ScoredStudy:
    """One study: true names and named causes with their probabilities.

    An unlisted force counts as the true name `unexplained`. said: name -> probability of all causes
    in mismatch.json; alternatives: rival name -> probability; probabilities: those of every
    candidate, where the verdict states them. credible_sets: that of each named cause.
    """

    study: str
    generator: str
    group: str
    fin: bool
    trials: int
    true: tuple[str, ...]
    said: Mapping[str, float]
    alternatives: Mapping[str, float]
    probabilities: Mapping[str, float]
    verdict: str
    cpu_s: float
    held_out: Mapping[str, Any]
    where: Sequence[Mapping[str, Any]]
    unlisted: Mapping[str, Any] | None
    failure: str
    credible_sets: Sequence[Sequence[str]] = ()

    @property
    def strict(self) -> bool:
        """Exactly the true causes are named."""
        return not self.failure and set(self.said) == set(self.true)

    @property
    def all_named(self) -> bool:
        """Every true cause is named, whatever else is."""
        return not self.failure and set(self.true) <= set(self.said)

    @property
    def extra(self) -> tuple[str, ...]:
        """Named causes that are not true, `unexplained` apart."""
        return tuple(n for n in self.said if n not in self.true and n != UNEXPLAINED)

    @property
    def needless_unexplained(self) -> bool:
        """`unexplained` beside complete true names."""
        return UNEXPLAINED in self.said and UNEXPLAINED not in self.true and self.all_named

    @property
    def null(self) -> bool:
        """Whether nothing but perhaps a fin is hidden."""
        return self.group == "null"


def score_all(directory: Path, label: str) -> list[ScoredStudy]:
    """Every study below a directory that has a verdict under `label`."""
    paths = {name: verdict_path(directory, label, name) for name in study_names(directory)}
    return [_score_study(directory, name, path) for name, path in paths.items() if path.is_file()]


def _score_study(directory: Path, name: str, path: Path) -> ScoredStudy:
    truth = open_truth(directory, name)
    found = json.loads(path.read_text())
    reported = found["mismatch"]
    unlisted = truth.get("unlisted")
    true = [c["name"] for c in truth["causes"]] + ([UNEXPLAINED] if unlisted else [])
    return ScoredStudy(
        study=name, generator=truth["generator"], group=truth["group"], fin=truth["fin"],
        trials=truth["trials"], true=tuple(true),
        said={c["name"]: c["weight"] for c in reported.get("causes", ())},
        alternatives={r["name"]: r["weight"] for r in reported.get("rivals", ())},
        probabilities=reported.get("probabilities", {}),
        verdict=reported.get("verdict", "failed"), cpu_s=found["cpu_s"],
        held_out=reported.get("held_out", {}), where=reported.get("where", ()),
        unlisted=unlisted, failure=found["failure"],
        credible_sets=[c.get("credible_set", [c["name"]]) for c in reported.get("causes", ())],
    )  # fmt: skip


def clopper_pearson(hits: int, count: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper and Pearson's interval of a share."""
    tail = 0.5 * (1 - level)
    low = beta.ppf(tail, hits, count - hits + 1) if hits else 0.0
    high = beta.ppf(1 - tail, hits + 1, count - hits) if hits < count else 1.0
    return float(low), float(high)


def hits_with_interval(
    studies: Sequence[ScoredStudy], test: Callable[[ScoredStudy], bool]
) -> dict[str, Any]:
    """Hits, count and interval of a test over studies."""
    hits, count = sum(map(test, studies)), len(studies)
    return {
        "hits": hits,
        "count": count,
        "interval_95": clopper_pearson(hits, count) if count else None,
    }


def summary(studies: Sequence[ScoredStudy]) -> dict[str, Any]:
    """All scores of a set of studies, ready for json."""
    groups = sorted({s.group for s in studies})
    parts: dict[str, list[ScoredStudy]] = {
        "all": list(studies),
        "24 trials": [s for s in studies if s.trials > 9],
        "nine trials": [s for s in studies if s.trials <= 9],
        "with a fin": [s for s in studies if s.fin],
        "without a fin": [s for s in studies if not s.fin],
        **{g: [s for s in studies if s.group == g] for g in groups},
    }
    return {
        "strict": {k: hits_with_interval(v, lambda s: s.strict) for k, v in parts.items()},
        "all_named": {k: hits_with_interval(v, lambda s: s.all_named) for k, v in parts.items()},
        "extra_name": hits_with_interval(list(studies), lambda s: bool(s.extra)),
        "needless_unexplained": hits_with_interval(list(studies), lambda s: s.needless_unexplained),
        "calibration": calibration_bins(studies),
        "credible_sets": credible_set_coverage(studies),
        "cpu_s": {"median": float(np.median([s.cpu_s for s in studies])),
                  "worst": max(s.cpu_s for s in studies)} if studies else {},
        "failures": [s.study for s in studies if s.failure],
    }  # fmt: skip


def calibration_bins(studies: Sequence[ScoredStudy]) -> list[dict[str, Any]]:
    """Bins of width 0.1 of the probabilities of named causes: how many were true."""
    pairs = [(min(p, 1.0), n in s.true) for s in studies for n, p in s.said.items()]
    out = []
    for low, high in itertools.pairwise(PROBABILITY_BIN_EDGES):
        inside = [(p, true) for p, true in pairs if low <= p < high or (high == 1.0 and p == 1.0)]
        if inside:
            hits, count = sum(true for _, true in inside), len(inside)
            mean = float(np.mean([p for p, _ in inside]))
            out.append({"from": float(low), "to": float(high), "mean": mean, "true": hits,
                        "count": count, "interval_95": clopper_pearson(hits, count)})  # fmt: skip
    return out


def credible_set_coverage(studies: Sequence[ScoredStudy]) -> dict[str, Any]:
    """How many credible sets hold a hidden cause; they state `CREDIBLE_SET_PROBABILITY`."""
    held = [bool({*one} & {*s.true}) for s in studies for one in s.credible_sets]
    interval = clopper_pearson(sum(held), len(held)) if held else None
    return {"hits": sum(held), "count": len(held), "interval_95": interval}


def study_records(studies: Sequence[ScoredStudy]) -> list[dict[str, Any]]:
    """One flat record a study, for validation/results."""
    return [asdict(s) | {"strict": s.strict, "all_named": s.all_named} for s in studies]


def summary_text(result: Mapping[str, Any]) -> str:
    """A summary as lines of text."""
    lines = []
    for key in ("strict", "all_named"):
        for part, cell in result[key].items():
            if cell["count"]:
                low, high = cell["interval_95"]
                percent = f"{cell['hits'] / cell['count']:4.0%} ({low:.0%} to {high:.0%})"
                lines.append(
                    f"{key:10} {part:14} {cell['hits']:4d} of {cell['count']:4d} {percent}"
                )
    for key in ("extra_name", "needless_unexplained"):
        lines.append(f"{key}: {result[key]['hits']} of {result[key]['count']}")
    for one in result["calibration"]:
        lines.append(
            f"  {one['from']:.1f} to {one['to']:.1f}: {one['true']} of {one['count']} true"
        )
    sets = result["credible_sets"]
    lines.append(f"credible sets that hold a hidden cause: {sets['hits']} of {sets['count']}")
    lines.append(f"cpu_s: {result['cpu_s']}  failures: {len(result['failures'])}")
    return "\n".join(lines)
