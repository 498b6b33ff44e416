"""Client of the fork server: asks it to run a stage. Imports no large module."""

from __future__ import annotations

import os
import socket
from collections.abc import Sequence

FORKSERVER_SOCKET_VARIABLE = "BLUEKOI_PRELOADED"
"""Environment variable with the path of the socket that the preloaded process listens on."""
USER_COMMAND_VARIABLE = "BLUEKOI_COMMAND"
"""Environment variable with the command that a person gave."""
END_OF_REQUEST = b"\0\0"
EXIT_RUN_ENDED = 143
"""Exit code of a job whose run has ended (128 + SIGTERM): nobody waits for its results, and the
study may be another by now.
"""
BLAS_THREAD_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""How many threads linear algebra takes, one unless the environment says more: matrices are small
here, threads only wait for each other and take the cores from the work beside them. A process with
one thread can also be forked.
"""


def limit_blas_to_one_thread() -> None:
    """Ask for one thread of linear algebra where the environment does not say; before numpy."""
    for name in BLAS_THREAD_VARIABLES:
        os.environ.setdefault(name, "1")


def request_stage(words: Sequence[str]) -> int | None:
    """Exit code of a stage that a fork of the preloaded process ran with our standard output.

    EXIT_RUN_ENDED where the run that this job belongs to has ended or been killed; it removes its
    socket. None where the preloaded process does not answer (a cluster's node, or it alone was
    killed): the caller then runs the stage itself.
    """
    address = os.environ.get(FORKSERVER_SOCKET_VARIABLE)
    if not address:
        return None
    with socket.socket(socket.AF_UNIX) as connection:
        try:
            connection.connect(address)
            request = (
                b"\0".join(os.fsencode(word) for word in (os.getcwd(), *words)) + END_OF_REQUEST
            )
            socket.send_fds(connection, [request], [1, 2])
            answer = connection.recv(16)
        except FileNotFoundError:
            return EXIT_RUN_ENDED
        except OSError:
            return None
    return int(answer) if answer else None
