"""`bluekoi stage`: what a rule of the Snakefile calls; one stage, for one trial or figure."""

from __future__ import annotations

import inspect
import logging
from importlib import import_module
from pathlib import Path

import click

FOLDER = Path(__file__).resolve().parents[1] / "stages"
SOME_TRIALS_BAD = 3


def stage_names() -> list[str]:
    """Names of the stages: the modules of pipeline/stages that have a function of their name."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.py")}
    return sorted(name for name, text in texts.items() if f"\ndef {name}(" in text)


@click.command(hidden=True)
@click.argument("name", type=click.Choice(stage_names()))
@click.option("--study", required=True, type=click.Path(path_type=Path))
@click.option("--results", required=True, type=click.Path(path_type=Path))
@click.option("--trial", "trial_id")
@click.option("--figure")
@click.option("--threads", type=click.IntRange(min=1), default=1)
@click.pass_context
def stage(ctx: click.Context, name: str, **options: object) -> None:
    """Run the stage NAME."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    logging.getLogger("pipeline").setLevel(logging.INFO)  # what a stage is at, for the run's line
    function = getattr(import_module(f"pipeline.stages.{name}"), name)
    takes = inspect.signature(function).parameters
    told = function(**{key: value for key, value in options.items() if key in takes})
    for line in told or []:
        click.echo(line, err=True)
    if told:
        ctx.exit(SOME_TRIALS_BAD)
