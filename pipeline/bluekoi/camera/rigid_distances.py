"""Distances between keypoints of the rigid parts, and how each geometry error would change them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..data import BoolNDArray, Float, KeypointPositions, is_confident
from ..errors import input_error
from ..study import Robot
from .lens import Lens
from .pool_projection import PoolCamera, map_to_pool, pool_to_pixels
from .study_camera import camera_from_corners

RIGID_PAIRS = (("head_tip", "hinge"), ("hinge", "core_center"), ("core_center", "tail_base"))
MAX_DISTANCE_SAMPLES = 30_000
STATED_LENGTH_STD_SHARE = 0.003
"""ASSUME the lengths of robot and pool in study.yaml are right to 0.3 %."""
MAD_TO_STD = 1.4826
MAX_DEVIATION_ROBUST_STDS = 6.0


@dataclass(frozen=True)
class RigidDistances:
    """Rigid distances of one campaign, each entry one pair in one frame.

    front_m, back_m: (n, 2) ends in the pool frame. excess_m: (n,) measured minus known length,
    the share that noise adds (s^2 / 2L) removed. std_m, known_m: (n,). trial, pair: (n,) numbers.
    bend_rad: (n,) head angle (core minus head) of the frame, for biased hinges. time_s: (n,) since
    the trial's first frame.
    """

    front_m: Float
    back_m: Float
    excess_m: Float
    std_m: Float
    known_m: Float
    trial: Float
    pair: Float
    bend_rad: Float
    time_s: Float

    @property
    def centers_m(self) -> Float:
        """Centre (n, 2) of each distance in the pool frame."""
        return np.asarray(0.5 * (self.front_m + self.back_m))

    def select(self, kept: BoolNDArray) -> RigidDistances:
        """The entries that are kept, (n,)."""
        return RigidDistances(**{f.name: getattr(self, f.name)[kept] for f in fields(self)})


@dataclass(frozen=True)
class CameraGeometry:
    """What maps pixels to places: a camera and the depth of the keypoints, m."""

    camera: PoolCamera
    depth_m: float


def rigid_distances(
    trials: Sequence[KeypointPositions], head_lengths_m: Sequence[float], robot: Robot
) -> RigidDistances:
    """Distances of all confident pairs of all trials against the robot's known lengths.

    The noise of each pair is the scatter (1.48 MAD) about its trial's own median; distances more
    than six of it away are left out.

    Raises: InputError where no pair of neighbouring parts is ever seen together.
    """
    known = (0.0, robot.hinge_to_com_m, robot.com_to_tail_base_m)
    parts = [
        found
        for t, (positions, head) in enumerate(zip(trials, head_lengths_m, strict=True))
        for k, pair in enumerate(RIGID_PAIRS)
        if (found := _distances_of_pair(positions, pair, head if k == 0 else known[k], (t, k)))
        is not None
    ]
    if not parts:
        raise input_error(
            "keypoints",
            "",
            "no two neighbouring rigid keypoints in one frame",
            f"confident {', '.join(' and '.join(pair) for pair in RIGID_PAIRS)} in some trial",
        )
    columns = {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
    stride = max(1, -(-len(columns["excess_m"]) // MAX_DISTANCE_SAMPLES))
    return RigidDistances(**{name: values[::stride] for name, values in columns.items()})


def _distances_of_pair(
    positions: KeypointPositions, pair: tuple[str, str], known_m: float, labels: tuple[int, int]
) -> dict[str, Float] | None:
    if not set(pair) <= set(positions.names):
        return None
    ends = [positions.names.index(name) for name in pair]
    front, back = positions.xy_m[:, ends[0]], positions.xy_m[:, ends[1]]
    trusted = is_confident(positions.likelihood[:, ends]).all(axis=1)
    length = np.linalg.norm(front - back, axis=1)
    good = trusted & np.isfinite(length)
    if good.sum() < 10:
        return None
    std, near = robust_std_and_inliers(length, good)
    good &= near
    n = int(good.sum())
    excess = length[good] - known_m - std**2 / (2 * known_m)
    return {
        "front_m": front[good],
        "back_m": back[good],
        "excess_m": excess,
        "std_m": np.full(n, std),
        "known_m": np.full(n, known_m),
        "trial": np.full(n, float(labels[0])),
        "pair": np.full(n, float(labels[1])),
        "bend_rad": _raw_head_angle(positions)[good],
        "time_s": positions.time_s[good] - positions.time_s[0],
    }


def robust_std_and_inliers(values: Float, good: np.ndarray) -> tuple[float, np.ndarray]:
    """Robust std of the good values (n,) about their median, and which of all lie within
    `MAX_DEVIATION_ROBUST_STDS` of it.
    """
    off = np.abs(values - np.median(values[good]))
    std = max(1e-6, MAD_TO_STD * float(np.median(off[good])))
    return std, off < MAX_DEVIATION_ROBUST_STDS * std


def _raw_head_angle(positions: KeypointPositions) -> Float:
    """Head angle (frames,) from raw points, within a half turn; 0 where it cannot be had."""
    if not {"head_tip", "hinge", "tail_base"} <= set(positions.names):
        return np.zeros(len(positions.time_s))
    head = positions.part("head_tip") - positions.part("hinge")
    core = positions.part("hinge") - positions.part("tail_base")
    across = head[:, 0] * core[:, 1] - head[:, 1] * core[:, 0]
    return np.nan_to_num(np.arctan2(across, np.sum(head * core, axis=1)))


def pixels_of_places(geometry: CameraGeometry, places_m: Float) -> Float:
    """Pixels (n, 2) of places (n, 2) at the keypoints' depth."""
    depth = np.full(len(places_m), -geometry.depth_m)
    return pool_to_pixels(geometry.camera, np.column_stack([places_m, depth]))


