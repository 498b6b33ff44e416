"""`bluekoi completion`: what a shell needs to complete commands, options, studies and trials."""

from __future__ import annotations

import click

SHELLS = ("bash", "zsh", "fish")


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print the script by which SHELL completes commands, options, studies and trials.

    \b
    bash: bluekoi completion bash > ~/.local/share/bash-completion/completions/bluekoi
    zsh:  bluekoi completion zsh > a folder of $fpath, as _bluekoi
    fish: bluekoi completion fish > ~/.config/fish/completions/bluekoi.fish

    These commands install the script for the shell named first; it works in the next shell that you
    open. A call of `bluekoi completion` in the start-up file of the shell has the same effect, but
    slows down each start of the shell.
    """  # noqa: D301  click's mark for lines that keep their breaks
    from click.shell_completion import get_completion_class  # noqa: PLC0415

    from . import main  # noqa: PLC0415

    made = get_completion_class(shell)
    assert made is not None
    click.echo(made(main, {}, "bluekoi", "_BLUEKOI_COMPLETE").source())
