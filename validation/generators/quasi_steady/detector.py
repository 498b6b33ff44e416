"""Detectability of hidden effects to an ideal observer, in sigma.

A Kalman filter runs along the true path of each trial in steps of 0.1 s. Its state is the
deviation of x, y, theta, u, v, r, two gust components and three correlated tracking errors
(Ornstein-Uhlenbeck). Signals are deterministic columns: G (change of one step when an effect is
removed, at the true state) and B (change of what is observed). With e = B + H d and
d' = F (d - K e) + G, the whitened innovations S^(-1/2) e of every column make a Gram matrix.
Servo and frequency errors enter with their priors, trial by trial; six coefficients and the other
effects' strengths enter freely. The sigma of an effect is the square root of the Schur complement.

Lengths between keypoints (1 mm tolerance in common, 0.3 mm per trial) and the recoil's frequency
against the log (0.3 % per trial) are added, for they alone show a wrong scale or clock. Recoil is
taken as filtered out. Each change is finite for the effect and linear for the rest.

Check by simulation (in the test): one trial with a weak fin or viscous drag;
thousands of simulated runs with gusts and starting rates give the covariance of the whole
trajectory, without linearisation or filter. The whitened norm of the simulated difference, without
nuisances, is compared with this filter's.
Result for 1500 runs of 2.5 s (filter, brute force): viscous drag in a turn 1.02, 1.01 and straight
1.10, 1.05; fin 0.263, 0.266; linear yaw damping 0.208, 0.209.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.generators.quasi_steady import observation as obs
from validation.generators.quasi_steady.dynamics import single_steps
from validation.generators.quasi_steady.effects import Effect
from validation.generators.quasi_steady.trials import (
    Lab,
    Noise,
    Trial,
    actual_head_angle,
    body_points,
    simulate_trial,
    trial_inputs,
    with_head,
)

BLOCK_S = 0.1  # s
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
SERVO, FLAP = np.radians(0.3), 0.003  # prior standard deviations
START_STDS = np.array([1.0, 1.0, 1.0, 3e-3, 3e-3, 0.02])  # prior of the starting state, m, rad, s
OBSERVATION_EFFECTS = {"sinking", "centre_of_mass_shift", "scale_error", "camera_shift",
            "uncorrected_refraction", "lens_error", "keypoint_bias"}  # fmt: skip


@dataclass(frozen=True)
class TrialSignals:
    """A trial: transitions F (n, 8, 8), columns G (n, 6, m), B (n + 1, 3, m), lengths (3, m)."""

    F: np.ndarray
    G: np.ndarray
    B: np.ndarray
    lengths: np.ndarray


def _transitions(
    times: np.ndarray, states: np.ndarray, path: np.ndarray, given: tuple
) -> np.ndarray:
    """Sensitivity of a step's end to its start and to a uniform gust, by differences."""
    n = len(times) - 1
    base = single_steps(times, states, *given, path)
    F = np.zeros((n, 8, 8))
    for j, h in enumerate((1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-3)):
        moved = states.copy()
        moved[:, j] += h
        F[:, :6, j] = (single_steps(times, moved, *given, path) - base)[:, :6] / h
    for j in range(2):
        schedule = given[2].copy()
        schedule[:, 2 + j] += 1e-4
        moved = single_steps(times, states, given[0], given[1], schedule, path)
        F[:, :6, 6 + j] = (moved - base)[:, :6] / 1e-4
    return F


def _perturbed_inputs(lab: Lab, trial: Trial, effects: Sequence[Effect]) -> list[tuple]:
    """Inputs with one thing changed: each effect gone, each coefficient up, servo, frequency."""
    out = [trial_inputs(lab, trial, [o for o in effects if o is not e]) for e in effects]
    robot, table, schedule = trial_inputs(lab, trial, effects)
    for name in COEFFICIENTS:
        out.append((robot._replace(**{name: getattr(robot, name) * 1.01}), table, schedule))
    out.append(trial_inputs(lab, trial, effects, servo=SERVO))
    out.append(trial_inputs(lab, trial, effects, flap=FLAP))
    return out


def _apparent_positions(
    lab: Lab, trial: Trial, effects: Sequence[Effect], times: np.ndarray, states: np.ndarray
) -> np.ndarray:
    """Positions (n, 5, 2) that the study's statements give."""
    given = trial_inputs(lab, trial, effects)
    points = body_points(states, actual_head_angle(given, times), given[0])
    seen = obs.keypoint_pixels(lab, trial, effects, times, points)
    return obs.pixels_to_stated_pool(lab, obs.stated_setup(lab, effects), seen)


