"""What the trials of a study determine and what not: Fisher spectrum and profiles.

All in relative changes of the coefficients (a change over the coefficient's size): one number says
of a combination of coefficients how far it may be off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import Z_95, FilterResults, TrialSeries, filter_all, fit_parameters_jointly
from ..integrate.batch import threaded_map
from .bounds import bound_sides
from .joint_fit import UNDETERMINED_ABOVE_RELATIVE_STD, JointFit
from .similar_robots import compiled_trial_system

PROFILE_POINTS_STDS = (-2.5, -1.25, -0.6, 0.6, 1.25, 2.5)
"""Where a profile is taken, in standard deviations from the fit."""
HALF_CHI2_95 = 1.92
"""Half of the 95 % quantile of chi squared with one degree of freedom."""
PROFILE_RANGE_STDS = 3.0
"""Half range of a profile, in standard deviations."""


@dataclass(frozen=True)
class ParameterCombination:
    """One direction of the Fisher spectrum: unit vector (p,) in relative changes, its deviation.

    std: that of a normal law with its 95 % interval, or the naive one where that is larger; `inf`
    if no trial determines it, or only one. naive: by the Fisher matrix. side: `lower` or `upper`
    of one number that stands at a bound, which is not determined however near it is held.
    """

    direction: Float
    std: float
    naive: float = np.inf
    side: str = ""

    @property
    def determined(self) -> bool:
        """Whether it is known to `UNDETERMINED_ABOVE_RELATIVE_STD`."""
        return self.std < UNDETERMINED_ABOVE_RELATIVE_STD and not self.side


@dataclass(frozen=True)
class LikelihoodProfile:
    """Log likelihood lost by holding one coefficient at values, all others refitted.

    values, lost: (n,), the fit itself left out. lower, upper: where 1.92 would be lost, the 95 %
    bounds by likelihood; None where the values tried do not lose so much.
    """

    values: Float
    lost: Float
    lower: float | None
    upper: float | None


def parameter_scales(tuned: JointFit) -> Float:
    """Size (p,) that a change of each free number is held against."""
    usual = np.array([abs(p.start) for p in tuned.fit.definitions])
    return np.maximum(np.abs(tuned.fit.values), usual)


def fisher_eigendirections(tuned: JointFit) -> list[ParameterCombination]:
    """Combinations of the free numbers by their deviation, the least determined first.

    Eigenvectors of the relative covariance, with the widths that the table has: Student's t with
    each combination's degrees of freedom, of which one trial alone gives none. Where the trials
    agree better than their Fisher matrix allows, that counts. Numbers at a bound stand alone.
    """
    held = bound_sides(tuned.fit)
    out = [
        _combination_at_bound(tuned, i) for i, side in enumerate(held) if side
    ] + _combinations_off_bounds(tuned, held)
    return sorted(out, key=lambda one: (one.std, one.naive), reverse=True)


def _combination_at_bound(tuned: JointFit, index: int) -> ParameterCombination:
    """A number at its bound; its interval is one-sided."""
    alone, size = np.eye(len(tuned.std))[index], parameter_scales(tuned)[index]
    width = float(np.diff(tuned.interval_95[index])[0])
    std = width / Z_95 / size if np.isfinite(width) else np.inf
    return ParameterCombination(alone, std, side=bound_sides(tuned.fit)[index])


def _combinations_off_bounds(tuned: JointFit, held: Sequence[str]) -> list[ParameterCombination]:
    """Combinations of the numbers that are off their bounds."""
    own = np.flatnonzero([not side for side in held])
    if not len(own):
        return []
    axes = np.eye(len(held))[:, own]
    size = parameter_scales(tuned)
    scale = np.outer(size, size)
    fisher = axes.T @ (tuned.fit.normal.hessian.sum(axis=0) * scale) @ axes
    values, vectors = np.linalg.eigh(fisher)
    blind = values < 1e-10 * values.max()
    seen = vectors[:, ~blind]
    _, turned = np.linalg.eigh(seen.T @ axes.T @ (tuned.cov / scale) @ axes @ seen)
    naive = np.sqrt(np.diag(turned.T @ np.diag(1.0 / values[~blind]) @ turned))
    determined = [
        _combination_along_direction(tuned, axes @ seen @ v, n)
        for v, n in zip(turned.T, naive, strict=True)
    ]
    return [ParameterCombination(axes @ v, np.inf) for v in vectors[:, blind].T] + determined


def _combination_along_direction(
    tuned: JointFit, direction: Float, naive: float
) -> ParameterCombination:
    std = tuned.covariance.half_width(direction / parameter_scales(tuned)) / Z_95
    return ParameterCombination(direction, max(std, float(naive)), float(naive))


def likelihood_profiles(series: Sequence[TrialSeries], tuned: JointFit) -> list[LikelihoodProfile]:
    """Profiles of the joint fit's free numbers, under the joint fit's noise and the gains of its
    filter: as predictor of one form, the fit is the likeliest (Ljung, System Identification, 1999,
    7.2), which it need not be when the gains of a model that lacks something move with it.
    """
    kernel = compiled_trial_system(series)
    predictor = filter_all(
        kernel, series, tuned.parameter_vectors_by_trial(kernel, series), tuned.noise
    )
    return threaded_map(
        lambda index: _profile_likelihood(series, tuned, index, predictor),
        range(len(tuned.fit.free)),
    )


def _profile_likelihood(
    series: Sequence[TrialSeries], tuned: JointFit, index: int, predictor: FilterResults
) -> LikelihoodProfile:
    """Profile of one free number, under held gains."""
    kernel, found = compiled_trial_system(series), tuned.fit
    held, parameter = found.free[index], found.definitions[index]
    largest = PROFILE_RANGE_STDS * parameter_scales(tuned)[index] / max(PROFILE_POINTS_STDS)
    unit = min(max(tuned.std[index], np.sqrt(found.naive_cov[index, index])), largest)
    values = np.clip(found.values[index] + unit * np.array(PROFILE_POINTS_STDS), parameter.lower,
                     parameter.upper)  # fmt: skip
    free = [f for i, f in enumerate(found.free) if i != index]

    def likelihood(value: float) -> float:
        base = tuned.base.copy()
        base[kernel.system.parameter_index[held.name]] = value
        return fit_parameters_jointly(
            kernel,
            series,
            base,
            free,
            tuned.noise,
            start=found.values_by_label(),
            iterations=12,
            tolerance=3e-2,
            predictor=predictor,
        ).log_likelihood

    lost = found.log_likelihood - np.array([likelihood(value) for value in values])
    return LikelihoodProfile(values, lost, *_profile_interval(found.values[index], values, lost))


def _profile_interval(best: float, values: Float, lost: Float) -> tuple[float | None, float | None]:
    """Where 1.92 is lost on either side, by the square root of what is lost, along a line."""
    out: list[float | None] = []
    for side in (values < best, values > best):
        order = np.argsort(np.abs(values[side] - best))
        at = np.concatenate([[best], values[side][order]])
        root = np.concatenate([[0.0], np.sqrt(np.maximum(lost[side][order], 0.0))])
        reached = len(root) > 1 and root.max() > np.sqrt(HALF_CHI2_95)
        root = np.maximum.accumulate(root)
        out.append(float(np.interp(np.sqrt(HALF_CHI2_95), root, at)) if reached else None)
    return out[0], out[1]


def parts_by_coefficient(names: Sequence[str], direction: Float) -> Mapping[str, float]:
    """Parts of a combination by coefficient, those that matter."""
    return {n: float(w) for n, w in zip(names, direction, strict=True) if abs(w) > 0.25}
