"""Deny a process the right to read the folder of the truths, irrevocably.

Linux' Landlock (kernel 5.13 and later) lets a process give up rights for itself and its children.
Rights are granted by folder: everything is granted that exists now, except the denied folder and
the folders above it. A folder made later in one of these cannot be read either. On other systems
an audit hook of the interpreter refuses; it covers only files that Python opens.
"""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from pathlib import Path

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
READ_FILE, READ_DIR = 1 << 2, 1 << 3
RULE_PATH_BENEATH = 1
PR_SET_NO_NEW_PRIVS = 38
O_PATH = getattr(os, "O_PATH", 0)
AUDITED_EVENTS = ("open", "os.listdir", "os.scandir")


def deny_reading(sealed: Path) -> str:
    """`kernel` or `interpreter`: what denies this process, from now on, reading `sealed`."""
    sealed = sealed.resolve()
    if sys.platform == "linux" and _landlock(sealed):
        return "kernel"
    _deny_in_interpreter(sealed)
    return "interpreter"


def readable_paths(sealed: Path) -> list[Path]:
    """Everything that may be read: on each level from the root down, all but the way to it.

    Links are left out: one of them may lead to the way.  What they lead to has rights of its own.
    """
    allowed: list[Path] = []
    above = Path(sealed.anchor)
    for part in sealed.relative_to(above).parts:
        try:
            entries = [
                Path(e.path) for e in os.scandir(above) if e.name != part and not e.is_symlink()
            ]
        except PermissionError:
            entries = []
        allowed += entries
        above = above / part
    return allowed


def _landlock(sealed: Path) -> bool:
    libc = ctypes.CDLL(None, use_errno=True)
    rights = READ_FILE | READ_DIR
    attr = struct.pack("Q", rights)
    ruleset = libc.syscall(CREATE_RULESET, attr, ctypes.c_size_t(len(attr)), 0)
    if ruleset < 0:
        return False
    try:
        for path in readable_paths(sealed):
            _allow_reading(libc, ruleset, path, rights)
        libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
        return bool(libc.syscall(RESTRICT_SELF, ruleset, 0) == 0)
    finally:
        os.close(ruleset)


def _allow_reading(libc: ctypes.CDLL, ruleset: int, path: Path, rights: int) -> None:
    """Let a file or folder be read; what vanished meanwhile is passed over."""
    try:
        handle = os.open(path, O_PATH | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return
    try:
        granted = rights if path.is_dir() else READ_FILE
        rule = struct.pack("=Qi", granted, handle)
        libc.syscall(ADD_RULE, ruleset, RULE_PATH_BENEATH, rule, 0)
    finally:
        os.close(handle)


def _deny_in_interpreter(sealed: Path) -> None:
    banned = str(sealed)

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        if (
            event in AUDITED_EVENTS
            and arguments
            and isinstance(arguments[0], str | bytes | os.PathLike)
        ):
            path = os.path.realpath(os.fsdecode(arguments[0]))
            if path == banned or path.startswith(banned + os.sep):
                raise PermissionError(f"{path} is sealed")

    sys.addaudithook(hook)
