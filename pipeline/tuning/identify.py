"""What the trials of a study determine and what not: Fisher spectrum, profiles, the trial to add.

All in relative changes of the coefficients (a change over the coefficient's size): one number says
of a combination of coefficients how far it may be off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Free, Series, fit, normal_equations
from ..integrate import LANES, Kernel, compiled
from ..integrate.batch import propagate
from ..model import constants, plates
from ..study import Setup
from .joint import OPEN, Tuned

POINTS = (-2.5, -1.25, 1.25, 2.5)
"""Where a profile is taken, in standard deviations from the fit."""
QUANTILE_95 = 1.92
"""Half of the 95 % quantile of chi squared with one degree of freedom."""
FAR = 3.0
ANGLES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0)
NEW_TRIAL_S, NEW_RATE_HZ = 5.0, 10.0


@dataclass(frozen=True)
class Combination:
    """One direction of the Fisher spectrum: unit vector (p,) in relative changes, its deviation."""

    direction: Float
    std: float

    @property
    def determined(self) -> bool:
        """Whether it is known to `OPEN`."""
        return self.std < OPEN


@dataclass(frozen=True)
class Profile:
    """Log likelihood lost by holding one coefficient at values, all others fitted anew.

    values, lost: (n,), the fit itself left out. lower, upper: where 1.92 would be lost, the 95 %
    bounds by likelihood; None where the values tried do not lose so much.
    """

    values: Float
    lost: Float
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class NewTrial:
    """A trial that would help: its condition, and what it leaves of the deviation (0 to 1)."""

    power_pct: float
    head_angle_deg: float
    head_length_m: float
    left: float


def sizes(tuned: Tuned) -> Float:
    """Size (p,) that a change of each free number is held against."""
    starts = {p.name: abs(p.start) for p in plates().parameters}
    usual = np.array([starts[f.name] for f in tuned.fit.free])
    return np.maximum(np.abs(tuned.fit.values), usual)


def spectrum(tuned: Tuned) -> list[Combination]:
    """Combinations of the free numbers by their deviation, the least determined first.

    Eigenvectors of the relative covariance; where the trials agree better than their Fisher matrix
    allows, that counts. A direction that no trial informs has a deviation of `inf`.
    """
    size = sizes(tuned)
    fisher = tuned.fit.normal.hessian.sum(axis=0) * np.outer(size, size)
    cov = tuned.cov / np.outer(size, size)
    values, vectors = np.linalg.eigh(fisher)
    blind = values < 1e-10 * values.max()
    out = [Combination(vectors[:, i], np.inf) for i in np.flatnonzero(blind)]
    seen = vectors[:, ~blind]
    among = seen.T @ cov @ seen
    spread, turned = np.linalg.eigh(among)
    naive = np.diag(turned.T @ np.diag(1.0 / values[~blind]) @ turned)
    order = np.argsort(-np.maximum(spread, naive))
    return out + [
        Combination(seen @ turned[:, i], float(np.sqrt(max(spread[i], naive[i])))) for i in order
    ]


def profile(series: Sequence[Series], tuned: Tuned, index: int) -> Profile:
    """Profile of one of the joint fit's free numbers, under the joint fit's noise."""
    kernel, found = compiled(plates()), tuned.fit
    held = found.free[index]
    parameter = plates().parameters[plates().slot[held.name]]
    unit = min(max(tuned.std[index], np.sqrt(found.naive_cov[index, index])),
               FAR * sizes(tuned)[index] / max(POINTS))  # fmt: skip
    values = np.clip(found.values[index] + unit * np.array(POINTS), parameter.lower,
                     parameter.upper)  # fmt: skip
    free = [f for i, f in enumerate(found.free) if i != index]
    lost = np.array([
        found.log_likelihood - _held_at(kernel, series, tuned, held=held, value=v, free=free)
        for v in values
    ])  # fmt: skip
    return Profile(values, lost, *_bounds(found.values[index], values, lost))


def _held_at(
    kernel: Kernel,
    series: Sequence[Series],
    tuned: Tuned,
    *,
    held: Free,
    value: float,
    free: Sequence[Free],
) -> float:
    base = tuned.base.copy()
    base[kernel.system.slot[held.name]] = value
    again = fit(kernel, series, base, free, tuned.noise, start=tuned.fit.by_label(),
                iterations=12, tolerance=3e-2)  # fmt: skip
    return again.log_likelihood


def _bounds(best: float, values: Float, lost: Float) -> tuple[float | None, float | None]:
    """Where 1.92 is lost on either side, by the square root of what is lost, along a line."""
    out: list[float | None] = []
    for side in (values < best, values > best):
        order = np.argsort(np.abs(values[side] - best))
        at = np.concatenate([[best], values[side][order]])
        root = np.concatenate([[0.0], np.sqrt(np.maximum(lost[side][order], 0.0))])
        reached = len(root) > 1 and root.max() > np.sqrt(QUANTILE_95)
        root = np.maximum.accumulate(root)
        out.append(float(np.interp(np.sqrt(QUANTILE_95), root, at)) if reached else None)
    return out[0], out[1]


def best_new_trial(
    series: Sequence[Series], tuned: Tuned, setup: Setup, combination: Combination
) -> NewTrial:
    """The trial, of those that the robot can swim, that would tell most of a combination.

    Each is simulated with the fitted coefficients and seen with the errors of the trials there are;
    its Fisher matrix is added, and what is left of the combination's deviation counts.
    """
    kernel = compiled(plates())
    conditions = _conditions(series, setup)
    imagined = [_imagined(kernel, series, tuned, setup, c) for c in conditions]
    added = normal_equations(kernel, imagined, tuned.base, tuned.fit.free, tuned.fit.values,
                             noise=tuned.noise).hessian  # fmt: skip
    size = sizes(tuned)
    scale = np.outer(size, size)
    now = tuned.fit.normal.hessian.sum(axis=0) * scale
    v = combination.direction
    before = _variance(now, v)
    left = [float(np.sqrt(_variance(now + H * scale, v) / before)) for H in added]
    best = int(np.argmin(left))
    power, angle, length = conditions[best]
    return NewTrial(float(power), angle, length, left[best])


def _variance(fisher: Float, direction: Float) -> float:
    floor = 1e-12 * np.trace(fisher) * np.eye(len(fisher))
    return float(direction @ np.linalg.solve(fisher + floor, direction))


def _conditions(series: Sequence[Series], setup: Setup) -> list[tuple[str, float, float]]:
    powers = sorted({s.group for s in series}, key=float)
    head = setup.robot.head_length_m
    return [(p, a, h) for p in powers for a in ANGLES_DEG for h in (head, 1.5 * head)]


def _imagined(
    kernel: Kernel,
    series: Sequence[Series],
    tuned: Tuned,
    setup: Setup,
    condition: tuple[str, float, float],
) -> Series:
    """A trial of that condition from rest, seen without error, with the usual errors stated."""
    power, angle, length = condition
    like = next(s for s in series if s.group == power)
    times = np.arange(round(NEW_TRIAL_S * NEW_RATE_HZ) + 1) / NEW_RATE_HZ
    inputs = np.tile([np.radians(angle), like.inputs[0, 1]], (len(times), 1))
    stated = np.nanmedian(like.noise[np.isfinite(like.seen).all(axis=1)], axis=0)
    one = replace(
        like,
        times=times,
        inputs=inputs,
        constants=constants(setup, length),
        noise=np.tile(stated, (len(times), 1, 1)),
        mean=np.zeros(len(like.mean)),
        evidence={},
        seen=np.zeros((len(times), stated.shape[0])),
    )
    return replace(one, seen=_simulated(kernel, one, tuned))


def _simulated(kernel: Kernel, series: Series, tuned: Tuned) -> Float:
    values = tuned.trial_values(kernel, [series])[0]
    observed, _ = propagate(
        kernel,
        np.repeat(series.mean[None, :, None], LANES, axis=2),
        np.repeat(values[None, :, None], LANES, axis=2),
        np.repeat(series.constants[None, :, None], LANES, axis=2),
        times=series.times[None],
        inputs=series.inputs[None],
    )
    return np.ascontiguousarray(observed[0, :, :, 0])


def by_name(names: Sequence[str], direction: Float) -> Mapping[str, float]:
    """Parts of a combination by coefficient, those that matter."""
    return {n: float(w) for n, w in zip(names, direction, strict=True) if abs(w) > 0.25}
