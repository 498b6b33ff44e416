"""Runs stages in forks of a process that has their modules loaded.

A run starts it once (`start_fork_server`); each job's own process asks for a fork
(`forkserver_client`) and waits for its exit code. The modules of a stage are imported, and its
compiled functions loaded, when it is first asked for, or earlier, while no job asks. A fork writes
to the standard output and works in the folder of the job that asked; it is killed when that job
ends, and at the end of the run.
"""

from __future__ import annotations

import gc
import hashlib
import os
import selectors
import shutil
import signal
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from .forkserver_client import END_OF_REQUEST, EXIT_RUN_ENDED
from .provenance import PACKAGE_FOLDER
from .stage_call import exit_fork_with_code_of, run_stage

MAX_REQUEST_BYTES = 2**20
COMPILING_MODULE_PREFIX = "bluekoi.stages.compiling"
"""Modules whose names begin so have functions that compile what is not compiled yet."""
COMPILING_MESSAGE = b"compiling (once on a machine, half a minute)\n"


@dataclass(frozen=True)
class ForkRequest:
    """A job that asks for a fork: its connection, its standard output, its folder, its words."""

    connection: socket.socket
    fds: Sequence[int]
    folder: str
    words: Sequence[str]


@dataclass
class ForkServer:
    """Listens for jobs until `lifeline`, the end of a pipe that the run holds, is closed.

    ahead: stages to load while no job asks. loaded_by: module of `stages` whose `preload` loads
    what a stage needs, where that is not the stage's own. loaders: of each loaded stage, the
    function that loads what it has compiled. compiling: forks that run such a function for the
    first time.
    """

    listener: socket.socket
    lifeline: int
    ahead: list[str]
    loaded_by: dict[str, str] = field(default_factory=dict)
    running: dict[int, ForkRequest] = field(default_factory=dict)
    held: list[ForkRequest] = field(default_factory=list)
    loaders: dict[str, Callable[[], None] | None] = field(default_factory=dict)
    compiling: dict[int, Callable[[], None]] = field(default_factory=dict)
    waiting: selectors.BaseSelector = field(default_factory=selectors.DefaultSelector)

    def serve(self) -> None:
        """Answer until the run is over; then kill what still runs."""
        wake_read, wake_write = os.pipe()
        os.set_blocking(wake_write, False)
        signal.set_wakeup_fd(wake_write)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        self.waiting.register(self.lifeline, selectors.EVENT_READ)
        self.waiting.register(self.listener, selectors.EVENT_READ)
        self.waiting.register(wake_read, selectors.EVENT_READ)
        while True:
            ready = {key.fileobj for key, _ in self.waiting.select(0 if self.ahead else None)}
            if self.lifeline in ready:
                break
            if not ready:
                self._preload_stage(self.ahead.pop(0))
            if wake_read in ready:
                os.read(wake_read, 512)
                self._reap()
            if self.listener in ready:
                self._accept_request()
            for connection in ready - {wake_read, self.listener}:
                self._kill_fork_of_closed_connection(connection)
        self._shut_down()

    def _shut_down(self) -> None:
        """Kill the forks and send the waiting jobs EXIT_RUN_ENDED, since a job without an answer
        would run its stage itself.
        """
        for pid in (*self.running, *self.compiling):
            os.kill(pid, signal.SIGKILL)
        shutil.rmtree(os.path.dirname(self.listener.getsockname()), ignore_errors=True)
        connections = [job.connection for job in (*self.running.values(), *self.held)]
        self.listener.setblocking(False)
        with suppress(BlockingIOError):
            while True:
                connections.append(self.listener.accept()[0])
        for connection in connections:
            with suppress(OSError):
                connection.sendall(str(EXIT_RUN_ENDED).encode())

    def _accept_request(self) -> None:
        connection, _ = self.listener.accept()
        request, fds, _, _ = socket.recv_fds(connection, MAX_REQUEST_BYTES, 2)
        while request and not request.endswith(END_OF_REQUEST):
            request += connection.recv(MAX_REQUEST_BYTES)
        folder, *words = (
            os.fsdecode(word) for word in request[: -len(END_OF_REQUEST)].split(b"\0")
        )
        self._preload_stage(words[0])
        job = ForkRequest(connection, fds, folder, words)
        if self.loaders[words[0]] in self.compiling.values():
            os.write(fds[-1], COMPILING_MESSAGE)
            self.held.append(job)
        else:
            self._fork_job(job)

    def _fork_job(self, job: ForkRequest) -> None:
        gc.freeze()
        if pid := os.fork():
            self.running[pid] = job
            self.waiting.register(job.connection, selectors.EVENT_READ)
            for fd in job.fds:
                os.close(fd)
        else:
            exit_fork_with_code_of(lambda: _run_stage_of_request(job))

    def _preload_stage(self, stage: str) -> None:
        """Import what a stage needs; a stage that cannot be imported says so when it is run.

        What is not compiled yet is compiled by a fork, so that other stages can run meanwhile.
        """
        if stage in self.loaders:
            return
        self.loaders[stage] = None
        with suppress(Exception):
            module = import_module(f"bluekoi.stages.{stage}")
            if stage in self.loaded_by:
                module = import_module(f"bluekoi.stages.{self.loaded_by[stage]}")
            self.loaders[stage] = getattr(module, "preload", None)
        if (load := self.loaders[stage]) and load not in self.compiling.values():
            if (
                not load.__module__.startswith(COMPILING_MODULE_PREFIX)
                or _compiled_marker_path(load).exists()
            ):
                _call_ignoring_errors(load)
            elif pid := os.fork():
                self.compiling[pid] = load
            else:
                exit_fork_with_code_of(lambda: _compile_once(load))
        gc.collect()

    def _reap(self) -> None:
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                pid, code = ended[0], os.waitstatus_to_exitcode(ended[1])
                if load := self.compiling.pop(pid, None):
                    if code == 0:
                        _call_ignoring_errors(load)
                    ready = [job for job in self.held if self.loaders[job.words[0]] is load]
                    self.held = [job for job in self.held if job not in ready]
                    for job in ready:
                        self._fork_job(job)
                elif pid in self.running:
                    job = self.running.pop(pid)
                    self.waiting.unregister(job.connection)
                    with suppress(OSError), job.connection as connection:
                        connection.sendall(str(code if code >= 0 else 128 - code).encode())

    def _kill_fork_of_closed_connection(self, connection: object) -> None:
        """Kill the fork of a job that has ended."""
        for pid, job in list(self.running.items()):
            if job.connection is connection:
                self.waiting.unregister(job.connection)
                job.connection.close()
                del self.running[pid]
                os.kill(pid, signal.SIGKILL)


