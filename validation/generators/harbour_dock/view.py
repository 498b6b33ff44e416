"""What the camera sees, and what somebody who trusts study.yaml computes from it."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from scipy.interpolate import CubicSpline

from .engine import Motion
from .law import Law
from .optics import Camera, Lens, Pose, corners, fit_pose, mark_depth, project, unproject
from .plan import Trials
from .robots import Robot

POINTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


def _still(time: np.ndarray, _trial: int) -> np.ndarray:
    return np.zeros((len(time), 3))


@dataclass
class View:
    """True optics, what is written down (`..._written`), clocks and misplaced labels.

    Lengths in m, times in s. depth: of the labels; marks_inset: of the corner marks from the walls;
    time_shift, clock_rate, clock_drift: of every trial, see `true_time`; moves: shift in x and y
    (m) and turn (rad) of the camera at label times of a trial; bias: of labels, complex in core
    axes (m), from the head angle.
    """

    robot: Robot
    trials: Trials
    camera: Camera
    corner_noise: np.ndarray
    depth: float
    lens_written: Lens
    index_written: float
    depth_written: float
    pool_written: tuple[float, float]
    height_written: float
    marks_inset: float = 0.0
    time_shift: np.ndarray = field(default_factory=lambda: np.zeros(0))
    clock_rate: np.ndarray = field(default_factory=lambda: np.zeros(0))
    clock_drift: np.ndarray = field(default_factory=lambda: np.zeros(0))
    moves: Callable[[np.ndarray, int], np.ndarray] = _still
    bias: dict[str, Callable[[np.ndarray], np.ndarray]] = field(default_factory=dict)
    pose_written: Pose | None = None

    def corner_px(self) -> np.ndarray:
        """The clicked corner marks, px."""
        camera, (length, width, _) = self.camera, self.trials.pool
        inwards = self.marks_inset * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        seen = project(
            corners(length, width) + inwards, mark_depth(camera.marks_height), camera.pose(),
            camera.lens, index=camera.index,
        )  # fmt: skip
        return np.round(seen + self.corner_noise, 2)

    def solve_pose(self) -> Pose:
        """Pose from the written numbers alone."""
        if self.pose_written is None:
            guess = np.concatenate([self.camera.rotation_vector, self.camera.position])
            marks = corners(*self.pool_written)
            self.pose_written = fit_pose(
                self.corner_px(), marks, self.height_written, self.lens_written, guess
            )
        return self.pose_written

    def true_time(self, time: np.ndarray, trial: int) -> np.ndarray:
        """Motor time of label time (s; 0 = first frame, at the written frame rate)."""
        drift = 1 + self.clock_drift[trial] * time
        return time * self.clock_rate[trial] * drift + self.time_shift[trial]

    def pixels(
        self, points: np.ndarray, depth: np.ndarray, time: np.ndarray, trial: int
    ) -> np.ndarray:
        """Pixels of complex pool points (m) at depths (m), seen at label times of a trial."""
        moved = self.moves(time, trial)
        pose = self.camera.pose(np.column_stack([moved[:, :2], np.zeros(len(time))]))
        places = np.column_stack([points.real, points.imag])
        return project(
            places, depth, pose, self.camera.lens, index=self.camera.index, roll=moved[:, 2]
        )

    def back(self, pixels: np.ndarray) -> np.ndarray:
        """Pool points (complex, m) of pixels, by the written numbers."""
        pose = self.solve_pose()
        found = unproject(
            pixels, self.depth_written, pose, self.lens_written, index=self.index_written
        )
        return found[:, 0] + 1j * found[:, 1]


def make_view(rng: Generator, robot: Robot, trials: Trials, camera: Camera) -> View:
    """The honest view: written numbers equal the true ones up to calibration noise."""
    count = len(trials.phi)
    lens = copy.deepcopy(camera.lens)
    lens.k = [round(float(value * (1 + rng.normal(0, 1.5e-4))), 2) for value in lens.k]
    return View(
        robot, trials, camera, corner_noise=rng.normal(0, 0.25, (4, 2)), depth=robot.depth,
        lens_written=lens, index_written=camera.index, depth_written=robot.depth,
        pool_written=(trials.pool[0], trials.pool[1]), height_written=camera.marks_height,
        time_shift=np.zeros(count), clock_rate=np.ones(count), clock_drift=np.zeros(count),
    )  # fmt: skip


def with_laws(base: View, laws: list[Law], sizes: list[float]) -> View:
    """A copy of `base` with the measurement laws applied."""
    view = copy.copy(base)
    view.lens_written = copy.deepcopy(base.lens_written)
    view.time_shift = base.time_shift.copy()
    view.clock_rate, view.clock_drift = base.clock_rate.copy(), base.clock_drift.copy()
    view.bias = dict(base.bias)
    view.pose_written = None
    for law, size in zip(laws, sizes, strict=True):
        if "view" in law.hooks and size != 0:
            law.hooks["view"](view, size)
    return view


class Track:
    """Continuous-time motion of one variant of a simulation."""

    def __init__(self, motion: Motion, variant: int = 0) -> None:
        self.time = motion.time
        self._splines = {}
        for name in ("x", "y", "theta", "phi", "depth", "shift_x", "shift_y", "flap"):
            values = getattr(motion, name)[:, variant]
            finite = np.where(np.isfinite(values), values, 0.0)
            self._splines[name] = CubicSpline(self.time, finite, axis=0)
        flap = motion.flap[:, variant]
        halves = np.cumsum(0.5 * (flap[1:] + flap[:-1]), 0)
        beats = np.concatenate([np.zeros((1, flap.shape[1])), halves])
        self._splines["beats"] = CubicSpline(
            self.time, beats * (self.time[1] - self.time[0]), axis=0
        )

    def at(self, name: str, time: np.ndarray, trial: int) -> np.ndarray:
        """Values at motor times (s) of a trial, `beats` among them; at rest before the start."""
        return self._splines[name](np.clip(time, 0, self.time[-1]))[:, trial]


@dataclass(frozen=True)
class Beat:
    """Of the body with the tail. sway: m, to port; recoil: of the head, rad; tail: its angle."""

    sway: np.ndarray | float = 0.0
    recoil: np.ndarray | float = 0.0
    tail: np.ndarray | float = 0.0


NO_BEAT = Beat()


def skeleton(
    view: View, track: Track, time: np.ndarray, trial: int, beat: Beat = NO_BEAT
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Pool positions (complex, m) of the labels at motor times (s), and their depth (m)."""
    robot = view.robot
    phi = track.at("phi", time, trial)
    head = np.exp(1j * (track.at("theta", time, trial) + beat.recoil))
    core = head * np.exp(1j * phi)
    centre = track.at("x", time, trial) + 1j * track.at("y", time, trial) + 1j * core * beat.sway
    centre = centre - track.at("shift_x", time, trial) - 1j * track.at("shift_y", time, trial)
    hinge = centre + robot.hinge_to_com * core
    base = centre - robot.com_to_tail * core
    points = {
        "head_tip": hinge + view.trials.head[trial] * head,
        "hinge": hinge,
        "core_center": centre,
        "tail_base": base,
        "tail_tip": base - robot.tail * core * np.exp(1j * np.asarray(beat.tail)),
    }
    for name, bias in view.bias.items():
        points[name] = points[name] + bias(phi) * core
    return points, view.depth + track.at("depth", time, trial)


def observe(view: View, track: Track, label_time: np.ndarray, trial: int) -> np.ndarray:
    """Noise-free x, y (m), heading, head angle (rad) and apparent length (m), (times, 5)."""
    time = view.true_time(label_time, trial)
    points, depth = skeleton(view, track, time, trial)
    seen = {
        name: view.back(view.pixels(points[name], depth, label_time, trial)) for name in POINTS[:4]
    }
    head, core = seen["head_tip"] - seen["hinge"], seen["hinge"] - seen["tail_base"]
    theta = np.unwrap(np.angle(head))
    true_theta = track.at("theta", time, trial)
    theta = theta + 2 * np.pi * np.round((true_theta - theta).mean() / (2 * np.pi))
    centre = seen["core_center"]
    return np.column_stack(
        [centre.real, centre.imag, theta, np.angle(core / head), np.abs(head) + np.abs(core)]
    )
