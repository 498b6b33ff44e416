"""`bluekoi challenge`: concealed studies made, analysed without the truth, scored."""

from __future__ import annotations

import inspect
import logging
import shutil
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import click

FOLDER = click.argument("folder", type=click.Path(path_type=Path))
WORKERS = click.option(
    "--workers", default=2, show_default=True, type=click.IntRange(min=1), help="Processes."
)
Command = Callable[..., None]


@click.group()
def challenge() -> None:
    """Prove the search on studies whose truth is concealed: make, find, score."""


def _teller() -> Callable[[str, int, int], None]:
    """Says what is done of how much, and how long the rest takes at the pace so far."""
    began_s = time.monotonic()

    def say(name: str, done: int, count: int) -> None:
        from ..workflow.remaining import duration  # noqa: PLC0415

        left_s = (time.monotonic() - began_s) * (count / max(done, 1) - 1)
        ends = f"  about {duration(left_s)} left" if done < count else ""
        click.echo(f"{done:4d}/{count}  {name}{ends}", err=True)

    return say


def _drawn(*, count: int, footage: int) -> Callable[[Command], Command]:
    """Options of what is drawn, and how many studies unless told otherwise."""
    whole = click.IntRange(min=1)
    seed = click.option("--seed", required=True, type=click.IntRange(min=0),
                        help="Start of the draw.")  # fmt: skip
    studies = click.option("--count", default=count, show_default=True, type=whole)
    filmed = click.option("--footage", default=footage, show_default=True,
                          type=click.IntRange(min=0),
                          help="So many of the studies are filmed.")  # fmt: skip
    return lambda command: seed(studies(filmed(command)))


@challenge.command()
@FOLDER
@_drawn(count=12, footage=0)
@WORKERS
def make(*, folder: Path, seed: int, count: int, footage: int, workers: int) -> None:
    """Draw COUNT studies into FOLDER; their truth goes under seal to FOLDER-sealed."""
    from ..challenge.make import make as write  # noqa: PLC0415

    write(folder, seed=seed, count=count, footage=footage, workers=workers, progress=_teller())
    click.echo(f"{count} studies in {folder}; hashes of their sealed truth in challenge.json")


@challenge.command()
@FOLDER
@WORKERS
@click.option("--again", is_flag=True, help="Also studies that have results.")
@click.pass_context
def find(ctx: click.Context, *, folder: Path, workers: int, again: bool) -> None:
    """Analyse every study of FOLDER in processes that cannot read the seals."""
    ctx.exit(_found(folder, workers=workers, again=again))


def _found(folder: Path, *, workers: int, again: bool = False) -> int:
    """Exit code of an analysis of all studies: 3 where some ended without a verdict."""
    from ..challenge.find import find as search  # noqa: PLC0415

    started = time.perf_counter()
    failed = search(folder, workers=workers, again=again, progress=_teller())
    click.echo(f"done in {time.perf_counter() - started:.0f} s; {failed} without a verdict")
    return 3 if failed else 0


@challenge.command()
@FOLDER
@click.option("--quiet", is_flag=True, help="The table alone, without a line a study.")
def score(*, folder: Path, quiet: bool) -> None:
    """Open the seals of FOLDER, check their hashes, print the table; also to score.json."""
    from dataclasses import asdict  # noqa: PLC0415

    from ..challenge.score import judge_all  # noqa: PLC0415
    from ..challenge.table import lines, summary, told  # noqa: PLC0415
    from ..files import write_json  # noqa: PLC0415

    judged = judge_all(folder)
    figures = summary(judged)
    for line in [*([] if quiet else lines(judged)), *told(figures)]:
        click.echo(line)
    each = [asdict(j) | {"right": j.right, "false": j.false} for j in judged]
    write_json(folder / "score.json", figures | {"each": each})


@challenge.command()
@FOLDER
def compare(*, folder: Path) -> None:
    """Set what others would use beside the search, on the analysed studies of FOLDER."""
    from ..challenge.compare import compare as rate  # noqa: PLC0415
    from ..challenge.compare import compared  # noqa: PLC0415
    from ..challenge.score import judge_all  # noqa: PLC0415
    from ..files import write_json  # noqa: PLC0415

    figures = rate(folder, judge_all(folder), _teller())
    for line in compared(figures):
        click.echo(line)
    write_json(folder / "compare.json", figures)


@challenge.command()
@FOLDER
@_drawn(count=120, footage=8)
@WORKERS
@click.pass_context
def run(ctx: click.Context, **given: object) -> None:
    """A large challenge in one go: make, find, score, compare. Goes on where it was broken off."""
    folder = Path(str(given["folder"]))
    if not (folder / "challenge.json").is_file():
        ctx.invoke(make, **given)
    code = _found(folder, workers=int(str(given["workers"])))
    ctx.invoke(score, folder=folder, quiet=False)
    ctx.invoke(compare, folder=folder)
    ctx.exit(code)


@challenge.command("find-alone", hidden=True)
@FOLDER
@click.argument("sealed", type=click.Path(path_type=Path))
@click.argument("names", nargs=-1)
def find_alone(*, folder: Path, sealed: Path, names: tuple[str, ...]) -> None:
    """Analyse studies one after the other; the first thing done is to give up the seals."""
    from ..challenge.find import results_of  # noqa: PLC0415
    from ..challenge.guard import shut_out  # noqa: PLC0415
    from ..files import write_json  # noqa: PLC0415

    guard = shut_out(sealed)
    logging.basicConfig(level=logging.ERROR, format="%(message)s")
    for name in names:
        results = results_of(folder, name)
        shutil.rmtree(results, ignore_errors=True)
        results.mkdir(parents=True)
        times, failure = _analysed(folder / "studies" / name, results)
        write_json(results / "times.json", {"guard": guard, "failure": failure, "cpu_s": times})
        click.echo(f"{name} {sum(times.values()):.1f} s {failure}".strip())


CHAIN = ("keypoints", "geometry", "tracks", "steady", "tuning", "mismatch")
"""Stages from a study folder to mismatch.json, in the order of the Snakefile."""


def _analysed(study: Path, results: Path) -> tuple[dict[str, float], str]:
    """Processor time (s) of each stage of one study, and why it failed (empty: it did not)."""
    from ..study import load_study  # noqa: PLC0415

    times: dict[str, float] = {}
    try:
        trials = [trial.trial_id for trial in load_study(study).trials]
        for name in CHAIN:
            begin = time.process_time()
            _stage(name, study, results, trials)
            times[name] = time.process_time() - begin
    except Exception as error:  # one study must not stop the others
        logging.getLogger(__name__).exception("study %s", study.name)
        return times, repr(error)
    return times, ""


def _stage(name: str, study: Path, results: Path, trials: list[str]) -> None:
    """Run a stage, once or for every trial, as its arguments say."""
    run = getattr(import_module(f"..stages.{name}", __package__), name)
    if "trial_id" not in inspect.signature(run).parameters:
        run(study, results)
        return
    for trial in trials:
        run(study, results, trial)
