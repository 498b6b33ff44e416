"""Start of a run: its plan, the lock of its results folder, the shell prefix of its jobs."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..errors import InputError, escape_control_characters
from ..stages.manifest import RUN_ENVIRONMENT_VARIABLE, record_file_sizes_and_times
from .forkserver_client import USER_COMMAND_VARIABLE
from .lock import acquire_lock, remove_stale_locks, remove_temporary_files
from .plan import RunPlan, make_plan
from .provenance import PACKAGE_FOLDER, source_fingerprint
from .settings import check_settings
from .stage_inputs import (
    outdated_stages,
    remove_outdated_results,
    remove_results_of_other_trials,
    stage_input_hashes,
)


def begin_run(workflow: Any, config: Mapping[str, Any], schema: Path) -> RunPlan:
    """Plan of the run that Snakemake is about to make; ends it with a message on an input error.

    A run holds its results folder, removes the locks and half-written files that a killed run left,
    and what was made from other inputs: markers of batches with such a trial, and results on the
    whole study. A dry run only lists these.
    """
    main, dry = workflow.is_main_process, workflow.output_settings.dryrun
    try:
        plan = make_plan(check_settings(config, schema))
        if not main:
            return replace(plan, dry_run=False)
        if not dry:
            plan = replace(plan, dry_run=False, lock=acquire_lock(plan.results))
    except InputError as error:
        sys.stderr.write(escape_control_characters(str(error)) + "\n")
        sys.exit(1)
    if dry:
        for stage, names in plan.due_trials_by_stage.items():
            if names:
                sys.stderr.write(f"{stage} is due for {len(names)}: {', '.join(sorted(names))}\n")
        if stages := outdated_stages(plan, stage_input_hashes(plan)):
            sys.stderr.write(f"Made from other inputs or by another version: {', '.join(stages)}\n")
        return plan
    command = os.environ.get(USER_COMMAND_VARIABLE) or shlex.join(sys.argv)
    run = {"command": command, "settings": dict(config), "code": source_fingerprint("stages")}
    os.environ[RUN_ENVIRONMENT_VARIABLE] = json.dumps(run)
    if not (plan.results / "manifest.json").is_file():
        (plan.results / "outcome.json").unlink(missing_ok=True)  # the stage that writes both
    remove_stale_locks(Path(".snakemake") / "locks", plan.results)
    remove_temporary_files(plan.results)
    record_file_sizes_and_times(plan.study, plan.results, made_by_run=plan.is_demo)
    plan.remove_due_marker_files()
    remove_outdated_results(plan)
    remove_results_of_other_trials(plan)
    return plan


def shell_prefix(workflow: Any) -> str:
    """Shell text before each command, so that it finds this very interpreter and package.

    Without activating its environment, `snakemake` would run whatever `python3` is on the PATH.
    """
    if workflow.deployment_settings.deployment_method:
        return f"export PYTHONPATH={shlex.quote(str(PACKAGE_FOLDER.parent))}; "
    return f'export PATH={shlex.quote(str(Path(sys.executable).parent))}:"$PATH"; '


def remove_job_rate_limit(workflow: Any) -> None:
    """Takes the limit of jobs a second off a run on this machine, where it limits nothing.

    While jobs wait, each look for the next one sets a timer for another look, and so does each job
    that ends: with hundreds of short jobs Snakemake looked hundreds of times a second (9.27).
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
