"""Fixtures shared by all tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bluekoi.mismatch import Found, find_mismatch
from bluekoi.synthetic.design import demo_design
from measured import Measured, measured

ROOT = Path(__file__).resolve().parents[1]


class Recordings:
    """Folder of recordings made by others; see docs/recordings.md for their sources."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def __truediv__(self, name: str) -> Path:
        path = self.root / name
        if not path.exists():
            pytest.skip(f"no recordings at {self.root} (set BLUEKOI_RECORDINGS): {name}")
        return path


@pytest.fixture(scope="session")
def recordings() -> Recordings:
    """Real recordings; a test that asks for a missing one is skipped with the reason."""
    return Recordings(Path(os.environ.get("BLUEKOI_RECORDINGS", ROOT.parent / "shared" / "data")))


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Measured, Found]:
    """The demo's campaign from keypoints, and what the search finds in it."""
    m = measured(demo_design(), tmp_path_factory.mktemp("demo"))
    return m, find_mismatch(m.study, m.series, m.steady, progress=lambda _: None)
