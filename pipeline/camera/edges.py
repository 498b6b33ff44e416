"""Pool edges found in a frame near where the camera expects them, and corners that follow."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..data import Float
from .boards import Grey
from .pool import PoolCamera, project

EDGES = ("(0,0) to (length,0)", "(length,0) to (length,width)", "(length,width) to (0,width)",
         "(0,width) to (0,0)")  # fmt: skip
SAMPLES = 80
REACH_SHARE = 0.012
STEP_PX = 0.25
SMOOTH_PX = 1.0
INLIER_PX = 1.5
ENOUGH = 0.4
FEWEST_CONTRAST = 4.0


@dataclass(frozen=True)
class Edge:
    """One pool edge: expected curve (n, 2) px, its unit normals (n, 2), and what was seen.

    offset_px: (n,) from curve to the strongest step, NaN where there is none. start_px, end_px:
    offset of the fitted edge at its two corners, NaN where no straight edge was found. bend_px:
    rms of the seen steps about that fit. share: part of the samples that lie on it.
    """

    curve_px: Float
    normal_px: Float
    offset_px: Float
    start_px: float
    end_px: float
    bend_px: float
    share: float


def find_edges(grey: Grey, camera: PoolCamera) -> tuple[Edge, ...]:
    """The four pool edges, each looked for within 1.2 % of the picture's width."""
    return tuple(_edge(grey, camera, k) for k in range(4))


def suggested_corners(camera: PoolCamera, edges: tuple[Edge, ...]) -> Float:
    """Corners (4, 2) px where neighbouring found edges meet; NaN where one of them is missing.

    The shift d solves n_1 . d = o_1 and n_2 . d = o_2 for the two edges' normals and offsets.
    """
    expected = project(camera, camera.corners_m)
    corners = np.full((4, 2), np.nan)
    for k in range(4):
        before, after = edges[k - 1], edges[k]
        normals = np.array([before.normal_px[-1], after.normal_px[0]])
        offsets = np.array([before.end_px, after.start_px])
        if np.all(np.isfinite(offsets)) and abs(np.linalg.det(normals)) > 0.2:
            corners[k] = expected[k] + np.linalg.solve(normals, offsets)
    return corners


def _edge(grey: Grey, camera: PoolCamera, k: int) -> Edge:
    along = np.linspace(0, 1, SAMPLES)
    start, end = camera.corners_m[k], camera.corners_m[(k + 1) % 4]
    curve = project(camera, start + along[:, None] * (end - start))
    tangent = np.gradient(curve, axis=0)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    offset = _steps(grey, curve, normal)
    offset[(along < 0.05) | (along > 0.95)] = np.nan
    line, inliers = _straight(along, offset)
    inner = (along >= 0.05) & (along <= 0.95)
    share = float(inliers.sum() / inner.sum())
    found = share >= ENOUGH
    bend = float(np.sqrt(np.mean((offset - np.polyval(line, along))[inliers] ** 2))) if found else 0
    ends = np.polyval(line, [0.0, 1.0]) if found else np.full(2, np.nan)
    return Edge(
        curve, normal, offset, float(ends[0]), float(ends[1]), bend if found else np.nan, share
    )


def _steps(grey: Grey, curve: Float, normal: Float) -> Float:
    """Offset (n,) along the normals of the strongest brightness step; NaN where it is faint."""
    reach = REACH_SHARE * grey.shape[1]
    across = np.arange(-reach, reach + STEP_PX, STEP_PX)
    points = curve[:, None] + across[:, None] * normal[:, None]
    maps = points.astype(np.float32)
    picture = cv2.GaussianBlur(grey, (0, 0), SMOOTH_PX)
    profile = cv2.remap(
        picture.astype(np.float32), maps[:, :, 0], maps[:, :, 1], cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    slope = np.abs(np.gradient(profile, axis=1)) / STEP_PX
    best = np.clip(np.argmax(slope, axis=1), 1, len(across) - 2)
    rows = np.arange(len(curve))
    left, middle, right = (slope[rows, best + i] for i in (-1, 0, 1))
    curvature = left - 2 * middle + right
    shift = np.where(curvature < 0, (left - right) / np.where(curvature < 0, 2 * curvature, 1), 0)
    contrast = FEWEST_CONTRAST * np.median(slope)
    return np.where(middle > max(contrast, 1.0), across[best] + shift * STEP_PX, np.nan)


def _straight(along: Float, offset: Float) -> tuple[Float, np.ndarray]:
    """Line of offset over place that most samples lie on (least median over pairs), refitted."""
    seen = np.flatnonzero(np.isfinite(offset))
    best, most = np.zeros(2), np.zeros(len(along), dtype=bool)
    for i in seen[::3]:
        for j in seen[::3]:
            if along[j] - along[i] < 0.3:
                continue
            slope = (offset[j] - offset[i]) / (along[j] - along[i])
            line = np.array([slope, offset[i] - slope * along[i]])
            close = np.abs(np.nan_to_num(offset, nan=1e9) - np.polyval(line, along)) < INLIER_PX
            if close.sum() > most.sum():
                best, most = line, close
    if most.sum() >= 3:
        best = np.polyfit(along[most], offset[most], 1)
    return best, most
