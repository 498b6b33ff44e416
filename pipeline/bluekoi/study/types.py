"""Trials and the study that they belong to; frozen, checked on construction."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from ..errors import did_you_mean, input_error
from .consistency_rules import raise_problems, trial_problems
from .image_files import expand_source, is_image_source
from .setup import PlainFloat, SettingsSection, StudySettings, described_field

VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".m4v", ".360", ".mts")
KEYPOINT_SUFFIXES = (".csv", ".h5", ".hdf5", ".slp")


class Trial(SettingsSection):
    """One row of trials.csv; `head_angle_rad` is core minus head, counter-clockwise positive."""

    trial_id: str = described_field("Name of the trial: unique; letters, digits, `_` and `-`.")
    source: str = described_field(
        "Video (chapters of one recording joined by `;`), pictures (a folder, or a pattern such as "
        "`T01/*.png` or `T01/%05d.png`), or keypoint file (.csv, .h5, .slp) in raw camera pixels. "
        "Paths are relative to the study folder, without `..`, or absolute; links are followed."
    )
    power_pct: Annotated[PlainFloat, Field(ge=0, le=300, allow_inf_nan=False)] = described_field(
        "Motor power, in percent of the full power of the motor controller. Trials with the same "
        "power, head angle and head length are one condition.",
        "%",
    )
    head_angle_deg: Annotated[PlainFloat, Field(ge=-120, le=120, allow_inf_nan=False)] = (
        described_field(
            "Commanded head angle: direction of the core minus direction of the head. It is "
            "positive if the head points to the right of the robot.",
            "deg",
        )
    )
    head_length_m: Annotated[PlainFloat, Field(gt=0, le=10, allow_inf_nan=False)] = described_field(
        "Nose to hinge in this trial.", "m"
    )
    fps: Annotated[PlainFloat, Field(ge=1, le=10000, allow_inf_nan=False)] | None = described_field(
        "Frame rate at which the scene was filmed: required for keypoint files and pictures; "
        "overrides the time stamps of a video. 30000/1001 is written 29.97003.",
        "frames/s",
        None,
    )
    motor_log: str | None = described_field(
        "Csv file `time_s,angle_deg` with the shaft angle, for example every 5 ms; time 0 is the "
        "first frame "
        "of the recording. One turn is one tail beat. Without it and `flap_hz`, the frequency is "
        "that of the tail in the video.",
        "",
        None,
    )
    flap_hz: Annotated[PlainFloat, Field(ge=0, le=100, allow_inf_nan=False)] | None = (
        described_field(
            "Flapping frequency, where there is no motor log; not counted in the same video, whose "
            "frame rate it checks. If the tail beats, at least 0.01 Hz.",
            "Hz",
            None,
        )
    )
    start_s: Annotated[PlainFloat, Field(ge=0, allow_inf_nan=False)] | None = described_field(
        "Start of the part of the recording to use.", "s", None
    )
    end_s: Annotated[PlainFloat, Field(gt=0, allow_inf_nan=False)] | None = described_field(
        "End of the part of the recording to use.", "s", None
    )
    role: Literal["fit", "held_out"] | None = described_field(
        "Whether the trial is used in the fit or held out to test it. If the cell is empty, "
        "BlueKoi holds out all trials of some conditions, at most a quarter of the trials.",
        "",
        None,
    )

    start_x_px: Annotated[PlainFloat, Field(ge=0, allow_inf_nan=False)] | None = described_field(
        "If several bodies are in the picture: pixel coordinate u of the intended one in the first "
        "frame used; together with start_y_px.",
        "px",
        None,
    )
    start_y_px: Annotated[PlainFloat, Field(ge=0, allow_inf_nan=False)] | None = described_field(
        "Pixel coordinate v of the intended body in the first frame used.", "px", None
    )

    @field_validator("trial_id")
    @classmethod
    def _check_id_characters(cls, name: str) -> str:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,100}", name):
            raise ValueError("letters, digits, _ and - only, 100 at most")
        return name

    @model_validator(mode="after")
    def _check_consistency(self) -> Trial:
        raise_problems(trial_problems(self))
        return self

    @property
    def sources(self) -> tuple[str, ...]:
        """Files of this trial: one, or the chapters of one recording."""
        return tuple(part.strip() for part in self.source.split(";") if part.strip())

    @property
    def reads_keypoints(self) -> bool:
        """Whether the source is a keypoint file rather than footage."""
        files = [name for name in self.sources if not name.endswith("/")]
        return any(Path(name).suffix.lower() in KEYPOINT_SUFFIXES for name in files)

    @property
    def reads_images(self) -> bool:
        """Whether the source is pictures in files: a folder of them or a pattern."""
        return not self.reads_keypoints and any(map(is_image_source, self.sources))

    @property
    def start_px(self) -> tuple[float, float] | None:
        """Where the intended body is in the first frame, px."""
        if self.start_x_px is None or self.start_y_px is None:
            return None
        return self.start_x_px, self.start_y_px

    @property
    def head_angle_rad(self) -> float:
        """Commanded head angle phi, rad."""
        return math.radians(self.head_angle_deg)

    @property
    def condition(self) -> tuple[float, float, float]:
        """What repeats share: power, head angle, head length."""
        return (self.power_pct, self.head_angle_deg, self.head_length_m)


class Study(SettingsSection):
    """A checked study folder."""

    root: Path
    setup: StudySettings
    trials: tuple[Trial, ...]

    def trial(self, trial_id: str) -> Trial:
        """The trial of that id; InputError with the nearest id if there is no such trial."""
        for trial in self.trials:
            if trial.trial_id == trial_id:
                return trial
        ids = [trial.trial_id for trial in self.trials]
        raise input_error(
            self.root / "trials.csv",
            "",
            f"no trial '{trial_id}'",
            "a known trial",
            did_you_mean(trial_id, ids),
        )

    def paths(self, trial: Trial) -> tuple[Path, ...]:
        """Absolute paths of a trial's source files; of pictures, each of them in order."""
        return tuple(path for name in trial.sources for path in expand_source(self.root, name))

    def motor_path(self, trial: Trial) -> Path | None:
        """Absolute path of a trial's motor log, where it has one."""
        return self.root / trial.motor_log if trial.motor_log else None

    def files(self) -> list[Path]:
        """Every file that the study consists of: study.yaml, trials.csv, sources, motor logs."""
        own = [self.root / "study.yaml", self.root / "trials.csv"]
        own += [path for trial in self.trials for path in self.paths(trial)]
        own += [log for trial in self.trials if (log := self.motor_path(trial))]
        return list(dict.fromkeys(own))
