"""Settings of the study and versions of the software."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from ..campaign import Campaign
from ..files import flatten_mapping

LISTED_PACKAGES = ("bluekoi", "numpy", "scipy", "opencv-python-headless", "av", "numba", "filterpy",
            "matplotlib")  # fmt: skip
"""Packages whose versions the report lists."""


def study_settings(campaign: Campaign) -> list[tuple[str, str]]:
    """All keys of study.yaml with values, including defaults."""
    rows = flatten_mapping(campaign.study.setup.model_dump())
    return [(key, "–" if value in (None, {}) else str(value)) for key, value in rows]


def software_versions() -> list[tuple[str, str]]:
    """Versions of Python and of the packages that affect the results."""
    return [
        ("python", platform.python_version()),
        *((name, _version(name)) for name in LISTED_PACKAGES),
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
