"""Figures, videos and the plotting library in the form in which the page embeds them."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from PIL import Image
from plotly.offline import get_plotlyjs

from ..campaign import Campaign
from ..files import read_json_if_present
from .packing import gzip_base64

MAX_CLIP_BYTES = 3_000_000
"""A larger video is loaded from the file beside the page."""
MAX_ALL_CLIPS_BYTES = 12_000_000
"""Limit for all embedded videos together, so that the page opens within 2 s; the others are loaded
from the files when their trial is selected."""
FIGURE_ORDER = ("fig3", "fig5", "fig6", "paths", "mismatch_laws", "mismatch_map",
         "mismatch_dependence", "mismatch_held_out", "mismatch_candidates")  # fmt: skip
"""Figures that come first in the report, in this order."""


@dataclass(frozen=True)
class EmbeddedFigure:
    """A figure: data URI and size in px, or the reason for its absence.

    pdf: relative link to the vector version. data: packed csv.
    """

    name: str
    title: str
    caption: str
    uri: str
    size: tuple[int, int]
    missing: str
    pdf: str
    data: str = ""


@dataclass(frozen=True)
class OverlayClip:
    """Overlay video: base64 of the mp4 (empty if not embedded), relative link, time of frame 1."""

    data: str
    link: str
    start_s: float = 0.0


@cache
def compressed_plotly_script() -> str:
    """Packed javascript of plotly, as installed."""
    return gzip_base64(get_plotlyjs())


def embedded_figures(
    texts: Mapping[str, tuple[str, str]], folder: Path, beside: Path
) -> list[EmbeddedFigure]:
    """Figures with titles and captions, those of the paper first."""
    order = [*(n for n in FIGURE_ORDER if n in texts), *(n for n in texts if n not in FIGURE_ORDER)]
    return [_embedded_figure(folder / f"{name}.png", texts[name], beside) for name in order]


def embedded_overlay_clips(
    folder: Path, beside: Path, campaign: Campaign
) -> dict[str, OverlayClip]:
    """Video of every trial that has one, embedded in the order of trials.csv up to the limit."""
    out: dict[str, OverlayClip] = {}
    room = MAX_ALL_CLIPS_BYTES
    for trial in campaign.study.trials:
        path = folder / f"{trial.trial_id}.mp4"
        if not path.is_file():
            continue
        size = path.stat().st_size
        embed = size <= min(MAX_CLIP_BYTES, room)
        room -= size if embed else 0
        data = _base64(path) if embed else ""
        out[trial.trial_id] = OverlayClip(
            data, _relative_link(path, beside), _overlay_first_frame_time_s(path)
        )
    return out


def _overlay_first_frame_time_s(video: Path) -> float:
    """Time of the first frame, from the status of the overlay; 0 without one."""
    status = video.parents[1] / "status" / "overlays" / f"{video.stem}.json"
    return float((read_json_if_present(status) or {}).get("first_frame_s") or 0.0)


def _embedded_figure(path: Path, text: tuple[str, str], beside: Path) -> EmbeddedFigure:
    missing, size = _png_comment_and_size(path)
    pdf, data = path.with_suffix(".pdf"), path.with_suffix(".csv")
    return EmbeddedFigure(
        name=path.stem,
        title=text[0],
        caption=text[1],
        uri="" if missing else f"data:image/png;base64,{_base64(path)}",
        size=size,
        missing=missing,
        pdf=_relative_link(pdf, beside) if pdf.is_file() and not missing else "",
        data=gzip_base64(data.read_bytes()) if data.is_file() and not missing else "",
    )


def _png_comment_and_size(path: Path) -> tuple[str, tuple[int, int]]:
    """Comment of the png (the results missing to draw it) and its size."""
    if not path.is_file():
        return f"{path.name} does not exist", (0, 0)
    with Image.open(path) as image:
        image.load()
        return str(getattr(image, "text", {}).get("Comment", "")), image.size


def _base64(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode("ascii")


def _relative_link(path: Path, beside: Path) -> str:
    return Path(os.path.relpath(path, beside)).as_posix()