def _pose_change(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Change of core position and of heading (n, 3), and of three mean lengths (3,)."""
    a, b = one[:, :4] @ [1, 1j], other[:, :4] @ [1, 1j]
    a0, b0 = (z - z.mean(axis=1, keepdims=True) for z in (a, b))
    turn = np.angle(np.sum(a0 * np.conj(b0), axis=1))
    move = a[:, 2] - b[:, 2]
    lengths = np.mean(np.abs(np.diff(a, axis=1)) - np.abs(np.diff(b, axis=1)), axis=0)
    return np.column_stack([move.real, move.imag, turn]), lengths


def trial_signals(lab: Lab, trial: Trial, effects: Sequence[Effect]) -> TrialSignals:
    """Transitions and columns of a trial along its true path."""
    times, states, path = simulate_trial(lab, trial, effects, 1 / BLOCK_S)
    given = trial_inputs(lab, trial, effects)
    base = single_steps(times, states, *given, path)
    changed = [
        single_steps(times, states, *g, path) for g in _perturbed_inputs(lab, trial, effects)
    ]
    G = np.stack([(base - c)[:, :6] for c in changed], axis=2)
    B = np.zeros((len(times), 3, G.shape[2]))
    lengths = np.zeros((3, G.shape[2]))
    for i, e in enumerate(effects):
        if e.form.cause in OBSERVATION_EFFECTS:
            fewer = [o for o in effects if o is not e]
            pair = [
                _apparent_positions(lab, trial, some, times, states) for some in (effects, fewer)
            ]
            B[:, :, i], lengths[:, i] = _pose_change(*pair)
    return TrialSignals(_transitions(times, states, path, given), G, B, lengths)


def tracking_variances(lab: Lab) -> tuple[np.ndarray, np.ndarray]:
    """Variances (3,) of x, y, heading: white error of a block, and correlated error."""
    noise, robot = lab.noise, lab.robot
    scale = lab.camera.position[2] / lab.camera.focal[0]
    along = np.array([robot.hinge + robot.head, robot.hinge, 0, -robot.base])
    shape = np.array([1 / 3, 1 / 3, 1 / np.sum((along - along.mean()) ** 2)]) * scale**2
    frames = max(1.0, lab.fps * BLOCK_S)
    return noise.white_px**2 * shape / frames, noise.drift_px**2 * shape


def whitened_innovations(
    s: TrialSignals, noise: Noise, white: np.ndarray, drift: np.ndarray
) -> np.ndarray:
    """Whitened innovations (steps, 3, m) of every column."""
    keep, fade = np.exp(-BLOCK_S / noise.gust_s), np.exp(-BLOCK_S / noise.drift_s)
    P = np.diag(np.r_[START_STDS**2, [noise.gust_m_s**2] * 2, drift])
    Q = np.diag(np.r_[[1e-12] * 6, [noise.gust_m_s**2 * (1 - keep**2)] * 2, drift * (1 - fade**2)])
    H = np.zeros((3, 11))
    H[:, :3] = H[:, 8:] = np.eye(3)
    F = np.diag(np.r_[np.ones(6), keep, keep, fade, fade, fade])
    d = np.zeros((11, s.B.shape[2]))
    out = np.empty_like(s.B)
    for k in range(len(s.B)):
        e = s.B[k] + H @ d
        PH = P @ H.T
        S = H @ PH + np.diag(white)
        root = np.linalg.cholesky(S)
        out[k] = np.linalg.solve(root, e)
        if k < len(s.F):
            K = np.linalg.solve(S, PH.T).T
            F[:6, :8] = s.F[k][:6]
            d = F @ (d - K @ e)
            d[:6] += s.G[k]
            P = F @ (P - K @ PH.T) @ F.T + Q
            P = 0.5 * (P + P.T)
    return out


def _trial_gram(lab: Lab, trial: Trial, effects: Sequence[Effect]) -> tuple[np.ndarray, np.ndarray]:
    """Gram matrix of effects and coefficients with servo and frequency absorbed; lengths."""
    s = trial_signals(lab, trial, effects)
    E = whitened_innovations(s, lab.noise, *tracking_variances(lab)).reshape(-1, s.B.shape[2])
    E, local = E[:, :-2], E[:, -2:]
    cross = local.T @ E
    gram = E.T @ E - cross.T @ np.linalg.solve(np.eye(2) + local.T @ local, cross)
    return gram, s.lengths[:, :-2]


def detectability(lab: Lab, effects: Sequence[Effect]) -> np.ndarray:
    """Sigma of each effect, in the effects' order."""
    parts = [_trial_gram(lab, trial, effects) for trial in lab.trials]
    gram = np.sum([g for g, _ in parts], axis=0)
    lengths = np.array([x for _, x in parts])  # (trials, 3, m)
    mean = lengths.mean(axis=0)
    gram += mean.T @ mean / 1e-3**2
    spread = (lengths - mean).reshape(-1, gram.shape[0])
    gram += spread.T @ spread / 3e-4**2
    for i, e in enumerate(effects):
        if e.form.cause == "clock_error":
            gram[i, i] += len(lab.trials) * (e.k / FLAP) ** 2
    out = []
    for i in range(len(effects)):
        rest = [j for j in range(len(gram)) if j != i]
        scale = np.sqrt(np.diag(gram)[rest]) + 1e-12
        inner = gram[np.ix_(rest, rest)] / np.outer(scale, scale) + 1e-9 * np.eye(len(rest))
        link = gram[rest, i] / scale
        out.append(np.sqrt(max(gram[i, i] - link @ np.linalg.solve(inner, link), 0.0)))
    return np.array(out)


def neutral_fin_area(lab: Lab, fin: Effect) -> float:
    """Fin area (m2) at which straight swimming becomes neutral, by bisection (MODEL.md, 5)."""
    from dataclasses import replace  # noqa: PLC0415

    trial = replace(lab.trials[0], head=lab.robot.head, gusts=0 * lab.trials[0].gusts)
    speed = trial.flap * np.sqrt(lab.robot.C_T / lab.robot.C_D0)
    state = np.array([[0, 0, 0, speed, 0, 0, 0.0]] * 2)

    def growth(area: float) -> float:
        robot, table, schedule = trial_inputs(lab, trial, [replace(fin, k=area)])
        schedule[:, 0], schedule[:, 2:] = 0.0, 0.0
        given = (with_head(robot, lab.robot.head), table, schedule)
        F = _transitions(np.array([0, BLOCK_S]), state, np.full((1, 5), np.inf), given)[0]
        return np.max(np.abs(np.linalg.eigvals(F[4:6, 4:6]))) - 1

    low, high = 1e-4, 0.1
    for _ in range(25):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if growth(middle) > 0 else (low, middle)
    return float(high)
