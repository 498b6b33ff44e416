"""Pool edges in the first frame of a trial's recording, against the corners of study.yaml."""

from __future__ import annotations

import logging
from dataclasses import asdict
from typing import Any

from ..camera.pool_edge_check import compare_pool_edges
from ..errors import InputError
from ..study import Study, Trial

stage_logger = logging.getLogger(__name__)


def check_pool_edges(study: Study, trial: Trial) -> tuple[dict[str, Any] | None, tuple[str, ...]]:
    """What goes into status/ID.json, and a warning where the camera was moved or turned.

    None for trials without footage.
    """
    if trial.reads_keypoints:
        return None, ()
    from ..footage import frames, open_recording  # noqa: PLC0415  only where there is footage

    try:
        recording = open_recording(study.paths(trial), fps=trial.fps, start_s=trial.start_s)
        first = next(iter(frames(recording)), None)
    except InputError as error:  # the recording went after its keypoints were detected
        stage_logger.warning("pool edges not checked: %s", error)
        return None, ()
    if first is None:
        return None, ()
    found = compare_pool_edges(first.luma, study.setup)
    shows = f"bluekoi pool {study.root} --trial {trial.trial_id}"
    remarks = tuple(f"{remark} (`{shows}` shows them)" for remark in found.remarks)
    return asdict(found), remarks
