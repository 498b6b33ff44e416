"""docs/commands.md from the parsers of the commands; a test checks that it is current.

python docs/commands_page.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import click

from bluekoi.cli import main

PAGE = Path(__file__).resolve().parent / "commands.md"
HEAD = """# Commands

`bluekoi COMMAND --help` shows the same text as this page. [Running a study](running.md) explains
exit codes, shell completion and troubleshooting. In the usage lines, STUDY is the path of a study
folder. The default results folder is results/NAME, where NAME is the name of the study folder."""


def page() -> str:
    """Text of docs/commands.md."""
    return "\n".join([HEAD, *_group(main, "bluekoi")]) + "\n"


def _group(group: click.Group, path: str) -> Iterator[str]:
    for name, command in group.commands.items():
        if not command.hidden:
            yield from _command(command, f"{path} {name}")
            if isinstance(command, click.Group):
                yield from _group(command, f"{path} {name}")


def _command(command: click.Command, path: str) -> Iterator[str]:
    context = click.Context(command, info_name=path)
    level = "#" * len(path.split())
    yield f"\n{level} `{path}`\n"
    yield f"    {' '.join([path, *command.collect_usage_pieces(context)])}\n"
    yield _text(inspect.cleandoc(command.help or ""))
    options = [p for p in command.params if isinstance(p, click.Option) and not p.hidden]
    if options:
        yield "\n| option | default | meaning |\n|---|---|---|"
    for option in options:
        yield f"| {_names(option, context)} | {_default(option)} | {_cell(option.help or '')} |"


def _names(option: click.Option, context: click.Context) -> str:
    value = "" if option.is_flag else f" {_cell(option.make_metavar(context))}"
    return f"`{', '.join([*option.opts, *option.secondary_opts])}{value}`"


def _default(option: click.Option) -> str:
    if option.required:
        return "required"
    plain = isinstance(option.default, (str, int, float, tuple, Path)) and not option.is_flag
    if option.multiple or not plain or option.default in ("", ()):
        return ""
    return _cell(str(option.default))


def _text(text: str) -> str:
    r"""Help as Markdown; paragraphs that click keeps as they are (`\b`) become code."""
    parts = re.split(r"\n\s*\n", text.strip())
    return "\n\n".join(_paragraph(part) for part in parts)


def _paragraph(part: str) -> str:
    if part.startswith("\b"):
        return "\n".join(f"    {line}" for line in part.splitlines()[1:])
    return part.strip()


def _cell(text: str) -> str:
    return text.replace("|", " or ").replace("\n", " ").strip()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
