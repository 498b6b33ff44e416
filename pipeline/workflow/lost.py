"""Trials whose results were taken away or cut short, so that they run again."""

from __future__ import annotations

from pathlib import Path

from ..faults import Fault
from ..files import read_json
from .plan import Plan


def forget_lost(plan: Plan) -> list[Path]:
    """Status files taken away because a result that they vouch for is gone or has another size.

    A trial's job declares its status file alone, since a bad trial has no results to declare; so
    a deleted or truncated result would not be missed otherwise.
    """
    found = lost(plan)
    for path in found:
        path.unlink()
    return found


def lost(plan: Plan) -> list[Path]:
    """Status files that vouch for a result that is gone or has another size."""
    return [path for path in _statuses(plan) if not _whole(plan.results, path)]


def _statuses(plan: Plan) -> list[Path]:
    status = plan.results / "status"
    folders = (status / "keypoints", status, status / "overlays")
    paths = [folder / f"{trial}.json" for folder in folders for trial in plan.trials]
    return [path for path in paths if path.is_file()]


def _whole(results: Path, status: Path) -> bool:
    try:
        products = read_json(status).get("products", {})
    except Fault:
        return False
    return all(_size(results / name) == size for name, size in products.items())


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else -1
