"""Starts and ends the process from which the stages of a run are forked."""

from __future__ import annotations

import atexit
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .forkserver_client import BLAS_THREAD_VARIABLES, FORKSERVER_SOCKET_VARIABLE
from .plan import RunPlan

DETECTOR_PRELOAD_ARGUMENT = "keypoints=compiling_detector"
FORKSERVER_COMMAND = (sys.executable, "-P", "-m", "bluekoi.workflow.forkserver")


class ForkServerProcess:
    """A process that stages are forked from; jobs find it by `FORKSERVER_SOCKET_VARIABLE`."""

    def __init__(self, stages: Sequence[str]) -> None:
        address = str(Path(tempfile.mkdtemp(prefix="bluekoi-")) / "socket")
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(address)
            listener.listen(128)
            self.process = subprocess.Popen(  # noqa: S603
                [*FORKSERVER_COMMAND, str(listener.fileno()), *stages],
                stdin=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C ends the jobs, and so their forks
                pass_fds=[listener.fileno()],
                env={**dict.fromkeys(BLAS_THREAD_VARIABLES, "1"), **os.environ},
            )
        os.environ[FORKSERVER_SOCKET_VARIABLE] = address
        atexit.register(self.close)

    def close(self) -> None:
        """End the process and its forks."""
        os.environ.pop(FORKSERVER_SOCKET_VARIABLE, None)
        if self.process.stdin:
            self.process.stdin.close()
        self.process.wait()


def start_fork_server(workflow: Any, plan: RunPlan) -> ForkServerProcess | None:
    """Process for the jobs that a workflow is about to run on this machine; None on a cluster."""
    here = workflow.local_exec and not workflow.deployment_settings.deployment_method
    if not here or sys.platform != "linux":
        return None
    due = {job.rule.name for job in workflow.dag.needrun_jobs()}
    stages = [rule.name for rule in workflow.rules if rule.name in due - {"all"}]
    if plan.detects_outlines:
        stages = [DETECTOR_PRELOAD_ARGUMENT if stage == "keypoints" else stage for stage in stages]
    return ForkServerProcess(stages)
