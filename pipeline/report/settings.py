"""Settings of the study and versions of what analysed it."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..campaign import Campaign

PACKAGES = ("bluekoi", "numpy", "scipy", "opencv-python-headless", "av", "numba", "filterpy",
            "matplotlib")  # fmt: skip


def settings(campaign: Campaign) -> list[tuple[str, str]]:
    """Everything in study.yaml, defaults included, as key and value."""
    return list(_flat("", campaign.study.setup.model_dump()))


def versions() -> list[tuple[str, str]]:
    """Python and the packages that the results hang on."""
    return [("python", platform.python_version()), *((name, _version(name)) for name in PACKAGES)]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _flat(prefix: str, value: Any) -> list[tuple[str, str]]:
    if not isinstance(value, dict):
        return [(prefix, "–" if value is None else str(value))]
    if not value:
        return [(prefix, "–")]
    return [
        row for key, entry in value.items() for row in _flat(f"{prefix}.{key}".lstrip("."), entry)
    ]
