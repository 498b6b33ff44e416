"""Footage of one trial with keypoints, measured path and model paths drawn on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..campaign import load_campaign
from ..files import read_json
from ..report.overlay import write_trial_overlay
from ..study import Study, load_study
from .result_paths import ResultPaths
from .status import run_with_status


def overlay(
    study: Path, results: Path, trial_id: str, *, threads: int = 1, inputs: str = ""
) -> None:
    """Write overlays/ID.mp4 and how that went; none for a trial that was left out."""
    import cv2  # noqa: PLC0415

    cv2.setNumThreads(threads)
    loaded, layout = load_study(study, only=trial_id), ResultPaths(results)
    run_with_status(
        layout.overlay_status(trial_id),
        trial_id,
        lambda: _draw_overlay(loaded, layout, trial_id),
        source=loaded.trial(trial_id).source,
        products=(layout.overlay(trial_id),),
        inputs=inputs,
    )


def _draw_overlay(study: Study, layout: ResultPaths, trial_id: str) -> dict[str, Any]:
    found = read_json(layout.status(trial_id))
    if not found["ok"]:
        return found
    campaign = load_campaign(layout.root, study, trial_ids=[trial_id])
    count, first_s = write_trial_overlay(campaign, trial_id, layout.root, layout.overlay(trial_id))
    return {"frames_drawn": count, "first_frame_s": first_s}
