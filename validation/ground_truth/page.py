"""The comparison as a self-contained page."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from bluekoi.campaign import Campaign, load_campaign
from bluekoi.errors import input_error
from bluekoi.files import write_text
from bluekoi.study import load_study

from .comparison import ground_truth
from .seal import Seal, open_seal, truth_without_hash

CSS = "page.css"


def write_ground_truth(study: Path, results: Path, truth: Path | None = None) -> Path:
    """Path of ground_truth.html, written to the results folder.

    truth: its file; by default the one that STUDY/truth.sha256 names, or STUDY-truth/truth.json.

    Raises: InputError for a study without a truth.
    """
    seal = truth_without_hash(truth) if truth else open_seal(study) or _truth_beside_study(study)
    path = results / "ground_truth.html"
    write_text(path, comparison_page(load_campaign(results, load_study(study)), seal))
    return path


def _truth_beside_study(study: Path) -> Seal:
    path = study.with_name(f"{study.name}-truth") / "truth.json"
    if not path.is_file():
        raise input_error(study, "", "no truth.sha256", "a truth: name its file with --truth")
    return truth_without_hash(path)


def comparison_page(campaign: Campaign, seal: Seal) -> str:
    """Text of the page; all text of the truth is escaped."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = (Path(__file__).parent / "page.html").read_text(encoding="utf-8")
    css = files("bluekoi.report").joinpath(CSS).read_text(encoding="utf-8")
    return environment.from_string(template).render(
        name=campaign.study.root.name or "study",
        ground_truth=ground_truth(campaign, seal),
        css=Markup(css),
    )
