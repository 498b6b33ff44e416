"""The studies of `concealed`, filmed: they go from pixels to a verdict."""

from pathlib import Path
from typing import Any

from validation.generators.concealed.studies import generate as concealed

__all__ = ["generate"]


def generate(seed: int, index: int, directory: Path) -> dict[str, Any]:
    """The truth of filmed study `index` of a seed, written below a directory."""
    return concealed(seed, index, directory, footage=True, name="concealed_footage")
