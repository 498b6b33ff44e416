"""`bluekoi run`: runs the whole workflow through Snakemake."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import click

from ..errors import EXIT_INTERRUPTED, EXIT_USAGE
from ..workflow.forkserver_client import USER_COMMAND_VARIABLE
from .parameter_types import NonEmptyPath, StudyName

PACKAGE_FOLDER = Path(__file__).resolve().parents[1]
EXIT_SOME_TRIALS_FAILED = 3
"""Exit code of a run in which some trials failed and the others finished."""
EXIT_RUN_FAILED = 1
MAX_FAILED_TRIALS_SHOWN = 12
"""Lines on trials after a run that ended early."""
EXIT_TERMINATED = 128 + signal.SIGTERM
"""Exit code of a run that was ended by SIGTERM."""


def workflow_folder() -> Path:
    """Folder with Snakefile and config: the checkout, or the copy that installing makes."""
    checkout = PACKAGE_FOLDER.parents[1]
    return checkout if (checkout / "Snakefile").is_file() else PACKAGE_FOLDER / "workflow" / "files"


def snakemake_command(
    study: str, results: Path | None, cores: str, further: tuple[str, ...]
) -> list[str]:
    """Arguments that start Snakemake on a study."""
    home = workflow_folder()
    values = {"study": study} | ({"results": str(results)} if results else {})
    keys, rest = _split_config_keys(further)
    return [
        *(
            sys.executable,
            "-P",
            "-m",
            "bluekoi.cli.snakemake_launcher",
            "--snakefile",
            str(home / "Snakefile"),
        ),
        *("--workflow-profile", "none", *_default_snakemake_profile_options(home)),
        *("--cores", cores, "--config"),
        *(f"{key}={_quoted_for_config(value)}" for key, value in values.items()),
        *keys,
        *rest,
    ]


def _quoted_for_config(value: str) -> str:
    """A value that Snakemake reads as this very text, even where it looks like a number or a list.

    It strips quotes at the ends and reads the rest as yaml; the spaces keep the quotes.
    """
    return f" {json.dumps(value, ensure_ascii=False)} "


def _default_snakemake_profile_options(home: Path) -> list[str]:
    """Options of the default profile; Snakemake announces a profile that it reads itself."""
    import yaml  # noqa: PLC0415

    text = (home / "config/profiles/default/config.yaml").read_text(encoding="utf-8")
    given = {key: value for key, value in yaml.safe_load(text).items() if value is not False}
    return [w for key, value in given.items() for w in (f"--{key}", str(value)) if w != "True"]


def _split_config_keys(further: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Configuration keys among the further options, and the others.

    Snakemake takes the last `--config` alone, which would make it forget the study.
    """
    keys: list[str] = []
    rest: list[str] = []
    inside = False
    for word in further:
        if word.startswith("-"):
            name, _, value = word.partition("=")
            inside = name in ("--config", "-C")
            if inside:
                keys += [value] if value else []
                continue
        (keys if inside else rest).append(word)
    return keys, rest


def check_cores(_ctx: click.Context, _param: click.Parameter, value: str) -> str:
    """How many jobs at once, as Snakemake takes it."""
    if value == "all" or (value.isdecimal() and int(value) > 0):
        return value
    raise click.BadParameter(f"'{value}'; expected 1 or more, or 'all'.")


@click.command()
@click.argument("study", default="demo", type=StudyName("demo", path_type=str))
@click.option("--results", type=NonEmptyPath(path_type=Path), help="Folder for the results.")
@click.option(
    "--cores", default="all", show_default=True, callback=check_cores, help="How many jobs at once."
)
@click.argument("further", nargs=-1, type=click.UNPROCESSED)
@click.pass_context
def run(
    ctx: click.Context, study: str, results: Path | None, cores: str, further: tuple[str, ...]
) -> None:
    """Analyse STUDY: a folder, or `demo` (the default). Results that are up to date are kept.

    The analysis runs as a Snakemake workflow. Write options for Snakemake itself after `--`.
    """
    if further and not further[0].startswith("-"):
        raise click.UsageError(
            f"Got a second study '{further[0]}'; expected one study, or options of Snakemake "
            "after --."
        )
    os.environ[USER_COMMAND_VARIABLE] = shlex.join(["bluekoi", *sys.argv[1:]])
    returned = _run_process(snakemake_command(study, results, cores, further))
    folder = _requested_results_folder(study, results, further)
    dry = {"-n", "--dry-run", "--dryrun"} & set(further)
    if returned == 0 and not dry and (bad := _failed_trial_lines(folder, study)):
        click.echo("\n".join(bad), err=True)
        ctx.exit(EXIT_SOME_TRIALS_FAILED)
    if returned == 0 and not dry and not (folder / "outcome.json").is_file():
        for text in _trial_warnings(folder, study):
            click.echo(f"Warning: {text}", err=True)
    code = _exit_code(returned, folder)
    if code == EXIT_RUN_FAILED and not dry:
        for line in _trial_problem_lines(folder, study):
            click.echo(line, err=True)
    ctx.exit(code)


