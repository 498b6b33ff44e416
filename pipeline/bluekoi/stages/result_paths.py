"""Paths of all results in the results folder."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

COPY_TIME_TOLERANCE_S = 2.0
"""Files of one folder that is copied get dates that lie so close together, in any order."""


@dataclass(frozen=True)
class ResultPaths:
    """Paths below one results folder; `{}` of a trial is its trial_id."""

    root: Path

    def detection_status(self, trial_id: str) -> Path:
        """How the detection of a trial went."""
        return self.root / "status" / "keypoints" / f"{trial_id}.json"

    def status(self, trial_id: str) -> Path:
        """How a trial went from its source to its steady state."""
        return self.root / "status" / f"{trial_id}.json"

    def keypoints(self, trial_id: str) -> Path:
        """Detections in DeepLabCut's layout; times and covariances in `.cov.csv` beside it."""
        return self.root / "keypoints" / f"{trial_id}.csv"

    def covariances(self, trial_id: str) -> Path:
        """Times and covariances of the detections."""
        return self.keypoints(trial_id).with_suffix(".cov.csv")

    def pose(self, trial_id: str) -> Path:
        """Measured pose, frame by frame."""
        return self.root / "poses" / f"{trial_id}.csv"

    def track(self, trial_id: str) -> Path:
        """Smoothed motion."""
        return self.root / "tracks" / f"{trial_id}.csv"

    def trial_steady(self, trial_id: str) -> Path:
        """The row of one trial in steady.csv."""
        return self.root / "steady" / f"{trial_id}.csv"

    def overlay(self, trial_id: str) -> Path:
        """Footage with what was found drawn on it."""
        return self.root / "overlays" / f"{trial_id}.mp4"

    def overlay_status(self, trial_id: str) -> Path:
        """How the overlay of a trial went."""
        return self.root / "status" / "overlays" / f"{trial_id}.json"

    def trial_files(self, trial_id: str) -> tuple[Path, ...]:
        """All files of one trial."""
        own = (self.detection_status, self.status, self.overlay, self.overlay_status)
        paths = (self.root / folder / f"{trial_id}.csv" for folder in ("simulations", "extended"))
        stages = (*self.detection_files(trial_id), *self.track_files(trial_id))
        return (*stages, *(path(trial_id) for path in own), *paths)

    @property
    def keypoint_errors(self) -> Path:
        """Errors of keypoint files that the rigid distances show."""
        return self.root / "status" / "stages" / "keypoint_errors.json"

    @property
    def geometry(self) -> Path:
        """What the rigid distances say about scale, lens, pose and depth."""
        return self.root / "geometry.json"

    @property
    def steady(self) -> Path:
        """A row a trial: speed, radius, flapping frequency."""
        return self.root / "steady.csv"

    @property
    def coefficients(self) -> Path:
        """The fits."""
        return self.root / "coefficients.json"

    @property
    def mismatch(self) -> Path:
        """The verdict, its causes and their numbers."""
        return self.root / "mismatch.json"

    @property
    def tuning_files(self) -> tuple[Path, ...]:
        """Files that the tuning stage writes for the whole study."""
        tables = (self.root / f"table{number}.csv" for number in (1, 2))
        return (self.coefficients, *tables)

    @property
    def mismatch_files(self) -> tuple[Path, ...]:
        """Files that the mismatch stage writes for the whole study."""
        return (self.mismatch, self.root / "mismatch_detail.json")

    @property
    def report(self) -> Path:
        """One page with all of it."""
        return self.root / "report.html"

    @property
    def outcome(self) -> Path:
        """What to check in a run in which no trial failed."""
        return self.root / "outcome.json"

    def report_is_current(self) -> bool:
        """Whether the page was made from the fits and the search that are there now."""
        made_from = (self.coefficients, self.mismatch)
        if not all(path.is_file() for path in (*made_from, self.report)):
            return False
        newest = max(path.stat().st_mtime for path in made_from)
        return self.report.stat().st_mtime > newest - COPY_TIME_TOLERANCE_S

    @property
    def end_of_run_results(self) -> tuple[Path, ...]:
        """What stands at the end of a run in which nothing but single trials went wrong."""
        return (self.steady, self.coefficients, self.report)

    def detection_files(self, trial_id: str) -> tuple[Path, ...]:
        """Files that the keypoints stage writes for one trial."""
        return (self.keypoints(trial_id), self.covariances(trial_id))

    def track_files(self, trial_id: str) -> tuple[Path, ...]:
        """Files that the tracks stage writes for one trial."""
        return (self.pose(trial_id), self.track(trial_id), self.trial_steady(trial_id))


def remove_files(paths: Iterable[Path]) -> None:
    """Take away files of an earlier run, where there are any."""
    for path in paths:
        path.unlink(missing_ok=True)
