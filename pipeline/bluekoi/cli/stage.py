"""`bluekoi stage`: runs one stage for one trial or figure; the rules of the Snakefile call it."""

from __future__ import annotations

import click


@click.command(hidden=True, context_settings={"ignore_unknown_options": True})
@click.argument("words", nargs=-1, type=click.UNPROCESSED)
@click.pass_context
def stage(ctx: click.Context, words: tuple[str, ...]) -> None:
    """Run a stage, as a rule of the Snakefile does."""
    from ..workflow.stage_call import run_stage  # noqa: PLC0415

    ctx.exit(run_stage(words))
