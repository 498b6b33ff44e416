"""Studies of a challenge written to a folder, their truth under seal in another."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path

from ..errors import input_error
from ..files import write_json
from ..synthetic.concealed.writing import Made, conceal
from .plan import Entry, deal, recipe_of

LEAST_REACHED = 0.6
ATTEMPTS = 4
Progress = Callable[[str, int, int], None]


def sealed_folder(folder: Path) -> Path:
    """Where the truth lies: beside the challenge, never in it."""
    return folder.with_name(f"{folder.name}-sealed")


def make(
    folder: Path, *, seed: int, count: int, footage: int, workers: int, progress: Progress
) -> list[Made]:
    """Studies made, each in `studies/NAME`; `challenge.json` publishes the hashes of the seals.

    The seed lies with the seals: whoever knows it could draw the truth again.

    Raises: InputError where the folder already holds a challenge.
    """
    if (folder / "challenge.json").exists() or sealed_folder(folder).exists():
        raise input_error(
            folder, "", "a challenge already", "a new folder", "Its seals would be lost."
        )
    entries = deal(seed, count, footage=footage)
    done: dict[str, Made] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        jobs = {pool.submit(make_one, e, seed, folder): e.name for e in entries}
        for number, job in enumerate(as_completed(jobs), start=1):
            done[jobs[job]] = job.result()
            progress(jobs[job], number, count)
    made = [done[entry.name] for entry in entries]
    published = {m.name: {"folder": f"studies/{m.name}", "truth_sha256": m.sha256} for m in made}
    stamp = datetime.now(UTC).isoformat(timespec="seconds")
    write_json(folder / "challenge.json", {"made": stamp, "studies": published})
    write_json(sealed_folder(folder) / "seed.json", {"seed": seed, "count": count})
    return made


def make_one(entry: Entry, seed: int, folder: Path) -> Made:
    """One study; drawn again where its effect cannot reach a strength worth looking for."""
    study = folder / "studies" / entry.name
    sealed = sealed_folder(folder) / f"{entry.name}.json"
    for attempt in range(ATTEMPTS):
        shutil.rmtree(study, ignore_errors=True)
        made = conceal(recipe_of(entry, seed, attempt), study, sealed)
        if made.reached >= LEAST_REACHED:
            break
    return made
