"""What must fit together in a study beyond the type of each value."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from pydantic_core import PydanticCustomError

from ..data import BODY_PART_NAMES
from ..errors import did_you_mean
from .pool_corner_order import corner_order_problems

if TYPE_CHECKING:
    from .setup import Camera, Robot, StudySettings
    from .types import Trial

INCONSISTENT_VALUES_ERROR_TYPE = "together"
UNITS_REMEDY = "Units are m, kg and kg m2."
BODY_WIDTH_TO_HEIGHT_RANGE = (0.2, 1.5)
"""Mean width over height of a swimming body: a disc-shaped fish 0.2, a box 1, a ray more."""
CORNER_MARGIN_SHARE_OF_IMAGE = 0.25
"""Pool corners may lie outside the image by this share of it, as marks laid out beyond its edge."""


@dataclass(frozen=True)
class SettingInconsistency:
    """A key (dotted, within its section) whose value does not fit the others."""

    key: str
    found: str
    expected: str
    remedy: str = ""


def raise_problems(problems: Iterable[SettingInconsistency]) -> None:
    """Nothing, or one validation error that carries all problems."""
    if found := tuple(problems):
        _raise_combined_error(found)


def _raise_combined_error(found: tuple[SettingInconsistency, ...]) -> NoReturn:
    raise PydanticCustomError(
        INCONSISTENT_VALUES_ERROR_TYPE, "values do not fit together", {"problems": found}
    )


def robot_problems(robot: Robot) -> list[SettingInconsistency]:
    """Lengths that do not add up to a robot."""
    ahead = robot.head_length_m + robot.hinge_to_com_m
    if ahead < robot.body_length_m:
        return []
    expected = f"head_length_m + hinge_to_com_m ({ahead:g}) smaller than body_length_m"
    remedies = [
        length_unit_remedy(key, getattr(robot, key), robot.body_length_m)
        for key in ("head_length_m", "hinge_to_com_m")
    ]
    remedy = " ".join(text for text in remedies if text)
    return [SettingInconsistency("body_length_m", f"{robot.body_length_m:g}", expected, remedy)]


def length_unit_remedy(key: str, value: float, body_m: float) -> str:
    """A question where a part is longer than the body and would fit in cm or mm; else nothing."""
    for unit, per_m in (("cm", 100.0), ("mm", 1000.0)):
        if value > 5.0 * body_m and value / per_m < body_m:
            return (
                f"Lengths are in m: is {key} in {unit}? {value:g} {unit} are {value / per_m:g} m."
            )
    return ""


def setup_problems(setup: StudySettings) -> list[SettingInconsistency]:
    """A robot that does not fit its pool, or is heavier than any: mostly other units than SI."""
    pool, robot = setup.pool, setup.robot
    length = robot.body_length_m
    cube = setup.water.density_kg_m3 * length * length * length  # infinite where `**` would raise
    limits = (
        ("body_length_m", pool.length_m, f"a robot shorter than the pool ({pool.length_m:g} m)"),
        ("head_span_m", length, f"a head less high than the robot is long ({length:g} m)"),
        ("keypoint_depth_m", pool.depth_m, f"a depth within the water ({pool.depth_m:g} m)"),
        ("mass_kg", cube, f"less than a cube of water of the robot's length ({cube:.3g} kg)"),
    )
    too_large = [
        SettingInconsistency(f"robot.{key}", f"{getattr(robot, key):g}", expected, UNITS_REMEDY)
        for key, limit, expected in limits
        if getattr(robot, key) >= limit
    ]
    return [
        *too_large,
        *_inertia_problems(setup),
        *_corner_height_problems(setup),
        *_unknown_bodypart_problems(setup.bodyparts),
        *_duplicate_bodypart_problems(setup.bodyparts),
    ]


def _inertia_problems(setup: StudySettings) -> list[SettingInconsistency]:
    """A yaw inertia that the mass cannot have; the mass is named where it is too small for the
    robot's size.
    """
    robot = setup.robot
    half = 0.5 * (robot.body_length_m + robot.tail_length_m)
    rod, inertia = robot.mass_kg * half * half, robot.yaw_inertia_kg_m2
    if inertia < rod:
        return []
    volume = robot.body_length_m * robot.head_span_m * robot.head_span_m
    if robot.mass_kg < BODY_WIDTH_TO_HEIGHT_RANGE[0] * setup.water.density_kg_m3 * volume:
        expected = (
            f"a mass with which yaw_inertia_kg_m2 {inertia:g} is possible: all of this one at nose "
            f"and tail tip would have {rod:.3g} kg m2"
        )
        return [SettingInconsistency("robot.mass_kg", f"{robot.mass_kg:g}", expected, UNITS_REMEDY)]
    expected = f"less than all mass at nose and tail tip would have ({rod:.3g} kg m2)"
    return [SettingInconsistency("robot.yaw_inertia_kg_m2", f"{inertia:g}", expected, UNITS_REMEDY)]


def _corner_height_problems(setup: StudySettings) -> list[SettingInconsistency]:
    """Marks of the corners further from the water than the pool is wide."""
    height, width = setup.camera.pool_corners_height_m, setup.pool.width_m
    if abs(height) < width:
        return []
    expected = f"a height above the water, less than the pool's width ({width:g} m)"
    key = "camera.pool_corners_height_m"
    return [SettingInconsistency(key, f"{height:g}", expected, "Units are m.")]


def _unknown_bodypart_problems(bodyparts: Iterable[str]) -> list[SettingInconsistency]:
    expected = "one of our parts, followed by the file's name for it"
    return [
        SettingInconsistency(
            f"bodyparts.{part}", "an unknown part", expected, did_you_mean(part, BODY_PART_NAMES)
        )
        for part in bodyparts
        if part not in BODY_PART_NAMES
    ]


def _duplicate_bodypart_problems(bodyparts: Mapping[str, str]) -> list[SettingInconsistency]:
    owners: dict[str, list[str]] = {}
    for part in BODY_PART_NAMES:
        owners.setdefault(bodyparts.get(part, part), []).append(part)
    return [
        SettingInconsistency(
            f"bodyparts.{next(part for part in parts if part in bodyparts)}",
            f"the file's name '{name}' for {' and '.join(parts)}",
            "another name for each part",
            "A part without an entry has its own name in the files.",
        )
        for name, parts in owners.items()
        if len(parts) > 1
    ]


def camera_problems(camera: Camera) -> list[SettingInconsistency]:
    """A lens or pool corners that cannot be."""
    order = corner_order_problems(camera.pool_corners_px)
    corners = f"{[list(corner) for corner in camera.pool_corners_px]}"
    return [
        *_lens_problems(camera),
        *(SettingInconsistency("pool_corners_px", corners, text) for text in order),
        *(_outside_image_problems(camera, corners) if not order else []),
    ]


def _lens_problems(camera: Camera) -> list[SettingInconsistency]:
    if camera.matrix is None:
        without = SettingInconsistency(
            "distortion", "a distortion without a matrix", "both or neither"
        )
        return [without] if camera.distortion else []
    size = SettingInconsistency(
        "image_size_px", "nothing", "width and height; image_size_px is needed with a matrix"
    )
    problems = _matrix_problems(camera.matrix) + ([size] if camera.image_size_px is None else [])
    allowed = (4,) if camera.model == "fisheye" else (4, 5, 8, 12, 14)
    if camera.distortion is not None and len(camera.distortion) not in allowed:
        found = f"{len(camera.distortion)} numbers"
        counts = " or ".join(map(str, allowed[:2]))
        problems.append(
            SettingInconsistency(
                "distortion", found, f"{counts} coefficients of a {camera.model} lens"
            )
        )
    return problems


def _matrix_problems(matrix: Sequence[Sequence[float]]) -> list[SettingInconsistency]:
    (fx, skew, _), (below, fy, _), last = matrix
    shape = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"
    problems = []
    if fx <= 0 or fy <= 0:
        problems.append(
            SettingInconsistency("matrix", f"fx {fx:g}, fy {fy:g}", "positive focal lengths")
        )
    if skew != 0:
        found, remedy = f"a first row {list(matrix[0])}", "Calibrate the lens with a skew of 0."
        problems.append(SettingInconsistency("matrix", found, shape, remedy))
    if below != 0 or tuple(last) != (0, 0, 1):
        problems.append(
            SettingInconsistency("matrix", f"rows {list(matrix[1])} and {list(last)}", shape)
        )
    return problems


def _outside_image_problems(camera: Camera, corners: str) -> list[SettingInconsistency]:
    """Corners or principal point far out of the picture: as where width and height are swapped."""
    if camera.image_size_px is None:
        return []
    width, height = camera.image_size_px
    image = f"the image ({width} x {height} px)"
    remedy = "image_size_px is width, then height."
    problems = []
    if any(
        _is_beyond_image_margin(u, width) or _is_beyond_image_margin(v, height)
        for u, v in camera.pool_corners_px
    ):
        problems.append(
            SettingInconsistency("pool_corners_px", corners, f"corners in {image}", remedy)
        )
    if camera.matrix is not None:
        cx, cy = camera.matrix[0][2], camera.matrix[1][2]
        if not (0 <= cx <= width and 0 <= cy <= height):
            found = f"cx {cx:g}, cy {cy:g}"
            problems.append(
                SettingInconsistency("matrix", found, f"a principal point in {image}", remedy)
            )
    return problems


def _is_beyond_image_margin(value: float, size: int) -> bool:
    return (
        not -CORNER_MARGIN_SHARE_OF_IMAGE * size
        <= value
        <= (1 + CORNER_MARGIN_SHARE_OF_IMAGE) * size
    )


MIN_FLAP_HZ = 0.01
"""Lowest flapping frequency besides 0: one tail beat in 100 s."""
MAX_NAME_BYTES, MAX_PATH_BYTES = 255, 4000
"""Longest name of a file or folder, and longest path, that Linux and macOS can open."""


def trial_problems(trial: Trial) -> list[SettingInconsistency]:
    """Cells of a row that do not go together, or that no file system can hold."""
    problems = [
        SettingInconsistency(
            key, f"a path of {len(text)} characters", f"names of {MAX_NAME_BYTES} bytes at most"
        )
        for key, text in (("source", trial.source), ("motor_log", trial.motor_log or ""))
        if any(is_too_long_path(path) for path in text.split(";"))
    ]
    if (trial.reads_keypoints or trial.reads_images) and trial.fps is None:
        kind = "a keypoint file" if trial.reads_keypoints else "pictures"
        expected = f"frames per second; fps is required where the source is {kind}"
        problems.append(SettingInconsistency("fps", "nothing", expected))
    if trial.flap_hz is not None and 0 < trial.flap_hz < MIN_FLAP_HZ:
        expected = f"tail beats per second: 0, or at least {MIN_FLAP_HZ:g}"
        remedy = "Leave flap_hz empty where the frequency is not known."
        problems.append(SettingInconsistency("flap_hz", f"{trial.flap_hz:g}", expected, remedy))
    if (trial.start_x_px is None) != (trial.start_y_px is None):
        lacking = "start_x_px" if trial.start_x_px is None else "start_y_px"
        problems.append(
            SettingInconsistency(lacking, "nothing", "start_x_px and start_y_px together")
        )
    if trial.start_s is not None and trial.end_s is not None and trial.end_s <= trial.start_s:
        expected = f"end_s must come after start_s ({trial.start_s:g})"
        problems.append(SettingInconsistency("end_s", f"{trial.end_s:g}", expected))
    return problems


def is_too_long_path(path: str) -> bool:
    """Whether no file system holds a path of that length."""
    names = [part.encode("utf-8", "surrogateescape") for part in path.strip().split("/")]
    return max(map(len, names)) > MAX_NAME_BYTES or sum(map(len, names)) > MAX_PATH_BYTES
