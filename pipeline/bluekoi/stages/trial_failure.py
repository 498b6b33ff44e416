"""Why a trial counts as bad; imports nothing, since the command reads it after each run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def failure_reason(status: Mapping[str, Any]) -> str:
    """Why a trial counts as bad, in one line; empty for a good one."""
    text = status.get("cut_short", "") if status["ok"] else status["message"]
    return " ".join(str(text or "").split())


def failed_trial_lines(statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A line for each bad trial; a remedy that several trials share is in the first one alone.

    statuses: content of status/ID.json by trial id.
    """
    seen, out = {""}, []
    for name, status in statuses.items():
        text = failure_reason(status)
        remedy = " ".join(str(status.get("remedy") or "").split()) if text else ""
        short = text.removesuffix(remedy).rstrip() if remedy in seen else text
        seen.add(remedy)
        out += [f"{name}: {short}"] if text else []
    return out
