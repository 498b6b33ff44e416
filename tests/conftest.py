"""Fixtures shared by all tests."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from bluekoi.mismatch import MismatchResult, find_mismatch
from bluekoi.synthetic.synthetic_study_design import demo_design
from measured_studies import MeasuredStudy, measure_design

ROOT = Path(__file__).resolve().parents[1]
LONGEST = (
    "test_any_study", "test_keypoints_silhouette", "test_workflow", "test_camera_calibrate",
    "test_finder", "test_camera_corner_fit", "test_explain", "test_engine", "test_cli",
    "test_bad_input", "test_camera_geometry", "test_figures", "test_tuning", "test_smoothing",
)  # fmt: skip
"""Files that take longest, first: no process of the suite is left with one of them at the end.

The first compiles the model of the robot while the second, which needs none, keeps the other
process at work.
"""


if "PYTEST_XDIST_WORKER" in os.environ:
    # xdist keeps all cores at work: several threads in each of its processes only take longer
    os.environ.setdefault("BLUEKOI_THREADS", "1")


def pytest_configure(config: pytest.Config) -> None:
    """The order of the files is ours, not that of xdist, which begins with most tests."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Longest files first, the others as they come."""
    place = {name: k for k, name in enumerate(LONGEST)}
    items.sort(key=lambda item: place.get(item.path.stem, len(place)))


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
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[MeasuredStudy, MismatchResult]:
    """Two thirds of the demo's trials from keypoints, and what the search finds in them.

    `make test-long` runs the search on all 24 (test_demo_truth.py).
    """
    design = demo_design()
    plans = tuple(plan for k, plan in enumerate(design.plans) if k % 3 != 1)
    m = measure_design(replace(design, plans=plans), tmp_path_factory.mktemp("demo"))
    return m, find_mismatch(m.study, m.series, m.steady, progress=lambda _: None)
