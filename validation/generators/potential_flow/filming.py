"""From motion to keypoints: body points, recoil, labels, exposure, picture, and the way back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from .form import HiddenForm
from .impulse import Motion, StudyWorld
from .lanes import ParallelTrials
from .lens import Camera, draw_camera, pool_corners, with_fitted_pose
from .tracker import KEYPOINT_NAMES, Tracker, draw_tracker

LABEL_STD_M = 0.35e-3
"""Standard deviation of a label's place on each axis, m; drawn values are below 0.7 mm."""


@dataclass(frozen=True)
class Recoil:
    """Amplitudes and phases of what the beat adds to the mean motion of the body."""

    yaw: float
    """rad."""
    sway: float
    """m, across the core."""
    lag: float
    """rad behind the shaft."""
    tail: float
    """Amplitude of the tail's angle, rad."""


@dataclass(frozen=True)
class FilmSetup:
    """Camera, tracker, recoil and labels of a study."""

    camera: Camera
    tracker: Tracker
    recoil: Recoil
    labels: np.ndarray
    """(5,) complex offsets, m: tip in the head's axes, the others in the core's."""


def draw_film(rng: np.random.Generator, pool, depth: float) -> FilmSetup:
    """Recoil of 1 to 3.5 degrees and 1 to 4 mm."""
    recoil = Recoil(np.deg2rad(rng.uniform(1.0, 3.5)), rng.uniform(1e-3, 4e-3),
                    rng.uniform(-np.pi, np.pi), rng.uniform(0.2, 0.45))  # fmt: skip
    labels = np.clip(LABEL_STD_M * rng.normal(size=(2, 5)), -2 * LABEL_STD_M, 2 * LABEL_STD_M)
    return FilmSetup(
        draw_camera(rng, pool, depth), draw_tracker(rng), recoil, labels[0] + 1j * labels[1]
    )


def interpolate_rows(values: np.ndarray, step: float, t: np.ndarray) -> np.ndarray:
    """Rows of `values` (times, n) at the times `t`, linear between steps, held outside."""
    at = np.clip(t / step, 0, len(values) - 1.001)
    i = at.astype(int)
    w = (at - i)[:, None]
    return values[i] * (1 - w) + values[i + 1] * w


def keypoint_positions(
    world: StudyWorld, film: FilmSetup, motion: Motion, lanes: ParallelTrials, *, columns, t
) -> np.ndarray:
    """(frames, columns, 5) true places of the labelled points in the pool, complex, m."""
    step = motion.times[1]
    place, theta, phi, phase = (
        interpolate_rows(v[:, columns], step, t)
        for v in (motion.place, motion.heading, motion.angle, motion.phase)
    )
    craft, recoil = world.craft, film.recoil
    beat = np.sin(phase - recoil.lag) * (t > 0)[:, None]
    theta = theta + recoil.yaw * beat
    head, core = np.exp(1j * theta), np.exp(1j * (theta + phi))
    s = SimpleNamespace(phi=phi, head=lanes.head[columns], craft=craft)
    shift = 0.0
    for i, law in enumerate(world.laws):
        if law.form.stage == "balance":
            shift = law(s, lanes.strengths[i, columns])
    centre = place - shift * head + 1j * core * recoil.sway * beat
    hinge = centre + core * craft.hinge_to_com
    base = centre - core * craft.stern
    bent = core * np.exp(1j * recoil.tail * np.sin(phase))
    out = np.stack(
        [hinge + head * s.head, hinge, centre, base, base - bent * craft.tail_length], -1
    )
    axes = np.stack([head, core, core, core, core], -1)
    return out + axes * film.labels


def exposure_times(
    fault: HiddenForm | None, lanes: ParallelTrials, trial: int, t, trials: int
) -> np.ndarray:
    """True times of the frames with nominal times `t`."""
    if fault is None or fault.form.stage != "exposure":
        return t
    return fault(SimpleNamespace(t=t, order=trial, power=lanes.power[trial], trials=trials))


def keypoint_pixels(
    world: StudyWorld,
    film: FilmSetup,
    motion: Motion,
    lanes: ParallelTrials,
    *,
    trial: int,
    t,
    fault: HiddenForm | None = None,
) -> np.ndarray:
    """(frames, 5, 2) pixels of the points at the frames' nominal times `t`, without errors."""
    true = exposure_times(fault, lanes, trial, t, motion.place.shape[1])
    points = keypoint_positions(world, film, motion, lanes, columns=[trial], t=true)[:, 0]
    stage = fault.form.stage if fault else ""
    if stage == "label":
        points = points + _label_bias(fault, motion, trial, true)
    depth = film.camera.depth
    if stage == "depth":
        depth = depth + fault(SimpleNamespace(t=true))[:, None]
    px = film.camera.see(points, depth)
    if stage == "picture":
        s = SimpleNamespace(px=px, t=t, order=trial, centre=np.array(film.camera.size) / 2)
        px = fault(s)
    return px


def _label_bias(fault: HiddenForm, motion: Motion, trial: int, t) -> np.ndarray:
    step = motion.times[1]
    theta = interpolate_rows(motion.heading[:, [trial]], step, t)
    phi = interpolate_rows(motion.angle[:, [trial]], step, t)
    axes = np.exp(1j * (theta + phi * np.array([0.0, 1, 1, 1, 1])))
    return axes * fault(SimpleNamespace(phi=phi[:, 0]))


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml says of the camera and the pool, and the corners' pixels."""

    camera: Camera
    pool: tuple[float, float, float]
    corners: np.ndarray


def stated_setup(world: StudyWorld, film: FilmSetup, fault: HiddenForm | None) -> StatedSetup:
    """The truth, unless the fault is one of the statement."""
    camera, pool = film.camera, world.pool
    if fault is not None and fault.form.stage == "stated":
        camera, pool = fault(SimpleNamespace(camera=camera, pool=pool))
    return StatedSetup(camera, pool, film.camera.project(pool_corners(world.pool)))


def stated_camera(said: StatedSetup) -> Camera:
    """The camera by which pixels are mapped back: the stated one, its pose from the corners."""
    return with_fitted_pose(said.camera, said.pool, said.corners)


def with_strength(fault: HiddenForm, k: float) -> HiddenForm:
    """The same fault with another strength."""
    return replace(fault, strength=k)


__all__ = [
    "KEYPOINT_NAMES",
    "LABEL_STD_M",
    "FilmSetup",
    "Recoil",
    "StatedSetup",
    "draw_film",
    "exposure_times",
    "interpolate_rows",
    "keypoint_pixels",
    "keypoint_positions",
    "stated_camera",
    "stated_setup",
    "with_strength",
]  # fmt: skip
