"""From motion to keypoints: body points with recoil, the camera, tracking errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from .camera import Camera, pool_corners
from .faults import ViewingConditions
from .form import Array, HiddenCause, ParallelTrials
from .motion import STEP_S, frequency, head_angle
from .robots import Robot

BODY_PARTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
REFRACTIVE_INDEX = 1.333
"""Refractive index of the basin's water."""


@dataclass(frozen=True)
class Tracker:
    """Errors of detections. white, slow: px; memory: s; shares of frames with outliers and gaps."""

    white: float
    slow: float
    memory: float
    outliers: float
    gaps: float


@dataclass(frozen=True)
class Recoil:
    """Tail beat and what it does to the body: angles in rad, sway in m."""

    tail: float
    heading: float
    sway: float
    phase: float


@dataclass(frozen=True)
class Scene:
    """Camera, its true viewing conditions, images of the corner marks and their height, m."""

    camera: Camera
    true: ViewingConditions
    corner_pixels: Array
    corner_height: float
    tracker: Tracker
    recoil: Recoil


def with_measurement_errors(scene: Scene, hidden: Sequence[HiddenCause]) -> ViewingConditions:
    """The viewing with the hidden measurement errors in it."""
    view = scene.true
    for h in hidden:
        if h.form.stage == "fault":
            view = h.form.law(view, h.strength, h.parameters)
    return view


def stated_camera(scene: Scene, view: ViewingConditions) -> Camera:
    """The camera that a reader of study.yaml takes it to be."""
    focal = (scene.camera.focal[0] * view.focal, scene.camera.focal[1] * view.focal)
    lens = replace(scene.camera, focal=focal, distortion=view.distortion)
    return lens.posed(scene.corner_pixels, pool_corners(view.pool), scene.corner_height)


@dataclass(frozen=True)
class FilmedMotion:
    """Motion of all trials as functions of true time, on the grid of the integration."""

    states: Array
    lanes: ParallelTrials
    robot: Robot
    hidden: tuple[HiddenCause, ...]

    def times(self) -> Array:
        """Grid of the integration, s."""
        return np.arange(len(self.states)) * STEP_S

    def frequencies(self) -> Array:
        """Flapping frequency on the grid, Hz, shape (steps + 1, trials)."""
        return frequency(self.times()[:, None], self.lanes, self.hidden)

    def cycles(self) -> Array:
        """Beats since the start on the grid, shape (steps + 1, trials)."""
        hertz = self.frequencies()
        steps = 0.5 * STEP_S * (hertz[1:] + hertz[:-1])
        return np.concatenate([np.zeros((1, hertz.shape[1])), np.cumsum(steps, axis=0)])

    def pose(self, k: int, t: Array) -> tuple[Array, Array, Array]:
        """Complex place (m), core heading and head angle (rad) of trial k at times t."""
        t = np.clip(t, 0, self.times()[-1])
        x, y, heading = CubicSpline(self.times(), self.states[:, :3, k])(t).T
        one = replace(self.lanes, angle=self.lanes.angle[k])
        return x + 1j * y, heading, head_angle(t, one, self.hidden)


@dataclass(frozen=True)
class _HeadAngles:
    """The part of a moment that laws of the centre of mass read."""

    angle: Array


def mass_offset(film: FilmedMotion, hidden: Sequence[HiddenCause]) -> Array:
    """Distance (trials, 1) by which the centre of mass lies ahead of its label, m."""
    total = np.zeros((film.lanes.angle.size, 1))
    angles = _HeadAngles(film.lanes.angle[:, None])
    for h in hidden:
        if h.form.stage == "arm":
            total = total + h.form.law(angles, h.strength, h.parameters)
    return total


def body_points(
    pose: tuple[Array, Array, Array], head: float, robot: Robot, beat: Array | float = 0.0
) -> dict[str, Array]:
    """Complex places of the body parts, m. beat: angle of the tail against the core, rad."""
    core, heading, angle = pose
    way = np.exp(1j * heading)
    hinge, base = core + robot.hinge_to_com * way, core - robot.base * way
    return {
        "head_tip": hinge + head * way * np.exp(-1j * angle),
        "hinge": hinge,
        "core_center": core,
        "tail_base": base,
        "tail_tip": base - robot.tail_length * way * np.exp(1j * beat),
    }


