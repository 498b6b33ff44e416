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

from .drive import FREQUENCY_DRIFT_STD, FREQUENCY_DRIFT_TIME_S, drive_history
from .eddies import EDDY_COUNT
from .filming import (
    LABEL_STD_M,
    FilmSetup,
    StatedSetup,
    exposure_times,
    keypoint_pixels,
    keypoint_positions,
    stated_camera,
    stated_setup,
    with_strength,
)
from .form import HiddenForm
from .impulse import STEP_S, Motion, StudyWorld, simulate_motion
from .lanes import FLAP_ERROR, SERVO_ERROR, ParallelTrials, repeat_trials

DIFFERENCE_STEP = 1e-4
"""Step of the finite differences, in units of each unknown's own size."""
USED_KEYPOINTS = 4
"""Keypoints used: all but the tail's tip."""


@dataclass(frozen=True)
class StudyRun:
    """A study's world, trials and film, ready to be simulated."""

    world: StudyWorld
    lanes: ParallelTrials
    film: FilmSetup
    fps: float
    frames: np.ndarray
    """(trials,)."""
    logged: bool
    """Whether the phase of the beat is known from motor logs."""
    fault: HiddenForm | None = None


def simulated_unknowns(
    run: StudyRun,
) -> tuple[list[tuple[str, tuple[int, ...], np.ndarray | float]], int]:
    """(field, row, size) of each simulated unknown, and how many are the study's (first)."""
    lanes, water = run.lanes, run.world.water
    study = [("coefficients", (i,), lanes.coefficients[i, 0]) for i in range(6)]
    study += [("strengths", (i,), lanes.strengths[i, 0]) for i in range(len(run.world.laws))]
    start = [("start", (i,), size) for i, size in enumerate((0.01, 0.01, 0.02, 0.01, 0.01, 0.02))]
    own = [("servo", (), SERVO_ERROR), ("flap", (), FLAP_ERROR * lanes.flap)]
    own += [("drift", (i,), water.drift) for i in range(2)]
    own += [("eddies", (m, i), water.eddy) for m in range(EDDY_COUNT) for i in range(2)]
    return study + start + own, len(study)


def simulate_with_unknowns(run: StudyRun, seconds: float) -> tuple[Motion, ParallelTrials]:
    """All lanes as they are, and once more for each unknown changed by SMALL of its size."""
    rows, n = simulated_unknowns(run)[0], len(run.lanes)
    many = repeat_trials(run.lanes, len(rows) + 1)
    changed = {name: np.array(getattr(many, name)) for name in {r[0] for r in rows}}
    for i, (name, row, size) in enumerate(rows, start=1):
        changed[name][(*row, slice(i * n, (i + 1) * n))] += DIFFERENCE_STEP * size
    many = replace(many, **changed)
    return simulate_motion(run.world, many, seconds), many


def _whitened(run: StudyRun, columns: np.ndarray) -> np.ndarray:
    """(8 frames, columns) real and white, from (frames, columns, SEEN) complex metres."""
    tracker, camera = run.film.tracker, run.film.camera
    a, b, scale = tracker.arma(run.fps)
    metre = camera.pose[5] / camera.focal
    unit = scale[:USED_KEYPOINTS] * metre / np.sqrt(tracker.sharpness)
    z = lfilter([1, -a], [1, b], columns / unit, axis=0)
    flat = np.moveaxis(z, 1, 2).reshape(-1, columns.shape[1])
    return np.concatenate([flat.real, flat.imag])


def _label_effects(motion: Motion, trial: int, t) -> np.ndarray:
    """(frames, 8, SEEN) effect of each label's place by LABEL."""
    step = motion.times[1]
    i = np.clip((t / step).astype(int), 0, len(motion.times) - 1)
    theta, phi = motion.heading[i, trial], motion.angle[i, trial]
    out = np.zeros((len(t), 2 * USED_KEYPOINTS, USED_KEYPOINTS), dtype=complex)
    for point in range(USED_KEYPOINTS):
        axis = LABEL_STD_M * np.exp(1j * (theta + phi * (point > 0)))
        out[:, 2 * point, point], out[:, 2 * point + 1, point] = axis, 1j * axis
    return out


def _recoil_phase_effect(
    run: StudyRun, motion: Motion, many: ParallelTrials, trial: int, t
) -> np.ndarray:
    """(frames, 1, SEEN) effect of the recoil's phase."""
    late = replace(run.film, recoil=replace(run.film.recoil, lag=run.film.recoil.lag + 1e-4))
    pair = [
        keypoint_positions(run.world, f, motion, many, columns=[trial], t=t)[..., :USED_KEYPOINTS]
        for f in (run.film, late)
    ]
    return (pair[1] - pair[0]) / 1e-4


def _fault_effect(
    run: StudyRun,
    said: tuple[StatedSetup, StatedSetup],
    motion: Motion,
    many: ParallelTrials,
    *,
    trial: int,
    t,
) -> np.ndarray:
    """(frames, 1, SEEN) effect of the fault, at its strength, on the mapped keypoints."""
    base, moved = (
        stated_camera(s).back(
            keypoint_pixels(run.world, run.film, motion, many, trial=trial, t=t, fault=fault)[
                :, :USED_KEYPOINTS
            ]
        )
        for s, fault in zip(said, (with_strength(run.fault, 0.0), run.fault), strict=True)
    )
    return (moved - base)[:, None]


