"""The notebook of the docs runs from `import bluekoi` to its figures, on a small study."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

import bluekoi
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.steady import steady
from bluekoi.stages.tracks import tracks
from bluekoi.stages.tuning import tuning
from small_studies import small_study

NOTEBOOK = Path(__file__).resolve().parents[1] / "docs/notebook.ipynb"


@pytest.fixture
def analysed_demo(tmp_path: Path) -> Path:
    """A folder with studies/demo and results/demo, the latter without a search."""
    study, results = small_study(tmp_path / "studies/demo"), tmp_path / "results/demo"
    for trial in bluekoi.load_study(study).trials:
        keypoints(study, results, trial.trial_id)
        tracks(study, results, trial.trial_id)
    steady(study, results)
    tuning(study, results)
    return tmp_path


def test_the_notebook_runs_to_its_figures(analysed_demo, monkeypatch, capsys):
    monkeypatch.chdir(analysed_demo)
    mpl.use("Agg")
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    texts = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert texts[0].startswith("import bluekoi")
    space: dict[str, object] = {}
    for text in texts:
        exec(compile(text, str(NOTEBOOK), "exec"), space)
    for name in ("figure", "own"):
        figure = space[name]
        assert isinstance(figure, Figure)
        assert any(axes.lines or axes.collections for axes in figure.axes)
    assert "C_T" in capsys.readouterr().out
    assert all(not cell.get("outputs") for cell in cells)


def test_every_exported_name_is_there_and_others_are_not():
    for name in bluekoi.__all__:
        assert getattr(bluekoi, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'sumulate'"):
        bluekoi.sumulate  # noqa: B018
