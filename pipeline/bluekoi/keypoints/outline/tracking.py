"""The template followed from frame to frame, detected again where it was lost, and learned."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...data import Float, Frame
from .background import LumaPicture
from .blob_detection import Blob, candidate_poses, find_blobs
from .edges import EDGE_WINDOW_HALF_WIDTH_PX
from .outline_fit_covariance import FrameQuadraticForms, covariance_kernels, frame_quadratic_forms
from .plane import SwimmingPlaneMap
from .pose_fit import OutlineArrays, fit_outline_pose, information_and_edge_support
from .tail_detection import tail_length, trace_tail
from .target_body import TargetBody
from .template import OutlineTemplate

PRIOR_PRECISION = np.array([330.0, 330.0, 30.0, 30.0, 1.0])
MIN_TRACKING_SUPPORT_SHARE = 0.55
MAX_HEAD_ANGLE_DEVIATION_RAD = 0.7
"""ASSUME a servo that lags or is wrong turns the head by less than 40 degrees from the scene's."""
STATISTICS_FRAME_INTERVAL = 2
NO_TAIL = (np.full(2, np.nan), math.nan, 0.0, (math.nan, math.nan, math.nan))
LOST_AFTER_FRAMES = 8
EDGE_NEARNESS_RANGE_BL = 0.042
TRACKING_EDGE_SEARCH_RANGES_BL = (0.042, 0.024)


@dataclass(frozen=True)
class DetectionScene:
    """What stays the same over a recording: background, plane, noise [grey levels], head angle."""

    floor: LumaPicture
    plane: SwimmingPlaneMap
    noise: float
    head_angle_rad: float

    @property
    def plane_to_pixel_map(self) -> tuple[Float, Float]:
        """Coefficients and scale of the plane's map to pixels."""
        return self.plane.to_px, self.plane.scale_bl


@dataclass(frozen=True)
class OutlineFit:
    """One frame's fit.

    pose: (4,) hinge x, y [body lengths], core heading, head angle [rad]. information: (5, 5) for
    offsets with a standard deviation of 1 px, in body axes, the outline's width last. statistics:
    of the offsets left (`outline_fit_covariance`). support: share of the outline's points whose
    edge lies where the template has it: head, core, all. nearness: mean over the outline of 1 at
    the edge, falling to 0 at EDGE_NEARNESS_RANGE_BL. tail: tip (2,) px, direction [rad], support
    and quality measures as `trace_tail` returns them. nose_px: distance of the nose's edge ahead of
    the template's. length: measured over stated length of the whole body, nose to tail; NaN if its
    ends were not seen.
    """

    pose: Float
    information: Float
    statistics: FrameQuadraticForms | None
    support: tuple[float, float, float]
    nearness: float
    tail: tuple[Float, float, float, tuple[float, float, float]]
    nose_px: float
    length: float = math.nan


def edge_search_ranges_px(scene: DetectionScene, *sizes_bl: float) -> npt.NDArray[np.int64]:
    """Search lengths in px, at least what an edge needs."""
    px = [
        max(EDGE_WINDOW_HALF_WIDTH_PX + 2, round(size * scene.plane.px_per_bl)) for size in sizes_bl
    ]
    return np.array([min(p, 40) for p in px], dtype=np.int64)


def edge_support_tolerance_px(scene: DetectionScene) -> float:
    """How far from the template an edge may lie and still support it."""
    return max(1.0, 0.0073 * scene.plane.px_per_bl)


def fit_template_to_frame(
    frame: LumaPicture,
    scene: DetectionScene,
    shape: OutlineArrays,
    start: Float,
    reach: npt.NDArray[np.int64],
    *,
    width_px: float = 0.1,
    known: Float | None = None,
) -> OutlineFit:
    """The template fitted to a frame from a starting pose, without its tail.

    width_px: offsets far beyond this width are outliers; wide while the shape is not yet known.
    known: kernels (K, n, n) for the statistics of the fit's variance.
    """
    pose, offset, weight, slope = fit_outline_pose(
        (frame, scene.floor),
        scene.plane_to_pixel_map,
        shape,
        start,
        (reach, PRIOR_PRECISION, width_px),
    )
    limits = (edge_support_tolerance_px(scene), EDGE_NEARNESS_RANGE_BL * scene.plane.px_per_bl)
    found = (offset, weight, slope)
    information, share = information_and_edge_support(found, shape[2], pose[2], limits)
    signs = (
        None
        if known is None
        else frame_quadratic_forms(found, float(pose[2]), PRIOR_PRECISION, known)
    )
    pose[2] = start[2] + math.remainder(pose[2] - start[2], 2 * math.pi)
    head, core, both, nearness = share.tolist()
    return OutlineFit(
        pose, information, signs, (head, core, both), nearness, NO_TAIL, float(offset[0])
    )


def redetect_robot(
    frame: LumaPicture, scene: DetectionScene, body: TargetBody, shape: OutlineArrays
) -> OutlineFit | None:
    """The best fit of the target body to any blob of a frame; None if no fit is good
    enough.
    """
    seen = find_blobs((frame, scene.floor), scene.plane, scene.noise, body.template.area_bl2)
    return best_fit_of_blobs(seen, frame, scene, body, shape)


