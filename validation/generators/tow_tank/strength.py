"""Strengths at which an ideal detector sees each hidden effect at the sigma asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .filming import (
    FilmSetup,
    frame_times,
    keypoint_pixels,
    labelled_points,
    shaft_turns,
    stated_setup,
)
from .ideal import Noise, SimulatedMotion, detectability_sigmas
from .motion import HiddenLaw, simulate_motion
from .placing import draw_start_poses, frames_inside_pool
from .plan import FAINT, FIN_CAUSE, LEAST, MOST
from .robots import Array, ParallelTrials, Robot

SIMULATED_S = 11.5
LENGTH_STD_M = 5e-4
"""Error with which a length of the body is known to the user, m."""
SERVO_STD_RAD = np.deg2rad(0.3)
FREQUENCY_STD = 3e-3
"""Errors of head angle and flapping frequency that belong to a trial."""
MAX_SPEED = 8.0
"""No robot moves faster, m/s, or yaws faster, rad/s."""
WATER_AND_BODY_STAGES = ("water", "body")


class TooFaintError(ValueError):
    """No strength within the form's range is seen as wanted."""


@dataclass(frozen=True)
class StudySetup:
    """All of a study but the hidden strengths."""

    robot: Robot
    lanes: ParallelTrials
    pool: tuple[float, float, float]
    film: FilmSetup
    fps: float
    lengths: Array
    fin: tuple[HiddenLaw, ...]


def simulate_from_starts(
    setup: StudySetup, laws: Sequence[HiddenLaw], rng: np.random.Generator, placed: bool
) -> SimulatedMotion:
    """Motion with these laws; starts are drawn, and drawn again where a trial ends early."""
    sub = max(1, round(60 / setup.fps))
    fine = np.arange(int(SIMULATED_S * setup.fps) * sub + 1) / (setup.fps * sub)
    wanted = np.round(setup.lengths * setup.fps).astype(int)
    lanes = setup.lanes
    if not placed:
        free = [
            law
            for law in laws
            if law.form.stage not in WATER_AND_BODY_STAGES or law.form.cause == FIN_CAUSE
        ]
        away = replace(lanes, start=lanes.start + 0.5 * complex(*setup.pool[:2]))
        lanes = draw_start_poses(
            rng, lanes, _complex_path(simulate_motion(away, setup.robot, free, fine)), setup.pool
        )
    for attempt in range(2):
        states = simulate_motion(lanes, setup.robot, laws, fine)[::sub]
        if not np.all(np.isfinite(states)) or np.abs(states[:, 3:6]).max() > MAX_SPEED:
            raise TooFaintError("the motion diverges")
        frames = np.minimum(frames_inside_pool(_complex_path(states), setup.pool), wanted)
        if attempt or np.all(frames >= np.minimum(wanted, 3.5 * setup.fps)):
            break
        moved = draw_start_poses(rng, lanes, _complex_path(states), setup.pool)
        short = frames < np.minimum(wanted, 3.5 * setup.fps)
        lanes = replace(lanes, start=np.where(short, moved.start, lanes.start),
                        heading=np.where(short, moved.heading, lanes.heading))  # fmt: skip
    if np.any(frames < 2.5 * setup.fps):
        raise TooFaintError("a trial leaves the pool")
    return SimulatedMotion(lanes, setup.robot, laws, fine[::sub], states, frames)


def _complex_path(states: Array) -> Array:
    return states[:, 0] + 1j * states[:, 1]


def detector_noise(setup: StudySetup) -> Noise:
    """Noise of the ideal detector."""
    return setup.film.noise(setup.fps, setup.lanes)


def set_forces(
    setup: StudySetup, laws: Sequence[HiddenLaw], wanted: Sequence[float], rng: np.random.Generator
) -> tuple[SimulatedMotion, list[HiddenLaw], list[float], float | None]:
    """Motion, laws at their strengths, their sigma, and that of the fin.

    Raises: TooFaintError where no strength in range is seen at LEAST to MOST.
    """
    found, placed, search = list(laws), False, [_SecantSearch() for _ in laws]
    for _ in range(6):
        motion = simulate_from_starts(setup, [*setup.fin, *found], rng, placed)
        setup, placed = replace(setup, lanes=motion.lanes), True
        fin = [setup.fin] if setup.fin else []
        seen = detectability_sigmas(
            motion, detector_noise(setup), [*[[law] for law in found], *fin]
        )
        values = [_servo_bound(law, s, motion) for law, s in zip(found, seen, strict=False)]
        ratio = np.array(wanted) / np.maximum(values, 1e-6)
        if np.all((ratio > 0.85) & (ratio < 1.18)) or not found:
            break
        found = [_with_scaled_strength(law, s.step(law, v, w)) for law, s, v, w in
                 zip(found, search, values, wanted, strict=True)]  # fmt: skip
    if any(not LEAST <= v <= MOST for v in values):
        raise TooFaintError("out of reach")
    return motion, list(motion.laws[len(setup.fin) :]), values, float(seen[-1]) if fin else None


