"""From motion to keypoints in pixels, and from keypoints back to the pose a user sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .form import Array, HiddenCause, Lanes
from .motion import acting, centre_offset, head_angle
from .optics import image_under_water, point_under_water, with_pose_from_corners
from .robots import Robot
from .view_faults import View

PARTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Tracker:
    """white, slow: standard deviations in px. memory: s. bad, gone: shares of frames."""

    white: float
    slow: float
    memory: float
    bad: float
    gone: float


@dataclass(frozen=True)
class Recoil:
    """Motion of the measured body at the flapping frequency.

    sway (m), yaw (rad): amplitudes. phase: of the sway, rad. beat: amplitude of the tail tip, rad.
    """

    sway: float
    yaw: float
    phase: float
    beat: float


def part_places(robot: Robot, head: Array, phi: Array, beat: Array) -> dict[str, Array]:
    """Parts in core axes from the stated centre of mass, complex, m."""
    back = robot.body_length - robot.head_length - robot.hinge_to_com
    hinge = robot.hinge_to_com + 0j * phi
    return {
        "head_tip": hinge + head * np.exp(-1j * phi),
        "hinge": hinge,
        "core_center": 0j * phi,
        "tail_base": -back + 0j * phi,
        "tail_tip": -back - robot.tail_length * np.exp(1j * beat) + 0j * phi,
    }


def with_faults(view: View, hidden: Sequence[HiddenCause]) -> View:
    """The view with all hidden errors of measurement."""
    for h in acting(hidden, "view"):
        view = h.form.law(view, h.strength, **h.parameters)
    return view


def extra_depth(t: Array, hidden: Sequence[HiddenCause]) -> Array:
    """Sinking since the start, m."""
    depth = 0 * np.asarray(t)
    for h in acting(hidden, "depth"):
        depth = depth + h.form.law(t, h.strength, **h.parameters)
    return depth


def pose_at(grid: Array, states: Array, t: Array) -> tuple[Array, Array]:
    """Position (complex, m) and core direction (rad) at times t (n, trials)."""
    columns = [
        [np.interp(t[:, k], grid, states[:, row, k]) for k in range(states.shape[2])]
        for row in (0, 1, 2)
    ]
    x, y, psi = (np.stack(c, axis=1) for c in columns)
    return x + 1j * y, psi


def images(
    t: Array,
    grid: Array,
    states: Array,
    lanes: Lanes,
    robot: Robot,
    *,
    hidden: Sequence[HiddenCause],
    view: View,
    recoil: tuple[Recoil, Array] | None = None,
) -> dict[str, Array]:
    """Pixels (complex) of the parts at video times t, (frames, trials).

    recoil: the amplitudes and the phase of the beat (rad) at the grid, (steps, trials).
    """
    video = t[:, None] + 0 * lanes.phi
    motion = view.clock(video, lanes.luck)
    place, psi = pose_at(grid, states, motion)
    phi = head_angle(motion, lanes, hidden)
    beat = 0 * phi
    place = place - centre_offset(phi, hidden) * np.exp(1j * psi)
    if recoil is not None:
        size, phase = recoil
        turn = np.stack([np.interp(motion[:, k], grid, phase[:, k])
                         for k in range(phi.shape[1])], axis=1)  # fmt: skip
        grown = np.clip(motion / 0.5, 0, 1)
        place = place + 1j * size.sway * grown * np.sin(turn + size.phase) * np.exp(1j * psi)
        psi = psi + size.yaw * grown * np.sin(turn)
        beat = size.beat * grown * np.sin(turn + 2.2)
    depth = view.depth + extra_depth(motion, hidden)
    seen = {}
    for part, where in part_places(robot, lanes.head, phi, beat).items():
        point = place + (where + view.labels(part, phi)) * np.exp(1j * psi)
        pixels = image_under_water(point, depth, view.camera, view.index)
        seen[part] = view.shift(pixels, video, lanes.luck)
    return seen


def pose_seen(seen: dict[str, Array], view: View) -> Array:
    """x, y (m), core direction and head angle (rad) with the stated camera, (4, frames, trials)."""
    lens = with_pose_from_corners(view.lens, view.marks, view.stated_pool, view.marks_height)
    tip, hinge, core, back = (
        point_under_water(seen[part], view.stated_depth, lens, view.stated_index)
        for part in PARTS[:4]
    )
    psi = np.unwrap(np.angle(hinge - back), axis=0)
    phi = np.angle((hinge - back) * np.conj(tip - hinge))
    return np.stack([core.real, core.imag, psi, phi])


def with_tracking_errors(
    rng: np.random.Generator, pixels: Array, tracker: Tracker, fps: float
) -> tuple[Array, Array]:
    """Pixels (frames,) with errors, NaN where nothing was found, and likelihoods."""
    n = pixels.size
    keep = np.exp(-1 / (fps * tracker.memory))
    drive = rng.normal(size=(2, n)) * np.sqrt(1 - keep**2)
    drive[:, 0] /= np.sqrt(1 - keep**2)
    slow = tracker.slow * lfilter([1], [1, -keep], drive, axis=1)
    error = slow + tracker.white * rng.normal(size=(2, n))
    likelihood = 1 - rng.gamma(1.2, 0.012, n)
    found = pixels + error[0] + 1j * error[1]
    bad = rng.random(n) < tracker.bad
    jump = rng.normal(0, 28, n) + 1j * rng.normal(0, 28, n)
    found = np.where(bad, found + jump, found)
    honest = rng.random(n) < 0.75
    likelihood = np.where(bad & honest, rng.uniform(0.02, 0.55, n), likelihood)
    dim = rng.random(n) < 0.01
    likelihood = np.where(dim & ~bad, rng.uniform(0.2, 0.85, n), likelihood)
    gone = np.zeros(n, bool)
    for start in np.flatnonzero(rng.random(n) < tracker.gone * 1.0 / 6):
        gone[start : start + rng.integers(2, 12)] = True
    found = np.where(gone, np.nan + 1j * np.nan, found)
    return found, np.where(gone, rng.uniform(0.001, 0.08, n), np.clip(likelihood, 0.001, 1))


def draw_tracker(rng: np.random.Generator) -> Tracker:
    """Total error between 0.5 and 2 px, partly slow."""
    total, share = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0)))), rng.uniform(0.3, 0.7)
    return Tracker(
        white=round(total * float(np.sqrt(1 - share)), 3),
        slow=round(total * float(np.sqrt(share)), 3),
        memory=round(float(rng.uniform(0.1, 0.5)), 3),
        bad=round(float(rng.uniform(0.003, 0.015)), 4),
        gone=round(float(rng.uniform(0.002, 0.02)), 4),
    )


def draw_recoil(rng: np.random.Generator) -> Recoil:
    """Amplitudes of a stiff body with a beating tail."""
    return Recoil(
        sway=float(rng.uniform(0.0008, 0.004)),
        yaw=float(np.radians(rng.uniform(0.8, 3.0))),
        phase=float(rng.uniform(0.8, 2.4)),
        beat=float(np.radians(rng.uniform(15, 30))),
    )
