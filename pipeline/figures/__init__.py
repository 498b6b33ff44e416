"""Figures of a campaign, one file each; the folder is the registry.

A figure module has TITLE, CAPTION (text for the report), NEEDS (fields of `Campaign` without
which nothing can be drawn) and `draw(campaign) -> Figure`; one whose words depend on the campaign
has `told(campaign) -> (title, caption)` as well. What several figures share stands in
the package `drawing`.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..campaign import Campaign, load_campaign
from ..faults import fault, nearest
from ..files import whole_file
from .drawing.look import LOOK, notice

__all__ = ["Campaign", "caption", "draw", "draw_file", "load_campaign", "missing", "names", "title"]

WORDS = {
    "tracks": "tracks of the trials",
    "steady": "steady speeds and radii",
    "coefficients": "fitted coefficients",
    "simulations": "simulated paths",
    "geometry": "the check of the rigid distances (geometry.json)",
    "mismatch": "the search for what was left out (mismatch.json)",
    "mismatch_detail": "the details of that search (mismatch_detail.json)",
}
PNG: Mapping[str, Any] = {"Software": None}
PDF: Mapping[str, Any] = {"CreationDate": None, "ModDate": None, "Creator": None, "Producer": None}


def names() -> tuple[str, ...]:
    """Names of all figures: the files of this folder, in alphabetical order."""
    found = (m.name for m in pkgutil.iter_modules(__path__) if not m.ispkg)
    return tuple(sorted(found))


def title(name: str, campaign: Campaign | None = None) -> str:
    """Title of a figure, of that campaign's figure where its words depend on the campaign."""
    return _told(name, campaign)[0]


def caption(name: str, campaign: Campaign | None = None) -> str:
    """What a figure shows, in sentences; as `title`."""
    return _told(name, campaign)[1]


def _told(name: str, campaign: Campaign | None) -> tuple[str, str]:
    module = _module(name)
    if campaign is not None and hasattr(module, "told"):
        heading, text = module.told(campaign)
        return str(heading), str(text)
    return str(module.TITLE), str(module.CAPTION)


def missing(name: str, campaign: Campaign) -> tuple[str, ...]:
    """What the figure needs and the campaign does not have, in words."""
    needs = _module(name).NEEDS
    return tuple(WORDS[need] for need in needs if not getattr(campaign, need))


def draw(name: str, campaign: Campaign) -> Figure:
    """The figure; where something it needs is missing, a notice that says what."""
    module = _module(name)
    lacking = missing(name, campaign)
    with matplotlib.rc_context(LOOK):
        if lacking:
            return notice(
                title(name, campaign), "Not drawn: this run has no " + " and no ".join(lacking)
            )
        figure: Figure = module.draw(campaign)
        return figure


def draw_file(name: str, campaign: Campaign, path_png: str | Path, path_pdf: str | Path) -> None:
    """Write a figure as png and as vector pdf, the same bytes for the same campaign.

    The png carries title and caption with it, and in `Comment` what was missing to draw it.
    """
    figure = draw(name, campaign)
    words = {"Title": title(name, campaign), "Description": caption(name, campaign)}
    if lacking := missing(name, campaign):
        words["Comment"] = "this run has no " + " and no ".join(lacking)
    FigureCanvasAgg(figure)
    with matplotlib.rc_context(LOOK):
        with whole_file(path_png) as temporary:
            figure.savefig(temporary, format="png", dpi=150, metadata={**PNG, **words})
        with whole_file(path_pdf) as temporary:
            figure.savefig(temporary, format="pdf", metadata=dict(PDF))


def _module(name: str) -> ModuleType:
    if name not in names():
        raise fault("figures", "", f"'{name}'", "the name of a figure", nearest(name, names()))
    return import_module(f"{__name__}.{name}")
