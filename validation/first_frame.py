"""Which accuracy of the start of a trial the measured studies support.

Log likelihood of the model without causes, with its own noise, for other standard deviations of the
starting time in each trial (`START_TIME_STD_S`) and of the velocities in the first frame of trials
that begin at rest (`RESTING_VELOCITY_STD`), less that for the values in use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bluekoi.engine.noise_estimation import fit_without_causes
from bluekoi.engine.problem import CauseSearchProblem
from bluekoi.fitting import TrialSeries

from .search_limits import study_problem

START_TIME_PARAMETER = "time_offset.start_delay"
VELOCITIES = slice(3, 6)
TIME_FACTORS = (0.25, 0.5, 2.0, 4.0)
VELOCITY_FACTORS = (0.25, 0.5, 2.0, 5.0)
Gains = dict[str, float]
"""Factor on one of the standard deviations -> log likelihood gained."""


def first_frame_gains(study: Path, results: Path) -> Gains:
    """Gains of a measured study, all of whose trials are fitted."""
    problem, start = study_problem(study, results)
    return gains_of_problem(problem, start)


def gains_of_problem(problem: CauseSearchProblem, start: Mapping[str, float]) -> Gains:
    """Gains of a problem of robot trials."""
    others = {f"start time x {k:g}": _with_start_time_std(problem, k) for k in TIME_FACTORS}
    others |= {f"velocity x {k:g}": _with_resting_velocity_std(problem, k)
               for k in VELOCITY_FACTORS}  # fmt: skip
    first = _log_likelihood(problem, start)
    return {name: _log_likelihood(other, start) - first for name, other in others.items()}


def _log_likelihood(problem: CauseSearchProblem, start: Mapping[str, float]) -> float:
    return float(fit_without_causes(problem, dict(start)).log_likelihood)


def _with_start_time_std(problem: CauseSearchProblem, factor: float) -> CauseSearchProblem:
    effects = tuple(replace(e, std=factor * e.std) if e.parameter == START_TIME_PARAMETER else e
                    for e in problem.noise.trial_effects)  # fmt: skip
    return replace(problem, noise=replace(problem.noise, trial_effects=effects))


def _with_resting_velocity_std(problem: CauseSearchProblem, factor: float) -> CauseSearchProblem:
    """The problem with other deviations where a trial begins at rest: its mean velocities are 0."""
    return replace(problem, series=tuple(
        one if np.any(one.mean[VELOCITIES]) else _with_velocity_std(one, factor)
        for one in problem.series))  # fmt: skip


def _with_velocity_std(one: TrialSeries, factor: float) -> TrialSeries:
    scale = np.ones(len(one.cov))
    scale[VELOCITIES] = factor
    return replace(one, cov=one.cov * np.outer(scale, scale))


def gain_table(found: Sequence[Gains]) -> str:
    """Lines: what is changed, and minimum, median and maximum of the gains of all studies."""
    rows = [f"{'standard deviation':<20}{'least':>8}{'median':>8}{'most':>8}"]
    for name in found[0]:
        gains = np.array([one[name] for one in found])
        rows.append(f"{name:<20}{gains.min():8.1f}{np.median(gains):8.1f}{gains.max():8.1f}")
    return "\n".join(rows)
