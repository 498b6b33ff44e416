"""Truth under seal: its canonical bytes and their hash."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from bluekoi.files import plain

__all__ = ["seal"]


def seal(truth: Mapping[str, Any]) -> tuple[str, bytes]:
    """SHA-256 (hex) and bytes of a truth as canonical json: sorted keys, no spaces, UTF-8."""
    text = json.dumps(
        plain(truth), sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
    )
    content = text.encode("utf-8")
    return hashlib.sha256(content).hexdigest(), content
