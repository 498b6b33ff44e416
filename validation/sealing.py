"""Truths under seal: their hashes are published when they are made and checked when they are read.

DIR/truth.sha256 has a line for each truth, as `sha256sum` writes it.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from bluekoi.errors import input_error
from bluekoi.files import write_text

HASHES_FILE = "truth.sha256"


def seal_truth(directory: Path, study: str) -> str:
    """SHA-256 of DIR/truth/STUDY.json, published in DIR/truth.sha256; kept where it is there."""
    known = published_hashes(directory)
    if study not in known:
        known[study] = _sha256(_truth_file(directory, study))
        lines = [f"{digest}  truth/{name}.json\n" for name, digest in sorted(known.items())]
        write_text(directory / HASHES_FILE, "".join(lines))
    return known[study]


def published_hashes(directory: Path) -> dict[str, str]:
    """Study -> published SHA-256; empty for a directory without seals."""
    path = directory / HASHES_FILE
    lines = path.read_text(encoding="ascii").splitlines() if path.is_file() else []
    return {Path(name).stem: digest for digest, name in (line.split("  ", 1) for line in lines)}


def open_truth(directory: Path, study: str) -> dict[str, Any]:
    """The truth of a study.

    Raises: InputError where its hash is not the published one.
    """
    path = _truth_file(directory, study)
    expected, found = published_hashes(directory).get(study), _sha256(path)
    if expected not in (None, found):
        raise input_error(path, "", f"SHA-256 {found}", f"{expected}, as published",
                    "This is not the truth that was sealed before the analysis.")  # fmt: skip
    truth: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return truth


def _truth_file(directory: Path, study: str) -> Path:
    return directory / "truth" / f"{study}.json"


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
