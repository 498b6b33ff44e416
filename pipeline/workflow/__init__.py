"""What the Snakefile leans on: the plan of a run, its fingerprints, its progress."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..faults import Fault, printable
from .lock import forget_stale, hold, sweep
from .lost import forget_lost, lost
from .plan import Plan, make_plan
from .progress import Progress, follow
from .settings import check_settings

__all__ = ["Plan", "Progress", "begin", "follow", "shell_prefix", "without_rate_limit"]


def begin(workflow: Any, config: Mapping[str, Any], schema: Path) -> Plan:
    """Plan of the run that Snakemake is about to make; ends it with a plain message on a fault.

    A run proper holds its results folder, takes away the locks and half-written files that a
    killed run left, and forgets trials whose results were taken away, so that they run again.
    """
    proper = workflow.is_main_process and not workflow.output_settings.dryrun
    try:
        plan = make_plan(check_settings(config, schema))
        plan = replace(plan, lock=hold(plan.results)) if proper else plan
    except Fault as fault:
        sys.stderr.write(printable(str(fault)) + "\n")
        sys.exit(1)
    if proper:
        forget_stale(Path(".snakemake") / "locks", plan.results)
        sweep(plan.results)
        forget_lost(plan)
    elif workflow.output_settings.dryrun and (again := lost(plan)):
        names = ", ".join(sorted({path.stem for path in again}))
        sys.stderr.write(
            f"Beside what follows, results of {names} that were taken away or cut short are made "
            "anew, and all that depends on them.\n"
        )
    return plan


def shell_prefix(workflow: Any) -> str:
    """Shell text before each command, so that it finds this very interpreter and package.

    Without activating its environment, `snakemake` would run whatever `python3` is on the PATH.
    """
    if workflow.deployment_settings.deployment_method:
        return f"export PYTHONPATH={shlex.quote(str(Path(workflow.basedir)))}; "
    return f'export PATH={shlex.quote(str(Path(sys.executable).parent))}:"$PATH"; '


def without_rate_limit(workflow: Any) -> None:
    """Takes the limit of jobs a second off a run on this machine, where it limits nothing.

    While jobs wait, each look for the next one sets a timer for another look, and so does each job
    that ends: with hundreds of short jobs Snakemake looked hundreds of times a second (9.27).
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
