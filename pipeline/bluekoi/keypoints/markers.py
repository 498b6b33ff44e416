"""Keypoints from coloured dots on the robot, by hue (`detection.marker_hues_deg` in study.yaml).

Every dot is found as a blob of its hue; its place is the centre of its coverage, its colour unmixed
from those around it. Dots whose distances do not fit the rigid robot are not believed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..data import BODY_PART_NAMES, Float, Frame, Keypoints, is_confident
from ..errors import input_error
from ..study import StudySettings, Trial
from .dots.centroid import coverage_centroid
from .dots.variances import dot_variances, occlusion_variances
from .outline.plane import SwimmingPlaneMap, swimming_plane_map

NEEDS_COLOUR = True
"""The detector takes colour frames (bgr), not grey ones."""
HUE_WIDTH_DEG = 20.0
MIN_HSV_SATURATION = 70.0
MIN_HSV_VALUE = 45.0
MARKER_RADIUS_RANGE_BL = (0.0045, 0.09)
DISTANCE_TOLERANCE_SHARE = 0.10
MAX_DOTS_PER_HUE = 4
SEARCH_MARGIN_BL = 0.45
DISTANCE_TOLERANCE_BL = 0.012


@dataclass(frozen=True)
class Dot:
    """A blob of a marker's colour: centre (2,) px and (2,) body lengths, weight of its colour, its
    radius as a disc, px.
    """

    px: Float
    bl: Float
    weight: float
    radius_px: float


def detect_keypoints(
    frames: Callable[[], Iterable[Frame]], setup: StudySettings, trial: Trial
) -> Keypoints:
    """Keypoints of the marked parts, frame by frame; NaN and likelihood 0 where not seen.

    Likelihood: share of the other dots whose distance is what the rigid robot's is. Covariance:
    how much the rigid robot's distances scatter, more where part of a dot is hidden.

    Raises: InputError where no hues are given, or the footage holds no frame.
    """
    hues = {
        part: hue
        for part, hue in setup.detection.marker_hues_deg.items()
        if part in BODY_PART_NAMES
    }
    if len(hues) < 3:
        found = f"{len(hues)} hues"
        expected = "a hue in degrees for head_tip and two of hinge, core_center, tail_base"
        raise input_error("study.yaml", "detection.marker_hues_deg", found, expected)
    plane, lengths = swimming_plane_map(setup), keypoint_distance_ranges_bl(setup, trial)
    names = tuple(part for part in BODY_PART_NAMES if part in hues)
    times, rows = [], []
    box: tuple[int, int, int, int] | None = None
    for frame in frames():
        row, box = _detect_parts_in_frame(frame, (hues, names, lengths), plane, box)
        times.append(frame.time_s)
        rows.append(row)
    if not times:
        raise input_error(trial.source, "", "no frames", "footage with frames")
    return _keypoints_of_rows(np.array(times), names, np.array(rows))


def keypoint_distance_ranges_bl(
    setup: StudySettings, trial: Trial
) -> dict[tuple[str, str], tuple[float, float]]:
    """Least and greatest distance [body lengths] of each pair of parts; head and core are rigid."""
    robot = setup.robot
    unit = robot.body_length_m
    head = trial.head_length_m / unit
    along = {
        "hinge": 0.0,
        "core_center": robot.hinge_to_com_m / unit,
        "tail_base": 1.0 - robot.head_length_m / unit,
    }
    bend = trial.head_angle_rad
    tip = np.array([head * math.cos(bend), -head * math.sin(bend)])
    places = {part: np.array([-x, 0.0]) for part, x in along.items()} | {"head_tip": tip}
    found = {}
    for a in places:
        for b in places:
            if a < b:
                length = float(np.hypot(*(places[a] - places[b])))
                slack = (
                    DISTANCE_TOLERANCE_SHARE * length
                    + DISTANCE_TOLERANCE_BL
                    + 0.1 * head * ("head_tip" in (a, b))
                )
                found[a, b] = (length - slack, length + slack)
    back = robot.tail_length_m / unit
    return found | {("tail_base", "tail_tip"): (0.5 * back, 1.15 * back)}


def _detect_parts_in_frame(
    frame: Frame,
    wanted: tuple[
        Mapping[str, float], tuple[str, ...], Mapping[tuple[str, str], tuple[float, float]]
    ],
    plane: SwimmingPlaneMap,
    box: tuple[int, int, int, int] | None,
) -> tuple[Float, tuple[int, int, int, int] | None]:
    """Row (parts, 5) of u, v, likelihood, area covered and radius; and where to look next."""
    hues, names, lengths = wanted
    if frame.bgr is None:
        raise input_error("footage", "", "grey frames", "colour frames for the markers")
    image, corner = _crop(frame.bgr, box)
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV).astype(np.float32)
    dots = {part: _dots_of_hue(hsv, hues[part], corner, plane) for part in names}
    row = np.full((len(names), 5), np.nan)
    row[:, 2] = 0.0
    for k, part in enumerate(names):
        best = max(
            (
                (_consistent_neighbour_share(dot, part, dots, lengths), dot.weight, i)
                for i, dot in enumerate(dots[part])
            ),
            default=None,
        )
        if best is not None:
            dot = dots[part][best[2]]
            place, covered = coverage_centroid(image, dot.px - corner, dot.radius_px)
            row[k] = [*(place + corner), best[0], covered, dot.radius_px]
    sure = row[row[:, 2] > 0.5]
    if len(sure) < 2:
        return row, None
    margin = SEARCH_MARGIN_BL * plane.px_per_bl
    low, high = sure[:, :2].min(axis=0) - margin, sure[:, :2].max(axis=0) + margin
    return row, (int(low[0]), int(low[1]), int(high[0]), int(high[1]))


def _crop(
    image: npt.NDArray[np.uint8], box: tuple[int, int, int, int] | None
) -> tuple[npt.NDArray[np.uint8], Float]:
    if box is None:
        return image, np.zeros(2)
    left, top = max(0, box[0]), max(0, box[1])
    return image[top : max(top + 1, box[3]), left : max(left + 1, box[2])], np.array([left, top])


def _dots_of_hue(
    hsv: npt.NDArray[np.float32], hue_deg: float, corner: Float, plane: SwimmingPlaneMap
) -> list[Dot]:
    """Blobs of a hue, those of most colour first."""
    away = np.abs((hsv[..., 0] * 2.0 - hue_deg + 180.0) % 360.0 - 180.0)
    closeness = np.clip(1.5 - 1.5 * away / HUE_WIDTH_DEG, 0.0, 1.0)
    colour = np.where(hsv[..., 2] > MIN_HSV_VALUE, hsv[..., 1] - MIN_HSV_SATURATION, 0.0)
    weight = (closeness * np.maximum(colour, 0.0)).astype(np.float32)
    contours, _ = cv2.findContours(
        (weight > 8).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    area = np.pi * (np.array(MARKER_RADIUS_RANGE_BL) * plane.px_per_bl) ** 2
    sized = [c for c in contours if area[0] < max(cv2.contourArea(c), len(c)) < area[1]]
    dots = [_dot_of_contour(weight, contour, corner, plane) for contour in sized]
    return sorted(dots, key=lambda dot: -dot.weight)[:MAX_DOTS_PER_HUE]


def _dot_of_contour(
    weight: npt.NDArray[np.float32],
    contour: npt.NDArray[np.int32],
    corner: Float,
    plane: SwimmingPlaneMap,
) -> Dot:
    x, y, w, h = cv2.boundingRect(contour)
    x, y = max(0, x - 2), max(0, y - 2)
    patch = weight[y : y + h + 4, x : x + w + 4].astype(float)
    total = patch.sum()
    v, u = np.indices(patch.shape)
    centre = np.array([(patch * u).sum() / total + x, (patch * v).sum() / total + y]) + corner
    radius = math.sqrt(max(cv2.contourArea(contour), float(len(contour))) / math.pi)
    return Dot(centre, plane.pixels_to_body_lengths(centre[None])[0], float(total), radius)


def _consistent_neighbour_share(
    dot: Dot,
    part: str,
    dots: Mapping[str, list[Dot]],
    lengths: Mapping[tuple[str, str], tuple[float, float]],
) -> float:
    """Share of the rigid neighbours of a part of which some dot lies at the right distance."""
    votes = []
    for (a, b), (least, most) in lengths.items():
        other = b if part == a else a if part == b else None
        if other is None or other not in dots:
            continue
        votes.append(any(least < float(np.hypot(*(dot.bl - d.bl))) < most for d in dots[other]))
    return float(np.mean(votes)) if votes else 0.0


def _keypoints_of_rows(times: Float, names: tuple[str, ...], rows: Float) -> Keypoints:
    xy, likelihood = rows[..., :2], rows[..., 2]
    variance = dot_variances(names, xy, likelihood) + occlusion_variances(
        rows[..., 3], rows[..., 4]
    )
    cov = variance[..., None, None] * np.eye(2)
    cov = np.where(np.isfinite(xy[..., :1, None]), cov, np.nan)
    lost = int(np.sum(~is_confident(likelihood).any(axis=1)))
    remarks = (f"{lost} of {len(times)} frames without two markers that fit",) if lost else ()
    return Keypoints(times, names, xy, likelihood, cov, remarks)
