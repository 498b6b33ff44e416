"""Output files of commands: they never replace a file of the study."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

GROUND_TRUTH_FILES = ("truth.sha256", "truth.json")
"""Files of a synthetic study that no command overwrites."""


def refuse_outputs_over_study_files(study: Path, outputs: Iterable[Path | None]) -> None:
    """Raises: InputError where an output, or what it links to, is a file of the study."""
    from ..errors import input_error  # noqa: PLC0415
    from ..study import load_incomplete_study  # noqa: PLC0415

    written = [path for path in outputs if path is not None and path.exists()]
    if not written:
        return
    own = [*load_incomplete_study(study).files(), *(study / name for name in GROUND_TRUTH_FILES)]
    for path in written:
        if any(file.exists() and os.path.samefile(path, file) for file in own):
            expected, remedy = "another file to write to", "Nothing was written."
            raise input_error(path, "", "a file of the study", expected, remedy)
