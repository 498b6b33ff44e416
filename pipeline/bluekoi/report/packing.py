"""Data embedded in the page: compressed, and time series as rounded differences."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..data import Float


def gzip_base64(content: bytes | str) -> str:
    """Base64 of the gzipped content; page.js unpacks it with `unpack`."""
    raw = content.encode() if isinstance(content, str) else content
    return base64.b64encode(gzip.compress(raw, 9, mtime=0)).decode("ascii")


def gzip_base64_json(content: Mapping[str, Any]) -> str:
    """As `gzip_base64`, of compact json."""
    return gzip_base64(json.dumps(content, separators=(",", ":"), allow_nan=False))


def quantised_differences(values: Float, resolution: float) -> dict[str, Any]:
    """A series as integer multiples of `resolution`, each minus the last known one; NaN as null.

    Differences of smooth series are small, which compresses to about one byte per value.
    """
    known = np.isfinite(values)
    rounded = np.round(values[known] / resolution).astype(np.int64)
    steps = iter(np.diff(rounded, prepend=0).tolist())
    return {"unit": resolution, "steps": [next(steps) if k else None for k in known.tolist()]}
