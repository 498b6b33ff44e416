"""One study of a seed in the layout of `validation.study_runs`, with its truth."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

from bluekoi.files import read_json, write_json
from validation.generators.concealed.plan import PlannedStudy, draw_recipe_of, planned_study
from validation.generators.concealed.writing import write_concealed_study

__all__ = ["generate", "truth_json"]

MIN_REACHED_RATIO = 0.6
"""Least share of the wanted path error that an effect must leave."""
ATTEMPTS = 4
UNLISTED_NAME = "unexplained"


def generate(
    seed: int, index: int, directory: Path, *, footage: bool = False, name: str = "concealed",
    trials: int | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The truth of study `index` of a seed, written below a directory; kept where it is there.

    A study is drawn again, at most three times, where its effect leaves too small an error.
    trials: how many instead of those dealt, a multiple of three.
    """
    entry, study = planned_study(seed, index, footage=footage), f"{name}-{seed}-{index:03d}"
    entry = replace(entry, trials=trials or entry.trials)
    truth_file = directory / "truth" / f"{study}.json"
    if truth_file.exists():
        return read_json(truth_file)
    folder, draft = directory / "studies" / study, directory / "studies" / f".{study}"
    for attempt in range(ATTEMPTS):
        for old in (folder, draft):
            shutil.rmtree(old, ignore_errors=True)
        reported = write_concealed_study(draw_recipe_of(entry, seed, attempt), draft)
        if reached_ratio(reported) >= MIN_REACHED_RATIO:
            break
    draft.rename(folder)
    truth = truth_json(entry, reported) | {"study": study, "generator": name}
    write_json(truth_file, truth)
    return truth


def reached_ratio(reported: dict[str, Any]) -> float:
    """Error of the weakest effect over what was wanted, or its inverse where more was reached."""
    shares = [c["ratio"] / c["wanted_ratio"] for c in reported["causes"] if "ratio" in c]
    return min((min(s, 1 / s) for s in shares), default=1.0)


def truth_json(entry: PlannedStudy, reported: dict[str, Any]) -> dict[str, Any]:
    """A truth with the keys that `validation.scoring` reads; forces outside the list apart."""
    listed = [c for c in reported["causes"] if c["name"] != UNLISTED_NAME]
    outside = [c for c in reported["causes"] if c["name"] == UNLISTED_NAME]
    group = "unlisted" if entry.kind == "outside" else entry.kind
    return reported | {
        "group": group,
        "fin": reported["has_fin"],
        "causes": listed,
        "unlisted": outside[0] if outside else None,
    }
