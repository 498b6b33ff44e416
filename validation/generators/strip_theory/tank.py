"""Trials: start poses within the pool, integration, stability of straight swimming."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.actuators import flapping_frequency, head_angle
from validation.generators.strip_theory.dynamics import STATE_SIZE, derivative, simulate
from validation.generators.strip_theory.parameters import INDEX, KEYS

Floats = NDArray[np.float64]
NO_WATER_MOTION = np.zeros((0, 6))
START_MARGIN, END_MARGIN = 0.27, 0.2  # m between the centre of mass and the walls
PLACE_DEPENDENT_EFFECTS = (
    "CUR",
    "GYRE",
    "WALL",
    "WAKE",
)  # effects that depend on the place in the pool


@dataclass(frozen=True)
class Trial:
    """Conditions of one trial; angles in rad, `lead_in` (s) of rest before the motor starts."""

    name: str
    order: int
    power_pct: float
    command: float
    head_length: float
    fps: float
    duration: float
    flap_hz: float
    servo_error: float
    flap_error: float
    lead_in: float
    modes: Floats
    session: int  # number of trials in the study
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SimulatedTrial:
    """One simulated trial: states `(frames, 8)` and the series the integrator used."""

    trial: Trial
    P: Floats
    dt: float
    sub: int
    Y: Floats
    phi: Floats
    freq: Floats
    extra: NDArray[np.complex128]

    @property
    def times(self) -> Floats:
        """Time of the frames (s)."""
        return np.arange(len(self.Y)) / self.trial.fps


def trial_parameters(P: Floats, trial: Trial) -> Floats:
    """Return `P` with the head of this trial: area h x span and arm l(h) (MODEL.md, STUDY.md)."""
    out = P.copy()
    h = trial.head_length
    out[KEYS.HEAD], out[KEYS.AREA] = h, h * P[KEYS.SPAN]
    out[KEYS.ARM] = h + P[KEYS.HINGE] - (P[KEYS.BODY] + h - P[KEYS.HEAD_1X]) / 4.0
    out[KEYS.CUR_NOW] = (
        math.exp(-trial.order / (0.5 * trial.session)) if P[KEYS.CUR_FORM] == 2 else 1.0
    )
    return out


def input_series(trial: Trial, P: Floats, frames: int) -> tuple[float, int, Floats, Floats]:
    """Return step (s), steps a frame, and head angle and frequency at every half step."""
    sub = math.ceil(59.0 / trial.fps)
    dt = 1.0 / (trial.fps * sub)
    t = 0.5 * dt * np.arange(2 * sub * (frames - 1) + 1)
    since = t - trial.lead_in - P[KEYS.TIME]
    phi = head_angle(since, trial.command, trial.servo_error, P)
    freq = flapping_frequency(since, trial.flap_hz * (1.0 + trial.flap_error), P)
    return dt, sub, phi, freq


def run_trial(trial: Trial, P: Floats, modes: Floats | None = None) -> SimulatedTrial:
    """Integrate one trial from rest at its start pose."""
    own = trial_parameters(P, trial)
    frames = round(trial.duration * trial.fps) + 1
    dt, sub, phi, freq = input_series(trial, own, frames)
    y0 = np.zeros(STATE_SIZE)
    y0[0], y0[1], y0[4] = trial.start
    Y, extra = simulate(y0, dt, sub, phi, freq, own, trial.modes if modes is None else modes)
    return SimulatedTrial(trial, own, dt, sub, Y, phi, freq, extra)


def frames_inside(Z: NDArray[np.complex128], P: Floats, margin: float) -> NDArray[np.int64]:
    """Number of leading frames of the paths `Z` (paths, frames) that keep `margin` to the walls."""
    inside = (Z.real > margin) & (Z.real < P[KEYS.POOL_L] - margin)
    inside &= (Z.imag > margin) & (Z.imag < P[KEYS.POOL_W] - margin)
    return np.where(inside.all(axis=1), Z.shape[1], np.argmin(inside, axis=1))


def with_start_pose(trial: Trial, P: Floats, rng: np.random.Generator) -> Trial:
    """Return the trial at a random start pose that keeps its path in the pool longest."""
    free = P.copy()
    free[[INDEX[name] for name in PLACE_DEPENDENT_EFFECTS]] = 0.0
    free[KEYS.U_FORM] = 0.0
    Y = run_trial(replace(trial, start=(0.0, 0.0, 0.0)), free, NO_WATER_MOTION).Y
    heading = rng.uniform(-math.pi, math.pi, 150)
    gap = START_MARGIN + 0.01
    start = rng.uniform(gap, P[KEYS.POOL_L] - gap, 150) + 1j * rng.uniform(
        gap, P[KEYS.POOL_W] - gap, 150
    )
    Z = start[:, None] + np.exp(1j * heading)[:, None] * (Y[:, 0] + 1j * Y[:, 1])[None]
    score = frames_inside(Z, P, START_MARGIN).astype(float)
    if P[KEYS.WALL] != 0.0:  # near the walls, where the effect acts
        gaps = np.minimum.reduce([Z.real, P[KEYS.POOL_L] - Z.real, Z.imag, P[KEYS.POOL_W] - Z.imag])
        score -= 20.0 * np.median(gaps, axis=1)
    best = int(np.argmax(score))
    return replace(trial, start=(start[best].real, start[best].imag, heading[best]))


def cut_at_wall(run: SimulatedTrial) -> SimulatedTrial:
    """Return the run up to the frame at which the centre of mass comes too near a wall."""
    Z = (run.Y[:, 0] + 1j * run.Y[:, 1])[None]
    n = max(int(frames_inside(Z, run.P, END_MARGIN)[0]), 2)
    k = 2 * run.sub * (n - 1) + 1
    return replace(run, Y=run.Y[:n], phi=run.phi[:k], freq=run.freq[:k], extra=run.extra[:k])


def run_trials(trials: list[Trial], P: Floats, seed: list[int]) -> list[SimulatedTrial]:
    """Place and integrate all trials; a trial that leaves the pool early is placed again."""
    runs = []
    for trial in trials:
        rng = np.random.default_rng([*seed, trial.order])
        attempts = []
        for _ in range(10):
            attempts.append(cut_at_wall(run_trial(with_start_pose(trial, P, rng), P)))
            if len(attempts[-1].Y) >= 3.0 * trial.fps:
                break
        runs.append(max(attempts, key=lambda run: len(run.Y)))
    return runs


def straight_growth_rate(P: Floats, freq: float) -> float:
    """Largest growth rate (1/s) of small disturbances of straight swimming at `freq` (Hz).

    Eigenvalues of the Jacobian of (sideways speed, heading, yaw rate) at the terminal speed
    f sqrt(C_T/C_D0); the zero eigenvalue of a turned frame is left out.
    """
    U = freq * math.sqrt(P[KEYS.C_T] / P[KEYS.C_D0])

    def rates(q: Floats) -> Floats:
        out = derivative(
            0j, complex(U, q[0]), q[1], q[2], 0.0, 0.0, 0.0, 0.0, freq, 0j, P, NO_WATER_MOTION
        )
        return np.array([out[1].imag, out[2], out[3]])

    h = 1e-5
    J = np.column_stack([(rates(h * d) - rates(-h * d)) / (2 * h) for d in np.eye(3)])
    eigenvalues = np.linalg.eigvals(J)
    return float(np.delete(eigenvalues, np.argmin(np.abs(eigenvalues))).real.max())


def fin_area_for(P: Floats, freq: float, rate: float, bounds: tuple[float, float]) -> float:
    """Fin area (m2) at which straight swimming has growth rate `rate` (1/s, negative: stable)."""
    low, high = bounds
    for _ in range(30):
        middle = math.sqrt(low * high)
        P = P.copy()
        P[KEYS.FIN_AREA] = middle
        low, high = (middle, high) if straight_growth_rate(P, freq) > rate else (low, middle)
    return math.sqrt(low * high)
