"""A lens and the pose of every view of a board, by bundle adjustment."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from ..data import Float
from .boards import View
from .lens import Lens, directions, pixels

FOCAL_SHARES = (0.45, 0.65, 0.95, 1.4, 2.1)
SMALLEST_COSINE = 0.05
ROUNDS = 60
PLACE_ROUNDS = 12
SMALLEST_GAIN = 1e-9
LOST_PX = -3000.0


@dataclass(frozen=True)
class Fitted:
    """A lens with poses (views, 6), residuals of each view (n, 2) px and covariance of the lens.

    lens_cov: (4 + k, 4 + k) of fx, fy, cx, cy and the distortion, views taken as independent and
    corners of one view as not (first-order jackknife over views).
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
            fits.append(adjust(lens, poses, views, rounds=8))
    if not fits:
        raise ValueError(f"no starting focal length suits the {model} model")
    best = min(fits, key=lambda fit: fit.rms_px)
    return adjust(best.lens, best.poses, views)


def adjust(lens: Lens, poses: Float, views: list[View], *, rounds: int = ROUNDS) -> Fitted:
    """Levenberg-Marquardt from a lens and poses (views, 6) over both.

    Each view's pose is eliminated from the normal equations (their form is an arrow), so the cost
    grows with the number of views, not its cube.
    """
    state, damping, given = parameters(lens), 1e-3, _problem(lens, views)
    misses = _misses(state, poses, given)
    for _ in range(rounds):
        parts = _normal_parts(state, poses, given, misses)
        while damping < 1e12:
            step, moves = _step(parts, damping)
            tried = _misses(state + step, poses + moves, given)
            if np.sum(tried**2) < np.sum(misses**2):
                break
            damping *= 8
        else:
            break
        gain = 1 - np.sum(tried**2) / np.sum(misses**2)
        state, poses, misses, damping = state + step, poses + moves, tried, damping / 10
        if gain < SMALLEST_GAIN:
            break
    lens_cov = _jackknife(_normal_parts(state, poses, given, misses))
    residuals = tuple(misses[part] for part in given.slices)
    return Fitted(lens_of(state, lens.model, lens.size_px), poses, residuals, lens_cov)


def place_views(lens: Lens, views: list[View]) -> Fitted:
    """Poses of views under a lens that is held fixed: what a held-out view is judged by."""
    poses = start_poses(lens, views)
    if poses is None:
        raise ValueError("a held-out view lies outside the lens model")
    state, damping, given = parameters(lens), np.full(len(views), 1e-3), _problem(lens, views)
    misses = _misses(state, poses, given)
    cost = np.array([np.sum(misses[part] ** 2) for part in given.slices])
    for _ in range(PLACE_ROUNDS):
        parts = _normal_parts(state, poses, given, misses)
        damped = parts.pose * (1 + damping[:, None, None] * np.eye(6)) + 1e-30 * np.eye(6)
        moves = np.linalg.solve(damped, parts.pose_pull[:, :, None])[:, :, 0]
        tried = _misses(state, poses + moves, given)
        after = np.array([np.sum(tried[part] ** 2) for part in given.slices])
        better = after < cost
        if not np.any(after < (1 - SMALLEST_GAIN) * cost) and np.all(damping > 1e3):
            break
        damping = np.where(better, damping / 10, damping * 100)
        poses = np.where(better[:, None], poses + moves, poses)
        misses = np.where(better[given.which, None], tried, misses)
        cost = np.minimum(cost, after)
    residuals = tuple(misses[part] for part in given.slices)
    return Fitted(lens, poses, residuals, np.zeros((len(state), len(state))))


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


@dataclass(frozen=True)
class _Problem:
    """All corners of all views in one: board_m (n, 3), image_px (n, 2), view number (n,)."""

    board_m: Float
    image_px: Float
    which: npt.NDArray[np.intp]
    slices: tuple[slice, ...]
    model: str
    size_px: tuple[int, int]


@dataclass(frozen=True)
class _Parts:
    """Normal equations, view by view: lens (v, p, p), cross (v, p, 6), pose (v, 6, 6), and J'r."""

    lens: Float
    cross: Float
    pose: Float
    lens_pull: Float
    pose_pull: Float


def _problem(lens: Lens, views: list[View]) -> _Problem:
    counts = [len(view.board_m) for view in views]
    ends = np.cumsum([0, *counts])
    return _Problem(
        board_m=np.concatenate([view.board_m for view in views]),
        image_px=np.concatenate([view.image_px for view in views]),
        which=np.repeat(np.arange(len(views)), counts),
        slices=tuple(slice(a, b) for a, b in pairwise(ends)),
        model=lens.model,
        size_px=lens.size_px,
    )


