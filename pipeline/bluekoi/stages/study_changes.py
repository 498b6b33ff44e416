"""Changes of a study since the run that made its results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..files import flatten_mapping, read_manifest
from ..study import Study
from .freshness import trial_row_as_dict
from .manifest import input_file_hashes

MAX_CHANGES_NAMED = 4
"""Changes that a message lists; of more it gives the number."""


def outdated_results_message(study: Study, results: Path) -> str:
    """One sentence that names what has changed since the last completed run; empty where nothing
    has, or where the results have no manifest.json.
    """
    changes = changes_since_run(study, results)
    if not changes:
        return ""
    more = len(changes) - MAX_CHANGES_NAMED
    named = [*changes[:MAX_CHANGES_NAMED], *([f"{more} more"] if more > 0 else [])]
    return (
        f"these results were made from another state of {study.root}: {'; '.join(named)}. "
        "`bluekoi run` updates them"
    )


def changes_since_run(study: Study, results: Path) -> list[str]:
    """Changes of study.yaml, of trials.csv and of the content of other files, a phrase each.

    Entries that a later version of this package has introduced are no change.
    """
    manifest = results / "manifest.json"
    if not manifest.is_file():
        return []
    before = read_manifest(manifest)
    trials = {trial.trial_id: trial_row_as_dict(trial) for trial in study.trials}
    return [
        *_changed_settings(before.get("study") or {}, study.setup.model_dump(mode="json")),
        *_changed_trials(before.get("trials") or {}, trials),
        *_changed_files(before.get("inputs") or {}, input_file_hashes(study, results)),
    ]


def _changed_settings(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    old, new = dict(flatten_mapping(before)), dict(flatten_mapping(now))
    for key, value in old.items():
        if new.get(key) != value:
            yield f"{key} was {_value_text(value)}, now {_value_text(new.get(key))}"


def _changed_trials(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for name, row in before.items():
        if name not in now:
            yield f"trial {name} was removed"
        for key, value in row.items():
            if name in now and now[name].get(key) != value:
                yield (f"{key} of trial {name} was {_value_text(value)}, "
                       f"now {_value_text(now[name].get(key))}")  # fmt: skip
    yield from (f"trial {name} was added" for name in now if name not in before)


def _changed_files(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for name in (n for n in before if n not in ("study.yaml", "trials.csv")):
        if name not in now:
            yield f"{name} is no longer used, or no longer there"
        elif now[name]["sha256"] != before[name]["sha256"]:
            yield f"{name} has another content"


def _value_text(value: Any) -> str:
    return "not given" if value in (None, {}, []) else str(value)
