"""Names given to a command: paths, studies and trials, with what a shell may complete."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

MAX_TRIALS_CSV_BYTES_FOR_COMPLETION = 10_000_000
"""Size of a trials.csv up to which a shell completes names of trials."""


class NonEmptyPath(click.Path):
    """A path that is not empty, as that of a shell's variable that was never set is."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path.

        Raises: click.BadParameter where it is empty.
        """
        if value == "":
            self.fail("is empty; expected a folder. Is a variable not set?", param, ctx)
        return super().convert(value, param, ctx)


class StudyName(NonEmptyPath):
    """A folder with a study.yaml, or that file itself; a shell completes the folders.

    also: further names that stand for a study.
    """

    def __init__(self, *also: str, path_type: type = str) -> None:
        super().__init__(path_type=path_type)
        self.also = also

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The study's folder, also where its study.yaml is given."""
        folder, name = os.path.split(value)
        is_settings_file = name == "study.yaml" and os.path.isfile(value)
        return super().convert(folder or "." if is_settings_file else value, param, ctx)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Studies and folders whose names begin so."""
        from click.shell_completion import CompletionItem  # noqa: PLC0415

        folder, _, start = incomplete.rpartition("/")
        try:
            entries = sorted(
                os.scandir(folder + "/" if "/" in incomplete else "."), key=_entry_name
            )
        except OSError:
            entries = []
        found = [CompletionItem(name, help="study") for name in self.also
                 if name.startswith(incomplete)]  # fmt: skip
        for entry in entries:
            if entry.name.startswith(start) and _is_completion_candidate(entry, start):
                path = f"{folder}/{entry.name}" if "/" in incomplete else entry.name
                study = os.path.isfile(os.path.join(entry.path, "study.yaml"))
                found.append(CompletionItem(path if study else f"{path}/",
                                            help="study" if study else "folder"))  # fmt: skip
        return found


class TrialName(click.ParamType):
    """The trial_id of a trial of the study that the command is given."""

    name = "trial"

    def shell_complete(
        self,
        ctx: click.Context,
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Trials of the study's trials.csv whose names begin so; none where it cannot be read."""
        import csv  # noqa: PLC0415

        from click.shell_completion import CompletionItem  # noqa: PLC0415

        # While an option lacks its value, click leaves the arguments before it unnamed.
        study = ctx.params.get("study") or next(iter(ctx.args), ".")
        path = os.path.join(str(study), "trials.csv")
        try:
            if (
                not os.path.isfile(path)
                or os.path.getsize(path) > MAX_TRIALS_CSV_BYTES_FOR_COMPLETION
            ):
                return []
            with open(path, encoding="utf-8-sig", newline="") as lines:
                names = [str(row.get("trial_id") or "") for row in csv.DictReader(lines)]
        except (OSError, UnicodeDecodeError, csv.Error):
            return []
        return [CompletionItem(name) for name in names if name and name.startswith(incomplete)]


def _entry_name(entry: os.DirEntry[str]) -> str:
    return entry.name


def _is_completion_candidate(entry: os.DirEntry[str], start: str) -> bool:
    """Whether an entry is a folder, hidden ones only where their dot is typed."""
    return entry.is_dir() and (start.startswith(".") or not entry.name.startswith("."))
