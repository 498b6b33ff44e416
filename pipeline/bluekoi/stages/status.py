"""Runs a stage for one trial; its outcome is a status file, and a failure stops no other trial."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, input_error
from ..files import read_json, write_json
from ..keypoints import keypoint_source_module, keypoint_source_names
from ..motor.swimming_plausibility import clock_and_length_warnings
from .result_paths import remove_files

stage_logger = logging.getLogger(__name__)

MEMORY_ADVICE = "run fewer jobs at once (--cores 1) or close other programs, then start again"
DEFAULT_FIT_FAILURE_ADVICE = (
    "Check fps, head_angle_deg and the lengths of study.yaml, and add trials."
)
"""Advice where no warning on the study says more."""


def run_with_status(
    status: Path, trial_id: str, work: Callable[[], Mapping[str, Any]], *, source: str, products:
    Sequence[Path], stale: Sequence[Path] = (), inputs: str = "",
) -> None:  # fmt: skip
    """Write the status of a trial: what `work` returned, or why it could not be done.

    `products` are the files that the work writes, `stale` those of an earlier run that hang on
    them. On failure none of them is left, and the message names the trial's `source`. A defect of
    ours counts as a failure of this trial; its traceback goes to the log. `inputs`: hash of all
    that the results depend on (`freshness`).
    """
    remove_files(stale)
    try:
        found = {"trial_id": trial_id, "ok": True, "message": "", **work()}
    except InputError as error:
        text = str(error)
        found = _failed_status(trial_id, text if source in text else f"{source}: {text}")
        found["remedy"] = error.findings[-1].remedy
        stage_logger.warning("%s", error)
    except MemoryError:
        found = _failed_status(trial_id, f"{source}: not enough memory; {MEMORY_ADVICE}")
        stage_logger.exception("trial %s", trial_id)
    except Exception as error:  # one trial must not stop the others, whatever is wrong with it
        found = _failed_status(
            trial_id, f"a defect of this program, {error!r}; the log of the trial has more"
        )
        stage_logger.exception("trial %s", trial_id)
    if not found["ok"]:
        remove_files(products)
    sizes = {
        f"{path.parent.name}/{path.name}": path.stat().st_size for path in products if found["ok"]
    }
    write_json(status, {**found, "products": sizes, "inputs": inputs})


def _failed_status(trial_id: str, message: str) -> dict[str, Any]:
    return {"trial_id": trial_id, "ok": False, "message": message, "remarks": []}


def successful_trials(statuses: Sequence[Path]) -> list[str]:
    """Ids of the trials that went well, in the order of their status files."""
    found = [read_json(path) for path in statuses]
    return [str(status["trial_id"]) for status in found if status["ok"]]


def has_measured_lengths(detection: Path) -> bool:
    """Whether a trial's keypoints were seen one by one, not placed at stated lengths."""
    name = read_json(detection).get("source")
    return name not in keypoint_source_names() or not getattr(
        keypoint_source_module(name), "USES_STATED_LENGTHS", False
    )


def with_numerical_failures_explained(
    stage: Callable[[Path, Path], None],
) -> Callable[[Path, Path], None]:
    """The stage of a whole study, a fit without a solution turned into an InputError with advice:
    the warnings on its trials' clocks and lengths.
    """

    @wraps(stage)
    def explained(study: Path, results: Path) -> None:
        try:
            stage(study, results)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            stage_logger.debug("stage %s", stage.__name__, exc_info=True)
            found = {path.stem: read_json(path) for path in (results / "status").glob("*.json")}
            raise input_error(
                study / "trials.csv",
                "",
                f"a fit without a solution ({error})",
                "trials that the model can describe",
                " ".join(clock_and_length_warnings(found)) or DEFAULT_FIT_FAILURE_ADVICE,
            ) from error

    return explained
