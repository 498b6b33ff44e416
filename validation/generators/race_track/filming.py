"""From motions to labels: frames, recoil of the beat, tail, depth, camera, tracker.

Recoil and the swing of the tail are added to the motion that the forces see: at first order they
have no mean effect, and at second order they would act as a linear yaw damping that is hidden in no
study.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from .camera import Camera
from .drive_laws import sink_share
from .faults import Fault, frame_times, moved_labels, moved_pixels, wait
from .form import Law
from .labels import Tracker, detected
from .loads import flapping
from .motion import TURNS, Path, Z, at_rest, integrate
from .robots import Array, Robot
from .trials import MARGIN, Schedule, bench_of, inside
from .water import Unrest

STEP = 1 / 120
LOG_STEP = 0.005
SINK_DEPTH = 0.5
"""Depth gained at the horizon, in body lengths, by unit of the share of drag."""
BEAT_PHASE, SWAY_PHASE, TAIL_PHASE = 0.6, 2.1, 0.0


@dataclass(frozen=True)
class Campaign:
    """All that is true of a study's trials. first: shaft angle at the start (turns)."""

    robot: Robot
    pool: tuple[float, float]
    depth: float
    schedule: Schedule
    laws: Sequence[Law]
    unrest: Unrest
    fault: Fault | None
    camera: Camera
    tracker: Tracker
    fps: float
    first: Array

    @property
    def scale(self) -> float:
        """Pixels by metre near the middle of the pool."""
        return self.camera.focal[0] / float(self.camera.position[2])


@dataclass(frozen=True)
class Take:
    """Labels, likelihoods, log (times, turns) and steady frequency of a trial."""

    seen: Array
    sure: Array
    log: tuple[Array, Array]
    flap: float
    duration: float


def swim(campaign: Campaign) -> Path:
    """Motion of all trials, with unrest, errors of servo and thrust, and pulsing thrust."""
    schedule = campaign.schedule
    bench = bench_of(campaign.robot, campaign.pool, schedule, laws=campaign.laws,
                     unrest=campaign.unrest, ripple=campaign.robot.ripple)  # fmt: skip
    y = at_rest(bench, schedule.z, schedule.psi, campaign.first)
    return integrate(bench, y, float(schedule.duration.max()) + 0.1, STEP)


def takes(rng: np.random.Generator, campaign: Campaign) -> Iterator[Take]:
    """What is recorded of each trial."""
    path = swim(campaign)
    for trial in range(campaign.schedule.count):
        yield _take(rng, campaign, path, trial)


def _last_sample(campaign: Campaign, path: Path, trial: int) -> int:
    """Sample at which the recording ends."""
    margin = MARGIN * campaign.robot.body_length
    stays = np.logical_and.accumulate(inside(path.y[:, Z, trial], campaign.pool, margin))
    late = path.times > campaign.schedule.duration[trial]
    return max(int((stays & ~late).sum()) - 1, 30)


def _take(rng: np.random.Generator, campaign: Campaign, path: Path, trial: int) -> Take:
    fault, fps = campaign.fault, campaign.fps
    end = float(path.times[_last_sample(campaign, path, trial)])
    lead = wait(fault, trial)
    rate = frame_times(fault, trial, 2, fps)[1] * fps
    times = frame_times(fault, trial, int((end + lead) / rate * fps), fps) - lead
    z, psi, phi, turns = _interpolated(path, trial, times)
    points = _points(campaign, trial, z, psi, phi=phi, turns=turns, times=times)
    points = moved_labels(fault, points, psi, phi)
    sunk = campaign.robot.keypoint_depth + _sunk(campaign, times)
    pixels = campaign.camera.film(points, np.broadcast_to(sunk[:, None], points.shape))
    pixels = moved_pixels(fault, trial, pixels, scale=campaign.scale,
                          centre=np.array(campaign.camera.centre))  # fmt: skip
    seen, sure = detected(rng, campaign.tracker, pixels, fps)
    clock = np.arange(0, end, LOG_STEP)
    return Take(seen, sure, (clock, _interpolated(path, trial, clock)[3]),
                _steady_flap(campaign, trial, end), len(times) / fps)  # fmt: skip


def _interpolated(path: Path, trial: int, times: Array) -> tuple[Array, Array, Array, Array]:
    """z, psi, phi and shaft turns at given times; before the start as at the start."""
    t = np.clip(times, 0, path.times[-1])
    z = path.y[:, Z, trial]
    columns = np.stack([z.real, z.imag, path.psi[:, trial], path.y[:, TURNS, trial].real], axis=1)
    x, y, psi, turns = CubicSpline(path.times, columns)(t).T
    return x + 1j * y, psi, np.interp(t, path.times, path.phi[:, trial]), turns


def _points(
    campaign: Campaign, trial: int, z: Array, psi: Array, *, phi: Array, turns: Array, times: Array
) -> Array:
    """Labels (frames, 5), complex: head tip, hinge, core, tail base and tip."""
    robot, beat = campaign.robot, 2 * np.pi * turns
    swing = robot.recoil * (1 - np.exp(-np.maximum(times, 0) * campaign.schedule.flap[trial]))
    bench = bench_of(robot, campaign.pool, campaign.schedule, laws=campaign.laws)
    for law in bench.hooked("centre"):
        z = z - law(phi, robot) * np.exp(1j * psi)
    z = z + 0.25j * robot.body_length * swing * np.cos(beat + SWAY_PHASE) * np.exp(1j * psi)
    psi = psi + swing * np.cos(beat + BEAT_PHASE)
    core, back = np.exp(1j * psi), robot.body_length - robot.head_length - robot.hinge_to_com
    hinge, base = z + robot.hinge_to_com * core, z - back * core
    tip = base - robot.tail_length * core * np.exp(0.4j * np.cos(beat + TAIL_PHASE))
    nose = hinge + campaign.schedule.head[trial] * np.exp(1j * (psi - phi))
    return np.stack([nose, hinge, z, base, tip], axis=1)


def _sunk(campaign: Campaign, times: Array) -> Array:
    """Depth gained (m), held above the floor."""
    gained, t = np.zeros(len(times)), np.maximum(times, 0)
    for law in campaign.laws:
        if law.family.name == "sinking":
            gained = gained + SINK_DEPTH * law.size * campaign.robot.body_length * sink_share(
                t, law.form
            )
    return np.minimum(gained, campaign.depth - 0.02 - campaign.robot.keypoint_depth)


def _steady_flap(campaign: Campaign, trial: int, end: float) -> float:
    """Mean frequency (Hz) over the second half, as a stroboscope gives it."""
    bench = bench_of(campaign.robot, campaign.pool, campaign.schedule, laws=campaign.laws)
    half = [flapping(bench, t)[trial] for t in np.linspace(end / 2, end, 12)]
    return float(np.mean(half) * (1 + campaign.schedule.logged[trial]))
