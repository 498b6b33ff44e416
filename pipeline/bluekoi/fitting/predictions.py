"""Predictions of a filter whose gains are held, of all trials and all differences in one call.

Sixteen lanes hold a trial and fifteen differences; a trial with more free numbers has more blocks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import map_ranges_in_threads, simulate_batch
from .filtering import MAX_FILTER_STEP_S, FilterResults, parameters_with_random_effects_on
from .gram import add_whitened_column_products
from .series import FreeParameter, Noise

CHANGES_PER_BLOCK = LANES - 1
RELATIVE_FINITE_DIFFERENCE_STEP = 1e-6
"""Relative size of differences: predictions are exact to 1e-12 and curved over one standard
deviation, which may be a thousandth of a number.
"""


@dataclass(frozen=True)
class ParameterChange:
    """A difference in parameters: its size, the trials (t,) that have it, and the parameters.

    slots: place -> how much of the step goes there; offsets: place -> change that does not count
    as part of the step (another form of a law while its strength is differenced).
    """

    step: float
    trials: np.ndarray
    slots: Mapping[int, float]
    offsets: Mapping[int, float] = field(default_factory=dict)


def parameter_index_by_name(kernel: CompiledSystem) -> dict[str, int]:
    """Place of every parameter by name."""
    return kernel.system.parameter_index


def finite_difference_step(kernel: CompiledSystem, free: FreeParameter, value: float) -> float:
    """Size of the difference in a free number, away from its upper bound.

    A share `RELATIVE_FINITE_DIFFERENCE_STEP` of the number, or of a twentieth of its plausible
    magnitude.
    """
    parameter = kernel.system.parameters[parameter_index_by_name(kernel)[free.name]]
    typical = parameter.typical_magnitude if np.isfinite(parameter.typical_magnitude) else 0.0
    step = RELATIVE_FINITE_DIFFERENCE_STEP * max(abs(value), 0.05 * typical, 1e-6)
    return -step if value + step > parameter.upper else step


def whitened_gram_matrices(
    kernel: CompiledSystem,
    passes: FilterResults,
    points: Sequence[Float],
    changes: Sequence[ParameterChange],
    noise: Noise,
) -> Float:
    """Products (trials, 1 + p, 1 + p) of the columns e, J_1 ... J_p of each trial.

    e are the whitened prediction errors at a full parameter vector of its own, J_k how the whitened
    predictions go with change k, per unit; 0 where a trial does not have it.
    """
    steps = np.array([1.0, *(c.step for c in changes)])
    own = np.array([c.trials for c in changes], dtype=bool).reshape(len(changes), len(passes)).T
    counts = own.sum(axis=1)
    first = np.cumsum([0, *np.maximum(1, -(-counts // CHANGES_PER_BLOCK))])
    trials = np.repeat(np.arange(len(passes)), np.diff(first))
    full = parameters_with_random_effects_on(kernel, np.array(points).T, noise).T
    values = np.repeat(full[trials][:, :, None], LANES, axis=2)
    column = np.cumsum(own, axis=1) - 1
    places = np.zeros((len(passes), 1 + int(counts.max(initial=0))), dtype=np.int64)
    for k, change in enumerate(changes):
        having = np.flatnonzero(own[:, k])
        places[having, column[having, k] + 1] = k + 1
        block, lane = np.divmod(column[having, k], CHANGES_PER_BLOCK)
        for slot, weight in change.slots.items():
            values[first[having] + block, slot, lane + 1] += weight * change.step
        for slot, offset in change.offsets.items():
            values[first[having] + block, slot, lane + 1] += offset
    observed = _predicted_observations(kernel, passes, values, trials)
    out = np.zeros((len(passes), len(steps), len(steps)))
    given = (
        observed,
        passes.padded_observations,
        passes.inverse_innovation_cholesky,
        passes.frame_counts,
        first,
        places,
        1 + counts,
    )
    map_ranges_in_threads(
        lambda *ends: add_whitened_column_products(*given, ends, out), len(passes)
    )
    return out / (steps[:, None] * steps)


def _predicted_observations(
    kernel: CompiledSystem, passes: FilterResults, values: Float, trials: np.ndarray
) -> Float:
    """Predicted observations (blocks, frames, observations, 16) of the trials of the blocks, at
    values (blocks, parameters, 16) with the random parts switched on.
    """

    def of_blocks(rows: Float) -> Float:
        return rows if len(trials) == len(rows) else rows[trials]

    mean, constants = (np.array([getattr(s, k) for s in passes.series])[trials]
                       for k in ("mean", "constants"))  # fmt: skip
    observed, _ = simulate_batch(
        kernel, np.repeat(mean[:, :, None], LANES, axis=2), values,
        np.repeat(constants[:, :, None], LANES, axis=2),
        times=of_blocks(passes.times), inputs=of_blocks(passes.inputs),
        frames=of_blocks(passes.frame_counts), seen=of_blocks(passes.padded_observations),
        gains=of_blocks(passes.gains), step_s=kernel.system.longest_step_s(MAX_FILTER_STEP_S),
    )  # fmt: skip
    return observed
