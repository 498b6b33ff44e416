"""A lens and the pose of every view of a board, by bundle adjustment."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ..data import Float
from .boards import View
from .lens import Lens, directions, pixels

FOCAL_SHARES = (0.45, 0.65, 0.95, 1.4, 2.1)
SMALLEST_COSINE = 0.05
ROUNDS = 60
LOST_PX = 300.0


@dataclass(frozen=True)
class Fitted:
    """A lens with poses (views, 6), residuals of each view (n, 2) px and covariance of the lens.

    lens_cov: (4 + k, 4 + k) of fx, fy, cx, cy and the distortion, views taken as independent and
    corners of one view as not (sandwich estimate).
    """

    lens: Lens
    poses: Float
    residuals: tuple[Float, ...]
    lens_cov: Float

    @property
    def rms_px(self) -> float:
        """Root mean square distance between found and modelled corners, px."""
        return float(np.sqrt(np.mean(np.concatenate([r**2 for r in self.residuals]).sum(axis=1))))


def fit_lens(views: list[View], model: str, terms: int, size_px: tuple[int, int]) -> Fitted:
    """Lens and poses with the least squared corner error, from the best of several focal lengths.

    terms: number of distortion coefficients. Raises ValueError where no start leads anywhere.
    """
    fits = []
    for share in FOCAL_SHARES:
        focal = share * size_px[0]
        begin = np.array([focal, focal, (size_px[0] - 1) / 2, (size_px[1] - 1) / 2])
        lens = lens_of(np.append(begin, np.zeros(terms)), model, size_px)
        poses = start_poses(lens, views)
        if poses is not None:
            fits.append(adjust(lens, poses, views, rounds=12))
    if not fits:
        raise ValueError(f"no starting focal length suits the {model} model")
    best = min(fits, key=lambda fit: fit.rms_px)
    return adjust(best.lens, best.poses, views)


def adjust(lens: Lens, poses: Float, views: list[View], *, rounds: int = ROUNDS) -> Fitted:
    """Levenberg-Marquardt from a lens and poses (views, 6) over both.

    Each view's pose is eliminated from the normal equations (their form is an arrow), so the cost
    grows with the number of views, not its cube.
    """
    state, damping = parameters(lens), 1e-3
    misses = _misses(state, poses, lens, views)
    for _ in range(rounds):
        parts = _normal_parts(state, poses, lens, views, misses)
        while damping < 1e12:
            step, moves = _step(parts, damping)
            tried = _misses(state + step, poses + moves, lens, views)
            if _cost(tried) < _cost(misses):
                break
            damping *= 8
        else:
            break
        gain = 1 - _cost(tried) / _cost(misses)
        state, poses, misses, damping = state + step, poses + moves, tried, damping / 10
        if gain < 1e-10:
            break
    lens_cov = _sandwich(_normal_parts(state, poses, lens, views, misses))
    return Fitted(lens_of(state, lens.model, lens.size_px), poses, tuple(misses), lens_cov)


def place_views(lens: Lens, views: list[View]) -> Fitted:
    """Poses of views under a lens that is held fixed: what a held-out view is judged by."""
    poses = start_poses(lens, views)
    if poses is None:
        raise ValueError("a held-out view lies outside the lens model")
    state, damping = parameters(lens), 1e-3
    misses = _misses(state, poses, lens, views)
    for _ in range(30):
        parts = _normal_parts(state, poses, lens, views, misses)
        moves = np.array([_solve(d, damping, g) for _, _, d, _, g in parts])
        tried = _misses(state, poses + moves, lens, views)
        better = np.array([_cost([t]) < _cost([m]) for t, m in zip(tried, misses, strict=True)])
        damping = damping / 10 if np.any(better) else damping * 10
        poses = np.where(better[:, None], poses + moves, poses)
        misses = [t if b else m for t, m, b in zip(tried, misses, better, strict=True)]
    return Fitted(lens, poses, tuple(misses), np.zeros((len(state), len(state))))


def parameters(lens: Lens) -> Float:
    """fx, fy, cx, cy and the distortion of a lens."""
    k = lens.matrix
    return np.concatenate([[k[0, 0], k[1, 1], k[0, 2], k[1, 2]], lens.distortion])


def lens_of(state: Float, model: str, size_px: tuple[int, int]) -> Lens:
    """Lens of parameters fx, fy, cx, cy and the distortion."""
    fx, fy, cx, cy = state[:4]
    return Lens(model, np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), state[4:], size_px)


def start_poses(lens: Lens, views: list[View]) -> Float | None:
    """Rotation vector and translation (views, 6) of each view, or None where a view has no ray."""
    poses = []
    for view in views:
        rays = directions(lens, view.image_px)
        good = rays[:, 2] > SMALLEST_COSINE
        if good.sum() < 6:
            return None
        plane = (rays[good, :2] / rays[good, 2:]).reshape(-1, 1, 2)
        _, turn, shift = cv2.solvePnP(
            view.board_m[good], plane, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
        )
        poses.append(np.concatenate([turn.ravel(), shift.ravel()]))
    return np.array(poses)


Parts = list[tuple[Float, Float, Float, Float, Float]]


def _misses(state: Float, poses: Float, lens: Lens, views: list[View]) -> list[Float]:
    tried = lens_of(state, lens.model, lens.size_px)
    turns = Rotation.from_rotvec(poses[:, :3]).as_matrix()
    placed = [
        view.board_m @ turn.T + pose[3:]
        for view, turn, pose in zip(views, turns, poses, strict=True)
    ]
    image = np.nan_to_num(pixels(tried, np.concatenate(placed)), nan=-LOST_PX * 10)
    ends = np.cumsum([len(view.board_m) for view in views])[:-1]
    return [v.image_px - i for v, i in zip(views, np.split(image, ends), strict=True)]


def _cost(misses: list[Float]) -> float:
    return float(sum(np.sum(m**2) for m in misses))


def _normal_parts(
    state: Float, poses: Float, lens: Lens, views: list[View], misses: list[Float]
) -> Parts:
    """Per view: J'J of the lens, lens by pose, of the pose; J'r of the lens and of the pose."""
    columns = []
    for i in range(len(state)):
        step = np.zeros(len(state))
        step[i] = 1e-6 * max(1.0, abs(state[i]))
        moved = _misses(state + step, poses, lens, views)
        columns.append([(m - t).ravel() / step[i] for m, t in zip(misses, moved, strict=True)])
    for i in range(6):
        step = np.zeros(6)
        step[i] = 1e-7
        moved = _misses(state, poses + step, lens, views)
        columns.append([(m - t).ravel() / 1e-7 for m, t in zip(misses, moved, strict=True)])
    parts = []
    for k, miss in enumerate(misses):
        slope = np.column_stack([column[k] for column in columns])
        a, b = slope[:, : len(state)], slope[:, len(state) :]
        r = miss.ravel()
        parts.append((a.T @ a, a.T @ b, b.T @ b, a.T @ r, b.T @ r))
    return parts


def _step(parts: Parts, damping: float) -> tuple[Float, Float]:
    normal = sum(p[0] for p in parts)
    reduced = normal + damping * np.diag(np.diag(normal))
    pull = np.sum([p[3] for p in parts], axis=0)
    inverses = [np.linalg.pinv(_damped(p[2], damping)) for p in parts]
    for (_, cross, _, _, g), inverse in zip(parts, inverses, strict=True):
        reduced = reduced - cross @ inverse @ cross.T
        pull = pull - cross @ inverse @ g
    step = _scaled_solve(reduced, pull)
    moves = [i @ (p[4] - p[1].T @ step) for p, i in zip(parts, inverses, strict=True)]
    return step, np.array(moves)


def _sandwich(parts: Parts) -> Float:
    """Covariance of the lens: bread of the reduced normal matrix, meat of each view's own pull."""
    size = len(parts[0][0])
    bread, meat = np.zeros((size, size)), np.zeros((size, size))
    for a, cross, d, pull, g in parts:
        inverse = np.linalg.pinv(d)
        bread += a - cross @ inverse @ cross.T
        own = pull - cross @ inverse @ g
        meat += np.outer(own, own)
    scale = 1 / np.sqrt(np.maximum(np.diag(bread), 1e-30))
    inverse = np.linalg.pinv(bread * np.outer(scale, scale)) * np.outer(scale, scale)
    views = len(parts)
    return inverse @ meat @ inverse * views / max(1, views - 1)


def _damped(matrix: Float, damping: float) -> Float:
    return matrix + damping * np.diag(np.diag(matrix))


def _solve(matrix: Float, damping: float, pull: Float) -> Float:
    return np.asarray(np.linalg.pinv(_damped(matrix, damping)) @ pull)


def _scaled_solve(matrix: Float, pull: Float) -> Float:
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    solution = np.linalg.lstsq(matrix * np.outer(scale, scale), pull * scale, rcond=None)[0]
    return np.asarray(solution * scale)
