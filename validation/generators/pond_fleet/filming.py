"""The recording of a session: labelled points in the image and the motor's shaft."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .camera import Camera
from .dynamics import SHAFT, THETA, Motion, Plant, X, Y, flow_at, integrate
from .eddies import Eddies
from .experiment import settled
from .faults import INDEX, Fault, Scene, label_shift, shift_course
from .law import Law
from .robots import Array, Robot
from .tracker import Tracker, track
from .trials import plain_plant

STEPS = 1200
LOG_INTERVAL = 0.005
"""Time between values of the motor log (s)."""
NEAREST = 0.03
"""A recording ends when a label comes this near to a wall, in body lengths."""


@dataclass(frozen=True)
class Campaign:
    """All that is filmed. phase: of the tail beat in each trial (turns)."""

    scene: Scene
    laws: Sequence[Law]
    fault: Fault | None
    eddies: Eddies
    tracker: Tracker
    fps: float
    phase: Array


@dataclass(frozen=True)
class Take:
    """Labels (frames, 5, 2) in px with likelihoods, and the shaft's angle (turns) at log times (s).

    path: true centre of mass (frames, 2) in m. flap: true frequency over the last two thirds (Hz).
    """

    seen: Array
    likelihood: Array
    log_times: Array
    log_turns: Array
    path: Array
    flap: float


def full_plant(campaign: Campaign) -> Plant:
    """The session's model with its laws, water and the errors of each trial."""
    session = campaign.scene.session
    erring = replace(session, phi=session.phi + session.servo_error)
    plant = plain_plant(campaign.scene.robot, campaign.scene.pool, erring)
    return replace(plant, laws=tuple(campaign.laws), unrest=campaign.eddies,
                   thrust_factor=session.quality)  # fmt: skip


def takes(rng: np.random.Generator, campaign: Campaign) -> Iterator[Take]:
    """The recording of each trial."""
    session = campaign.scene.session
    plant = full_plant(campaign)
    motion = integrate(plant, settled(plant, session.start), STEPS)
    angle, forward, port = _body_angles(plant, motion)
    for trial in range(session.count):
        own = (angle[:, trial], forward[:, trial], port[:, trial])
        yield _film(rng, campaign, motion, own, trial)


def _body_angles(plant: Plant, motion: Motion) -> tuple[Array, Array, Array]:
    """Head angle (rad), and centre of mass from the core's label (m), (instants, columns)."""
    found = [flow_at(plant, t, y) for t, y in zip(motion.times, motion.states, strict=True)]
    angle = np.array([flow.phi for flow, _ in found])
    forward, port = (np.array([offset[i] for _, offset in found]) for i in (0, 1))
    return angle, forward, port


def _film(
    rng: np.random.Generator, campaign: Campaign, motion: Motion, own: tuple[Array, Array, Array],
    trial: int,
) -> Take:  # fmt: skip
    scene, fault = campaign.scene, campaign.fault
    duration = float(scene.session.duration[trial])
    delay, rate = _timing(campaign, trial)
    stated = np.arange(int((duration + delay) * campaign.fps) + 1) / campaign.fps
    time = stated / rate
    moving = np.clip(time - delay, 0, duration)
    state = motion.column_at(trial, moving)
    now = [np.interp(moving, motion.times[:, trial], values) for values in own]
    labels = _labels(campaign, state, now, trial)
    kept = _clear_frames(labels, scene)
    x, y = labels[:kept].real, labels[:kept].imag
    pixels = scene.camera.film(x, y, scene.depth, INDEX)
    if fault is not None and fault.name == "camera_shift":
        pixels = _shifted(pixels, fault, scene, trial, moving[:kept] / duration)
    seen, likelihood = track(rng, campaign.tracker, pixels, campaign.fps)
    log_times = np.arange(int(time[kept - 1] / LOG_INTERVAL) + 1) * LOG_INTERVAL
    turns = motion.column_at(trial, np.minimum(log_times, duration))[SHAFT]
    turns = turns + campaign.phase[trial]
    third = len(turns) // 3
    flap = (turns[-1] - turns[third]) / (log_times[-1] - log_times[third])
    return Take(seen, likelihood, log_times, turns, state[[X, Y], :kept].T, float(flap))


def _timing(campaign: Campaign, trial: int) -> tuple[float, float]:
    """Delay of the motion (s) and true over stated frame rate."""
    fault = campaign.fault
    if fault is not None and fault.name == "clock_error":
        return 0.0, 1 + fault.size * float(fault.strength[trial])
    if fault is not None and fault.name == "time_offset":
        return fault.size * float(fault.strength[trial]) * campaign.scene.robot.body_time, 1.0
    return 0.0, 1.0


def _labels(campaign: Campaign, state: Array, now: Sequence[Array], trial: int) -> Array:
    """Places of the five labels in the pool (m), complex, (frames, 5)."""
    scene, fault = campaign.scene, campaign.fault
    robot, session = scene.robot, scene.session
    phi, forward, port = now
    beat = 2 * np.pi * (state[SHAFT] + campaign.phase[trial])
    theta = state[THETA] + robot.recoil * np.sin(beat)
    ahead = np.exp(1j * theta)
    behind = np.exp(1j * (theta + phi))
    centre = state[X] + 1j * state[Y] - (forward + 1j * port) * ahead
    centre = centre + 1j * behind * 0.3 * robot.recoil * robot.hinge_to_com * np.cos(beat)
    hinge = centre + robot.hinge_to_com * behind
    tip = hinge + session.head[trial] * ahead
    base = centre - robot.aft_length * behind
    tail = base - robot.tail_length * behind * np.exp(1j * robot.tail_swing * np.sin(beat - 1.3))
    if fault is not None and fault.name == "keypoint_bias":
        along, across, _ = label_shift(fault, robot, phi)
        centre = centre + (along + 1j * across) * ahead
        if fault.form == "hinge_to_port":
            hinge = hinge + 1j * fault.size * robot.body_length * ahead
    return np.stack([tip, hinge, centre, base, tail], axis=-1)


def _clear_frames(labels: Array, scene: Scene) -> int:
    """Frames before a label comes too near to a wall; at least two."""
    edge = NEAREST * scene.robot.body_length
    length, width = scene.pool
    inside = (
        (labels.real > edge) & (labels.real < length - edge)
        & (labels.imag > edge) & (labels.imag < width - edge)
    ).all(axis=1)  # fmt: skip
    return max(2, len(inside) if inside.all() else int(np.argmin(inside)))


def _shifted(pixels: Array, fault: Fault, scene: Scene, trial: int, share: Array) -> Array:
    """Pixels after the camera has moved: shifted, and twisted about the image's centre."""
    moved, twist = shift_course(fault, share, np.full(len(share), trial))
    camera: Camera = scene.camera
    length = scene.robot.body_length
    scale = camera.focal[0] / float(camera.position[2])
    shift = fault.size * length * scale * moved * np.exp(-1j * fault.direction)
    turn = np.exp(-1j * fault.size * twist * length / scene.pool[1])
    centre = complex(*camera.centre)
    place = pixels[..., 0] + 1j * pixels[..., 1] - centre
    place = place * turn[:, None] + shift[:, None] + centre
    return np.stack([place.real, place.imag], axis=-1)


def metres_per_px(camera: Camera) -> float:
    """Size of a pixel at the surface below the camera (m)."""
    return float(camera.position[2]) / camera.focal[0]


def body_lengths_swum(robot: Robot, take: Take) -> float:
    """Length of a take's path in body lengths."""
    return float(np.hypot(*np.diff(take.path, axis=0).T).sum() / robot.body_length)
