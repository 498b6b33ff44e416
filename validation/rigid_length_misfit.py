"""Misfit of rigid lengths to right geometry, chi-squared where nothing stretches the picture."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bluekoi.campaign import load_campaign
from bluekoi.files import read_json
from bluekoi.mismatch.rigid_lengths import effects_that_change_lengths
from bluekoi.model import robot_system
from bluekoi.stages.mismatch import with_rigid_length_measurement
from bluekoi.stages.tuning import campaign_series
from bluekoi.study import load_study

MisfitRow = tuple[str, bool, float, int]
"""Study, whether an error stretches its picture, misfit, dimension."""


def length_misfit(directory: Path, name: str) -> MisfitRow | None:
    """The row of a measured study of a directory; None where no lengths were measured."""
    study, results = directory / "studies" / name, directory / "tracks" / name
    loaded = load_study(study)
    system = robot_system(loaded.setup.robot)
    series = campaign_series(load_campaign(results, loaded, measured=True))
    geometry = read_json(results / "geometry.json")
    shared = with_rigid_length_measurement(series, geometry, loaded.setup)[0].shared
    if shared is None:
        return None
    errors = shared.errors(
        system.parameter_vector({})[[system.parameter_index[n] for n in shared.parameters]]
    )
    truth = json.loads((directory / "truth" / f"{name}.json").read_text(encoding="utf-8"))
    causes = {cause["name"] for cause in truth["causes"]}
    stretched = bool(causes & {e.name for e in effects_that_change_lengths(system)})
    return name, stretched, float(errors @ errors), len(errors)


def length_misfit_report(rows: Sequence[MisfitRow]) -> str:
    """A line for each study whose picture is stretched, then the others' misfit by dimension."""
    lines = [f"{name}: {value:.1f} of {size}" for name, stretched, value, size in rows if stretched]
    value, size = np.array([(v, m) for _, stretched, v, m in rows if not stretched]).T
    return "\n".join([*lines, f"others, {len(value)} studies: mean {value.sum() / size.sum():.2f}, "
                      f"median {np.median(value / size):.2f}, largest {(value / size).max():.1f} "
                      "times the dimension"])  # fmt: skip