def _run_stage_of_request(job: ForkRequest) -> int:
    for target, fd in enumerate(job.fds, 1):
        os.dup2(fd, target)
    os.chdir(job.folder)
    return run_stage(job.words)


def _compile_once(load: Callable[[], None]) -> int:
    load()
    _compiled_marker_path(load).touch()
    return 0


def _call_ignoring_errors(load: Callable[[], None]) -> None:
    with suppress(Exception):  # the stage that needs it says what is wrong
        load()


def _compiled_marker_path(load: Callable[[], None]) -> Path:
    """File that is there when the functions that `load` calls were compiled from these sources."""
    from ..integrate import kernel_folder  # noqa: PLC0415  heavy

    digest = hashlib.sha256(f"{load.__module__} {load.__name__} {version('numba')}".encode())
    for path in sorted(PACKAGE_FOLDER.rglob("*.py")):
        state = path.stat()
        digest.update(f"{path} {state.st_mtime_ns} {state.st_size}".encode())
    return kernel_folder() / f"compiled-{digest.hexdigest()[:16]}"


def main() -> None:
    """Serve on the socket whose number is the first word; further words: stages to load ahead,
    each alone or as STAGE=MODULE that loads what it needs.
    """
    named = [word.partition("=") for word in sys.argv[2:]]
    loaded_by = {stage: module for stage, _, module in named if module}
    with socket.socket(fileno=int(sys.argv[1])) as listener:
        ForkServer(listener, 0, [stage for stage, _, _ in named], loaded_by).serve()


if __name__ == "__main__":
    main()
