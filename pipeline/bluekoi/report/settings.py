"""Settings of the study and versions of the software."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..campaign import Campaign

PACKAGES = ("bluekoi", "numpy", "scipy", "opencv-python-headless", "av", "numba", "filterpy",
            "matplotlib")  # fmt: skip


def settings(campaign: Campaign) -> list[tuple[str, str]]:
    """All keys of study.yaml with values, including defaults."""
    rows = flattened(campaign.study.setup.model_dump())
    return [(key, "–" if value in (None, {}) else str(value)) for key, value in rows]


def versions() -> list[tuple[str, str]]:
    """Versions of Python and of the packages that affect the results."""
    return [("python", platform.python_version()), *((name, _version(name)) for name in PACKAGES)]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def flattened(value: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Entries of a nested mapping as (`a.b.c`, value)."""
    if isinstance(value, Mapping) and value:
        for key, entry in value.items():
            yield from flattened(entry, f"{prefix}.{key}".lstrip("."))
    else:
        yield prefix, value