def _whitened_columns(
    run: StudyRun, motion: Motion, many: ParallelTrials, trial: int, said
) -> tuple[np.ndarray, ...]:
    """White columns of the study's unknowns and of the trial's own."""
    n, (rows, study) = len(run.lanes), simulated_unknowns(run)
    nominal = np.arange(run.frames[trial]) / run.fps
    t = exposure_times(run.fault, run.lanes, trial, nominal, n)
    which = trial + n * np.arange(len(rows) + 1)
    seen = keypoint_positions(run.world, run.film, motion, many, columns=which, t=t)[
        ..., :USED_KEYPOINTS
    ]
    moved = (seen[:, 1:] - seen[:, :1]) / DIFFERENCE_STEP
    lag = _recoil_phase_effect(run, motion, many, trial, t)
    own = [moved[:, study:]] + ([] if run.logged else [lag])
    shared = [moved[:, :study], _label_effects(motion, trial, t)] + ([lag] if run.logged else [])
    if run.fault is not None:
        shared.append(_fault_effect(run, said, motion, many, trial=trial, t=nominal))
    return tuple(_whitened(run, np.concatenate(c, axis=1)) for c in (shared, own))


def _project_out(shared: np.ndarray, own: np.ndarray, priors: np.ndarray) -> np.ndarray:
    """Information of the study's columns after projecting out the trial's own (priors 0 or 1).

    [own shared] = Q R; what is left of the shared columns has the lower right block of R.
    """
    own = np.concatenate([own, np.diag(priors)])
    own = own / (np.linalg.norm(own, axis=0) + 1e-300)
    shared = np.concatenate([shared, np.zeros((len(priors), shared.shape[1]))])
    R = np.linalg.qr(np.concatenate([own, shared], axis=1), mode="r")
    rest = R[own.shape[1] :, own.shape[1] :]
    return rest.T @ rest


def information_matrix(run: StudyRun) -> tuple[np.ndarray, int]:
    """Information of the study's unknowns in units of their size; row of the first strength."""
    seconds = float(np.max(run.frames)) / run.fps + 0.3
    motion, many = simulate_with_unknowns(run, seconds)
    study = simulated_unknowns(run)[1]
    said = ()
    if run.fault is not None:
        said = (
            stated_setup(run.world, run.film, None),
            stated_setup(run.world, run.film, run.fault),
        )
    total = 0.0
    for trial in range(len(run.lanes)):
        shared, own = _whitened_columns(run, motion, many, trial, said)
        priors = np.ones(own.shape[1])
        priors[:6] = 0
        if not run.logged:
            priors[-1] = 0
        total = total + _project_out(shared, own, priors)
    labels = slice(study, study + 2 * USED_KEYPOINTS)
    total[labels, labels] += np.eye(2 * USED_KEYPOINTS)
    strengths = slice(6, study)
    if run.logged:
        total[strengths, strengths] += shaft_information(run)
    return total, 6


def detectability_sigmas(run: StudyRun) -> np.ndarray:
    """Strength over its standard deviation for each law and, last, the fault if there is one."""
    total, first = information_matrix(run)
    scale = np.sqrt(np.diag(total)) + 1e-300
    spread = np.sqrt(np.maximum(np.diag(np.linalg.pinv(total / np.outer(scale, scale), 1e-13)), 0))
    values = scale / np.maximum(spread, 1e-12)
    laws = values[first : first + len(run.world.laws)]
    return np.append(laws, values[-1]) if run.fault is not None else laws


def shaft_information(run: StudyRun, noise_deg: float = 1.5) -> np.ndarray:
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
    memory = (
        np.exp(-a / FREQUENCY_DRIFT_TIME_S)
        + np.exp(-b / FREQUENCY_DRIFT_TIME_S)
        - np.exp(-np.abs(a - b) / FREQUENCY_DRIFT_TIME_S)
    )
    covariance = (
        FREQUENCY_DRIFT_STD**2
        * FREQUENCY_DRIFT_TIME_S
        * (2 * np.minimum(a, b) - FREQUENCY_DRIFT_TIME_S * (1 - memory))
    )
    steady = np.zeros((int(MAX_GRID_S / STEP_S), len(run.lanes)))
    times = STEP_S * (np.arange(len(steady)) + 0.5)
    base = drive_history(run.lanes, list(run.world.laws), steady, times).phase
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


MAX_GRID_S = 10.0


def _phase_change(run: StudyRun, law: int, base, times):
    """Function of times and trial: change of the beat's phase with the law's strength."""
    strengths = run.lanes.strengths.copy()
    strengths[law] *= 1 + DIFFERENCE_STEP
    lanes = replace(run.lanes, strengths=strengths)
    moved = drive_history(lanes, list(run.world.laws), np.zeros_like(base), times).phase
    return lambda t, trial: np.interp(t, times, (moved - base)[:, trial]) / DIFFERENCE_STEP
