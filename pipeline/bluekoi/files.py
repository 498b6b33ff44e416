"""Files that are there whole or not at all."""

from __future__ import annotations

import csv
import errno
import json
import math
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .errors import input_error

MANIFEST_SECTIONS = ("settings", "versions", "study", "trials", "inputs")
"""Sections of a manifest.json; each is a json object, and each may be missing."""
MANIFEST_TABLES = ("trials", "inputs")
"""Sections whose entries are json objects too."""
MAX_TEXT_BYTES = 500_000_000
"""Largest text file that is read: a track of some days."""


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that replaces it only if the block ends without an error."""
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
    except OSError as error:
        raise _input_error_of_failed_write(target, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        os.chmod(temporary, 0o666 & ~_current_umask())
        os.replace(temporary, target)
    except OSError as error:
        raise _input_error_of_failed_write(target, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8, whole or not at all."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_rows(path: str | Path, rows: Iterable[Iterable[Any]]) -> None:
    """Write rows of cells as csv, whole or not at all."""
    with atomic_write(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(rows)


def write_json(path: str | Path, content: Mapping[str, Any]) -> None:
    """Write `content` as json (numpy scalars and arrays allowed, NaN as null)."""
    write_text(path, json.dumps(to_json_types(content), indent=2, allow_nan=False) + "\n")


def read_text(path: str | Path, most_bytes: int = MAX_TEXT_BYTES) -> str:
    """Text of a file in UTF-8, without a byte order mark.

    Raises: OSError or UnicodeDecodeError where it cannot be read; OSError also for what is not a
    regular file (a pipe or a device may have no end) and for more than `most_bytes`.
    """
    target = Path(path)
    state = target.stat()
    if not stat.S_ISREG(state.st_mode):
        kind = "a folder" if stat.S_ISDIR(state.st_mode) else "a pipe or a device"
        raise OSError(errno.EINVAL, f"{kind}, not a file")
    if state.st_size > most_bytes:
        raise OSError(errno.EFBIG, f"{state.st_size} bytes, more than {most_bytes}")
    return target.read_text(encoding="utf-8-sig")


def read_json(path: str | Path) -> dict[str, Any]:
    """Content of a json file.

    Raises: InputError where it is missing or is not a json object.
    """
    try:
        content = json.loads(read_text(path))
    except FileNotFoundError as error:
        raise input_error(path, "", "no such file", "a json object") from error
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise input_error(path, "", f"no readable json ({error})", "a json object") from error
    except RecursionError as error:
        raise input_error(path, "", "brackets nested too deeply", "a json object") from error
    if not isinstance(content, dict):
        raise input_error(path, "", type(content).__name__, "a json object")
    return content


def read_json_if_present(path: str | Path) -> dict[str, Any] | None:
    """As `read_json`; None where there is no such file."""
    return read_json(path) if Path(path).is_file() else None


def read_manifest(path: Path) -> dict[str, Any]:
    """Content of a manifest.json. A missing section is valid.

    Raises: InputError if a section, or an entry of a table, is not a json object.
    """
    content = read_json(path)
    sections = {name: content.get(name) or {} for name in MANIFEST_SECTIONS}
    rows = {f"{name}.{key}": row or {} for name in MANIFEST_TABLES
            if isinstance(sections[name], dict) for key, row in sections[name].items()}  # fmt: skip
    for key, value in (sections | rows).items():
        if not isinstance(value, dict):
            raise input_error(path, key, repr(value), "a json object",
                              "Run the study again: the run replaces this file.")  # fmt: skip
    return content


def to_json_types(value: Any) -> Any:
    """`value` with numpy types, tuples and paths turned into json's own; NaN and inf to None."""
    if isinstance(value, Mapping):
        return {str(key): to_json_types(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json_types(entry) for entry in value]
    if hasattr(value, "tolist"):
        return to_json_types(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def flatten_mapping(value: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Entries of a nested mapping as (`a.b.c`, value)."""
    if isinstance(value, Mapping) and value:
        for key, entry in value.items():
            yield from flatten_mapping(entry, f"{prefix}.{key}".lstrip("."))
    else:
        yield prefix, value


def _input_error_of_failed_write(path: Path, error: OSError) -> Exception:
    if isinstance(error, (IsADirectoryError, NotADirectoryError, FileExistsError)):
        found = "a folder" if path.is_dir() else "a file where a folder is needed"
        remedy = "Name another file, or choose another results folder."
        return input_error(path, "", found, "the name of a file in a folder", remedy)
    return input_error(
        path,
        "",
        f"'{error.strerror or error}' on writing",
        "a folder that can be written and a disk with room",
        "Free space or choose another results folder; nothing half-written was left.",
    )


def _current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


FORMAT_SIGNATURES = {
    b"PK\x03\x04": "a workbook (xlsx or ods) or another zip archive",
    b"\xd0\xcf\x11\xe0": "a workbook (xls)",
    b"\x89HDF\r\n\x1a\n": "an HDF5 file",
}
"""First bytes of files that are no text -> what they are."""


def binary_format(path: Path) -> str:
    """What a file is by its first bytes, whatever its name says; "" where it may be text."""
    if not path.is_file():
        return ""
    with path.open("rb") as content:
        head = content.read(8)
    return next((kind for first, kind in FORMAT_SIGNATURES.items() if head.startswith(first)), "")


def found_instead_of_file(path: Path, name: str) -> str:
    """What is at a path where no regular file is, with its name."""
    if path.is_dir():
        return f"a folder {name}"
    if path.exists():
        return f"a pipe or a device {name}, not a file"
    return f"a link {name} that leads nowhere" if path.is_symlink() else f"no file {name}"
