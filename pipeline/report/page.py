"""The page: its parts gathered, put into the template, written whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from ..campaign import Campaign
from ..files import write_text
from ..study.seal import Seal
from . import identify, proof, story, tables
from .hidden import hidden
from .media import Clip, Picture, clips, pictures
from .settings import settings, versions
from .trials import cards, left_out


def write_report(
    campaign: Campaign,
    figures: Mapping[str, tuple[str, str]],
    figures_dir: str | Path,
    overlays_dir: str | Path,
    path: str | Path,
    *,
    seal: Seal | None = None,
) -> None:
    """Write report.html: one page without network, all text escaped, media inside.

    figures: name -> (title, caption), their png stand in `figures_dir`. overlays_dir: ID.mp4,
    embedded while they are small, linked beside the page otherwise. What is missing is said.
    seal: of a made study; what was hidden stands at the end of the page.
    """
    beside = Path(path).parent
    shown = pictures(figures, Path(figures_dir), beside)
    films = clips(Path(overlays_dir), beside, campaign)
    write_text(path, page(campaign, shown, films, seal))


def page(
    campaign: Campaign,
    shown: Sequence[Picture],
    films: Mapping[str, Clip],
    seal: Seal | None = None,
) -> str:
    """Text of the page."""
    return str(
        _template("page.html").render(
            name=campaign.study.root.name or "study",
            **_story(campaign),
            joint=tables.joint(campaign),
            joint_words=tables.joint_words(campaign),
            spectrum=identify.spectrum(campaign),
            profiles=identify.profiles(campaign),
            table_1=tables.table_1(campaign),
            table_2=tables.table_2(campaign),
            columns=tables.COLUMNS,
            story_figures=[one for one in shown if one.name.startswith("mismatch")],
            figures=[one for one in shown if not one.name.startswith("mismatch")],
            left_out=left_out(campaign),
            cards=cards(campaign, films),
            settings=settings(campaign),
            versions=versions(),
            hidden=hidden(campaign, seal),
            css=Markup(_text("page.css")),  # noqa: S704  our own file
            js=Markup(_text("page.js")),  # noqa: S704  our own file
        )
    )


def _story(campaign: Campaign) -> dict[str, Any]:
    return {
        "summary": story.summary(campaign),
        "verdict": story.verdict(campaign),
        "numbers": story.numbers(campaign),
        "causes": story.causes(campaign),
        "where": story.where(campaign),
        "rivals": story.rivals(campaign),
        "next_trial": story.next_trial(campaign),
        "candidates": story.candidates(campaign),
        "held_out": proof.held_out(campaign),
        "proof": proof.which_trials(campaign),
        "proof_columns": proof.columns(campaign),
        "with_additions": campaign.has_additions,
        "shifts": tables.shifts(campaign),
    }


def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _template(name: str) -> Any:
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(_text(name))
