"""`bluekoi watch`: a study analysed again whenever one of its files has changed."""

from __future__ import annotations

import signal
import subprocess
import threading
from pathlib import Path

import click

from .number_types import FiniteNumber
from .parameter_types import NonEmptyPath, StudyName
from .run import check_cores, snakemake_command

ANALYSIS_FAILED_MESSAGE = "Some of it could not be analysed: see the terminal."
FileStates = dict[str, tuple[int, int]]
MIN_UNCHANGED_DURATION_S = 3.0
"""A file that has not changed for so long is whole: a copy from a card writes all the time."""


WATCH_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>BlueKoi: watching</title>
<style>body{margin:0;font:15px sans-serif}p{margin:0;padding:.4em 1em;background:#20262e;color:#fff}
iframe{border:0;width:100%;height:calc(100vh - 2.2em)}</style>
<p role="status">Watching.</p><iframe title="Report" src="report.html"></iframe>
<script>
let shown;
function update(state) {
  document.querySelector("p").textContent = state.text;
  if (shown !== undefined && shown !== state.count)
    document.querySelector("iframe").src = "report.html?" + state.count;
  shown = state.count;
}
setInterval(() => {
  const script = document.createElement("script");
  script.src = "watch.js?" + Date.now();
  script.onload = script.onerror = () => script.remove();
  document.head.append(script);
}, 2000);
</script></html>
"""
"""Shows the report, and again when it has changed: a local page may load scripts beside it, not
ask for files.
"""


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.option("--results", type=NonEmptyPath(path_type=Path), help="Folder for the results.")
@click.option("--cores", default="all", show_default=True, callback=check_cores,
              help="How many jobs at once.")  # fmt: skip
@click.option("--every", "every_s", type=FiniteNumber(0.1), default=2.0, show_default=True,
              help="Seconds between two checks of the files.")  # fmt: skip
def watch(study: Path, results: Path | None, cores: str, every_s: float) -> None:
    """Analyse STUDY again whenever a file or a row in it changes, until Ctrl-C.

    The page watch.html in the results folder shows the report, and reloads it after each analysis.
    A file that is still being copied is read when its size no longer changes. If there is an error
    in the study, the command reports it and waits for the next change.
    """
    from ..errors import input_error  # noqa: PLC0415
    from ..files import write_text  # noqa: PLC0415

    if not study.is_dir():
        raise input_error(study, "", "no such folder", "a study folder")
    over = threading.Event()
    before = [(n, signal.signal(n, lambda *_: over.set())) for n in (signal.SIGINT, signal.SIGTERM)]
    folder = results or Path("results") / study.resolve().name
    page, script = folder / "watch.html", folder / "watch.js"
    write_text(page, WATCH_PAGE)
    click.echo(f"Watching {study}; the report: {page}. Ctrl-C ends it.")
    seen: FileStates | None = None
    count = 0
    try:
        while not over.is_set():
            now = study_file_states(study, folder)
            if now != seen and remains_unchanged(now, study, folder, over):
                write_text(script, _status_update_script(count, "Analysing."))
                code = run_analysis(snakemake_command(str(study), results, cores, ()), over)
                seen, count = now, count + 1
                write_text(
                    script,
                    _status_update_script(
                        count, "Up to date." if code == 0 else ANALYSIS_FAILED_MESSAGE
                    ),
                )
            over.wait(every_s)
    finally:
        for path in (page, script):
            path.unlink(missing_ok=True)
        for number, handler in before:
            signal.signal(number, handler)
    click.echo("Watching ended. What is done is kept.")


def _status_update_script(count: int, text: str) -> str:
    return f"update({{count: {count}, text: {text!r}}});\n"


def study_file_states(study: Path, results: Path) -> FileStates:
    """Size and date of each file of a study, by path, without results inside its folder."""
    own, found = results.resolve(), {}
    for path in sorted(study.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(study).parts)
        if hidden or path.resolve().is_relative_to(own) or not path.is_file():
            continue
        try:
            state = path.stat()
        except OSError:
            continue  # removed in between
        found[str(path)] = (state.st_size, state.st_mtime_ns)
    return found


def remains_unchanged(now: FileStates, study: Path, results: Path, over: threading.Event) -> bool:
    """Whether nothing in the study changes for `MIN_UNCHANGED_DURATION_S`."""
    return not over.wait(MIN_UNCHANGED_DURATION_S) and study_file_states(study, results) == now


def run_analysis(words: list[str], over: threading.Event) -> int:
    """Exit code of one run, ended as soon as its jobs allow when `over` is set."""
    # A session of its own: Ctrl-C comes to this process alone, which ends the run in order.
    with subprocess.Popen(words, start_new_session=True) as run:  # noqa: S603
        while run.poll() is None:
            if over.wait(0.2):
                run.terminate()
                break
        return run.wait()
