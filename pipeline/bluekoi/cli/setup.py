"""`bluekoi setup`: a study set up in the browser."""

from __future__ import annotations

import signal
import sys
import webbrowser
from pathlib import Path

import click

from .parameter_types import NonEmptyPath


def bluekoi_run_arguments(study: Path, results: Path) -> list[str]:
    """The command of a run from the page: `bluekoi run`, with its exit codes."""
    return [sys.executable, "-P", "-m", "bluekoi", "run", str(study), "--results", str(results)]


@click.command()
@click.argument("study", default=".", type=NonEmptyPath(path_type=Path))
@click.option(
    "--results", type=NonEmptyPath(path_type=Path), help="Folder for the results of a run."
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, show_default=True,
              help="Port on this machine; 0 takes a free one.")  # fmt: skip
@click.option("--browser/--no-browser", default=True, show_default=True,
              help="Open the page in the browser.")  # fmt: skip
def setup(study: Path, results: Path | None, port: int, browser: bool) -> None:
    """Fill in the files of STUDY in the browser, starting from a folder of videos.

    STUDY is a folder with videos, or an existing study; without it, the current folder. Only
    programs on this machine can reach the page, at an address with a random token. Ctrl-C ends the
    command. No file is written before you click Save on the page.
    """
    from ..errors import input_error  # noqa: PLC0415
    from ..preparation.draft import read_draft  # noqa: PLC0415
    from ..preparation.server import SetupServer  # noqa: PLC0415

    if not study.is_dir():
        found = "a file" if study.exists() else "no such folder"
        raise input_error(study, "", found, "a folder with videos")
    read_draft(study)
    folder = results or Path("results") / study.resolve().name
    try:
        server = SetupServer(study, folder, bluekoi_run_arguments(study, folder), port=port)
    except OSError as error:
        raise input_error("--port", "", f"port {port}: {error.strerror or error}", "a free port",
                          "Leave --port out to take one.") from error  # fmt: skip
    click.echo(f"Setting up {study}: {server.page_url}")
    click.echo("Open this address in a browser on this machine. Ctrl-C ends it.")
    if browser:
        webbrowser.open(server.page_url)
    # A request to terminate ends it as Ctrl-C does: in order, with the run.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        server.serve()
    except KeyboardInterrupt:
        pass
    finally:
        server.close()
    click.echo("Ended. What was saved is kept.")
