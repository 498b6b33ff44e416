"""Fits of all frames as keypoints: pixels, likelihood, covariance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...data import PARTS, Keypoints
from .template import Template
from .tracking import Fit, Scene

Float = npt.NDArray[np.float64]
CERTAIN, WORTHLESS = 0.80, 0.35
BEND_RAD = 0.07
CLIPPED = 9.0
FLOOR_PX = 0.05


def keypoints_of(
    times: Sequence[float],
    fits: Sequence[Fit | None],
    scene: Scene,
    template: Template,
    remarks: tuple[str, ...],
) -> Keypoints:
    """Keypoints of a recording; NaN with likelihood 0 where the robot was not found."""
    n, p = len(times), len(PARTS)
    xy, likelihood = np.full((n, p, 2), np.nan), np.zeros((n, p))
    cov = np.full((n, p, 2, 2), np.nan)
    known = [one for one in fits if one is not None]
    usual = usual_covariance(known)
    bend = float(np.median([one.pose[3] for one in known])) if known else 0.0
    jumps = _jumps(times, fits)
    nose_m = _nose(known) / scene.plane.px_per_m
    for i, one in enumerate(fits):
        if one is None:
            continue
        xy[i], cov[i] = _points(one, scene, template, (usual, nose_m))
        likelihood[i] = _likelihood(one, bend) * jumps[i]
    likelihood[~np.isfinite(xy).all(axis=2)] = 0.0
    return Keypoints(np.array(times), PARTS, xy, likelihood, cov, remarks)


def _nose(fits: Sequence[Fit]) -> float:
    """Median distance [px] of the nose's edge ahead of the template's, over the whole recording.

    The template's nose is known from a few frames only; all of them place the outline better.
    """
    seen = [one.nose_px for one in fits if math.isfinite(one.nose_px) and one.support[0] > CERTAIN]
    return float(np.median(seen)) if len(seen) > 4 else 0.0


def usual_covariance(fits: Sequence[Fit]) -> tuple[Float, Float]:
    """Mean covariance (4, 4) of the pose in body axes over frames, and the mean information.

    Each frame's is the sandwich of its information and the scores of its outline's arcs, which
    holds where errors are alike along an arc; one frame alone would be too few arcs.
    """
    if not fits:
        return np.eye(4), np.eye(4)
    middle = np.median([one.information for one in fits], axis=0)
    scores = np.array([one.scores for one in fits])
    size = np.trace(scores, axis1=1, axis2=2)
    kept = size <= CLIPPED * np.median(size)
    inverse = np.linalg.inv(middle + 1e-6 * np.diag(np.diag(middle)))
    return inverse @ scores[kept].mean(axis=0) @ inverse, middle


def _points(
    one: Fit, scene: Scene, template: Template, common: tuple[tuple[Float, Float], float]
) -> tuple[Float, Float]:
    """Pixels (5, 2) and covariances (5, 2, 2) of one fit.

    common: usual covariance and information; how far the nose lies ahead of the template's [m].
    """
    usual, nose_m = common
    x, y, heading, bend = one.pose
    core, head = np.exp(1j * heading), np.exp(1j * (heading - bend))
    moved = nose_m * math.cos(bend) * core
    arms = np.array(
        [
            template.head_m * head,
            0.0,
            -template.com_m * core,
            -template.core_m * core,
        ]
    )
    places = np.column_stack([x + (arms + moved).real, y + (arms + moved).imag])
    uv = scene.plane.pixels(places)
    slope = _slope(scene, places[1], heading)
    pose_cov = _pose_covariance(one, usual)
    arms_body = arms / core
    turns = [1.0, 1.0, 1.0, 1.0], [-1.0, 0.0, 0.0, 0.0]
    cov = np.empty((5, 2, 2))
    for k, arm in enumerate(arms_body):
        across = np.array([-arm.imag, arm.real])
        moves = np.column_stack([np.eye(2), across * turns[0][k], across * turns[1][k]])
        cov[k] = slope @ moves @ pose_cov @ moves.T @ slope.T + FLOOR_PX**2 * np.eye(2)
    cov[4] = _tail_covariance(one, cov[3])
    return np.vstack([uv, one.tail[0]]), cov


def _slope(scene: Scene, place: Float, heading: float) -> Float:
    """d(u, v)/d(along, across) the core at a place, px per m."""
    step = 0.01 * np.array(
        [[math.cos(heading), math.sin(heading)], [-math.sin(heading), math.cos(heading)]]
    )
    ends = scene.plane.pixels(np.concatenate([place + step, place - step]))
    return (ends[:2] - ends[2:]).T / 0.02


def _pose_covariance(one: Fit, usual: tuple[Float, Float]) -> Float:
    """Covariance (4, 4) of one frame: the usual one, wider where less of the outline was seen."""
    cov, middle = usual
    ridge = 1e-3 * np.diag(np.diag(middle))
    widened = np.linalg.solve(one.information + ridge, middle + ridge)
    return widened @ cov @ widened.T


def _tail_covariance(one: Fit, base: Float) -> Float:
    """Covariance of the tail tip: the base's, and the trace's scatter across its end."""
    _, heading, _, scatter = one.tail
    if not math.isfinite(heading):
        return np.full((2, 2), np.nan)
    along = np.array([math.cos(heading), math.sin(heading)])
    across = np.array([-along[1], along[0]])
    sideways = max(scatter, 0.1) ** 2
    return base + sideways * np.outer(across, across) + 0.02 * np.outer(along, along)


def _likelihood(one: Fit, bend: float) -> Float:
    """Likelihood (5,) from how much of the outline about each part is where it should be."""
    head, core, both = (_graded(value) for value in one.support)
    off = math.remainder(one.pose[3] - bend, 2 * math.pi) / BEND_RAD
    sane = math.exp(-0.5 * max(0.0, abs(off) - 1.0) ** 2)
    tail = min(core, _graded(one.tail[2]))
    return sane * np.array([head, min(head, core, both), core, core, tail])


def _graded(support: float) -> float:
    return min(max((support - WORTHLESS) / (CERTAIN - WORTHLESS), 0.0), 1.0)


def _jumps(times: Sequence[float], fits: Sequence[Fit | None]) -> Float:
    """Factor (frames,) that falls where the hinge jumps both to and from a frame.

    A lone frame that lies off the line between its neighbours by more than a body can accelerate.
    """
    factor = np.ones(len(fits))
    for i in range(1, len(fits) - 1):
        before, one, after = fits[i - 1], fits[i], fits[i + 1]
        if before is None or one is None or after is None:
            continue
        share = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1])
        between = before.pose + share * (after.pose - before.pose)
        off = math.hypot(*(one.pose - between)[:2])
        turned = abs(math.remainder(one.pose[2] - between[2], 2 * math.pi))
        factor[i] = 0.2 if off > 0.02 or turned > 0.5 else 1.0
    return factor
