"""The end of a run: which trials failed, why, and what to check in the others."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..files import read_json, read_json_if_present, write_json
from ..study import Study, load_study
from ..trial_warnings import warnings_after_run
from .manifest import write_manifest
from .result_paths import ResultPaths, remove_files
from .trial_failure import failed_trial_lines

INPUTS_CHANGED_DURING_RUN_MESSAGE = (
    "{} changed while the run was at work: some results are of the file as it was before. "
    "Run the study again."
)


def outcome(study: Path, results: Path) -> list[str]:
    """A line for each trial that failed or was cut short; outcome.json where there is none.

    Runs last, so that all results of the other trials are there, and writes what they were made
    from (manifest.json). outcome.json carries `warnings` on files that changed meanwhile and on
    trials that were used: clocks that disagree, speeds that no swimmer has, powers that do not go
    with the flapping frequency, rigid lengths of another size.
    """
    layout, done = ResultPaths(results), ResultPaths(results).outcome
    loaded = load_study(study)
    statuses = {t.trial_id: read_json(layout.status(t.trial_id)) for t in loaded.trials}
    bad = failed_trial_lines(statuses)
    warnings = run_warnings(loaded, results, statuses)
    remove_files([done])
    if changed := write_manifest(study, results):
        warnings.insert(0, INPUTS_CHANGED_DURING_RUN_MESSAGE.format(", ".join(changed)))
    if bad:
        return [*bad, *(f"Warning: {text}" for text in warnings)]
    write_json(done, {"trials": len(statuses), "all_good": True, "warnings": warnings})
    return []


def run_warnings(
    study: Study, results: Path, statuses: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """A sentence for each doubt about trials, clocks, lengths and inertia after a run.

    statuses: content of status/ID.json by trial id.
    """
    geometry, mismatch = (
        read_json_if_present(results / f"{n}.json") for n in ("geometry", "mismatch")
    )
    return warnings_after_run(study, statuses, geometry, mismatch)


def available_trial_statuses(study: Study, results: Path) -> dict[str, dict[str, Any]]:
    """Content of status/ID.json by trial id, of the trials that have one so far."""
    paths = {t.trial_id: ResultPaths(results).status(t.trial_id) for t in study.trials}
    return {name: read_json(path) for name, path in paths.items() if path.is_file()}