def length_sensitivity_to_camera_errors(
    geometry: CameraGeometry, distances: RigidDistances, names: Collection[str] = ()
) -> dict[str, Float]:
    """Excess (n,) that a unit error of each parameter of the camera makes, to first order.

    names: parameters of `GEOMETRY_ERROR_FUNCTIONS`; without, all.

    A parameter's error is true value minus value used; where it changes the lens or the pool, the
    pose is fitted again to the same corner pixels, as it was when the error was made.
    """
    ends = [pixels_of_places(geometry, end) for end in (distances.front_m, distances.back_m)]

    def length(changed: CameraGeometry) -> Float:
        front, back = (map_to_pool(changed.camera, uv, changed.depth_m) for uv in ends)
        return np.asarray(np.linalg.norm(front - back, axis=1), dtype=np.float64)

    patterns = {}
    for name in names or GEOMETRY_ERROR_FUNCTIONS:
        change, step = GEOMETRY_ERROR_FUNCTIONS[name]
        if name in CAMERA_ERROR_NAMES and geometry.camera.lens is None:
            continue
        high, low = length(change(geometry, step)), length(change(geometry, -step))
        patterns[name] = np.nan_to_num(-(high - low) / (2 * step))
    if "depth_m" in patterns:
        patterns["sinks_m_s"] = patterns["depth_m"] * distances.time_s
    return patterns


def geometry_with_errors(geometry: CameraGeometry, errors: Mapping[str, float]) -> CameraGeometry:
    """A geometry changed by errors: name in `GEOMETRY_ERROR_FUNCTIONS` -> true minus used value."""
    for name, value in errors.items():
        geometry = GEOMETRY_ERROR_FUNCTIONS[name][0](geometry, value)
    return geometry


def remove_camera_errors(
    geometry: CameraGeometry, distances: RigidDistances, errors: Mapping[str, float]
) -> tuple[CameraGeometry, RigidDistances]:
    """Geometry and distances as they would be without errors of the camera, however large.

    errors: parameter -> true value minus value used.
    """
    changed = geometry_with_errors(geometry, errors)
    front, back = (
        map_to_pool(changed.camera, pixels_of_places(geometry, end), changed.depth_m)
        for end in (distances.front_m, distances.back_m)
    )
    before = np.linalg.norm(distances.front_m - distances.back_m, axis=1)
    grown = np.nan_to_num(np.linalg.norm(front - back, axis=1) - before)
    return changed, replace(distances, front_m=front, back_m=back,
                            excess_m=distances.excess_m + grown)  # fmt: skip


