"""Templates of the pages, and the headings that both pages give a verdict.

The page of `bluekoi explain` needs nothing else of the report of a study.
"""

from __future__ import annotations

import re
from importlib.resources import files
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

VERDICT_HEADINGS = {
    "none": "No mismatch beyond the noise",
    "physics": "Missing physics",
    "measurement": "Measurement error",
    "unexplained": "A mismatch that no known cause explains",
}


def verdict_heading(kind: str, sentence: str = "") -> str:
    """Heading of a kind of verdict; without causes, the first clause of the verdict's sentence,
    which tells whether the model describes the trials.
    """
    if kind == "none" and sentence:
        return re.split("[:,]", sentence, maxsplit=1)[0]
    return VERDICT_HEADINGS.get(kind, kind)


def render_template(template: str, **values: Any) -> str:
    """A template of this folder, with the page's style."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    css = Markup(read_resource("page.css"))  # noqa: S704  our own file
    return environment.from_string(read_resource(template)).render(css=css, **values)


def read_resource(name: str) -> str:
    """Text of a file of this folder."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
