"""Checks of studies that a generator has written."""

from __future__ import annotations

from pathlib import Path


def assert_same_files(written: Path, reference: Path) -> None:
    """Every file below `written`, more than ten, is byte for byte that below `reference`."""
    files = [path for path in written.rglob("*.*") if path.is_file()]
    assert len(files) > 10
    for path in files:
        assert path.read_bytes() == (reference / path.relative_to(written)).read_bytes()
