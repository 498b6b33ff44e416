"""steady.csv, gathered from the trials that went well."""

from __future__ import annotations

from pathlib import Path

from ..errors import input_error
from ..steady import read_steady, write_steady
from ..study import load_study
from .result_paths import ResultPaths, remove_files
from .status import successful_trials


def steady(study: Path, results: Path) -> None:
    """Write steady.csv, a row a good trial in the order of trials.csv.

    Where no trial went well, the fits, the verdict and the report of an earlier run are removed:
    they are not of these trials.

    Raises: InputError where no trial went well.
    """
    layout = ResultPaths(results)
    ids = [trial.trial_id for trial in load_study(study).trials]
    good = successful_trials([layout.status(trial_id) for trial_id in ids])
    if not good:
        remove_files([*layout.tuning_files, *layout.mismatch_files, layout.report, layout.outcome])
        found = f"none of {len(ids)} trials that went well"
        raise input_error(
            results / "status", "", found, "one or more", "What is wrong with each of them follows."
        )
    rows = {name: read_steady(layout.trial_steady(name))[name] for name in good}
    write_steady(layout.steady, rows)