def best_fit_of_blobs(
    seen: Sequence[Blob],
    frame: LumaPicture,
    scene: DetectionScene,
    body: TargetBody,
    shape: OutlineArrays,
) -> OutlineFit | None:
    """The best fit of the target body to any of these blobs, either way round; None if no fit is
    good enough.
    """
    steps = edge_search_ranges_px(scene, 0.066, 0.054, 0.042, 0.030, 0.024, 0.024)
    starts = [
        pose
        for blob in seen
        if is_plausible_blob(blob, body.template)
        for pose in candidate_poses(blob, body.template, scene.head_angle_rad)
    ]
    tried = [fit_template_to_frame(frame, scene, shape, start, steps) for start in starts]
    tried = [one for one in tried if body.is_candidate(one.pose)]
    best = max(tried, key=lambda one: one.support[2], default=None)
    return best if best is not None and is_good_fit(best, scene) else None


def is_plausible_blob(blob: Blob, template: OutlineTemplate) -> bool:
    """Whether a blob is of the robot's order of size and grey level."""
    if abs(blob.skin - template.core_grey_level) > 0.5 * abs(blob.contrast):
        return False
    return 0.35 * template.area_bl2 < blob.area_bl2 < 4.0 * template.area_bl2


def is_good_fit(one: OutlineFit, scene: DetectionScene) -> bool:
    """Whether a fit is the robot: enough of the outline there, head and core both, pose sane."""
    bend = abs(math.remainder(one.pose[3] - scene.head_angle_rad, 2 * math.pi))
    return (
        one.support[2] > MIN_TRACKING_SUPPORT_SHARE
        and min(one.support[:2]) > 0.35
        and bend < MAX_HEAD_ANGLE_DEVIATION_RAD
    )


def track_robot(
    film: Iterable[Frame],
    scene: DetectionScene,
    template: OutlineTemplate,
    start_px: tuple[float, float] | None = None,
) -> tuple[list[float], list[OutlineFit | None]]:
    """Times and fits of all frames; None where the robot was not found.

    start_px: where the robot is in the first frame, if other bodies like it may be there.
    """
    place = (
        None if start_px is None else scene.plane.pixels_to_body_lengths(np.array([start_px]))[0]
    )
    body = TargetBody(template, place)
    shape = template.outline_arrays()
    known = covariance_kernels(
        *template.turned_points_and_normals(scene.head_angle_rad),
        template.head_bl + template.core_bl,
    )
    steps = edge_search_ranges_px(scene, *TRACKING_EDGE_SEARCH_RANGES_BL)
    times: list[float] = []
    fits: list[OutlineFit | None] = []
    for frame in film:
        start = _extrapolated_pose(frame.time_s, times, fits)
        asked = None if len(times) % STATISTICS_FRAME_INTERVAL else known
        one = (
            start
            if start is None
            else fit_template_to_frame(frame.luma, scene, shape, start, steps, known=asked)
        )
        if one is None or not is_good_fit(one, scene):
            one = redetect_robot(frame.luma, scene, body, shape)
        body.record_pose(None if one is None else one.pose)
        times.append(frame.time_s)
        fits.append(None if one is None else with_traced_tail(frame.luma, scene, template, one))
    return times, fits


def _extrapolated_pose(
    time_s: float, times: Sequence[float], fits: Sequence[OutlineFit | None]
) -> Float | None:
    """Pose expected at a time from the last two fits of the last frames; None without any."""
    first = max(0, len(fits) - LOST_AFTER_FRAMES)
    known = [(t, one) for t, one in zip(times[first:], fits[first:], strict=True) if one]
    if not known:
        return None
    if len(known) < 2:
        return known[-1][1].pose.copy()
    (before_s, before), (last_s, last) = known[-2:]
    ahead = (time_s - last_s) / (last_s - before_s)
    return last.pose + min(ahead, float(LOST_AFTER_FRAMES)) * (last.pose - before.pose)


def with_traced_tail(
    frame: LumaPicture, scene: DetectionScene, template: OutlineTemplate, one: OutlineFit
) -> OutlineFit:
    """The fit with its tail traced, and the whole body's length."""
    x, y, heading, _ = one.pose
    back = np.array([math.cos(heading), math.sin(heading)])
    base_bl = np.array([x, y]) - template.core_bl * back
    ends = scene.plane.body_lengths_to_pixels(
        np.stack([base_bl, base_bl - template.tail_bl * back])
    )
    along = ends[1] - ends[0]
    back_rad, length_px = math.atan2(along[1], along[0]), float(np.hypot(*along))
    pictures = (frame, scene.floor)
    tail = trace_tail(pictures, ends[0], back_rad, length_px, template.core_grey_level)
    seen_px = tail_length(pictures, ends[0], back_rad, length_px, template.core_grey_level)
    stated_bl = template.head_bl + template.core_bl + template.tail_bl
    longer_bl = (seen_px - length_px + one.nose_px) * template.tail_bl / length_px
    return replace(one, tail=tail, length=1.0 + longer_bl / stated_bl)
