"""Pictures and clips as they stand in the page."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from ..campaign import Campaign

CLIP_BYTES = 3_000_000
"""A longer clip is linked, not embedded."""
ALL_CLIPS_BYTES = 40_000_000
"""Once the embedded clips weigh this much, the others are linked."""
FIRST = ("fig3", "fig5", "fig6", "paths", "mismatch_map", "mismatch_dependence",
         "mismatch_held_out", "mismatch_candidates")  # fmt: skip


@dataclass(frozen=True)
class Picture:
    """A figure: data URI and size in px, or why there is none; pdf: relative link, if there."""

    name: str
    title: str
    caption: str
    uri: str
    size: tuple[int, int]
    missing: str
    pdf: str


@dataclass(frozen=True)
class Clip:
    """A trial's overlay video: base64 of the mp4, empty where it is only linked."""

    data: str
    link: str


def pictures(told: Mapping[str, tuple[str, str]], folder: Path, beside: Path) -> list[Picture]:
    """Figures with their titles and captions, the paper's first; one without a png says so."""
    order = [*(n for n in FIRST if n in told), *(n for n in told if n not in FIRST)]
    return [_picture(folder / f"{name}.png", told[name], beside) for name in order]


def clips(folder: Path, beside: Path, campaign: Campaign) -> dict[str, Clip]:
    """Clip of every trial that has one, embedded in the order of trials.csv while room is left."""
    out: dict[str, Clip] = {}
    room = ALL_CLIPS_BYTES
    for trial in campaign.study.trials:
        path = folder / f"{trial.trial_id}.mp4"
        if not path.is_file():
            continue
        size = path.stat().st_size
        embed = size <= min(CLIP_BYTES, room)
        room -= size if embed else 0
        out[trial.trial_id] = Clip(_base64(path) if embed else "", _link(path, beside))
    return out


def _picture(path: Path, told: tuple[str, str], beside: Path) -> Picture:
    missing, size = _read(path)
    pdf = path.with_suffix(".pdf")
    return Picture(
        name=path.stem,
        title=told[0],
        caption=told[1],
        uri="" if missing else f"data:image/png;base64,{_base64(path)}",
        size=size,
        missing=missing,
        pdf=_link(pdf, beside) if pdf.is_file() and not missing else "",
    )


def _read(path: Path) -> tuple[str, tuple[int, int]]:
    """What the png says was missing to draw it (its comment), and its size."""
    if not path.is_file():
        return f"{path.name} is not there", (0, 0)
    with Image.open(path) as image:
        image.load()
        return str(getattr(image, "text", {}).get("Comment", "")), image.size


def _base64(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode("ascii")


def _link(path: Path, beside: Path) -> str:
    return Path(os.path.relpath(path, beside)).as_posix()
