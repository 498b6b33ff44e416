"""A study and everything its run has written: what figures and report are made from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .data import Float, Pose, SteadyState, Track, read_columns, read_pose, read_track
from .files import read_json, read_json_if_present
from .steady import read_steady
from .study import Study, Trial
from .study.keypoint_depth import study_with_keypoint_depth

T = TypeVar("T")
JsonMapping = Mapping[str, Any]
MIN_SHARE_OF_TRACK_SIMULATED = 0.8
"""Share of a track that a simulated path must cover to be judged."""
DIVERGED_ABOVE_ERROR_PCT = 1000.0
"""A larger error counts as a diverged model."""


@dataclass(frozen=True)
class Campaign:
    """A study (a series of trials, or campaign) with all results of its run.

    Mappings are by trial id. A trial that failed appears only in `statuses`.

    - coefficients: content of coefficients.json, empty before the fit of the coefficients;
    - mismatch, mismatch_detail: content of these json files, None before the search for causes;
    - simulations: columns of simulations/ID.csv and extended/ID.csv, paths that are simulated from
      the fitted initial state of each trial;
    - geometry: content of geometry.json, None before the geometry check;
    - keypoint_errors: errors of keypoint files that the rigid lengths show, None in studies of
      videos alone.
    """

    study: Study
    tracks: Mapping[str, Track] = field(default_factory=dict)
    poses: Mapping[str, Pose] = field(default_factory=dict)
    steady: Mapping[str, SteadyState] = field(default_factory=dict)
    coefficients: JsonMapping = field(default_factory=dict)
    mismatch: JsonMapping | None = None
    mismatch_detail: JsonMapping | None = None
    simulations: Mapping[str, Mapping[str, Float]] = field(default_factory=dict)
    statuses: Mapping[str, JsonMapping] = field(default_factory=dict)
    geometry: JsonMapping | None = None
    keypoint_errors: JsonMapping | None = None

    @property
    def analysed(self) -> tuple[Trial, ...]:
        """Trials with a track and a steady state, in the order of trials.csv."""
        both = self.tracks.keys() & self.steady.keys()
        return tuple(trial for trial in self.study.trials if trial.trial_id in both)

    @property
    def left_out(self) -> tuple[tuple[Trial, str], ...]:
        """Trials without a track or a steady state, each with the reason."""
        done = {trial.trial_id for trial in self.analysed}
        return tuple(
            (trial, self.why_left_out(trial.trial_id))
            for trial in self.study.trials
            if trial.trial_id not in done
        )

    @property
    def keypoint_displacements(self) -> Sequence[JsonMapping]:
        """Displacements of keypoints in the pool that the tracks are corrected for: `trials` and
        `keypoints` of each part of the session.
        """
        found: Sequence[JsonMapping] = (self.keypoint_errors or {}).get("displacements") or []
        return found

    @property
    def keypoint_smoothing_s(self) -> float:
        """Duration over which the keypoints were smoothed before they were read, or 0."""
        found = (self.keypoint_errors or {}).get("smoothing")
        return float(found["duration_s"]) if found else 0.0

    @property
    def has_additions(self) -> bool:
        """Whether causes were added to the model; if not, there is no extended model."""
        causes = (self.mismatch or {}).get("causes") or []
        return any(cause.get("parameters") for cause in causes)

    def model_columns(self, trial_id: str) -> Mapping[str, Float]:
        """Columns of the simulated paths of a trial. Those of the extended model (`extended_...`)
        are included only if causes were added.
        """
        columns = self.simulations.get(trial_id, {})
        if self.has_additions:
            return columns
        return {name: c for name, c in columns.items() if not name.startswith("extended_")}

    def path_rmse_m(self, trial_id: str, prefix: str) -> float:
        """Root mean square distance of a simulated path to the track, at the track's times, m.

        prefix: `joint`, `paper` or `extended`. NaN where there is no such path, or where it ends
        early or is off by more than the pool is wide (a simulation that ran away).
        """
        track, columns = self.tracks[trial_id], self.simulations.get(trial_id, {})
        if f"{prefix}_x_m" not in columns:
            return float("nan")
        t, times = track.time_s, columns["time_s"]
        x, y = (
            np.interp(t, times, columns[f"{prefix}_{k}"], np.nan, np.nan) for k in ("x_m", "y_m")
        )
        square = (x - track.x_m) ** 2 + (y - track.y_m) ** 2
        known = np.isfinite(square)
        enough = known.mean() > MIN_SHARE_OF_TRACK_SIMULATED
        found = float(np.sqrt(square[known].mean())) if enough else float("nan")
        return found if found < self.study.setup.pool.width_m else float("nan")

    @property
    def held_out_models(self) -> tuple[str, ...]:
        """Models with errors on held-out trials: the baseline, and the extended model if causes
        were added.
        """
        return ("baseline", "extended") if self.has_additions else ("baseline",)

    def held_out_error(self, model: str, key: str) -> float:
        """Error on held-out trials, from mismatch.json; NaN if it is not stated.

        model: `baseline` or `extended`; key as in mismatch.json. Infinite where the model ran
        away: a path off by more than the pool is wide, a radius or speed by more than tenfold.
        """
        errors = ((self.mismatch or {}).get("held_out") or {}).get(model) or {}
        value = float("nan") if errors.get(key) is None else float(errors[key])
        most = self.study.setup.pool.width_m if key.endswith("_m") else DIVERGED_ABOVE_ERROR_PCT
        return float("inf") if value > most else value

    def why_left_out(self, trial_id: str) -> str:
        """Message of a trial's status, or that it was never run."""
        status = self.statuses.get(trial_id)
        return str(status.get("message") or "no reason given") if status else "not run yet"


