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
from .freshness import trial_row

RUN_VARIABLE = "BLUEKOI_RUN"
"""Environment variable with the run's command, settings and code, as json."""


def write_manifest(study: Path, results: Path) -> None:
    """Write manifest.json: command, settings, versions, the study as read, and the sha256 of every
    input file. Hashes of files that have kept size and date are taken from the last run.
    """
    loaded, run = load_study(study), json.loads(os.environ.get(RUN_VARIABLE, "{}"))
    content = {
        "command": run.get("command", ""),
        "settings": run.get("settings", {}),
        "code": run.get("code", ""),
        "versions": versions(),
        "study": loaded.setup.model_dump(mode="json"),
        "trials": {trial.trial_id: trial_row(trial) for trial in loaded.trials},
        "inputs": _input_hashes(loaded, results / "logs" / "hashes.cache"),
    }
    write_json(results / "manifest.json", content)


def versions() -> dict[str, str]:
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


def _input_hashes(study: Study, cache: Path) -> dict[str, dict[str, Any]]:
    known = _cached_hashes(cache)
    found: dict[str, dict[str, Any]] = {}
    for path in (p for p in study.files() if p.is_file()):
        state = path.stat()
        name = os.path.relpath(path, study.root)
        stamp = [state.st_size, state.st_mtime_ns]
        last = known.get(name, {})
        same = last.get("stamp") == stamp
        found[name] = {"sha256": last["sha256"] if same else sha256(path), "stamp": stamp}
    write_json(cache, found)
    return {name: {"sha256": e["sha256"], "bytes": e["stamp"][0]} for name, e in found.items()}


def _cached_hashes(cache: Path) -> Mapping[str, Any]:
    try:
        return read_json(cache)
    except InputError:
        return {}


def sha256(path: Path) -> str:
    """Hash of a file's content, hexadecimal."""
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