class _SecantSearch:
    """Secant rule for log sigma over log strength."""

    def __init__(self) -> None:
        self.last: tuple[float, float] | None = None

    def step(self, law: HiddenLaw, sigma: float, wanted: float) -> float:
        """Factor on the strength that should bring sigma to `wanted`."""
        here = (float(np.log(abs(law.strength))), float(np.log(max(sigma, 1e-6))))
        slope = 1.0
        if self.last and abs(here[0] - self.last[0]) > 0.02:
            slope = float(np.clip((here[1] - self.last[1]) / (here[0] - self.last[0]), 0.5, 4))
        self.last = here
        return float((wanted / max(sigma, 1e-6)) ** (1 / slope))


def _servo_bound(law: HiddenLaw, sigma: float, motion: SimulatedMotion) -> float:
    """The keypoints show an offset of the head; errors of the servo alone hide it."""
    if law.form.cause != "head_angle_offset":
        return float(sigma)
    more = np.deg2rad(law.strength) / SERVO_STD_RAD
    if law.form.name == "gain":
        more = more * np.sqrt(np.mean((motion.lanes.head_angle / 0.5) ** 2))
    return float(max(sigma, abs(more) * np.sqrt(len(motion.frames))))


def _with_scaled_strength(law: HiddenLaw, ratio: float, most: float | None = None) -> HiddenLaw:
    size = abs(law.strength) * float(np.clip(ratio, 0.04, 25))
    size = float(np.clip(size, law.form.low, min(law.form.high, most or np.inf)))
    return replace(law, strength=float(np.sign(law.strength) * size))


def set_fault(
    setup: StudySetup, motion: SimulatedMotion, fault: HiddenLaw, wanted: float, deepest: float
) -> tuple[HiddenLaw, float, float | None]:
    """The fault at its strength, its sigma, and the fin's. deepest: greatest depth, m.

    Raises: TooFaintError as `set_forces`.
    """
    most = deepest if fault.form.stage in ("sink", "depth") else None
    fin = [setup.fin] if setup.fin else []
    fault, search = _with_scaled_strength(fault, 1.0, most), _SecantSearch()
    for _ in range(7):
        change, direct = _apparent_change(setup, motion, fault)
        seen = detectability_sigmas(motion, detector_noise(setup), fin, [change])
        value = float(np.hypot(seen[-1], direct))
        if 0.85 < wanted / max(value, 1e-6) < 1.18:
            break
        fault = _with_scaled_strength(fault, search.step(fault, value, wanted), most)
    if not LEAST <= value <= MOST:
        raise TooFaintError("out of reach")
    return fault, value, float(seen[0]) if fin else None


def _apparent_change(
    setup: StudySetup, motion: SimulatedMotion, fault: HiddenLaw
) -> tuple[Array, float]:
    """Change of x, y and psi, (times, 3, lanes), and sigma of lengths, head angles and beats."""
    said = stated_setup(setup.film, setup.robot, fault)
    out = np.zeros((len(motion.times), 3, len(motion.frames)))
    turns = shaft_turns(motion, np.zeros(len(motion.frames)), 0.05, SIMULATED_S)
    rigid = []
    for k, n in enumerate(motion.frames):
        seen = labelled_points(motion, k, turns, fault, None)
        px = keypoint_pixels(setup.film.camera, seen, motion, k, fault)
        back = said.back(px.reshape(-1, 2)).reshape(n, -1)
        state = motion.states[:n, :3, k]
        psi = np.angle((back[:, 1] - back[:, 3]) * np.exp(-1j * state[:, 2]))
        shift = back[:, 2] - (state[:, 0] + 1j * state[:, 1])
        out[:n, :, k] = np.column_stack([shift.real, shift.imag, psi])
        rigid.append(
            _mean_rigid_lengths(back) - _true_lengths(setup.robot, float(motion.lanes.head[k]))
        )
    if not np.all(np.isfinite(out)):
        raise TooFaintError("the stated lens has no inverse")
    direct = float(np.linalg.norm(np.sqrt(np.mean(np.square(rigid), 0)) / LENGTH_STD_M))
    if fault.form.cause == "clock_error":
        m = [fault.form.law(frame_times(motion, k), fault.strength, fault.shape)[-1]
             / motion.times[n - 1] - 1 for k, n in enumerate(motion.frames)]  # fmt: skip
        direct = float(np.linalg.norm(m) / FREQUENCY_STD)
    return out, direct


def _mean_rigid_lengths(at: Array) -> Array:
    """Mean nose-hinge, hinge-core and hinge-base distances, and the core's side offset, m."""
    nose, hinge, core, base = at[:, 0], at[:, 1], at[:, 2], at[:, 3]
    axis = (hinge - base) / np.maximum(np.abs(hinge - base), 1e-9)
    side = ((core - hinge) * np.conj(axis)).imag
    return np.array([np.abs(nose - hinge).mean(), np.abs(hinge - core).mean(),
                     np.abs(hinge - base).mean(), side.mean()])  # fmt: skip


def _true_lengths(robot: Robot, head: float) -> Array:
    behind = robot.body_length - robot.head_length
    return np.array([head, robot.hinge_to_com, behind, 0.0])


def draw_target_sigma(rng: np.random.Generator) -> float:
    """A sigma between faint and clear, even on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(1.15 * LEAST), np.log(0.85 * MOST))))


def visibility_group(values: Sequence[float]) -> str:
    """Group of a study with one hidden cause."""
    return "faint" if min(values) < FAINT else "clear"
