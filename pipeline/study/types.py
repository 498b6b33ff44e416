"""What a study is: pool, water, robot, camera, trials; frozen, checked on construction."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from ..data import PARTS
from ..faults import fault, nearest
from .corners import corner_problems

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Number = Annotated[float, Field(allow_inf_nan=False)]
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
    refractive_index: Annotated[float, Field(ge=1.0, le=2.0)] = 1.333


class Robot(_Section):
    """Geometry and inertia; lengths in m, mass in kg, yaw inertia in kg m2."""

    mass_kg: Positive
    yaw_inertia_kg_m2: Positive
    body_length_m: Positive
    head_length_m: Positive
    head_span_m: Positive
    hinge_to_com_m: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    tail_length_m: Positive
    keypoint_depth_m: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.04

    @model_validator(mode="after")
    def _lengths_fit(self) -> Robot:
        if self.head_length_m + self.hinge_to_com_m >= self.body_length_m:
            raise ValueError(
                "head_length_m + hinge_to_com_m must be smaller than body_length_m, "
                f"found {self.head_length_m} + {self.hinge_to_com_m} and {self.body_length_m}"
            )
        return self

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
    def _consistent(self) -> Camera:
        problems = [*self._lens_problems(), *corner_problems(self.pool_corners_px)]
        if problems:
            raise ValueError("; ".join(problems))
        return self

    def _lens_problems(self) -> list[str]:
        if self.matrix is None:
            return ["distortion is given without a matrix"] if self.distortion else []
        problems = []
        fx, fy = self.matrix[0][0], self.matrix[1][1]
        if fx <= 0 or fy <= 0:
            problems.append(f"matrix: focal lengths must be positive, found {fx} and {fy}")
        if self.image_size_px is None:
            problems.append("image_size_px is needed with a matrix")
        allowed = (4,) if self.model == "fisheye" else (4, 5, 8, 12, 14)
        if self.distortion is not None and len(self.distortion) not in allowed:
            problems.append(
                f"distortion: a {self.model} lens has {' or '.join(map(str, allowed[:2]))} "
                f"coefficients, found {len(self.distortion)}"
            )
        return problems


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
    def _known_parts(self) -> Setup:
        unknown = [part for part in self.bodyparts if part not in PARTS]
        if unknown:
            hints = "; ".join(f"'{part}': {nearest(part, PARTS)}" for part in unknown)
            raise ValueError(f"bodyparts maps our part to the file's name; unknown {hints}")
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

    @model_validator(mode="after")
    def _consistent(self) -> Trial:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,100}", self.trial_id):
            raise ValueError(f"trial_id: letters, digits, _ and - only, found '{self.trial_id}'")
        if self.reads_keypoints and self.fps is None:
            raise ValueError("fps is required where the source is a keypoint file")
        if self.start_s is not None and self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s must come after start_s, found {self.start_s}, {self.end_s}")
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
