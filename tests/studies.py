"""Small keypoint studies for tests of the stages and of the workflow."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

from bluekoi.synthetic.design import bare_design
from validation.tracking import keypoint_study

PLANS = ("T09", "T10", "T11")  # full power, so the shortest: straight, 30 degrees, -45 degrees


def small_study(folder: Path) -> Path:
    """A study of three keypoint trials, simulated from the bare model, in `folder`."""
    design = bare_design()
    plans = tuple(plan for plan in design.plans if plan.trial_id in PLANS)
    keypoint_study(replace(design, plans=plans), folder, folder.with_name("truth"))
    return folder


def edit_rows(study: Path, **cells: dict[str, str]) -> None:
    """Change cells of trials.csv: `edit_rows(study, T09={"fps": "30"})`."""
    with (study / "trials.csv").open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    names = list(dict.fromkeys([*rows[0], *(n for change in cells.values() for n in change)]))
    with (study / "trials.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, names, restval="")
        writer.writeheader()
        writer.writerows([row | cells.get(row["trial_id"], {}) for row in rows])
