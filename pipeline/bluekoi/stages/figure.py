"""One figure of a study, as png, vector pdf and csv."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from ..campaign import load_campaign
from ..study import load_study


def figure(study: Path, results: Path, figure: str) -> None:
    """Write figures/NAME.png, figures/NAME.pdf and figures/NAME.csv."""
    # By name, so that the fingerprint of one figure does not cover the files of all others.
    figures = import_module("bluekoi.figures")
    target = results / "figures" / f"{figure}.png"
    campaign = load_campaign(results, load_study(study))
    figures.write_figure_files(figure, campaign, target, target.with_suffix(".pdf"))


def preload() -> None:
    """Import all figures."""
    figures = import_module("bluekoi.figures")
    for name in figures.figure_names():
        figures.figure_title(name)
