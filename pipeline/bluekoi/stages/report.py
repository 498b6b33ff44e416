"""The report: one HTML page with all results."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from ..campaign import load_campaign
from ..report.page import write_report
from ..study import load_study
from .result_paths import ResultPaths


def report(study: Path, results: Path) -> None:
    """Write report.html from the results and the figures that have been drawn."""
    # By name, so that editing one figure's code does not count as a change of the page's.
    figures = import_module("bluekoi.figures")
    campaign = load_campaign(results, load_study(study))
    figures_text = {
        name: (figures.figure_title(name, campaign), figures.figure_caption(name, campaign))
        for name in figures.figure_names()
    }
    write_report(
        campaign,
        figures_text,
        results / "figures",
        results / "overlays",
        ResultPaths(results).report,
    )
