"""The command `bluekoi`; each command imports what it needs only when it is called."""

from __future__ import annotations

import click

from ..errors import EXIT_INTERRUPTED, InputError, escape_control_characters
from ..workflow.forkserver_client import limit_blas_to_one_thread
from .camera import calibrate, pool
from .check import check
from .compare import compare
from .completion import completion
from .design import design
from .doctor import doctor
from .explain import explain
from .export import export
from .init import init
from .report import report
from .run import run
from .setup import setup
from .simulate import simulate
from .stage import stage
from .watch import watch

EXIT_CODES = """\b
Exit codes: 0 done; 1 an error in the study, the files or the machine; 2 wrong use of this command;
3 done, but some trials went wrong (each is named); 130 interrupted.
"""


class InputErrorGroup(click.Group):
    """Commands that print an input error as its message (exit code 1); Ctrl-C ends with 130."""

    def invoke(self, ctx: click.Context) -> object:
        """Result of the command."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            click.echo(escape_control_characters(str(error)), err=True)
            ctx.exit(1)
        except KeyboardInterrupt:
            click.echo("Interrupted.", err=True)
            ctx.exit(EXIT_INTERRUPTED)


@click.group(
    cls=InputErrorGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=EXIT_CODES,
)
@click.version_option(package_name="bluekoi", prog_name="bluekoi")
def main() -> None:
    """Overhead footage of a fish-like robot in; coefficients and left-out physics out."""
    limit_blas_to_one_thread()


_COMMANDS = (
    setup,
    init,
    run,
    report,
    compare,
    watch,
    check,
    doctor,
    calibrate,
    pool,
    simulate,
    design,
    explain,
    export,
    completion,
    stage,
)
for _command in _COMMANDS:
    main.add_command(_command)
