"""The last word of a run: which trials went wrong, and why."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..files import read_json, write_json
from ..study import load_study
from .layout import Layout, remove


def outcome(study: Path, results: Path) -> list[str]:
    """A line for each trial that went wrong or was cut short; outcome.json where there is none.

    Comes last, so that all results of the other trials are there when it complains.
    """
    layout, done = Layout(results), results / "outcome.json"
    ids = [trial.trial_id for trial in load_study(study).trials]
    told = {name: complaint(read_json(layout.status(name))) for name in ids}
    bad = [f"{name}: {text}" for name, text in told.items() if text]
    remove([done])
    if not bad:
        write_json(done, {"trials": len(ids), "all_good": True})
    return bad


def complaint(status: Mapping[str, Any]) -> str:
    """Why a trial counts as bad, in one line; empty for a good one."""
    text = status.get("cut_short", "") if status["ok"] else status["message"]
    return " ".join(str(text or "").split())
