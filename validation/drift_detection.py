"""How often a drifting trial is reported: of studies as they are, and with a drift put into one."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bluekoi.campaign import load_campaign
from bluekoi.fitting import TrialSeries
from bluekoi.mismatch.drift import add_drift, trial_with_camera_drift
from bluekoi.stages.tuning import campaign_flapping, campaign_series
from bluekoi.study import load_study
from bluekoi.tuning import compiled_trial_system, downsampled, fit_all_trials

DRIFT_SIZE_M = 0.085
"""Drift that is put in: 40 px of a usual picture."""


def drift_detections(study: Path, results: Path) -> tuple[bool, bool]:
    """Whether a trial is reported as the study is; whether the right one is where one drifts."""
    campaign = load_campaign(results, load_study(study), measured=True)
    series = downsampled(campaign_series(campaign, campaign_flapping(campaign)))
    rng = np.random.default_rng(zlib.crc32(study.name.encode()))
    chosen, towards = int(rng.integers(len(series))), rng.uniform(0.0, 2.0 * np.pi)
    size = DRIFT_SIZE_M * np.array([np.cos(towards), np.sin(towards)])
    moved = [add_drift(s, size) if k == chosen else s for k, s in enumerate(series)]
    return _reported_trial(series) != "", _reported_trial(moved) == series[chosen].name


def _reported_trial(series: Sequence[TrialSeries]) -> str:
    """Name of the trial that is reported, or no text."""
    kernel, model = compiled_trial_system(series), fit_all_trials(series)
    found = trial_with_camera_drift(
        kernel, series, model.parameter_vectors_by_trial(kernel, series), model.noise
    )
    return found.trial if found else ""


def detection_rate_report(rows: Sequence[tuple[bool, bool]]) -> str:
    """Rates over studies."""
    without, within = (sum(column) for column in zip(*rows, strict=True))
    return (
        f"reported without a drift: {without} of {len(rows)} studies\n"
        f"reported with {100 * DRIFT_SIZE_M:g} cm in one trial: {within} of {len(rows)}"
    )
