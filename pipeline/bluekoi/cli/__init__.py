"""The command `bluekoi`; each command imports what it needs only when it is called."""

from __future__ import annotations

from typing import NoReturn

import click

from ..errors import EXIT_INTERRUPTED, InputError, escape_control_characters, input_error
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

EXIT_CODES_HELP = """\b
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
            _print_and_fail(ctx, error)
        except PermissionError as error:
            expected = "a file or folder that may be read, and written where a command writes"
            remedy = "Change its permissions, or name another one."
            place = error.filename or "a file"
            _print_and_fail(ctx, input_error(place, "", f"'{error.strerror}'", expected, remedy))
        except KeyboardInterrupt:
            click.echo("Interrupted.", err=True)
            ctx.exit(EXIT_INTERRUPTED)


def _print_and_fail(ctx: click.Context, error: InputError) -> NoReturn:
    click.echo(escape_control_characters(str(error)), err=True)
    ctx.exit(1)


@click.group(
    cls=InputErrorGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=EXIT_CODES_HELP,
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