def load_campaign(
    folder: str | Path, study: Study, *, trial_ids: Iterable[str] | None = None,
    measured: bool = False,
) -> Campaign:  # fmt: skip
    """What stands in a results folder for a study; files that are not there yet are left out.

    trial_ids: read only the files of these trials. measured: read only the files of the measurement
    (tracks, poses, steady state, geometry), not those of the fits, which another process may be
    writing.

    `campaign.study` differs from `study` in one value: `keypoint_depth_m` is the depth with which
    the tracks were computed, which may be an estimate.

    Raises: InputError where a file is there and cannot be read.

        >>> campaign = load_campaign("results/lab", load_study("lab"))
        >>> sorted(campaign.tracks)
        ['T09']
    """
    root = Path(folder)
    ids = [t.trial_id for t in study.trials] if trial_ids is None else list(trial_ids)
    table = root / "steady.csv"
    steady = read_steady(table) if table.is_file() else {}
    geometry = read_json_if_present(root / "geometry.json")
    found = Campaign(
        study=study_with_keypoint_depth(study, geometry),
        tracks=_read_files_by_trial(root / "tracks", ids, ".csv", read_track),
        poses=_read_files_by_trial(root / "poses", ids, ".csv", read_pose),
        steady={name: steady[name] for name in ids if name in steady},
        statuses=_read_files_by_trial(root / "status", ids, ".json", read_json),
        geometry=geometry,
        keypoint_errors=read_json_if_present(root / "status" / "stages" / "keypoint_errors.json"),
    )
    if measured:
        return found
    return replace(
        found,
        coefficients=read_json_if_present(root / "coefficients.json") or {},
        mismatch=read_json_if_present(root / "mismatch.json"),
        mismatch_detail=read_json_if_present(root / "mismatch_detail.json"),
        simulations=_read_simulated_paths(root, ids),
    )


def _read_files_by_trial(
    folder: Path, ids: Iterable[str], suffix: str, read: Callable[[Path], T]
) -> dict[str, T]:
    paths = {name: folder / f"{name}{suffix}" for name in ids}
    return {name: read(path) for name, path in paths.items() if path.is_file()}


def _read_simulated_paths(root: Path, ids: Sequence[str]) -> dict[str, dict[str, Float]]:
    """Trial -> columns of its model paths, those of the search beside those of the tuning."""
    tuned, extended = (_read_files_by_trial(root / folder, ids, ".csv", _read_simulation)
                       for folder in ("simulations", "extended"))  # fmt: skip
    return {name: tuned.get(name, {}) | extended.get(name, {}) for name in {**tuned, **extended}}


def _read_simulation(path: Path) -> dict[str, Float]:
    return read_columns(path, ("time_s",))
