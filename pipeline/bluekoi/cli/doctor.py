"""`bluekoi doctor`: whether this machine has what a run needs."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import click

from ..errors import InputError

MIN_FREE_GB = 2.0
"""Free space of the disk, GB, below which `bluekoi doctor` complains."""
OPTIONAL_PACKAGES = {
    "snakemake-executor-plugin-slurm": (
        "runs on a Slurm cluster",
        "pip install snakemake-executor-plugin-slurm",
    )
}
"""What a run can do without: what it is for, and how to get it."""
MachineCheckResult = tuple[bool, str]


@click.command()
@click.pass_context
def doctor(ctx: click.Context) -> None:
    """Check whether this machine has what a run needs, and say how to install what is missing."""
    sound = True
    for check in (
        _check_python,
        _check_packages,
        _check_shell,
        _check_codec,
        _check_compilation,
        _check_disk_space,
        _check_memory,
        _check_optional_packages,
    ):
        for good, text in check():
            click.echo(f"{'ok  ' if good else 'FAIL'} {text}")
            sound = sound and good
    ctx.exit(0 if sound else 1)


def _check_python() -> Iterator[MachineCheckResult]:
    found = ".".join(map(str, sys.version_info[:3]))
    yield sys.version_info >= (3, 11), f"Python {found} (3.11 or newer)"


def _check_packages() -> Iterator[MachineCheckResult]:
    from packaging.requirements import Requirement  # noqa: PLC0415

    for text in requires("bluekoi") or []:
        wanted = Requirement(text)
        if wanted.marker and not wanted.marker.evaluate({"extra": ""}):
            continue
        try:
            found = version(wanted.name)
        except PackageNotFoundError:
            yield False, f"{wanted.name} is missing: pip install '{wanted}'"
            continue
        good = wanted.specifier.contains(found, prereleases=True)
        yield good, f"{wanted.name} {found}" + ("" if good else f": pip install '{wanted}'")


def _check_shell() -> Iterator[MachineCheckResult]:
    found = shutil.which("bash")
    yield found is not None, f"bash {'at ' + found if found else 'is missing: install it'}"


def _check_codec() -> Iterator[MachineCheckResult]:
    yield from (
        _run_machine_check("reading and writing H.264", _check_h264_codecs),
        _run_machine_check("OpenCV", _check_opencv),
    )


def _run_machine_check(what: str, work: Callable[[], str]) -> MachineCheckResult:
    try:
        return True, f"{what}: {work()}"
    except InputError as found:
        return False, f"{what}: {found}"
    except OSError as error:
        return False, f"{what}: {error}; name another folder: BLUEKOI_CACHE=FOLDER"
    except Exception as error:  # whatever a broken installation raises is the finding
        return False, f"{what}: {error}; reinstall with pip install --force-reinstall"


def _check_h264_codecs() -> str:
    av = import_module("av")
    av.codec.Codec("libx264", "w")
    av.codec.Codec("h264", "r")
    return f"PyAV {av.__version__}"


def _check_opencv() -> str:
    cv2 = import_module("cv2")
    cv2.findHomography  # noqa: B018  gone where another package overwrote cv2
    return str(cv2.__version__)


def _check_compilation() -> Iterator[MachineCheckResult]:
    yield _run_machine_check(
        "compiling, and a folder to keep what is compiled", _check_compiled_code_folder
    )


def _check_compiled_code_folder() -> str:
    """Where compiled models are kept, after a function of ours was compiled and kept."""
    folder = import_module("bluekoi.integrate").kernel_folder()
    with tempfile.TemporaryFile(dir=folder):
        pass
    import_module("bluekoi.smoothing")  # numba refuses here where it finds no place for its cache
    return str(folder)


def _check_optional_packages() -> Iterator[MachineCheckResult]:
    for name, (purpose, remedy) in OPTIONAL_PACKAGES.items():
        try:
            yield True, f"{name} {version(name)}, for {purpose}"
        except PackageNotFoundError:
            yield True, f"without {name}: no {purpose}; {remedy}"


def _check_disk_space() -> Iterator[MachineCheckResult]:
    for name, folder in (("here", Path.cwd()), ("temporary files", Path(tempfile.gettempdir()))):
        free = shutil.disk_usage(folder).free / 1e9
        writable = os.access(folder, os.W_OK)
        text = f"{free:.1f} GB free for {name} ({MIN_FREE_GB:g} GB or more)"
        yield free >= MIN_FREE_GB and writable, text + ("" if writable else "; not writable")


def _check_memory() -> Iterator[MachineCheckResult]:
    try:
        total = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    except (ValueError, OSError):
        return
    yield total >= MIN_FREE_GB, f"{total:.1f} GB of memory ({MIN_FREE_GB:g} GB or more)"
