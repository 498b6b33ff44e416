"""The frame of every example's command: its faults told in one line, never as a traceback."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import click

from bluekoi.errors import InputError, printable

P = ParamSpec("P")


def plainly(command: Callable[P, None]) -> Callable[P, None]:
    """The command, ending with the message of a `InputError` and exit code 1 where there is one."""

    @wraps(command)
    def told(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except InputError as error:
            raise click.ClickException(printable(str(error))) from None

    return told
