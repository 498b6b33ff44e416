"""Paths given to a command."""

from __future__ import annotations

from typing import Any

import click


class Named(click.Path):
    """A path that is not empty, as that of a shell's variable that was never set is."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path.

        Raises: click.BadParameter where it is empty.
        """
        if value == "":
            self.fail("is empty; expected a folder. Is a variable not set?", param, ctx)
        return super().convert(value, param, ctx)