def length_sensitivity_to_keypoint_shift(distances: RigidDistances) -> dict[str, Float]:
    """Excess (n,) that a unit shift of one keypoint along the body makes, m per m.

    head_tip along the head; hinge and core_center along the core, forwards; tail_base backwards.
    """
    head, front, rear = (distances.pair == k for k in range(3))
    return {
        "head_tip_m": np.where(head, 1.0, 0.0),
        "hinge_m": np.where(head, -np.cos(distances.bend_rad), 0.0) + front,
        "core_center_m": rear.astype(float) - front,
        "tail_base_m": rear.astype(float),
    }


def _camera_with_lens(camera: PoolCamera, lens: Lens) -> PoolCamera:
    return camera_from_corners(lens, camera.corners_px, camera.corners_m, camera.refractive_index)


def _with_focal_length_changed(geometry: CameraGeometry, step: float) -> CameraGeometry:
    lens = geometry.camera.lens
    assert lens is not None
    matrix = lens.matrix.copy()
    matrix[0, 0] *= 1 + step
    matrix[1, 1] *= 1 + step
    changed = Lens(lens.model, matrix, lens.distortion, lens.size_px)
    return replace(geometry, camera=_camera_with_lens(geometry.camera, changed))


def _with_distortion_k1_changed(geometry: CameraGeometry, step: float) -> CameraGeometry:
    lens = geometry.camera.lens
    assert lens is not None
    distortion = lens.distortion.copy()
    distortion[0] += step
    changed = Lens(lens.model, lens.matrix, distortion, lens.size_px)
    return replace(geometry, camera=_camera_with_lens(geometry.camera, changed))


def _with_pool_scale_changed(geometry: CameraGeometry, step: float) -> CameraGeometry:
    camera = geometry.camera
    wide = camera.corners_m * np.array([1 + step, 1 + step, 1.0])
    if camera.lens is None:
        assert camera.homography is not None
        grown = np.diag([1 + step, 1 + step, 1.0]) @ camera.homography
        return replace(geometry, camera=replace(camera, homography=grown, corners_m=wide))
    changed = camera_from_corners(camera.lens, camera.corners_px, wide, camera.refractive_index)
    return replace(geometry, camera=changed)


def _with_keypoint_depth_changed(geometry: CameraGeometry, step: float) -> CameraGeometry:
    return replace(geometry, depth_m=geometry.depth_m + step)


def _with_refractive_index_changed(geometry: CameraGeometry, step: float) -> CameraGeometry:
    camera = geometry.camera
    index = camera.refractive_index + step
    return replace(geometry, camera=replace(camera, refractive_index=index))


def _with_camera_tilted(axis: int) -> Callable[[CameraGeometry, float], CameraGeometry]:
    """The camera turned about its own x or y axis after the corners were taken."""

    def turned(geometry: CameraGeometry, step: float) -> CameraGeometry:
        camera = geometry.camera
        assert camera.rotation is not None
        assert camera.translation is not None
        turn = Rotation.from_rotvec(step * np.eye(3)[axis]).as_matrix()
        moved = replace(
            camera, rotation=turn @ camera.rotation, translation=turn @ camera.translation
        )
        return replace(geometry, camera=moved)

    return turned


GEOMETRY_ERROR_FUNCTIONS: dict[
    str, tuple[Callable[[CameraGeometry, float], CameraGeometry], float]
] = {
    "scale": (_with_pool_scale_changed, 1e-3),
    "focal": (_with_focal_length_changed, 1e-3),
    "k1": (_with_distortion_k1_changed, 1e-3),
    "tilt_x_rad": (_with_camera_tilted(0), 1e-3),
    "tilt_y_rad": (_with_camera_tilted(1), 1e-3),
    "depth_m": (_with_keypoint_depth_changed, 1e-3),
    "refractive_index": (_with_refractive_index_changed, 1e-3),
}
CAMERA_ERROR_NAMES = frozenset(GEOMETRY_ERROR_FUNCTIONS) - {"scale"}
