"""How many standard deviations an ideal detector sees of each hidden strength.

It knows every form, the camera and the noise. Its unknowns are the strengths, the six coefficients
and the labels' places (of the study), and of each trial the starting state, the errors of servo and
frequency, the water's drift and eddies, each with its true spread. Columns are finite differences
of the simulated keypoints; the tracker's ARMA filter whitens them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from .drive import MEMORY, WANDER, drive
from .eddies import MODES
from .filming import (
    LABEL,
    Film,
    Statement,
    at_strength,
    exposure,
    pixels,
    reader,
    skeleton,
    statement,
)
from .form import Hidden
from .impulse import STEP, Motion, World, swim
from .lanes import FLAP_ERROR, SERVO_ERROR, Lanes, tiled

SMALL = 1e-4
"""Step of the finite differences, in units of each unknown's own size."""
SEEN = 4
"""Keypoints used: all but the tail's tip."""


@dataclass(frozen=True)
class Run:
    """A study's world, trials and film, ready to be simulated."""

    world: World
    lanes: Lanes
    film: Film
    fps: float
    frames: np.ndarray
    """(trials,)."""
    logged: bool
    """Whether the phase of the beat is known from motor logs."""
    fault: Hidden | None = None


def unknowns(run: Run) -> tuple[list[tuple[str, tuple[int, ...], np.ndarray | float]], int]:
    """(field, row, size) of each simulated unknown, and how many are the study's (first)."""
    lanes, water = run.lanes, run.world.water
    study = [("coefficients", (i,), lanes.coefficients[i, 0]) for i in range(6)]
    study += [("strengths", (i,), lanes.strengths[i, 0]) for i in range(len(run.world.laws))]
    start = [("start", (i,), size) for i, size in enumerate((0.01, 0.01, 0.02, 0.01, 0.01, 0.02))]
    own = [("servo", (), SERVO_ERROR), ("flap", (), FLAP_ERROR * lanes.flap)]
    own += [("drift", (i,), water.drift) for i in range(2)]
    own += [("eddies", (m, i), water.eddy) for m in range(MODES) for i in range(2)]
    return study + start + own, len(study)


def simulated(run: Run, seconds: float) -> tuple[Motion, Lanes]:
    """All lanes as they are, and once more for each unknown changed by SMALL of its size."""
    rows, n = unknowns(run)[0], len(run.lanes)
    many = tiled(run.lanes, len(rows) + 1)
    changed = {name: np.array(getattr(many, name)) for name in {r[0] for r in rows}}
    for i, (name, row, size) in enumerate(rows, start=1):
        changed[name][(*row, slice(i * n, (i + 1) * n))] += SMALL * size
    many = replace(many, **changed)
    return swim(run.world, many, seconds), many


def _white(run: Run, columns: np.ndarray) -> np.ndarray:
    """(8 frames, columns) real and white, from (frames, columns, SEEN) complex metres."""
    tracker, camera = run.film.tracker, run.film.camera
    a, b, scale = tracker.arma(run.fps)
    metre = camera.pose[5] / camera.focal
    unit = scale[:SEEN] * metre / np.sqrt(tracker.sharpness)
    z = lfilter([1, -a], [1, b], columns / unit, axis=0)
    flat = np.moveaxis(z, 1, 2).reshape(-1, columns.shape[1])
    return np.concatenate([flat.real, flat.imag])


def _labels(motion: Motion, trial: int, t) -> np.ndarray:
    """(frames, 8, SEEN) effect of each label's place by LABEL."""
    step = motion.times[1]
    i = np.clip((t / step).astype(int), 0, len(motion.times) - 1)
    theta, phi = motion.heading[i, trial], motion.angle[i, trial]
    out = np.zeros((len(t), 2 * SEEN, SEEN), dtype=complex)
    for point in range(SEEN):
        axis = LABEL * np.exp(1j * (theta + phi * (point > 0)))
        out[:, 2 * point, point], out[:, 2 * point + 1, point] = axis, 1j * axis
    return out


def _lag(run: Run, motion: Motion, many: Lanes, trial: int, t) -> np.ndarray:
    """(frames, 1, SEEN) effect of the recoil's phase."""
    late = replace(run.film, recoil=replace(run.film.recoil, lag=run.film.recoil.lag + 1e-4))
    pair = [
        skeleton(run.world, f, motion, many, columns=[trial], t=t)[..., :SEEN]
        for f in (run.film, late)
    ]
    return (pair[1] - pair[0]) / 1e-4


def _fault(run: Run, said: tuple[Statement, Statement], motion: Motion, many: Lanes, *,
           trial: int, t) -> np.ndarray:  # fmt: skip
    """(frames, 1, SEEN) effect of the fault, at its strength, on the mapped keypoints."""
    base, moved = (
        reader(s).back(
            pixels(run.world, run.film, motion, many, trial=trial, t=t, fault=fault)[:, :SEEN]
        )
        for s, fault in zip(said, (at_strength(run.fault, 0.0), run.fault), strict=True)
    )
    return (moved - base)[:, None]


