"""The missing force along the paths, and the variables that it depends on.

The missing force is the smoothed estimate of the disturbance states of the filter around the fitted
model. Its dependence on a variable is tested by cross-validation: a smooth curve over the variable
is fitted to the other conditions and predicts the force in the condition left out. Errors that are
correlated within a trial cannot produce such a dependence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import MissingForce, TrialSeries
from ..study import Trial

FOLD_COUNT, POLYNOMIAL_DEGREE = 6, 3
MIN_INCREMENTAL_EXPLAINED_SHARE = 0.02
MAX_VARIABLES_PER_CHANNEL = 2
"""A channel's force is stated to depend on at most so many variables; each must explain this share
of all missing force beyond the variables before it. Only for the statement of where force is
missing (`where` in mismatch.json); no probability depends on it.
"""
MIN_EXPLAINED_SHARE_IN_WEAK_CHANNEL, MIN_TOTAL_SHARE_OF_WEAK_CHANNEL = 0.3, 0.002
"""In a channel where no variable explains `MIN_INCREMENTAL_EXPLAINED_SHARE`, the best one is stated
if it explains the first share of the channel's force, and this force is at least the second share
of all missing force (sums of squares, scaled).
"""
FORCE_CHANNELS = ("surge", "sway", "yaw")


@dataclass(frozen=True)
class ExplainedForceShare:
    """Share of all the missing force that a variable explains in a channel, in conditions left
    out; channels are scaled by the random force that remains in each. adds: the share that it
    explains beyond better variables of the channel; 0 where it is not among the first.
    """

    channel: int
    variable: str
    share: float
    trials: tuple[str, ...]
    adds: float = 0.0


def trial_indices_by_fold(
    series: Sequence[TrialSeries], count: int = FOLD_COUNT
) -> list[np.ndarray]:
    """Trials by fold; a condition is in one fold only, folds are about equally long."""
    conditions = sorted({s.condition for s in series})
    order = {c: i % min(count, max(len(conditions), 1)) for i, c in enumerate(conditions)}
    chosen = np.array([order[s.condition] for s in series])
    return [np.flatnonzero(chosen == k) for k in sorted(set(order.values()))]


def force_dependences(
    series: Sequence[TrialSeries],
    forces: Sequence[Float],
    variables: Sequence[Mapping[str, Float]],
    units: Float,
) -> list[ExplainedForceShare]:
    """Dependences of every channel on every variable, the largest share first.

    forces: (n, channels) of each trial. variables: one mapping a trial, name -> (n,), as `forces`
    has frames. units (channels,): size of a force in each channel that means as much as in the
    others.
    """
    parts = trial_indices_by_fold(series)
    scaled = [f / units for f in forces]
    total = max(sum(float(np.sum(y**2)) for y in scaled), 1e-300)
    found = []
    for channel in range(len(units)):
        force = [y[:, channel] for y in scaled]
        adds = _incremental_explained_shares(variables, force, parts, total)
        for name in variables[0]:
            explained = cv_explained_sum_of_squares([v[name] for v in variables], force, parts)
            order = [int(t) for t in np.argsort(-explained) if explained[t] > 0]
            trials = tuple(series[t].name for t in order[: max(3, len(order) // 4)])
            share = max(0.0, float(explained.sum())) / total
            found.append(ExplainedForceShare(channel, name, share, trials, adds.get(name, 0.0)))
    return sorted(found, key=lambda d: -d.share)


def _incremental_explained_shares(
    variables: Sequence[Mapping[str, Float]], force: Sequence[Float],
    parts: Sequence[np.ndarray], total: float,
) -> dict[str, float]:  # fmt: skip
    """Variable -> share that it explains beyond those before it, the best first."""
    adds: dict[str, float] = {}
    own = sum(float(np.sum(y**2)) for y in force) / total
    while len(adds) < MAX_VARIABLES_PER_CHANNEL:
        shares = {
            name: float(
                cv_explained_sum_of_squares([v[name] for v in variables], force, parts).sum()
            )
            / total
            for name in variables[0]
            if name not in adds
        }
        best = max(shares, key=lambda name: shares[name])
        weak = (
            not adds
            and own >= MIN_TOTAL_SHARE_OF_WEAK_CHANNEL
            and shares[best] >= MIN_EXPLAINED_SHARE_IN_WEAK_CHANNEL * own
        )
        if shares[best] < MIN_INCREMENTAL_EXPLAINED_SHARE and not weak:
            break
        adds[best] = shares[best]
        force = residualise([v[best] for v in variables], force)
    return adds


def residualise(x: Sequence[Float], y: Sequence[Float]) -> list[Float]:
    """Residuals of y after a smooth curve over x, fitted to all trials."""
    design = _chebyshev_basis(x)
    A = sum(d.T @ d for d in design) + 1e-6 * np.eye(POLYNOMIAL_DEGREE + 1)
    coefficients = np.linalg.solve(A, sum(d.T @ v for d, v in zip(design, y, strict=True)))
    return [v - d @ coefficients for d, v in zip(design, y, strict=True)]


def _chebyshev_basis(x: Sequence[Float]) -> list[Float]:
    """Chebyshev polynomials (n, degree + 1) of x over its range in all trials."""
    low, high = (float(f([f(v) for v in x])) for f in (np.min, np.max))
    scaled = [2 * (v - low) / max(high - low, 1e-12) - 1 for v in x]
    return [
        np.asarray(np.polynomial.chebyshev.chebvander(v, POLYNOMIAL_DEGREE), float) for v in scaled
    ]


def cv_explained_sum_of_squares(
    x: Sequence[Float], y: Sequence[Float], parts: Sequence[np.ndarray]
) -> Float:
    """Sum of squares of y explained by a smooth curve over x fitted to other folds, (trials,)."""
    design = _chebyshev_basis(x)
    grams = [d.T @ d for d in design]
    moments = [d.T @ v for d, v in zip(design, y, strict=True)]
    explained = np.zeros(len(y))
    for part in parts:
        rest = [t for t in range(len(y)) if t not in set(part.tolist())]
        if not rest:  # one condition: nothing to fit to
            continue
        A = sum(grams[t] for t in rest) + 1e-6 * np.eye(POLYNOMIAL_DEGREE + 1)
        coefficients = np.linalg.solve(A, sum(moments[t] for t in rest))
        for t in part:
            error = y[t] - design[t] @ coefficients
            explained[t] = float(y[t] @ y[t] - error @ error)
    return explained


def covariates(
    series: Sequence[TrialSeries], forces: Sequence[MissingForce], trials: Mapping[str, Trial]
) -> list[dict[str, Float]]:
    """What a missing force may depend on, frame by frame, for every trial."""
    return [_trial_covariates(s, f, trials[s.name]) for s, f in zip(series, forces, strict=True)]


def _trial_covariates(series: TrialSeries, force: MissingForce, trial: Trial) -> dict[str, Float]:
    x, y, psi, u, v, r = force.states[:, :6].T
    n = len(x)
    phi = trial.head_angle_rad
    u_h, v_h = u * np.cos(phi) - v * np.sin(phi), u * np.sin(phi) + v * np.cos(phi)
    beat = 2 * np.pi * series.inputs[:, 1] * series.times
    return {
        "speed_m_s": np.hypot(u, v),
        "sway_speed_m_s": v,
        "yaw_rate_rad_s": r,
        "angle_of_attack_rad": -np.arctan2(v_h, np.maximum(np.abs(u_h), 1e-3)),
        "head_angle_rad": np.full(n, phi),
        "flap_hz": series.inputs[:, 1],
        "head_length_m": np.full(n, trial.head_length_m),
        "x_m": x,
        "y_m": y,
        "time_s": series.times,
        "heading_turned_rad": np.abs(psi - psi[0]),
        "tail_beat_phase_rad": np.arctan2(np.sin(beat), np.cos(beat)),
        "side": np.full(n, np.sign(trial.head_angle_deg)),
    }
