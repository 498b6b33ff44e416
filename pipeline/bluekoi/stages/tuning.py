"""Coefficients, Tables I and II, and the model's path for every trial."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..campaign import Campaign, load_campaign
from ..data import FlappingFrequency, write_columns
from ..errors import input_error
from ..files import write_json
from ..fitting import TrialSeries
from ..study import load_study
from ..tuning import (
    coefficients_json_and_fit,
    simulation_columns_by_trial,
    study_series,
    table_1_coefficients,
    table_2_radius_errors,
)
from .clock_factor import correct_clock
from .compiling import precompile_model as preload
from .result_paths import ResultPaths, remove_files
from .status import with_numerical_failures_explained
from .trial_exclusion import contradicted_trials

__all__ = ["campaign_flapping", "campaign_series", "preload", "tuning"]


@with_numerical_failures_explained
def tuning(study: Path, results: Path) -> None:
    """Write coefficients.json, table1.csv, table2.csv and simulations/ID.csv of all good trials."""
    layout = ResultPaths(results)
    campaign = load_campaign(results, load_study(study), measured=True)
    loaded = campaign.study
    campaign, flapping, factors = correct_clock(campaign, campaign_flapping(campaign))
    series = campaign_series(campaign, flapping)
    remove_files((results / "simulations").glob("*.csv"))
    found, joint = coefficients_json_and_fit(loaded, series, campaign.steady)
    found |= {"clock_factor": {name: f.value for name, f in factors.items()}} if factors else {}
    steps = found["paper_steps"]
    for name, columns in simulation_columns_by_trial(series, joint, steps).items():
        recorded = columns["time_s"] / (factors[name].value if name in factors else 1.0)
        write_columns(results / "simulations" / f"{name}.csv", columns | {"time_s": recorded})
    write_columns(results / "table1.csv", table_1_coefficients(steps))
    write_columns(results / "table2.csv", table_2_radius_errors(loaded, steps))
    write_json(layout.coefficients, found)


def campaign_series(
    campaign: Campaign, flapping: Mapping[str, FlappingFrequency] | None = None
) -> list[TrialSeries]:
    """Trials of a campaign as the fit takes them; flapping: `campaign_flapping` without it.

    Not a robot that never moved, nor `contradicted_trials`, nor the start of trials whose keypoints
    were smoothed: the smoothing spreads the start over its duration.

    Raises: InputError where no trial can be used.
    """
    moved = {i for i, row in campaign.steady.items() if row.quality != "no_data"}
    flapping = campaign_flapping(campaign) if flapping is None else flapping
    kept = moved - contradicted_trials(campaign, flapping).keys()
    tracks = {i: track for i, track in campaign.tracks.items() if i in kept}
    series = study_series(campaign.study, campaign.poses, tracks, flapping,
                          skipped_s=campaign.keypoint_smoothing_s)  # fmt: skip
    if not series:
        raise input_error(campaign.study.root, "", "no trial with a track", "one or more",
                    "See status/ in the results folder for what each trial lacks.")  # fmt: skip
    return series


def campaign_flapping(campaign: Campaign) -> dict[str, FlappingFrequency]:
    """Flapping frequency of each trial as its tracks stage found it."""
    found = {i: campaign.statuses[i].get("flapping") for i in campaign.tracks}
    return {
        i: FlappingFrequency(
            flap_hz=f["flap_hz"],
            flap_hz_std=f["flap_hz_std"] or 0.0,
            source=f["source"],
            video_hz=_none_to_nan(f["video_hz"]),
            video_hz_std=_none_to_nan(f["video_hz_std"]),
            ratio=_none_to_nan(f.get("ratio")),
            ratio_std=_none_to_nan(f.get("ratio_std")),
            beat_lag_rad=_none_to_nan(f.get("beat_lag_rad")),
            beat_lag_std_rad=_none_to_nan(f.get("beat_lag_std_rad")),
            start_s=_none_to_nan(f.get("start_s")),
            lost_time_s=_none_to_nan(f.get("lost_time_s")),
            drift_per_s=_none_to_nan(f.get("drift_per_s")),
            drift_std_per_s=_none_to_nan(f.get("drift_std_per_s")),
            agrees=bool(f["agrees"]),
        )
        for i, f in found.items()
        if f
    }


def _none_to_nan(value: float | None) -> float:
    return np.nan if value is None else float(value)
