"""study.yaml: pool, water, robot, camera, detection; frozen, checked on construction."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from ..data import Float
from .consistency_rules import camera_problems, raise_problems, robot_problems, setup_problems


def _reject_bool_underscore_and_nonfinite(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("a number, not true or false")
    if isinstance(value, str) and "_" in value:
        raise ValueError("a number without underscores")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("a finite number")
    return value


PlainNumberCheck = BeforeValidator(_reject_bool_underscore_and_nonfinite)
PlainFloat = Annotated[float, PlainNumberCheck]
MAX_SETTING_MAGNITUDE = 1e7
"""No length, mass, focal length or pixel of a study in SI units is larger; a slip of the pen is."""
PositiveNumber = Annotated[
    float, PlainNumberCheck, Field(gt=0, le=MAX_SETTING_MAGNITUDE, allow_inf_nan=False)
]
BoundedNumber = Annotated[
    float,
    PlainNumberCheck,
    Field(ge=-MAX_SETTING_MAGNITUDE, le=MAX_SETTING_MAGNITUDE, allow_inf_nan=False),
]
Pixel = tuple[BoundedNumber, BoundedNumber]
MatrixRow = tuple[BoundedNumber, BoundedNumber, BoundedNumber]
ImageSize = tuple[Annotated[int, Field(gt=0)], Annotated[int, Field(gt=0)]]


def described_field(meaning: str, unit: str = "", default: Any = ..., **limits: Any) -> Any:
    """A field with its meaning and unit, from which `check --explain` and the docs are made."""
    extra: JsonDict = {"unit": unit}
    if callable(default):
        return Field(default_factory=default, description=meaning, json_schema_extra=extra)
    return Field(default, description=meaning, json_schema_extra=extra, **limits)


class SettingsSection(BaseModel):
    """Keys that stand together; immutable, and a key that is not listed is refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Pool(SettingsSection):
    """The pool: inner size and water depth."""

    length_m: PositiveNumber = described_field(
        "Inner length, along the x axis of the pool frame.", "m", 2.6
    )
    width_m: PositiveNumber = described_field(
        "Inner width, along the y axis of the pool frame.", "m", 1.6
    )
    depth_m: PositiveNumber = described_field("Depth of the water.", "m", 0.3)


class Water(SettingsSection):
    """The water."""

    density_kg_m3: PlainFloat = described_field(
        "Density of the water: 998 fresh, 1025 sea. Coefficients of forces are inversely "
        "proportional to it, and no recording can check it.",
        "kg/m3",
        1000.0,
        ge=500.0,
        le=2000.0,
    )
    refractive_index: PlainFloat = described_field(
        "Refractive index of the water against air; 1 switches the correction off.",
        "1",
        1.333,
        ge=1.0,
        le=2.0,
    )


