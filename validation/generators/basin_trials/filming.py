"""The trials as they are swum and filmed: motor, head angle, frames, pixels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .body_laws import depth_gained
from .catalogue import INPUT
from .design import StudySetup
from .faults import Fault, draw_bump, draw_delays, misplaced
from .form import Array, HiddenLaw, Quantity
from .head_laws import mass_shift
from .keypoints import FilmedPoses, body_points, pixels_of
from .motion import STATE_SIZE, act, integrate, situation
from .trials import inside_pool

LOG_STEP = 0.005
"""Interval of a motor log, s."""
WALL_GAP = 0.1
"""Distance (m) to a wall at which a trial ends."""
LEAST_TRIAL_S = 2.0
STEP_RATE = 100
"""Least number of integration steps per second."""
TAIL_BUILD_UP_S = 0.35


def drive(
    times: Array, setup: StudySetup, laws: Sequence[HiddenLaw], trial: int
) -> tuple[Array, Array]:
    """True frequency (Hz) and head angle (rad) of a trial, with the laws of motor and servo."""
    runs = setup.true_runs.take(np.full(len(times), trial))
    state = np.zeros((STATE_SIZE, len(times)))
    now = situation(np.maximum(times, 0), state, runs, setup.robot, None)
    act(now, laws, INPUT)
    return now.f * (times >= 0), now.phi * np.ones(len(times))


def shaft_turns(
    setup: StudySetup, laws: Sequence[HiddenLaw], trial: int, end: float
) -> tuple[Array, Array]:
    """Times every 5 ms from the start of the motor to `end` (s), and turns of the shaft since."""
    times = np.arange(0, end, LOG_STEP)
    f, _ = drive(times, setup, laws, trial)
    return times, np.concatenate([[0], np.cumsum((f[1:] + f[:-1]) / 2) * LOG_STEP])


def film(
    rng: np.random.Generator, setup: StudySetup, laws: Sequence[HiddenLaw],
    fault: Fault | None, fps: float,
) -> Iterator[tuple[Array, Array]]:  # fmt: skip
    """For each trial: pixels (frames, 5, 2), and times (frames,) since the start of the motor."""
    idle = np.round(draw_delays(rng, fault, setup.trials) * fps).astype(int)
    frames = int(np.ceil(setup.duration.max() * fps))
    steps = int(np.ceil(STEP_RATE / fps))
    path = integrate(
        setup.start, setup.true_runs, setup.robot, laws=laws, water=setup.water,
        step=1 / fps / steps, count=frames, every=steps,
    )  # fmt: skip
    bump = draw_bump(rng, fault, setup.camera, setup.trials)
    for trial in range(setup.trials):
        states = path[:, :, trial]
        swum = np.arange(frames + 1) <= setup.duration[trial] * fps
        free = inside_pool(states[:, 0], states[:, 1], WALL_GAP) & swum
        last = max(int(np.cumprod(free).sum()), int(LEAST_TRIAL_S * fps))
        rows = np.arange(last + idle[trial]) - idle[trial]
        times = rows / fps
        poses = _poses(setup, laws, trial, states[np.maximum(rows, 0)], times)
        points, psi = body_points(setup.robot, poses, setup.noise)
        points = misplaced(fault, points, psi, poses.phi)
        camera, later = setup.camera, None
        if bump and trial == bump.trial:
            later = (int(bump.share * len(rows)), bump.camera)
        elif bump and trial > bump.trial:
            camera = bump.camera
        yield pixels_of(camera, points, poses.depth, later), times


def _poses(
    setup: StudySetup, laws: Sequence[HiddenLaw], trial: int, states: Array, times: Array
) -> FilmedPoses:
    """Poses of the states (frames, 8) of a trial at these times (frames,)."""
    _, phi = drive(times, setup, laws, trial)
    turned = np.interp(times, *shaft_turns(setup, laws, trial, times[-1] + 0.1))
    turns = setup.first_turn[trial] + turned
    growth = 1 - np.exp(-np.maximum(times, 0) / TAIL_BUILD_UP_S)
    beat = np.exp(2j * np.pi * turns + 1j * setup.tail_phase) * growth
    head = setup.true_runs.head[trial]
    depth = np.full(len(times), setup.robot.keypoint_depth)
    shift: Quantity = 0.0
    for law in laws:
        if law.name == "sinking":
            depth = depth + depth_gained(np.maximum(times, 0), law)
        if law.name == "centre_of_mass_shift":
            shift = mass_shift(setup.robot, head, law)
    place = states[:, 0] + 1j * states[:, 1]
    return FilmedPoses(place, states[:, 2], phi, depth, beat, head, shift)
