"""The truth of a synthetic study, shown only if it has the published hash.

`truth.sha256` in the study folder holds the SHA-256 of the sealed file and, after two spaces, its
path from there, as `sha256sum` writes it; without a path it is `truth.json` beside it. The maker
may hold that file back until the study has been analysed. A study without `truth.sha256` has none.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bluekoi.files import read_json

SEAL_FILE = "truth.sha256"
TRUTH_FILE = "truth.json"
MAX_TRUTH_BYTES = 50_000_000
HASH_LINE = re.compile(r"\s*([0-9a-fA-F]{64})(?:\s+\*?(\S.*?))?\s*")


@dataclass(frozen=True)
class Seal:
    """A study's seal: its hash, and what was under it, or why that cannot be shown.

    truth: what was sealed; empty where `trouble` says why not. broken: the truth is there and is
    not what was sealed, rather than held back.
    """

    sha256: str
    truth: Mapping[str, Any] = field(default_factory=dict)
    trouble: str = ""
    broken: bool = False


def open_seal(folder: str | Path) -> Seal | None:
    """The seal of a study, opened if the truth is there and has the published hash.

    None for a study without a seal. Never raises for what stands in the files: a seal that cannot
    be opened must not cost the page that it is shown on.
    """
    seal = Path(folder) / SEAL_FILE
    if not seal.is_file():
        return None
    named = _hash_and_path(seal)
    if named is None:
        return Seal("", trouble=f"{SEAL_FILE} does not hold a SHA-256 (64 hex digits)", broken=True)
    digest, path = named
    if not path.is_file():
        return Seal(digest, trouble=f"{path.name} is not there yet")
    if path.stat().st_size > MAX_TRUTH_BYTES:
        return Seal(digest, trouble=f"{path.name} is larger than a truth can be", broken=True)
    return _open_with_hash(digest, path)


def truth_without_hash(path: Path) -> Seal:
    """A truth whose hash was not published.

    Raises: InputError where the file is missing or is not a json object.
    """
    truth = read_json(path)
    return Seal(hashlib.sha256(path.read_bytes()).hexdigest(), truth)


def _open_with_hash(digest: str, path: Path) -> Seal:
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != digest:
        return Seal(digest, trouble=f"{path.name} has the SHA-256 {found}", broken=True)
    try:
        truth = json.loads(content)
    except ValueError:
        truth = None
    if not isinstance(truth, dict):
        return Seal(digest, trouble=f"{path.name} is not a json object", broken=True)
    return Seal(digest, truth)


def _hash_and_path(seal: Path) -> tuple[str, Path] | None:
    """Hash and path that the seal names; None where it names none."""
    try:
        line = HASH_LINE.fullmatch(seal.read_text(encoding="ascii"))
    except (OSError, UnicodeDecodeError):
        return None
    return (line[1].lower(), seal.parent / (line[2] or TRUTH_FILE)) if line else None
