"""Why a trial counts as bad; imports nothing, since the command reads it after each run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def failure_reason(status: Mapping[str, Any]) -> str:
    """Why a trial counts as bad, in one line; empty for a good one."""
    text = status.get("cut_short", "") if status["ok"] else status["message"]
    return " ".join(str(text or "").split())