def _trial_problem_lines(results: Path, study: str) -> list[str]:
    """What is wrong with the trials of a run that a later stage ended: they may be why. Nothing
    where the study cannot be read.
    """
    from ..errors import InputError  # noqa: PLC0415

    try:
        bad = [*_failed_trial_lines(results, study), *_trial_remark_lines(results, study)]
    except InputError:  # printed by the run itself
        return []
    more = len(bad) - MAX_FAILED_TRIALS_SHOWN
    return [*bad[:MAX_FAILED_TRIALS_SHOWN], *([f"... and {more} more trials"] if more > 0 else [])]


def _requested_results_folder(study: str, results: Path | None, further: tuple[str, ...]) -> Path:
    """Where the results are, given as an option, as a key of Snakemake's or not at all."""
    named = [
        key.partition("=")[2]
        for key in _split_config_keys(further)[0]
        if key.startswith("results=")
    ]
    return Path(named[-1]) if named else results or Path("results") / Path(study).resolve().name


def _run_process(words: list[str]) -> int:
    """Exit code of a command, 130 where it was interrupted, 143 where it was asked to terminate.

    Ctrl-C reaches Snakemake and its jobs as well; they are waited for, not killed. A request to
    terminate (a supervisor's, `kill`) reaches this process alone and is handed on to Snakemake,
    which ends after the jobs at work. Snakemake starts with Ctrl-C blocked and lifts that itself,
    when it can take one (`snakemake_launcher`).
    """
    stopped = 0
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    with subprocess.Popen(words) as running:  # noqa: S603

        def terminate(*_: object) -> None:
            nonlocal stopped
            stopped = EXIT_TERMINATED
            running.terminate()

        before = signal.signal(signal.SIGTERM, terminate)
        try:
            while True:
                try:
                    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
                    return stopped if running.wait() and stopped else running.returncode
                except KeyboardInterrupt:
                    stopped = EXIT_INTERRUPTED
        finally:
            signal.signal(signal.SIGTERM, before)


def _failed_trial_lines(results: Path, study: str) -> list[str]:
    """A line for each bad trial of a run that ended before its last stage (`-- --until STAGE`)."""
    from ..files import read_json  # noqa: PLC0415
    from ..stages.trial_failure import failed_trial_lines, failure_reason  # noqa: PLC0415

    found = {p.stem: p for folder in ("status/keypoints", "status")
             for p in sorted((results / folder).glob("*.json"))}  # fmt: skip
    statuses = {name: read_json(path) for name, path in sorted(found.items())}
    bad = {name: status for name, status in statuses.items() if failure_reason(status)}
    known = _study_trial_ids(study) if bad else set()
    return failed_trial_lines({n: s for n, s in bad.items() if not known or n in known})


def _trial_remark_lines(results: Path, study: str) -> list[str]:
    """Remarks on the trials that were measured: one of them may hinder a later stage."""
    from ..files import read_json  # noqa: PLC0415

    known = _study_trial_ids(study)
    found = {p.stem: read_json(p) for p in sorted((results / "status").glob("*.json"))
             if not known or p.stem in known}  # fmt: skip
    return [f"{name}: {'; '.join(status['remarks'])}" for name, status in found.items()
            if status.get("ok") and status.get("remarks")]  # fmt: skip


def _trial_warnings(results: Path, study: str) -> list[str]:
    """Warnings on the trials of a run that ended before its last stage, which prints them; none on
    the demo.
    """
    from ..stages.outcome import available_trial_statuses  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415
    from ..trial_warnings import trial_warnings  # noqa: PLC0415

    if study == "demo":
        return []
    loaded = load_study(study)
    return trial_warnings(loaded, available_trial_statuses(loaded, results))


def _study_trial_ids(study: str) -> set[str]:
    """Ids of the trials of a study; none of the demo, all of whose trials are known."""
    from ..study import load_study  # noqa: PLC0415

    return set() if study == "demo" else {t.trial_id for t in load_study(study).trials}


def _exit_code(returned: int, results: Path) -> int:
    """0 where all is well, 3 where all is there but some trials are bad, else 1."""
    if returned in (0, EXIT_USAGE, EXIT_INTERRUPTED, EXIT_TERMINATED):
        return returned
    from ..stages.result_paths import ResultPaths  # noqa: PLC0415

    last = ResultPaths(results).end_of_run_results
    complained = not (results / "outcome.json").is_file()
    some_failed = complained and all(path.is_file() for path in last)
    return EXIT_SOME_TRIALS_FAILED if some_failed else EXIT_RUN_FAILED
