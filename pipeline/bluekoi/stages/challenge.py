"""A small challenge: concealed studies made, analysed without their truth, scored."""

from __future__ import annotations

import logging
import shutil
from dataclasses import asdict
from pathlib import Path

from ..challenge.find import find
from ..challenge.make import make, sealed_folder
from ..challenge.score import judge_all
from ..challenge.table import lines, summary, told
from ..files import write_json, write_text

SEED, COUNT = 7, 12
"""The small challenge; larger ones and other seeds: `bluekoi challenge make`."""

log = logging.getLogger(__name__)


def challenge(results: Path, *, threads: int = 1) -> None:
    """Write challenge/score.json and challenge/score.txt; the truth lies in challenge-sealed."""
    folder = results / "challenge"
    for old in (folder, sealed_folder(folder)):
        shutil.rmtree(old, ignore_errors=True)
    make(folder, seed=SEED, count=COUNT, footage=0, workers=threads, progress=_log)
    find(folder, workers=threads, again=False, progress=_log)
    judged = judge_all(folder)
    figures = summary(judged)
    write_text(folder / "score.txt", "\n".join([*lines(judged), *told(figures)]) + "\n")
    write_json(folder / "score.json", figures | {"each": [asdict(j) for j in judged]})


def _log(name: str, done: int, count: int) -> None:
    log.info("%s of %s: %s", done, count, name)
