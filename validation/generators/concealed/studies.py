"""One study of a seed in the layout of `validation.running`, with its truth."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

from bluekoi.files import read_json, write_json
from validation.generators.concealed.plan import Entry, entry_of, recipe_of
from validation.generators.concealed.writing import conceal

__all__ = ["generate", "truth_of"]

MIN_REACHED = 0.6
"""Least share of the wanted path error that an effect must leave."""
ATTEMPTS = 4
OUTSIDE = "unexplained"


def generate(
    seed: int, index: int, directory: Path, *, footage: bool = False, name: str = "concealed",
    trials: int | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The truth of study `index` of a seed, written below a directory; kept where it is there.

    A study is drawn again, at most three times, where its effect leaves too small an error.
    trials: how many instead of those dealt, a multiple of three.
    """
    entry, study = entry_of(seed, index, footage=footage), f"{name}-{seed}-{index:03d}"
    entry = replace(entry, trials=trials or entry.trials)
    truth_file = directory / "truth" / f"{study}.json"
    if truth_file.exists():
        return read_json(truth_file)
    folder, draft = directory / "studies" / study, directory / "studies" / f".{study}"
    for attempt in range(ATTEMPTS):
        for old in (folder, draft):
            shutil.rmtree(old, ignore_errors=True)
        reported = conceal(recipe_of(entry, seed, attempt), draft)
        if reached(reported) >= MIN_REACHED:
            break
    draft.rename(folder)
    truth = truth_of(entry, reported) | {"study": study, "generator": name}
    write_json(truth_file, truth)
    return truth


def reached(reported: dict[str, Any]) -> float:
    """Error of the weakest effect over what was wanted, or its inverse where more was reached."""
    shares = [c["ratio"] / c["wanted_ratio"] for c in reported["causes"] if "ratio" in c]
    return min((min(s, 1 / s) for s in shares), default=1.0)


def truth_of(entry: Entry, reported: dict[str, Any]) -> dict[str, Any]:
    """A truth with the keys that `validation.scoring` reads; forces outside the list apart."""
    listed = [c for c in reported["causes"] if c["name"] != OUTSIDE]
    outside = [c for c in reported["causes"] if c["name"] == OUTSIDE]
    group = "unlisted" if entry.kind == "outside" else entry.kind
    return reported | {
        "group": group,
        "fin": reported["has_fin"],
        "causes": listed,
        "unlisted": outside[0] if outside else None,
    }
