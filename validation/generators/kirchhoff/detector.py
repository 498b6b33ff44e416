"""Detectability of a hidden effect by an ideal observer, in sigma.

Along the simulated path the dynamics is linearised over blocks of 0.1 s. A Kalman filter with the
state (x, y, theta, momenta, three Ornstein-Uhlenbeck water accelerations, three
Ornstein-Uhlenbeck tracking errors) whitens the change that each parameter makes in the
block-averaged x, y and heading; open-loop growth therefore does not matter. The Matern-3/2
tracking error is replaced by an Ornstein-Uhlenbeck process of the same variance and integral
time. The six coefficients and the other effects' strengths are projected out freely, servo and
frequency errors of each trial with their known spreads, starting states by the filter's wide
prior. Nuisances of a measurement error are the same.

``sigma_path`` is this number. For errors of reporting and for sinking, ``sigma`` adds what the
body's apparent size, the recoil frequency or the label geometry shows (see
``length_and_label_sigma`` in observe.py).

Check by brute force (tests, ``test_detector_against_brute_force``): 6000 sampled
linearised paths under water motion and tracking errors give an open-loop covariance; inverted in
full, it gives the same sigma for a current on two stable trials within 15 per cent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .dynamics import StudyWorld, Trials, midpoint_step
from .noise import Noise

BLOCK_S = 0.1
STEPS_PER_BLOCK = 3  # integration steps per block
COEFFICIENTS = ("C_T", "C_La", "C_D0", "C_Da", "C_Ma", "C_Md")
STATE_DIFFERENCES = np.array([1e-3, 1e-3, 1e-3, 2e-4, 2e-4, 5e-6])


@dataclass(frozen=True)
class BlockPath:
    """States (8, N) at the start of each of N = blocks x trials blocks, their times and trials."""

    y: np.ndarray
    t: np.ndarray
    trials: Trials
    seen: np.ndarray  # (blocks, trials), block lies within the trial
    count: int


def cut_into_blocks(path: np.ndarray, trials: Trials, per_second: int) -> BlockPath:
    """Cut a simulated path (steps + 1, 8, B) into blocks."""
    y = path[:: round(BLOCK_S * per_second)][:-1]
    K, _, B = y.shape
    t = np.arange(K) * BLOCK_S
    return BlockPath(
        np.moveaxis(y, 1, 0).reshape(8, K * B),
        np.repeat(t, B),
        trials.take(np.tile(np.arange(B), K)),
        t[:, None] <= trials.duration[None] - BLOCK_S,
        B,
    )


def advance_block(
    world: StudyWorld, path: BlockPath, y: np.ndarray, push: np.ndarray | float = 0.0
) -> np.ndarray:
    """First six state components (6, N) one block later."""
    dt = BLOCK_S / STEPS_PER_BLOCK
    for i in range(STEPS_PER_BLOCK):
        y = midpoint_step(world, path.trials, path.t + i * dt, y, dt, push)
    return y[:6]


def reshape_by_block(change: np.ndarray, path: BlockPath) -> np.ndarray:
    """(6, N) to (blocks, trials, 6)."""
    return np.moveaxis(change.reshape(6, -1, path.count), 0, -1)


def block_jacobians(world: StudyWorld, path: BlockPath) -> tuple[np.ndarray, np.ndarray]:
    """Jacobians of a block with respect to the state (K, B, 6, 6) and the gusts (K, B, 6, 3)."""
    F, G = [], []
    for i, h in enumerate(STATE_DIFFERENCES):
        if i < 2 and not any(world.active(c) for c in ("water", "force")):
            column = np.zeros((6, path.y.shape[1]))
            column[i] = 1
        else:
            moved = np.zeros((8, 1))
            moved[i] = h
            plus, minus = (advance_block(world, path, path.y + k * moved) for k in (1, -1))
            column = (plus - minus) / (2 * h)
        F.append(reshape_by_block(column, path))
    for i in range(3):
        push = np.zeros((3, 1))
        push[i] = 0.05
        change = advance_block(world, path, path.y, push) - advance_block(
            world, path, path.y, -push
        )
        G.append(reshape_by_block(change / 0.1, path))
    return np.stack(F, -1), np.stack(G, -1)


def nuisance_responses(world: StudyWorld, path: BlockPath, base: np.ndarray) -> tuple[list, list]:
    """Responses (K, B, 6) to shared parameters (one per cent) and to servo and frequency errors."""
    shared, trial = [], []
    for name in COEFFICIENTS:
        robot = replace(world.robot, **{name: getattr(world.robot, name) * 1.01})
        shared.append(advance_block(replace(world, robot=robot), path, path.y) - base)
    for i, hidden in enumerate(world.hidden):
        if hidden.form.channel not in ("observe", "report"):
            other = world.with_strength(i, hidden.strength * 1.02)
            shared.append(advance_block(other, path, path.y) - base)
    for name, step in (("servo", 1e-3), ("f", 1e-3 * path.trials.f)):
        trials = replace(path.trials, **{name: getattr(path.trials, name) + step})
        trial.append((advance_block(world, replace(path, trials=trials), path.y) - base) / 1e-3)
    return [reshape_by_block(c, path) for c in shared], [reshape_by_block(c, path) for c in trial]


def tracking_variances(world: StudyWorld, noise: Noise, pixel_m: float, fps: float) -> tuple:
    """Block-averaged white and correlated variances of x, y (m^2) and heading (rad^2)."""
    robot = world.robot
    lever = np.hypot(robot.head_length, robot.body_length - robot.head_length) / np.sqrt(2)
    scale = pixel_m**2 * np.array([1, 1, 1 / lever**2])
    return scale * noise.white_px**2 / (fps * BLOCK_S), scale * noise.matern_px**2


def whitened_innovations(
    path: BlockPath, F: np.ndarray, G: np.ndarray, columns: np.ndarray, levels: tuple
) -> np.ndarray:
    """Whitened innovations (blocks, trials, 3, P) of the responses.

    ``columns`` (blocks, trials, 9, P): rows 0-5 added to the state in a block, rows 6-8 to what is
    seen.
    ``levels``: white and correlated tracking variances (3,), gust deviations (3,), both times (s).
    """
    white, correlated, gust, gust_tau, track_tau = levels
    K, B, _, n = columns.shape
    rho = np.exp(-BLOCK_S / np.array([gust_tau] * 3 + [track_tau] * 3))
    cov = np.zeros((B, 12, 12))
    cov[:, range(12), range(12)] = np.concatenate(
        [[0.3, 0.3, 0.3, 6e-4, 6e-4, 1e-6], gust**2, correlated]
    )
    H = np.zeros((3, 12))
    H[:, :3] = H[:, 9:] = np.eye(3)
    Q = np.diag(np.concatenate([np.zeros(6), (1 - rho**2) * np.concatenate([gust**2, correlated])]))
    step, d, out = np.zeros((B, 12, 12)), np.zeros((B, 12, n)), np.zeros((K, B, 3, n))
    step[:, range(6, 12), range(6, 12)] = rho
    for k in range(K):
        S = H @ cov @ H.T + np.diag(white)
        gain = np.swapaxes(np.linalg.solve(S, H @ cov), 1, 2)
        innovation = d[:, :3] + columns[k, :, 6:]
        out[k] = np.linalg.solve(np.linalg.cholesky(S), innovation) * path.seen[k][:, None, None]
        d, cov = d - gain @ innovation, cov - gain @ S @ np.swapaxes(gain, 1, 2)
        step[:, :6, :6], step[:, :6, 6:9] = F[k], G[k]
        d, cov = step @ d, step @ cov @ np.swapaxes(step, 1, 2) + Q
        d[:, :6] += columns[k, :, :6]
    return out


def residual_norm(
    signal: np.ndarray, shared: np.ndarray, trial: np.ndarray, spread: np.ndarray
) -> float:
    """Norm of whitened ``signal`` (K, B, 3) after projection.

    ``shared`` (K, B, 3, P) is free; ``trial`` (K, B, 3, 2) has a parameter a trial with prior
    ``spread``.
    """
    K, B = signal.shape[:2]
    own = np.zeros((K, B, 3, B, 2))
    for b in range(B):
        own[:, b, :, b] = trial[:, b]
    X = np.concatenate([shared.reshape(K * B * 3, -1), own.reshape(K * B * 3, -1)], 1)
    scale = np.linalg.norm(X, axis=0).clip(1e-12)
    prior = np.concatenate(
        [np.full(shared.shape[-1], 1e-9), np.tile(1 / spread, B) / scale[-2 * B :]]
    )
    a, X = signal.ravel(), X / scale
    b = X.T @ a
    return float(np.sqrt(max(a @ a - b @ np.linalg.solve(X.T @ X + np.diag(prior**2), b), 0)))


def path_detectability_sigmas(
    world: StudyWorld,
    path: BlockPath,
    noise: Noise,
    seen: list[np.ndarray | None],
    *,
    pixel_m: float,
    fps: float,
) -> list[float]:
    """Sigma of each effect; ``seen[i]`` (K, B, 3) is the change it makes in what is observed."""
    base = advance_block(world, path, path.y)
    F, G = block_jacobians(world, path)
    shared, trial = nuisance_responses(world, path, base)
    signals = []
    for i, observed in enumerate(seen):
        off = advance_block(world.with_strength(i, 0.0), path, path.y)
        response = reshape_by_block(base - off, path)
        unseen = np.zeros((*response.shape[:2], 3))
        signals.append(np.concatenate([response, unseen if observed is None else observed], -1))
    states = np.stack([*shared, *trial], -1)
    states = np.concatenate([states, np.zeros((*states.shape[:2], 3, states.shape[-1]))], 2)
    columns = np.concatenate([states, np.stack(signals, -1)], -1) if signals else states
    gust = np.array([noise.gust_m_s2, noise.gust_m_s2, noise.gust_rad_s2])
    variances = tracking_variances(world, noise, pixel_m, fps)
    w = whitened_innovations(
        path, F, G, columns, (*variances, gust, noise.gust_tau_s, noise.matern_tau_s)
    )
    first = len(shared)
    spread = np.array([noise.servo_rad, noise.frequency])
    order = [i for i, h in enumerate(world.hidden) if h.form.channel not in ("observe", "report")]
    out = []
    for i in range(len(seen)):
        kept = [j for j in range(first) if j < 6 or order[j - 6] != i]
        out.append(
            residual_norm(w[..., first + 2 + i], w[..., kept], w[..., first : first + 2], spread)
        )
    return out
