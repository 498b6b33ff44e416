"""An ideal detector: signals whitened by a Kalman filter along the true motion.

State of the filter: place, direction, velocity in head axes, yaw rate; moving water (2) and torque;
slow tracking errors (3); errors of servo and thrust of the trial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .robots import Array

STATES = 14
SEEN = 3


@dataclass(frozen=True)
class Noise:
    """Standard deviations; pairs and triples are for place, place, direction.

    white: of an average over one interval; slow: of the slow error; slow_keep, water_keep:
    correlation over one interval; push: water (2) and torque (1); start: of the first state (6);
    servo (rad) and thrust of a trial.
    """

    white: Array
    slow: Array
    slow_keep: float
    push: Array
    water_keep: float
    start: Array
    servo: float
    thrust: float


@dataclass(frozen=True)
class Linear:
    """Along the motion: trials x intervals x; moves: (6, 6), by_push: (6, 3), by_trial: (6, 2).

    used: whether the instant at the start of an interval belongs to the recording.
    """

    moves: Array
    by_push: Array
    by_trial: Array
    used: Array


def whitened(linear: Linear, noise: Noise, kicks: Array, sights: Array) -> Array:
    """Whitened innovations (trials x rows x columns) of signals.

    kicks: change of state over an interval, trials x intervals x 6 x columns; sights: change of
    what is seen at its start, trials x intervals x 3 x columns.
    """
    trials, intervals, _, columns = kicks.shape
    look = np.zeros((SEEN, STATES))
    look[:, :3] = look[:, 9:12] = np.eye(3)
    look[2, 12] = 1.0
    spread = np.concatenate([noise.start, noise.push, noise.slow, [noise.servo, noise.thrust]])
    covariance = np.tile(np.diag(spread**2), (trials, 1, 1))
    fresh = np.zeros(STATES)
    fresh[6:9] = noise.push**2 * (1 - noise.water_keep**2)
    fresh[9:12] = noise.slow**2 * (1 - noise.slow_keep**2)
    error = np.zeros((trials, STATES, columns))
    out = np.zeros((trials, intervals, SEEN, columns))
    for k in range(intervals):
        move = _transition(linear, noise, k)
        seen = covariance @ look.T
        inside = look @ seen + np.diag(noise.white**2)
        surprise = look @ error + sights[:, k]
        root = np.linalg.cholesky(inside)
        out[:, k] = np.linalg.solve(root, surprise) * linear.used[:, k, None, None]
        gain = np.linalg.solve(inside, seen.transpose(0, 2, 1)).transpose(0, 2, 1)
        error = move @ (error - gain @ surprise)
        error[:, :6] += kicks[:, k]
        covariance = covariance - gain @ seen.transpose(0, 2, 1)
        covariance = move @ covariance @ move.transpose(0, 2, 1) + np.diag(fresh)
        covariance = 0.5 * (covariance + covariance.transpose(0, 2, 1))
    return out.reshape(trials, intervals * SEEN, columns)


def _transition(linear: Linear, noise: Noise, k: int) -> Array:
    move = np.zeros((len(linear.moves), STATES, STATES))
    move[:, :6, :6] = linear.moves[:, k]
    move[:, :6, 6:9] = linear.by_push[:, k]
    move[:, :6, 12:] = linear.by_trial[:, k]
    keep = [noise.water_keep] * 3 + [noise.slow_keep] * 3 + [1.0] * 2
    move[:, range(6, STATES), range(6, STATES)] = keep
    return move


def significance(signal: Array, nuisance: Array) -> float:
    """Length of a whitened signal (rows) outside the space of nuisances (rows x columns)."""
    scale = np.linalg.norm(nuisance, axis=0)
    kept = nuisance[:, scale > 1e-9] / scale[scale > 1e-9]
    basis, values, _ = np.linalg.svd(kept, full_matrices=False)
    basis = basis[:, values > 1e-7 * values.max()] if values.size else basis
    return float(np.linalg.norm(signal - basis @ (basis.T @ signal)))