def pixels_of(
    film: FilmedMotion, scene: Scene, view: ViewingConditions, k: int, t: Array, *, recoil: bool
) -> Mapping[str, Array]:
    """Exact pixels (frames, 2) of the body parts of trial k at stated times t."""
    true_t = view.clock(k, t)
    place, heading, angle = film.pose(k, true_t)
    place = place - mass_offset(film, film.hidden)[k] * np.exp(1j * heading)
    beat: Array | float = 0.0
    if recoil:
        r = scene.recoil
        phase = 2 * np.pi * np.interp(true_t, film.times(), film.cycles()[:, k]) + r.phase
        running = 1 - np.exp(-np.maximum(true_t, 0) / 0.2)
        beat = r.tail * running * np.sin(phase)
        place = place + 1j * r.sway * running * np.cos(phase) * np.exp(1j * heading)
        heading = heading - r.heading * running * np.sin(phase - 0.4)
    points = body_points((place, heading, angle), float(film.lanes.head[k]), film.robot, beat)
    images = {}
    for name, plan in points.items():
        if name in view.labels:
            plan = plan + view.labels[name](angle) * np.exp(1j * heading)  # noqa: PLW2901
        exact = scene.camera.image_through_surface(plan, scene.true.depth, scene.true.index)
        images[name] = view.shift(k, t, exact)
    return images


def perceived_poses(
    film: FilmedMotion, scene: Scene, view: ViewingConditions, knots: Array
) -> Array:
    """x, y, core heading, head angle (trials, knots, 4) as a careful reader of the files sees them.

    Without recoil and tracking errors; place from the core's label, heading from hinge to base.
    """
    camera = stated_camera(scene, view)
    poses = []
    for k in range(film.lanes.angle.size):
        images = pixels_of(film, scene, view, k, knots, recoil=False)
        at = {name: camera.locate(px, view.depth, view.index) for name, px in images.items()}
        core, tip = at["hinge"] - at["tail_base"], at["head_tip"] - at["hinge"]
        heading = np.unwrap(np.angle(core))
        place = at["core_center"]
        angle = np.angle(core * np.conj(tip))
        poses.append(np.stack([place.real, place.imag, heading, angle], axis=-1))
    return np.array(poses)


def detections(
    rng: np.random.Generator, images: Mapping[str, Array], tracker: Tracker, fps: float
) -> dict[str, tuple[Array, Array]]:
    """Pixels with tracking errors and likelihoods; unseen points are NaN or of low likelihood."""
    return {name: _detected(rng, exact, tracker, fps) for name, exact in images.items()}


def _detected(
    rng: np.random.Generator, exact: Array, tracker: Tracker, fps: float
) -> tuple[Array, Array]:
    count = len(exact)
    fade = np.exp(-1 / (fps * tracker.memory))
    slow = np.empty((count, 2))
    slow[0] = rng.normal(0, tracker.slow, 2)
    drive = rng.normal(0, tracker.slow * np.sqrt(1 - fade**2), (count, 2))
    for j in range(1, count):
        slow[j] = fade * slow[j - 1] + drive[j]
    found = exact + slow + rng.normal(0, tracker.white, (count, 2))
    likelihood = np.clip(1 - rng.exponential(0.015, count), 0.6, 1)
    wild = rng.random(count) < tracker.outliers
    found[wild] += rng.normal(0, 25, (int(wild.sum()), 2))
    likelihood[wild] = rng.uniform(0.15, 0.95, int(wild.sum()))
    for start in np.flatnonzero(rng.random(count) < tracker.gaps / 4):
        stop = start + 1 + rng.geometric(0.3)
        if rng.random() < 0.5:
            found[start:stop] = np.nan
            likelihood[start:stop] = np.nan
        else:
            found[start:stop] += rng.normal(0, 15, 2)
            likelihood[start:stop] = 0.03
    return found, likelihood


def draw_scene(rng: np.random.Generator, camera: Camera, robot: Robot,
               pool: tuple[float, float]) -> Scene:  # fmt: skip
    """True viewing conditions, clicked corner marks, a tracker and a tail beat."""
    true = ViewingConditions(
        robot.keypoint_depth, REFRACTIVE_INDEX, pool, distortion=camera.distortion
    )
    height = float(rng.choice([0.0, 0.0, 0.08, 0.15]))
    marks = camera.image(pool_corners(pool), height) + rng.normal(0, 0.15, (4, 2))
    tracker = Tracker(*map(float, rng.uniform((0.25, 0.15, 0.2, 0.003, 0.004),
                                              (0.6, 0.4, 0.7, 0.015, 0.02))))  # fmt: skip
    recoil = Recoil(*map(float, rng.uniform((0.2, 0.004, 2e-4, -3), (0.5, 0.02, 1e-3, 3))))
    return Scene(camera, true, np.round(marks, 2), height, tracker, recoil)
