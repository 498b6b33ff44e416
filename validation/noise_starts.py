"""What other starts of the noise estimate gain, and what more work does.

The estimate of the random forces begins at forces as first estimated. Others begin at a share of
these, with another correlation time, or at another random current. For the model without causes
and for the most probable set of a measured study: log joint density that is reached from another
start, or with twice the rounds and steps (`engine.own_noise.MAX_NOISE_ROUNDS`, `NOISE_STEPS`), less
that from the first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from bluekoi.engine import fit_cause_set, fit_noise_and_parameters, search_cause_sets
from bluekoi.engine.fitted_sets import FittedCauseSets
from bluekoi.engine.noise_estimation import (
    MAX_NOISE_ROUNDS,
    NOISE_STEPS,
    noise_with_small_random_forces,
)
from bluekoi.engine.problem import CauseSearchProblem
from bluekoi.fitting import Noise, random_state_indices
from bluekoi.model.random_current import EFFECT_STATE_NAMES as CURRENT_STATE_NAMES

from .search_limits import study_problem

SHARES, CORRELATION_TIMES_S = (0.005, 0.05, 0.5), (0.05, 0.5, 5.0)
CURRENT_FACTORS = (0.1, 10.0)
"""Other random currents, over that with which the estimate begins."""
Gains = dict[str, float]
"""Start -> log joint density gained; `more work`: the first start, twice the rounds and steps."""


def other_start_gains(study: Path, results: Path) -> list[Gains]:
    """Gains of the sets of a measured study, all of whose trials are fitted."""
    problem, start = study_problem(study, results)
    return gains_of_sets(search_cause_sets(problem, start), start)


def gains_of_sets(visited: FittedCauseSets, start: Mapping[str, float]) -> list[Gains]:
    """Gains of the model without causes and of the most probable set, where that is another one."""
    return [
        _gains(visited, key, start) for key in dict.fromkeys([frozenset(), visited.best.model.key])
    ]


def _gains(visited: FittedCauseSets, key: frozenset[str], start: Mapping[str, float]) -> Gains:
    problem, model = visited.problem, visited.sets[key].model
    known = {**start, **model.fit.values_by_label()}
    starts = {
        f"{share:g}  {time:g} s": noise_with_small_random_forces(
            problem, problem.noise, share=share, time_s=time
        )
        for share, time in product(SHARES, CORRELATION_TIMES_S)
    } | _noises_with_other_currents(problem)

    def reached(noise: Noise, factor: int = 1) -> float:
        begun = fit_cause_set(problem, model.causes, noise, known)
        return fit_noise_and_parameters(problem, begun, most=factor * MAX_NOISE_ROUNDS,
                             steps=factor * NOISE_STEPS).log_joint  # fmt: skip

    first = reached(problem.noise)
    gains = {name: reached(noise) - first for name, noise in starts.items()}
    return gains | {"more work": reached(problem.noise, 2) - first}


def _noises_with_other_currents(problem: CauseSearchProblem) -> dict[str, Noise]:
    """Start -> noise; none of a problem without a random current."""
    noise, system = problem.noise, problem.kernel.system
    slots = random_state_indices(problem.kernel)[: len(noise.disturbance)]
    own = np.array([system.all_states[slot] in CURRENT_STATE_NAMES for slot in slots])
    if not own.any():
        return {}
    return {f"current x {k:g}": replace(noise, disturbance=noise.disturbance * np.where(own, k, 1))
            for k in CURRENT_FACTORS}  # fmt: skip


def gain_table(gains: Sequence[Gains]) -> str:
    """Lines: start (share of the random forces and their correlation time, or current), median and
    largest gain over the sets, and in how many sets the start comes within 1 of the best of all.
    """
    best = [max(0.0, *one.values()) for one in gains]
    lines = [f"{len(gains)} sets: start, gain in the median, largest, near best"]
    for start in gains[0]:
        own = np.array([one[start] for one in gains])
        near = sum(max(value, 0.0) > top - 1.0 for value, top in zip(own, best, strict=True))
        lines.append(f"{start}  {np.median(own):.1f}  {own.max():.1f}  {near} of {len(own)}")
    return "\n".join(lines)
