"""The search on a subset of the trials beside one on all: verdicts and processor time.

    python benchmarks/search_subset.py FOLDER [--trials 66] [--count 10] [--seed 811]

Studies of the project's own generator, made and measured in FOLDER where they are not there yet.
"""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import ExitStack
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))  # validation/

import bluekoi.engine  # noqa: E402, F401  the modules below
from validation.generators.concealed.studies import generate  # noqa: E402
from validation.study_runs import analyse, measure, measured_names, verdict_path  # noqa: E402

MAX_SEARCH_TRIALS_BY_LABEL = {"subset": None, "all": 10**6}
"""Label of the verdicts -> the greatest number of trials that is searched as a whole."""


def search_result(folder: Path, label: str, name: str) -> tuple[dict[str, float], float]:
    """Names and probabilities that a search gives a study, and its processor time (s)."""
    with ExitStack() as patches:
        for module in ("search", "refit") if MAX_SEARCH_TRIALS_BY_LABEL[label] else ():
            patched = sys.modules[f"bluekoi.engine.{module}"]
            patches.enter_context(
                mock.patch.object(patched, "MAX_SEARCH_TRIALS", MAX_SEARCH_TRIALS_BY_LABEL[label])
            )
        analyse(folder, label, name)
    said = json.loads(verdict_path(folder, label, name).read_text())
    return {c["name"]: c["weight"] for c in said["mismatch"].get("causes", ())}, said["cpu_s"]


def main() -> None:
    """Make, measure and search the studies; print a row for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--trials", type=int, default=66)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=811)
    given = parser.parse_args()
    same = 0
    for index in range(given.count):
        truth = generate(given.seed, index, given.folder, trials=given.trials)
        name = truth["study"]
        if name not in measured_names(given.folder):
            measure(given.folder, name)
        rows = {
            label: search_result(given.folder, label, name) for label in MAX_SEARCH_TRIALS_BY_LABEL
        }
        same += rows["subset"][0].keys() == rows["all"][0].keys()
        print(name, "true:", *(c["name"] for c in truth["causes"]), truth["group"])
        for label, (names, cpu_s) in rows.items():
            said = ", ".join(f"{n} {p:.2f}" for n, p in names.items()) or "nothing"
            print(f"   {label:7s} {cpu_s:6.1f} s  {said}", flush=True)
    print(f"the same names in {same} of {given.count}")


if __name__ == "__main__":
    main()
