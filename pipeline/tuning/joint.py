"""One set of coefficients for all powers, from whole trajectories of all trials at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Float
from ..fitting import (
    Fit,
    Free,
    Noise,
    Series,
    Spread,
    fit,
    fit_noise,
    moving,
    spread_over_trials,
    thinned,
    trial_values,
)
from ..integrate import Kernel, compiled
from ..model import COEFFICIENTS, plates

HEAD_ANGLE = 3
FIRST_NOISE = Noise(
    np.array([0.005, 0.005, 0.0005, 3e-4, 3e-4, 3e-3]),
    np.array([0.5, 0.5, 0.5, 0.2, 0.2, 0.2]),
    np.ones(4),
)
"""Before it is fitted: 5 mN, 5 mN, 0.5 mN m of water, forgotten within 0.5 s; tracking errors of
0.3 mm and 0.17 degrees, forgotten within 0.2 s; white noise as stated."""


def thin(series: Sequence[Series]) -> list[Series]:
    """The trials as fits take them: about ten observations a second, head angle once a trial."""
    return [thinned(s, constant=(HEAD_ANGLE,)) for s in series]


@dataclass(frozen=True)
class Tuned:
    """A joint fit, its noise, and its covariance (p, p) from how its trials disagree.

    freedom (p,): degrees of freedom of each variance, None where the normal law is to do.
    """

    fit: Fit
    noise: Noise
    cov: Float
    base: Float
    freedom: Float | None = None

    @property
    def std(self) -> Float:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.cov))

    @property
    def interval_95(self) -> Float:
        """Bounds (p, 2) that hold the truth in 95 of 100 studies."""
        many = np.full(len(self.std), 1e9) if self.freedom is None else self.freedom
        half = Spread(self.cov, many).half_widths(0.95)
        return self.fit.values[:, None] + np.outer(half, [-1.0, 1.0])

    def trial_values(self, kernel: Kernel, series: Sequence[Series]) -> list[Float]:
        """Full parameter vector for each trial."""
        return [
            trial_values(kernel, self.base, self.fit.free, self.fit.values, s.group) for s in series
        ]


def tune(
    series: Sequence[Series],
    free: Sequence[Free] | None = None,
    *,
    base: Float | None = None,
    noise: Noise | None = None,
    start: dict[str, float] | None = None,
) -> Tuned:
    """Joint fit of the free numbers (default: the six coefficients); without `noise` that too."""
    kernel = compiled(plates())
    free = tuple(free or (Free(p.name) for p in COEFFICIENTS))
    base = plates().values({}) if base is None else base
    found = fit(kernel, series, base, free, noise or FIRST_NOISE, start=start)
    if noise is None:
        points = [trial_values(kernel, base, free, found.values, s.group) for s in series]
        noise = fit_noise(kernel, series, points, FIRST_NOISE, rounds=5)
        found = fit(kernel, series, base, free, noise, start=found.by_label())
    spread = spread_over_trials(found.normal, moving(kernel, found))
    return Tuned(found, noise, spread.cov, base, spread.freedom)


def table(tuned: Tuned) -> dict[str, dict[str, Any]]:
    """Coefficient -> value, std, interval_95, naive_std, unit, whether determined, and why not."""
    parameters = {p.name: p for p in plates().parameters}
    naive = np.sqrt(np.diag(tuned.fit.naive_cov))
    return {
        f.label: {
            "value": float(tuned.fit.values[i]),
            "std": float(tuned.std[i]),
            "interval_95": tuned.interval_95[i],
            "naive_std": float(naive[i]),
            "unit": parameters[f.name].unit,
            **determined(
                f.name,
                float(tuned.fit.values[i]),
                float(max(_as_normal(tuned.interval_95[i]), naive[i])),
            ),
        }
        for i, f in enumerate(tuned.fit.free)
    }


def _as_normal(interval: Sequence[float]) -> float:
    """Standard deviation of a normal distribution with this 95 % interval: wide where few trials
    could disagree.
    """
    return 0.5 * (interval[1] - interval[0]) / 1.96


def determined(name: str, value: float, std: float) -> dict[str, Any]:
    """Whether a number is determined (deviation below 30 % of it or of its usual size), and why."""
    parameter = {p.name: p for p in plates().parameters}[name]
    size = max(abs(value), abs(parameter.start))
    at_bound = value <= parameter.lower or value >= parameter.upper
    yes = bool(np.isfinite(std) and std < 0.3 * size and not at_bound)
    reason = "" if yes else _reason(at_bound and std < 0.3 * size, std, size)
    return {"determined": yes, "why": reason}


def _reason(at_bound: bool, std: float, size: float) -> str:
    if at_bound:
        return "at the edge of what is plausible: the data ask for physics that is not in the model"
    return (
        f"its deviation is {100 * std / size:.0f} % of its size: these trials hardly depend on it"
    )
