"""What is in the files that jobs depend on: sources of a study, words of a figure."""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from pathlib import Path

SMALL_BYTES = 2**20
"""Up to this size a file is told by its content: a keypoint file, a motor log, not a video."""


@cache
def state_of(path: Path) -> str:
    """Hash of a small file's content; of a large one's size and date."""
    found = path.stat()
    large = found.st_size > SMALL_BYTES
    told = f"{found.st_size} {found.st_mtime_ns}".encode() if large else path.read_bytes()
    return hashlib.sha256(told).hexdigest()[:12]


def words_of(figure: Path) -> dict[str, str]:
    """Title and caption of a figure, read from its file without running it."""
    texts = {
        node.targets[0].id: node.value
        for node in ast.parse(figure.read_bytes()).body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    return {name.lower(): ast.literal_eval(texts[name]) for name in ("TITLE", "CAPTION")}
