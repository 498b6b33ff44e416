"""What a study is: pool, water, robot, camera, trials; frozen, checked on construction."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    field_validator,
    model_validator,
)

from ..faults import fault, nearest
from .rules import camera_problems, refuse, robot_problems, setup_problems, trial_problems


def _plain_number(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("a number, not true or false")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("a finite number")
    return value


Plain = BeforeValidator(_plain_number)
Positive = Annotated[float, Plain, Field(gt=0, allow_inf_nan=False)]
Number = Annotated[float, Plain, Field(allow_inf_nan=False)]
Pixel = tuple[Number, Number]
Row3 = tuple[Number, Number, Number]
VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".m4v", ".360", ".mts")
KEYPOINT_SUFFIXES = (".csv", ".h5", ".hdf5")


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Pool(_Section):
    """Inner size of the pool along x and y and the water's depth, m."""

    length_m: Positive = 2.6
    width_m: Positive = 1.6
    depth_m: Positive = 0.3


class Water(_Section):
    """Density in kg/m3 and refractive index against air."""

    density_kg_m3: Positive = 1000.0
    refractive_index: Annotated[float, Plain, Field(ge=1.0, le=2.0)] = 1.333


class Robot(_Section):
    """Geometry and inertia; lengths in m, mass in kg, yaw inertia in kg m2."""

    mass_kg: Positive
    yaw_inertia_kg_m2: Positive
    body_length_m: Positive
    head_length_m: Positive
    head_span_m: Positive
    hinge_to_com_m: Annotated[float, Plain, Field(ge=0, allow_inf_nan=False)]
    tail_length_m: Positive
    keypoint_depth_m: Annotated[float, Plain, Field(ge=0, allow_inf_nan=False)] = 0.04

    @model_validator(mode="after")
    def _fits(self) -> Robot:
        refuse(robot_problems(self))
        return self

    @property
    def depth_given(self) -> bool:
        """Whether study.yaml says how deep the keypoints lie."""
        return "keypoint_depth_m" in self.model_fields_set

    def aerodynamic_arm_m(self, head_length_m: float) -> float:
        """Aerodynamic arm l, m, for head length h.

        l = h + hinge_to_com - (body_length + h - head_length) / 4
        """
        body = self.body_length_m + head_length_m - self.head_length_m
        return head_length_m + self.hinge_to_com_m - body / 4

    def head_area_m2(self, head_length_m: float) -> float:
        """A = head length x span, m2."""
        return head_length_m * self.head_span_m

    @property
    def com_to_tail_base_m(self) -> float:
        """Distance from the centre of mass back to the caudal base on the core axis, m."""
        return self.body_length_m - self.head_length_m - self.hinge_to_com_m


class Camera(_Section):
    """One fixed overhead camera; without `matrix` the pool corners give a homography alone."""

    model: Literal["pinhole", "fisheye"] = "pinhole"
    image_size_px: tuple[Annotated[int, Field(gt=0)], Annotated[int, Field(gt=0)]] | None = None
    matrix: tuple[Row3, Row3, Row3] | None = None
    distortion: tuple[Number, ...] | None = None
    pool_corners_px: tuple[Pixel, Pixel, Pixel, Pixel]
    pool_corners_height_m: Number = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Camera:
        refuse(camera_problems(self))
        return self


class Detection(_Section):
    """How keypoints are found in footage."""

    source: str = "silhouette"
    marker_hues_deg: dict[str, Annotated[float, Field(ge=0, lt=360)]] = Field(default_factory=dict)


class Setup(_Section):
    """The whole of study.yaml."""

    pool: Pool = Pool()
    water: Water = Water()
    robot: Robot
    camera: Camera
    bodyparts: dict[str, str] = Field(default_factory=dict)
    detection: Detection = Detection()

    @model_validator(mode="after")
    def _fits(self) -> Setup:
        refuse(setup_problems(self))
        return self


class Trial(_Section):
    """One row of trials.csv; `head_angle_rad` is core minus head, counter-clockwise positive."""

    trial_id: str
    source: str
    power_pct: Annotated[float, Field(ge=0, le=300, allow_inf_nan=False)]
    head_angle_deg: Annotated[float, Field(ge=-120, le=120, allow_inf_nan=False)]
    head_length_m: Annotated[float, Field(gt=0, le=10, allow_inf_nan=False)]
    fps: Annotated[float, Field(gt=0, le=10000, allow_inf_nan=False)] | None = None
    motor_log: str | None = None
    flap_hz: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] | None = None
    start_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    end_s: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    role: Literal["fit", "held_out"] | None = None

    @field_validator("trial_id")
    @classmethod
    def _plain(cls, name: str) -> str:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,100}", name):
            raise ValueError("letters, digits, _ and - only, 100 at most")
        return name

    @model_validator(mode="after")
    def _fits(self) -> Trial:
        refuse(trial_problems(self))
        return self

    @property
    def sources(self) -> tuple[str, ...]:
        """Files of this trial: one, or the chapters of one recording."""
        return tuple(part.strip() for part in self.source.split(";") if part.strip())

    @property
    def reads_keypoints(self) -> bool:
        """Whether the source is a keypoint file rather than footage."""
        return any(Path(name).suffix.lower() in KEYPOINT_SUFFIXES for name in self.sources)

    @property
    def head_angle_rad(self) -> float:
        """Commanded head angle phi, rad."""
        return math.radians(self.head_angle_deg)

    @property
    def condition(self) -> tuple[float, float, float]:
        """What repeats share: power, head angle, head length."""
        return (self.power_pct, self.head_angle_deg, self.head_length_m)


class Study(_Section):
    """A checked study folder."""

    root: Path
    setup: Setup
    trials: tuple[Trial, ...]

    def trial(self, trial_id: str) -> Trial:
        """The trial of that id; Fault with the nearest id where there is none."""
        for trial in self.trials:
            if trial.trial_id == trial_id:
                return trial
        ids = [trial.trial_id for trial in self.trials]
        raise fault(
            self.root / "trials.csv",
            "",
            f"no trial '{trial_id}'",
            "a known trial",
            nearest(trial_id, ids),
        )

    def paths(self, trial: Trial) -> tuple[Path, ...]:
        """Absolute paths of a trial's source files."""
        return tuple(self.root / name for name in trial.sources)

    def motor_path(self, trial: Trial) -> Path | None:
        """Absolute path of a trial's motor log, where it has one."""
        return self.root / trial.motor_log if trial.motor_log else None
