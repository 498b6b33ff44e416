"""From states to images and back to apparent poses, with true and stated camera, depth and pool."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.camera import (
    Camera,
    pixels_to_pool,
    project,
    with_fitted_pose,
)
from validation.generators.strip_theory.parameters import KEYS
from validation.generators.strip_theory.tank import SimulatedTrial

Floats = NDArray[np.float64]
KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
RIGID_KEYPOINTS = 4  # the tail tip wags


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml says: camera with the pose its corners give, keypoint depth, pool sides."""

    camera: Camera
    depth: float
    pool: tuple[float, float]
    corners_px: Floats


def corner_points(length: float, width: float) -> Floats:
    """Corners (0,0), (L,0), (L,W), (0,W) on the surface, (4, 3), m."""
    return np.array([[0, 0, 0], [length, 0, 0], [length, width, 0], [0, width, 0]], dtype=float)


def stated_optics(camera: Camera, depth: float, P: Floats, corner_error_px: Floats) -> StatedSetup:
    """Return what the lab states, with the measurement errors that `P` holds."""
    pool = (P[KEYS.POOL_L], P[KEYS.POOL_W])
    corners_px = project(camera, corner_points(*pool)) + corner_error_px
    s = P[KEYS.SCALE]
    reported = (pool[0] * (1 + s), pool[1] * (1 + (s if P[KEYS.SCALE_FORM] == 1 else 0.0)))
    k, center, index = camera.distortion, camera.center, camera.index
    if P[KEYS.LENS_FORM] == 1:
        k = (k[0] + P[KEYS.LENS], *k[1:])
    elif P[KEYS.LENS_FORM] == 2:
        center = (center[0] + 1000 * P[KEYS.LENS], center[1] - 600 * P[KEYS.LENS])
    if P[KEYS.REFR_FORM] == 1:
        index = camera.index - (camera.index - 1.0) * P[KEYS.REFR]
    elif P[KEYS.REFR_FORM] == 2:
        depth = depth * (1 - P[KEYS.REFR])
    lens = replace(camera, distortion=k, center=center, index=index)
    return StatedSetup(
        with_fitted_pose(lens, corner_points(*reported), corners_px), depth, reported, corners_px
    )


def body_points(heading: Floats, phi: Floats, P: Floats) -> NDArray[np.complex128]:
    """Keypoints relative to core_center, complex (frames, 5), m; core along heading + phi."""
    e, c = np.exp(1j * heading), np.exp(1j * (heading + phi))
    hinge = P[KEYS.HINGE] * c
    tail = -P[KEYS.AFT] * c
    return np.stack([hinge + P[KEYS.HEAD] * e, hinge, 0 * c, tail, tail - P[KEYS.TAIL] * c], axis=1)


def labelled_keypoints(run: SimulatedTrial, Y: Floats, phi: Floats) -> NDArray[np.complex128]:
    """World positions (frames, 5) as labelled: the bias is a displaced label."""
    P = run.P
    c = np.exp(1j * (Y[:, 4] + phi))
    ahead = 1.0 if P[KEYS.COM_FORM] == 1 else 1j
    core = Y[:, 0] + 1j * Y[:, 1] - P[KEYS.COM_SHIFT] * ahead * c
    out = core[:, None] + body_points(Y[:, 4], phi, P)
    moved = {1: (2, 1.0), 2: (2, 1j), 3: (1, 1j)}.get(int(P[KEYS.BIAS_FORM]), (0, 0.0))
    out[:, moved[0]] += P[KEYS.BIAS] * moved[1] * c
    return out


def keypoint_depth(t: Floats, depth: float, P: Floats) -> Floats:
    """Depth (m) of the keypoints: 1 sinking at a constant rate; 2 settling within 3 s."""
    way = t if P[KEYS.SINK_FORM] == 1 else 3.0 * (1.0 - np.exp(-t / 3.0))
    return depth + np.minimum(P[KEYS.SINK] * way, 0.18)


def camera_shift_share(run: SimulatedTrial, t: Floats) -> Floats:
    """Share of the camera's displacement: 1 a step within one trial, 2 a drift over the session."""
    when = run.trial.order + t / max(run.times[-1], 1e-9)
    if run.P[KEYS.SHIFT_FORM] == 2:
        return when / run.trial.session
    return (when > run.trial.session // 3 + 0.5).astype(float)


def displaced_camera(camera: Camera, P: Floats, share: float) -> Camera:
    """Return the camera turned by SHIFT about its x axis and by SHIFT_B/0.03 of that about z."""
    s = P[KEYS.SHIFT] * share
    turn = np.add(camera.turn, (s, 0.4 * s, s * P[KEYS.SHIFT_B] / 0.03))
    return replace(camera, turn=tuple(map(float, turn)))


def keypoint_pixels(
    run: SimulatedTrial, points: NDArray[np.complex128], t: Floats, camera: Camera, depth: float
) -> Floats:
    """Raw pixels (frames, 5, 2) of the keypoints at times `t` (s)."""
    z = np.broadcast_to(-keypoint_depth(t, depth, run.P)[:, None], points.shape)
    world = np.stack([points.real, points.imag, z], axis=2)
    if run.P[KEYS.SHIFT] == 0.0:
        return project(camera, world.reshape(-1, 3)).reshape(*points.shape, 2)
    share = camera_shift_share(run, t)
    return np.stack([
        project(displaced_camera(camera, run.P, a), w) for a, w in zip(share, world, strict=True)
    ])  # fmt: skip


def apparent_poses(
    run: SimulatedTrial,
    frames: NDArray[np.int64],
    camera: Camera,
    depth: float,
    stated: StatedSetup,
) -> tuple[Floats, NDArray[np.complex128]]:
    """Apparent poses (n, 3) of core_center and head plate, and the body-frame misfit (n, 4).

    Rigid fit (complex Procrustes) of the stated shape to the keypoints seen through the stated
    camera. A wrong clock reads the path at another time.
    """
    s = run.P[KEYS.CLOCK]
    stretch = (1 + s) if run.P[KEYS.CLOCK_FORM] == 1 else 1 / (1 - abs(s))
    at = np.clip(frames * stretch, 0, len(run.Y) - 1)
    Y = np.stack([np.interp(at, np.arange(len(run.Y)), column) for column in run.Y.T], axis=1)
    phi = np.interp(at, np.arange(len(run.Y)), run.phi[:: 2 * run.sub])
    t = at / run.trial.fps
    pixels = keypoint_pixels(run, labelled_keypoints(run, Y, phi), t, camera, depth)[
        :, :RIGID_KEYPOINTS
    ]
    ground = pixels_to_pool(stated.camera, pixels.reshape(-1, 2), stated.depth).reshape(
        *pixels.shape
    )
    seen = ground[..., 0] + 1j * ground[..., 1]
    shape = body_points(np.zeros(len(at)), phi, run.P)[:, :RIGID_KEYPOINTS]
    a = seen - seen.mean(axis=1, keepdims=True)
    b = shape - shape.mean(axis=1, keepdims=True)
    e = np.exp(1j * np.angle(np.sum(a * b.conj(), axis=1)))[:, None]
    core = seen.mean(axis=1) - e[:, 0] * shape.mean(axis=1)
    pose = np.stack([core.real, core.imag, np.unwrap(np.angle(e[:, 0]))], axis=1)
    return pose, a / e - b
