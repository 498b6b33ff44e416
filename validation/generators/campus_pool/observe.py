"""From paths to keypoints in the pool, and through the true and the stated optics."""

from __future__ import annotations

from typing import Any

import numpy as np

from .dynamics import Flow
from .optics import Stated, corner_points, place, see, see_mark, with_pose
from .registry import Law
from .simulate import Path
from .world import World

NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
SEEN = 4


class Scene:
    """Working state of an observation; laws of the later stages read and change it."""

    def __init__(self, world: World, path: Path) -> None:
        """Prepare depth, clock and camera without hidden errors."""
        rb = world.robot
        self.world, self.k, self.fps = world, world.trials, world.fps
        self.t = np.broadcast_to(path.t, path.phi.shape)
        self.duration, self.size, self.span = world.duration, rb.body, rb.span
        self.phi = path.phi
        self.core = np.exp(1j * (path.state[2] + path.phi))
        self.points: list[np.ndarray] = []
        self.depth: Any = rb.depth + 0 * path.phi
        speed = np.hypot(path.state[3], path.state[4])
        gap = np.diff(self.t, axis=1, prepend=self.t[:, :1])
        self.travel = np.cumsum(speed * gap, axis=1)
        self.reach = world.scales.speed * world.duration
        self.delay: Any = 0.0 * path.phi
        self.turn: Any = None
        self.move: Any = None
        self.true = world
        self.stated = stated_base(world)


def stated_base(world: World) -> Stated:
    """A statement without hidden errors (the corners are filled in later)."""
    return Stated(
        world.camera.copy(),
        world.pool.length,
        world.pool.width,
        world.index,
        world.stated_robot.depth,
        world.extra["mark_height"],
    )


def finish_stated(world: World, stated: Stated) -> Stated:
    """Fill in the corner pixels as the true camera sees the marks."""
    marks = corner_points(
        world.pool.length, world.pool.width, world.extra["mark_height"], stated.inset
    )
    stated.corners = see_mark(world.camera, marks)
    return stated


def mass_offset(world: World, path: Path, laws: list[Law]) -> Any:
    """Offset of the true mass from its stated place, in core axes."""
    shifts = [law for law in laws if law.name == "centre_of_mass_shift"]
    if not shifts:
        return 0.0
    w = Flow(world, path.t, path.state)
    w.phi = path.phi
    w.relative()
    for law in shifts:
        law.apply(w)
    return w.com


def keypoints(
    world: World,
    path: Path,
    laws: list[Law],
    *,
    recoil: Any = 0.0,
    sway: Any = 0.0,
    tail: Any = 0.0,
    sizes: Any = None,
) -> list[np.ndarray]:
    """Pool positions of the five labels.  `recoil` and `tail` are angles, `sway` a length."""
    rb = world.robot
    head, front, core_length = world.trials.head, rb.hinge_to_com, rb.core
    if sizes is not None:
        head, front, core_length = head * sizes[0], front * sizes[1], core_length * sizes[2]
    scene = Scene(world, path)
    core = scene.core * np.exp(1j * recoil)
    nose = np.exp(1j * (path.state[2] + recoil))
    mass = path.state[0] + 1j * path.state[1]
    centre = mass - mass_offset(world, path, laws) * core + 1j * core * sway
    hinge = centre + front * core
    base = hinge - core_length * core
    scene.points = [
        hinge + head * nose,
        hinge,
        centre,
        base,
        base - rb.tail * core * np.exp(1j * tail),
    ]
    for law in laws:
        if law.stage == "label":
            law.apply(scene)
    return scene.points


def delays(world: World, path: Path, laws: list[Law]) -> np.ndarray:
    """True time minus believed time of the frames."""
    scene = Scene(world, path)
    for law in laws:
        if law.stage == "clock":
            law.apply(scene)
    return np.asarray(scene.delay)


def optical(laws: list[Law]) -> list[Law]:
    """The laws that act through the camera."""
    return [law for law in laws if law.stage in ("optics", "depth")]


def project(
    world: World, path: Path, points: list[np.ndarray], laws: list[Law]
) -> tuple[list[np.ndarray], Stated]:
    """Pixels of the labels as the true camera sees them, and the statement of the optics."""
    scene = Scene(world, path)
    for law in optical(laws):
        law.apply(scene)
    depth = np.minimum(scene.depth, world.pool.depth - 0.3 * world.robot.span)
    pixels = [
        see(world.camera, p, depth, world.index, turn=scene.turn, move=scene.move) for p in points
    ]
    return pixels, finish_stated(world, scene.stated)


def reread(stated: Stated, pixels: list[np.ndarray]) -> list[np.ndarray]:
    """Pool positions that follow from the statement."""
    cam = with_pose(stated)
    return [place(cam, p, stated.depth, stated.index) for p in pixels]


def optical_shift(
    world: World, path: Path, points: list[np.ndarray], laws: list[Law]
) -> np.ndarray:
    """Displacement (SEEN, K, N) of the read labels by the optical laws."""
    pixels, stated = project(world, path, points[:SEEN], laws)
    read = reread(stated, pixels)
    return np.stack(read) - np.stack(points[:SEEN])
