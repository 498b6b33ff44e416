"""`bluekoi stage`: one stage, for one trial or figure, as a rule of the Snakefile calls it."""

from __future__ import annotations

import argparse
import ctypes
import inspect
import logging
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from ..errors import InputError, escape_control_characters
from ..files import write_json, write_text
from ..stages.freshness import is_fresh, status_file_path, trial_inputs_hash
from ..stages.result_paths import ResultPaths
from ..study import load_study

StageFunction = Callable[..., list[str] | None]
stage_logger = logging.getLogger(__name__)
PR_SET_PDEATHSIG = 1  # linux/prctl.h: the signal to get when the parent ends

STAGES_FOLDER = Path(__file__).resolve().parents[1] / "stages"
"""Folder of the stages, a file each."""
EXIT_SOME_TRIALS_FAILED = 3
"""Exit code of a stage in which some trials failed."""
MAXRSS_UNITS_PER_MB = 2**20 if sys.platform == "darwin" else 2**10  # of ru_maxrss


def stage_names() -> list[str]:
    """Names of the stages: modules of `stages` that have a function of their name."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in STAGES_FOLDER.glob("*.py")}
    return sorted(name for name, text in texts.items() if f"\ndef {name}(" in text)


def parse_options(words: Sequence[str]) -> argparse.Namespace:
    """Options of a stage; wrong ones end the process with exit code 2."""
    parser = argparse.ArgumentParser("bluekoi stage")
    parser.add_argument("name", choices=stage_names())
    parser.add_argument("--study", type=Path, required=True)
    parser.add_argument("--results", type=Path, required=True)
    parser.add_argument("--trial", dest="trials", action="append", default=[])
    parser.add_argument("--code", default="", help="hash of the stage's source files")
    parser.add_argument("--done", type=Path, help="marker to write when all trials are done")
    parser.add_argument("--figure")
    parser.add_argument("--threads", type=int, default=1)
    return parser.parse_args(words)


def run_stage(words: Sequence[str]) -> int:
    """Exit code of a stage: 0, 1 after an error in the input, 3 where some trials are bad."""
    options, start_s = parse_options(words), time.monotonic()
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    logging.getLogger("bluekoi").setLevel(logging.INFO)  # shown in the run's line of progress
    function = getattr(import_module(f"bluekoi.stages.{options.name}"), options.name)
    try:
        code = (
            run_stage_for_due_trials(function, options)
            if options.trials
            else _call_with_accepted_options(function, options)
        )
        if code in (0, EXIT_SOME_TRIALS_FAILED):
            _write_resource_usage(options, time.monotonic() - start_s)
    except InputError as error:
        sys.stderr.write(escape_control_characters(str(error)) + "\n")
        return 1
    return code


def _call_with_accepted_options(
    function: StageFunction, options: argparse.Namespace, **more: Any
) -> int:
    takes, given = inspect.signature(function).parameters, {**vars(options), **more}
    lines = function(**{key: value for key, value in given.items() if key in takes})
    sys.stderr.writelines(f"{line}\n" for line in lines or [])
    return EXIT_SOME_TRIALS_FAILED if lines else 0


def run_stage_for_due_trials(function: StageFunction, options: argparse.Namespace) -> int:
    """Run a stage for each trial that is out of date; the greatest exit code is returned.

    Of several trials each has a fork of this process, so that one whose process is killed costs the
    others nothing.
    """
    run = (
        _run_in_fork
        if len(options.trials) > 1 and _can_fork_safely()
        else _call_with_accepted_options
    )
    layout, codes = ResultPaths(options.results), [0]
    study = load_study(options.study, only=options.trials[0] if len(options.trials) == 1 else None)
    for number, name in enumerate(options.trials, 1):
        inputs = ""
        if options.code:
            inputs = trial_inputs_hash(options.name, study, study.trial(name), layout, options.code)
            if is_fresh(status_file_path(options.name, layout, name), options.results, inputs):
                continue
        stage_logger.info("%s (%d of %d)", name, number, len(options.trials))
        codes.append(run(function, options, trial_id=name, inputs=inputs))
    if not any(codes) and options.done:
        write_json(options.done, {"trials": options.trials})
    return max(codes)


def _can_fork_safely() -> bool:
    """Whether this process may be forked: elsewhere than on Linux system libraries may not be used
    after a fork, and a lock that another thread holds stays locked in the fork for ever.
    """
    return sys.platform == "linux" and len(os.listdir("/proc/self/task")) == 1


def _run_in_fork(function: StageFunction, options: argparse.Namespace, **more: Any) -> int:
    if not (pid := os.fork()):
        exit_fork_with_code_of(lambda: _call_with_accepted_options(function, options, **more))
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return code if code >= 0 else 128 - code


def exit_fork_with_code_of(work: Callable[[], int]) -> NoReturn:
    """End this process, a fork, with the exit code that `work` returns."""
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        terminate_with_parent()
        code = work()
    except InputError as error:
        sys.stderr.write(escape_control_characters(str(error)) + "\n")
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:  # whatever it is, this process must end here
        traceback.print_exc()
    finally:
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def terminate_with_parent() -> None:
    """Have the kernel kill this process when its parent ends (Linux)."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _write_resource_usage(options: argparse.Namespace, wall_s: float) -> None:
    """Write benchmarks/STAGE.tsv or benchmarks/STAGE/NAME.tsv: time and memory of this process."""
    own, jobs = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    cpu_s = own.ru_utime + own.ru_stime + jobs.ru_utime + jobs.ru_stime
    memory_mb = max(own.ru_maxrss, jobs.ru_maxrss) / MAXRSS_UNITS_PER_MB
    name = options.figure or (options.trials[0] if options.trials else "")
    path = options.results / "benchmarks" / options.name / name
    text = f"s\tmax_rss\tcpu_time\n{wall_s:.3f}\t{memory_mb:.1f}\t{cpu_s:.3f}\n"
    write_text(path.with_name(f"{path.name}.tsv"), text)