def _columns(run: Run, motion: Motion, many: Lanes, trial: int, said) -> tuple[np.ndarray, ...]:
    """White columns of the study's unknowns and of the trial's own."""
    n, (rows, study) = len(run.lanes), unknowns(run)
    nominal = np.arange(run.frames[trial]) / run.fps
    t = exposure(run.fault, run.lanes, trial, nominal, n)
    which = trial + n * np.arange(len(rows) + 1)
    seen = skeleton(run.world, run.film, motion, many, columns=which, t=t)[..., :SEEN]
    moved = (seen[:, 1:] - seen[:, :1]) / SMALL
    lag = _lag(run, motion, many, trial, t)
    own = [moved[:, study:]] + ([] if run.logged else [lag])
    shared = [moved[:, :study], _labels(motion, trial, t)] + ([lag] if run.logged else [])
    if run.fault is not None:
        shared.append(_fault(run, said, motion, many, trial=trial, t=nominal))
    return tuple(_white(run, np.concatenate(c, axis=1)) for c in (shared, own))


def _without(shared: np.ndarray, own: np.ndarray, priors: np.ndarray) -> np.ndarray:
    """Information of the study's columns after projecting out the trial's own (priors 0 or 1).

    [own shared] = Q R; what is left of the shared columns has the lower right block of R.
    """
    own = np.concatenate([own, np.diag(priors)])
    own = own / (np.linalg.norm(own, axis=0) + 1e-300)
    shared = np.concatenate([shared, np.zeros((len(priors), shared.shape[1]))])
    R = np.linalg.qr(np.concatenate([own, shared], axis=1), mode="r")
    rest = R[own.shape[1] :, own.shape[1] :]
    return rest.T @ rest


def information(run: Run) -> tuple[np.ndarray, int]:
    """Information of the study's unknowns in units of their size; row of the first strength."""
    seconds = float(np.max(run.frames)) / run.fps + 0.3
    motion, many = simulated(run, seconds)
    study = unknowns(run)[1]
    said = ()
    if run.fault is not None:
        said = (statement(run.world, run.film, None), statement(run.world, run.film, run.fault))
    total = 0.0
    for trial in range(len(run.lanes)):
        shared, own = _columns(run, motion, many, trial, said)
        priors = np.ones(own.shape[1])
        priors[:6] = 0
        if not run.logged:
            priors[-1] = 0
        total = total + _without(shared, own, priors)
    labels = slice(study, study + 2 * SEEN)
    total[labels, labels] += np.eye(2 * SEEN)
    strengths = slice(6, study)
    if run.logged:
        total[strengths, strengths] += shaft_information(run)
    return total, 6


def sigmas(run: Run) -> np.ndarray:
    """Strength over its standard deviation for each law and, last, the fault if there is one."""
    total, first = information(run)
    scale = np.sqrt(np.diag(total)) + 1e-300
    spread = np.sqrt(np.maximum(np.diag(np.linalg.pinv(total / np.outer(scale, scale), 1e-13)), 0))
    values = scale / np.maximum(spread, 1e-12)
    laws = values[first : first + len(run.world.laws)]
    return np.append(laws, values[-1]) if run.fault is not None else laws


def shaft_information(run: Run, noise_deg: float = 1.5) -> np.ndarray:
    """(laws, laws) information of the logged shaft angles, every 20 ms, on laws of the motor.

    Noise: 4 readings averaged, and the integral of the frequency's wander (Ornstein-Uhlenbeck,
    variance s^2, time tau), whose phase has the covariance
    (2 pi f s)^2 tau (2 min(a, b) - tau (1 - e^(-a/tau) - e^(-b/tau) + e^(-|a - b|/tau))).
    Unknown: phase and mean frequency of each trial.
    """
    n = len(run.world.laws)
    active = [i for i, h in enumerate(run.world.laws) if h.form.stage == "motor"]
    total = np.zeros((n, n))
    if not active:
        return total
    t = np.arange(0.01, np.median(run.frames) / run.fps, 0.02)
    a, b = t[:, None], t[None, :]
    memory = np.exp(-a / MEMORY) + np.exp(-b / MEMORY) - np.exp(-np.abs(a - b) / MEMORY)
    covariance = WANDER**2 * MEMORY * (2 * np.minimum(a, b) - MEMORY * (1 - memory))
    steady = np.zeros((int(LONGEST_GRID / STEP), len(run.lanes)))
    times = STEP * (np.arange(len(steady)) + 0.5)
    base = drive(run.lanes, list(run.world.laws), steady, times).phase
    changes = [_phase_change(run, i, base, times) for i in active]
    for trial in range(len(run.lanes)):
        beat = 2 * np.pi * run.lanes.flap[trial]
        noise = beat**2 * covariance + np.diag(np.full(len(t), np.deg2rad(noise_deg) ** 2 / 4))
        columns = np.stack([np.ones(len(t)), beat * t]
                           + [change(t, trial) for change in changes], 1)  # fmt: skip
        J = columns.T @ np.linalg.solve(noise, columns)
        J = J[2:, 2:] - J[2:, :2] @ np.linalg.solve(J[:2, :2], J[:2, 2:])
        total[np.ix_(active, active)] += J
    return total


LONGEST_GRID = 10.0


def _phase_change(run: Run, law: int, base, times):
    """Function of times and trial: change of the beat's phase with the law's strength."""
    strengths = run.lanes.strengths.copy()
    strengths[law] *= 1 + SMALL
    lanes = replace(run.lanes, strengths=strengths)
    moved = drive(lanes, list(run.world.laws), np.zeros_like(base), times).phase
    return lambda t, trial: np.interp(t, times, (moved - base)[:, trial]) / SMALL
