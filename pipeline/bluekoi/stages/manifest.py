"""manifest.json: what a run was made from, so that it can be made again and compared."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files import read_json, write_json
from ..study import Study, load_study
from .freshness import trial_row_as_dict

RUN_ENVIRONMENT_VARIABLE = "BLUEKOI_RUN"
"""Environment variable with the run's command, settings and code, as json."""


def record_file_sizes_and_times(study: Study, results: Path, *, made_by_run: bool = False) -> None:
    """Keep size and date of each file of a study as a run begins. made_by_run: the run itself
    renders the files, as it does for the demo; then nothing is kept.
    """
    states = {} if made_by_run else _file_sizes_and_times(study)
    write_json(_start_file_record_path(results), states)


def write_manifest(study: Path, results: Path) -> list[str]:
    """Write manifest.json: command, settings, versions, the study as read, and the sha256 of every
    input file. Hashes of files that have kept size and date are taken from the last run.

    Returns the files that were changed after the run began, which the manifest names as well: what
    was computed before is of what they were.
    """
    loaded, run = load_study(study), json.loads(os.environ.get(RUN_ENVIRONMENT_VARIABLE, "{}"))
    changed = _changed_since_start(loaded, results)
    hashed = _hashed_files(loaded, results)
    write_json(_hash_cache(results), hashed)
    content = {
        "command": run.get("command", ""),
        "settings": run.get("settings", {}),
        "code": run.get("code", ""),
        "versions": environment_versions(),
        "study": loaded.setup.model_dump(mode="json"),
        "trials": {trial.trial_id: trial_row_as_dict(trial) for trial in loaded.trials},
        "inputs": _without_modification_times(hashed),
        "changed_during_run": changed,
    }
    write_json(results / "manifest.json", content)
    return changed


def environment_versions() -> dict[str, str]:
    """Versions of Python, the system, this package and all that it depends on."""
    try:
        needed = [re.split(r"[^\w.-]", text)[0] for text in requires("bluekoi") or []
                  if "extra ==" not in text]  # fmt: skip
    except PackageNotFoundError:
        needed = []
    return {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        **{name: _package_version(name) for name in ("bluekoi", *sorted(needed))},
    }


def _package_version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _start_file_record_path(results: Path) -> Path:
    return results / "logs" / "files_at_start.cache"


def _file_sizes_and_times(study: Study) -> dict[str, list[int]]:
    """Size in bytes and date in ns of each file of a study that is there, by relative path."""
    states = {path: path.stat() for path in study.files() if path.is_file()}
    return {
        os.path.relpath(path, study.root): [state.st_size, state.st_mtime_ns]
        for path, state in states.items()
    }


def _changed_since_start(study: Study, results: Path) -> list[str]:
    before, now = _read_cache(_start_file_record_path(results)), _file_sizes_and_times(study)
    return sorted(name for name in before if now.get(name) != before[name])


def input_file_hashes(study: Study, results: Path) -> dict[str, dict[str, Any]]:
    """`sha256` and `bytes` of each input file that is there, by relative path.

    Hashes of files that have kept size and date since the last run are those of that run.
    """
    return _without_modification_times(_hashed_files(study, results))


def _hashed_files(study: Study, results: Path) -> dict[str, dict[str, Any]]:
    known = _read_cache(_hash_cache(results))
    found = {}
    for name, stamp in _file_sizes_and_times(study).items():
        last = known.get(name, {})
        content = last["sha256"] if last.get("stamp") == stamp else file_sha256(study.root / name)
        found[name] = {"sha256": content, "stamp": stamp}
    return found


def _without_modification_times(hashed: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    return {name: {"sha256": e["sha256"], "bytes": e["stamp"][0]} for name, e in hashed.items()}


def _hash_cache(results: Path) -> Path:
    return results / "logs" / "hashes.cache"


def _read_cache(cache: Path) -> Mapping[str, Any]:
    try:
        return read_json(cache)
    except InputError:
        return {}


def file_sha256(path: Path) -> str:
    """Hash of a file's content, hexadecimal."""
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