class Robot(SettingsSection):
    """Lengths, mass and yaw inertia of the robot. The 1x head is the head that others are scaled
    from.
    """

    mass_kg: PositiveNumber = described_field(
        "Mass of the robot as it swims, with the water in its hull, without added mass. All "
        "coefficients are proportional to it, and no recording can check it.",
        "kg",
    )
    yaw_inertia_kg_m2: PositiveNumber = described_field(
        "Moment of inertia about the vertical axis through the centre of mass, without added mass. "
        "Yaw coefficients are proportional to it.",
        "kg m2",
    )
    body_length_m: PositiveNumber = described_field(
        "Nose to caudal base (root of the tail), with the standard (1x) head.", "m"
    )
    head_length_m: PositiveNumber = described_field(
        "Length of the standard (1x) head: nose to hinge.", "m"
    )
    head_span_m: PositiveNumber = described_field(
        "Vertical extent of the head plate; head area = head length x span. Coefficients of forces "
        "are inversely proportional to it, and no recording can check it.",
        "m",
    )
    hinge_to_com_m: PlainFloat = described_field(
        "Distance of the centre of mass behind the hinge, on the core axis.",
        "m",
        ge=0,
        allow_inf_nan=False,
    )
    tail_length_m: PositiveNumber = described_field(
        "Caudal base (root of the tail) to tail tip.", "m"
    )
    keypoint_depth_m: PlainFloat = described_field(
        "Depth of the keypoints below the still water surface. Without this key, the depth is "
        "estimated from distances between keypoints on one rigid part, which must be the same "
        "everywhere in the pool. The default is used if the standard deviation of the estimate is "
        "above 10 mm.",
        "m",
        0.04,
        ge=0,
        allow_inf_nan=False,
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Robot:
        raise_problems(robot_problems(self))
        return self

    @property
    def keypoint_depth_given(self) -> bool:
        """Whether study.yaml says how deep the keypoints lie."""
        return "keypoint_depth_m" in self.model_fields_set

    def whole_length_m(self, head_length_m: float) -> float:
        """Nose to tail tip along the straight body, with a head of this length."""
        return self.body_length_m + head_length_m - self.head_length_m + self.tail_length_m

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

    def body_points(
        self, head_length_m: float, centre_m: Float, heading_rad: Any, head_angle_rad: Any
    ) -> Float:
        """Nose, hinge, centre of mass and caudal base (..., 4, 2), m, of centres (..., 2)."""
        angles = (heading_rad, heading_rad - head_angle_rad)
        core, head = (np.stack([np.cos(a), np.sin(a)], axis=-1) for a in angles)
        hinge = centre_m + self.hinge_to_com_m * core
        base = centre_m - self.com_to_tail_base_m * core
        return np.stack([hinge + head_length_m * head, hinge, centre_m, base], axis=-2)


class Camera(SettingsSection):
    """One fixed overhead camera.

    Without `matrix` the pool corners give a homography: no correction of lens or refraction.
    """

    model: Literal["pinhole", "fisheye"] = described_field(
        "Lens model, as OpenCV defines it.", "", "pinhole"
    )
    image_size_px: ImageSize | None = described_field(
        "Width and height of the calibration images; required with `matrix`.", "px", None
    )
    matrix: tuple[MatrixRow, MatrixRow, MatrixRow] | None = described_field(
        "Camera matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], from `bluekoi calibrate`.", "px", None
    )
    distortion: tuple[BoundedNumber, ...] | None = described_field(
        "Distortion coefficients in OpenCV's order: pinhole k1, k2, p1, p2, k3 (4, 5, 8, 12 or 14 "
        "numbers); fisheye k1 to k4.",
        "1",
        None,
    )
    pool_corners_px: tuple[Pixel, Pixel, Pixel, Pixel] = described_field(
        "Pixels [u, v] of the pool's inner corners (0, 0), (length, 0), (length, width), "
        "(0, width) in the raw frame, as `bluekoi pool` finds them.",
        "px",
    )
    pool_corners_height_m: BoundedNumber = described_field(
        "Height of the corner marks above the water surface.", "m", 0.0
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Camera:
        raise_problems(camera_problems(self))
        return self


class DetectionSettings(SettingsSection):
    """How keypoints are found in footage."""

    source: str = described_field(
        "Detector: `silhouette` (outline of the body) or `markers` (coloured dots).",
        "",
        "silhouette",
    )
    body: Literal["auto", "rigid", "bending"] = described_field(
        "How the body moves: a rigid head and core (`rigid`), a bending midline as of a fish or a "
        "soft robot (`bending`), or what the footage shows (`auto`).",
        "",
        "auto",
    )
    marker_hues_deg: dict[str, Annotated[float, Field(ge=0, lt=360)]] = described_field(
        "For `markers`: hue of the dot on each body part, from 0 (red) over 120 (green) to 360, "
        "for "
        "example `{head_tip: 0, hinge: 60, core_center: 120, tail_base: 240}`.",
        "deg",
        dict,
    )


class StudySettings(SettingsSection):
    """The whole of study.yaml."""

    pool: Pool = described_field("Size of the pool.", "", Pool())
    water: Water = described_field("Properties of the water.", "", Water())
    robot: Robot = described_field("Dimensions and inertia of the robot.")
    camera: Camera = described_field("Lens and position of the camera.")
    bodyparts: dict[str, str] = described_field(
        "Names of the body parts in keypoint files. The names in BlueKoi are `head_tip`, `hinge`, "
        "`core_center`, `tail_base` and `tail_tip`; `head_tip: nose` means that the files call the "
        "first one `nose`. A part that is not listed has the same name in the files.",
        "",
        dict,
    )
    detection: DetectionSettings = described_field(
        "How keypoints are found in footage.", "", DetectionSettings()
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> StudySettings:
        raise_problems(setup_problems(self))
        return self