def _misses(state: Float, poses: Float, given: _Problem) -> Float:
    """Found minus modelled corner (n, 2), px."""
    turns = Rotation.from_rotvec(poses[:, :3]).as_matrix()
    placed = np.einsum("nij,nj->ni", turns[given.which], given.board_m) + poses[given.which, 3:]
    image = pixels(lens_of(state, given.model, given.size_px), placed)
    return given.image_px - np.nan_to_num(image, nan=LOST_PX)


def _normal_parts(state: Float, poses: Float, given: _Problem, misses: Float) -> _Parts:
    size = len(state)
    slope = np.empty((*misses.shape, size + 6))
    for i, step in enumerate(np.diag(1e-6 * np.maximum(1.0, np.abs(state)))):
        slope[:, :, i] = (misses - _misses(state + step, poses, given)) / step[i]
    for i, step in enumerate(1e-7 * np.eye(6)):
        slope[:, :, size + i] = (misses - _misses(state, poses + step, given)) / 1e-7
    blocks, pulls = [], []
    for part in given.slices:
        rows = slope[part].reshape(-1, size + 6)
        blocks.append(rows.T @ rows)
        pulls.append(rows.T @ misses[part].ravel())
    block, pull = np.array(blocks), np.array(pulls)
    return _Parts(
        lens=block[:, :size, :size],
        cross=block[:, :size, size:],
        pose=block[:, size:, size:],
        lens_pull=pull[:, :size],
        pose_pull=pull[:, size:],
    )


def _step(parts: _Parts, damping: float) -> tuple[Float, Float]:
    """Step of the lens (p,) and of the poses (v, 6): Schur complement of the arrow."""
    normal = parts.lens.sum(axis=0)
    inverse = np.linalg.inv(_damped(parts.pose, damping))
    share = parts.cross @ inverse
    reduced = _damped(normal[None], damping)[0] - np.sum(
        share @ np.swapaxes(parts.cross, 1, 2), axis=0
    )
    pull = np.sum(parts.lens_pull - (share @ parts.pose_pull[:, :, None])[:, :, 0], axis=0)
    step = _scaled_solve(reduced, pull)
    left = parts.pose_pull - np.einsum("vpi,p->vi", parts.cross, step)
    return step, np.einsum("vij,vj->vi", inverse, left)


def _jackknife(parts: _Parts) -> Float:
    """Covariance of the lens by leaving out one view at a time, to first order (CR3).

    d_v = (B - B_v)^-1 g_v, cov = (v - 1)/v sum d_v d_v', B the normal matrix with poses eliminated.
    A plain sandwich is too small by a third for a dozen views.
    """
    inverse = np.linalg.inv(_damped(parts.pose, 1e-12))
    share = parts.cross @ inverse
    blocks = parts.lens - share @ np.swapaxes(parts.cross, 1, 2)
    own = parts.lens_pull - (share @ parts.pose_pull[:, :, None])[:, :, 0]
    scale = 1 / np.sqrt(np.maximum(np.einsum("vii->i", blocks), 1e-30))
    scaled = blocks * np.outer(scale, scale)
    fewer = np.linalg.pinv(scaled.sum(axis=0) - scaled, hermitian=True)
    shifts = (fewer @ (own * scale)[:, :, None])[:, :, 0] * scale
    return np.asarray(shifts.T @ shifts * (len(own) - 1) / len(own))


def focal_shifts(fitted: Fitted, views: list[View]) -> tuple[Float, Float]:
    """By how much each view alone would lengthen both focal lengths, and how well it can tell.

    Shares (views,) and their standard deviations (views,), to first order, the view's own pose
    following, by the misses of all views as white noise.
    """
    state, given = parameters(fitted.lens), _problem(fitted.lens, views)
    misses = _misses(state, fitted.poses, given)
    parts = _normal_parts(state, fitted.poses, given, misses)
    along = np.zeros(len(state))
    along[:2] = state[:2]
    turned = np.linalg.solve(parts.pose, np.swapaxes(parts.cross, 1, 2) @ along[:, None])[:, :, 0]
    told = np.einsum("p,vpq,q->v", along, parts.lens, along)
    told -= np.einsum("vp,vp->v", np.einsum("vpi,p->vi", parts.cross, along), turned)
    pull = parts.lens_pull @ along - np.einsum("vi,vi->v", parts.pose_pull, turned)
    noise = float(np.mean(misses**2))
    told = np.maximum(told, 1e-12)
    return pull / told, np.sqrt(noise / told)


def _damped(matrices: Float, damping: float) -> Float:
    diagonal = np.einsum("vii->vi", matrices)
    return matrices + (damping * diagonal + 1e-30)[:, :, None] * np.eye(matrices.shape[1])


def _scaled_solve(matrix: Float, pull: Float) -> Float:
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    solution = np.linalg.lstsq(matrix * np.outer(scale, scale), pull * scale, rcond=None)[0]
    return np.asarray(solution * scale)
