"""One self-contained html page: what was analysed, what was found, how sure that is.

No network, no file beside it: pictures and films are in the page. All text is escaped by the
template engine; ids of trials hold only letters, digits, `_` and `-`.
"""

from __future__ import annotations

import base64
import math
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import jinja2

from ..campaign import Campaign
from ..files import write_text
from .tables import candidate_rows, coefficient_rows, power_rows, radius_rows, trial_rows

FOLDER = Path(__file__).parent
FILM_LIMIT_BYTES = 40_000_000
LIBRARIES = (
    "bluekoi", "numpy", "scipy", "opencv-python-headless", "av", "numba", "filterpy", "snakemake",
)  # fmt: skip


def write_report(
    campaign: Campaign,
    figures: Mapping[str, tuple[str, str]],
    figures_dir: Path,
    overlays_dir: Path,
    path: Path,
) -> None:
    """Write the page; figures: name -> (title, caption), their png stand in `figures_dir`."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    page = environment.get_template("page.html").render(
        **contents(campaign),
        figures=_figures(figures, figures_dir),
        films=_films(campaign, overlays_dir),
        style=_inline("page.css"),
        script=_inline("page.js"),
    )
    write_text(path, page)


def contents(campaign: Campaign) -> dict[str, Any]:
    """What the template tells, as plain rows and sentences."""
    joint = campaign.coefficients.get("joint", {})
    return {
        "study": campaign.study.root.name,
        "analysed": len(campaign.analysed),
        "planned": len(campaign.study.trials),
        "left_out": [(trial.trial_id, why) for trial, why in campaign.left_out],
        "mismatch": campaign.mismatch,
        "candidates": candidate_rows(campaign),
        "changes": coefficient_rows(campaign),
        "joint": joint,
        "unit_reading": campaign.coefficients.get("unit_reading", ""),
        "powers": power_rows(campaign),
        "radii": radius_rows(campaign),
        "trials": trial_rows(campaign),
        "setup": campaign.study.setup.model_dump(),
        "versions": versions(),
        "truth": None,
    }


def number(value: object, digits: int = 3) -> str:
    """A number with so many significant digits, or a dash where there is none."""
    if not isinstance(value, (int, float)) or math.isnan(value):
        return "–"
    return f"{value:.{digits}g}" if abs(value) < 1e5 else f"{value:.2e}"


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that decide results."""
    found = {"Python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    return found


def _inline(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def _figures(figures: Mapping[str, tuple[str, str]], folder: Path) -> list[dict[str, str]]:
    return [
        {"name": name, "title": title, "caption": caption, "data": _data(folder / f"{name}.png")}
        for name, (title, caption) in figures.items()
        if (folder / f"{name}.png").is_file()
    ]


def _films(campaign: Campaign, folder: Path) -> dict[str, str]:
    """Overlay films by trial, as many as fit into `FILM_LIMIT_BYTES`."""
    films, room = {}, FILM_LIMIT_BYTES
    for trial in campaign.analysed:
        path = folder / f"{trial.trial_id}.mp4"
        if path.is_file() and path.stat().st_size <= room:
            room -= path.stat().st_size
            films[trial.trial_id] = _data(path)
    return films


def _data(path: Path) -> str:
    """Content as base64."""
    return base64.b64encode(path.read_bytes()).decode("ascii")
