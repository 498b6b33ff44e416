"""How strong an effect must be to leave a wanted path error when all the rest is refitted.

The rest: six coefficients, the fin where there is one, and each trial's state at release. Their
first-order changes of path and heading (finite differences of this tank) span what a refit can
take up; what is left over of an effect's change of the path is the error that it leaves.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from validation.generators.concealed.recipe import ChosenEffect, Recipe, effect_by_name, with_effect
from validation.generators.concealed.swimmer.inputs import (
    NO_EDDIES,
    BodyParameters,
    HiddenLaws,
    TrialCommand,
)
from validation.generators.concealed.swimmer.motion import states

__all__ = [
    "HEADING_ARM_M",
    "refit_basis",
    "rms_after_refit",
    "simulated_paths",
    "strength_for_path_error",
]

STEP_S, KEEP = 1 / 120, 8
HEADING_ARM_M = 0.15
"""Weight of headings beside places: 1 mm against 0.4 degrees."""
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
RELEASE_STEPS = {"u": 0.002, "v": 0.002, "r": 0.01}
MAX_SECANT_STEPS = 5

TimedCommands = Sequence[tuple[TrialCommand, float]]


def simulated_paths(body: BodyParameters, laws: HiddenLaws, trials: TimedCommands) -> np.ndarray:
    """x, y, heading arm (m) of all trials one after the other, `(3, samples)`, still water."""
    calm = body._replace(pulse=0.0)
    parts = []
    for command, duration_s in trials:
        found = states(calm, laws, command, NO_EDDIES, int(duration_s / STEP_S), STEP_S, KEEP)
        shift = laws.com_shift_m * np.stack([np.cos(found[:, 2]), np.sin(found[:, 2])])
        parts.append(np.vstack([found[:, :2].T - shift, HEADING_ARM_M * found[None, :, 2]]))
    return np.concatenate(parts, axis=1)


def _columns_by_trial(column: np.ndarray, sizes: Sequence[int]) -> list[np.ndarray]:
    """A change of all paths `(3, samples)` cut into one column a trial, zero elsewhere."""
    ends = np.cumsum([0, *sizes])
    out = []
    for low, high in pairwise(ends):
        alone = np.zeros_like(column)
        alone[:, low:high] = column[:, low:high]
        out.append(alone)
    return out


def refit_basis(body: BodyParameters, laws: HiddenLaws, trials: TimedCommands) -> np.ndarray:
    """Orthonormal basis `(3 samples, directions)` of what a refit of the rest can take up."""
    base = simulated_paths(body, laws, trials)
    sizes = [int(d / STEP_S) // KEEP + 1 for _, d in trials]
    columns = [
        simulated_paths(body._replace(**{n: getattr(body, n) * 1.01}), laws, trials) - base
        for n in COEFFICIENTS
    ]
    if laws.fin_m2 > 0:
        for name in ("fin_m2", "fin_arm_m"):
            changed = laws._replace(**{name: getattr(laws, name) * 1.01})
            columns.append(simulated_paths(body, changed, trials) - base)
    for name, step in RELEASE_STEPS.items():
        moved = [(c._replace(**{name: step}), d) for c, d in trials]
        columns += _columns_by_trial(simulated_paths(body, laws, moved) - base, sizes)
    for direction in ((1.0, 0.0), (0.0, 1.0)):
        shift = np.zeros_like(base)
        shift[:2] = np.array(direction)[:, None]
        columns += _columns_by_trial(shift, sizes)
    places = np.concatenate([np.repeat([[c.x], [c.y]], n, axis=1)
                             for (c, _), n in zip(trials, sizes, strict=True)], axis=1)  # fmt: skip
    turn = np.stack([places[1] - base[1], base[0] - places[0], np.full_like(base[2], 0.15)])
    columns += _columns_by_trial(turn, sizes)
    flat = np.stack([c.ravel() for c in columns], axis=1)
    flat /= np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
    left, sizes_of, _ = np.linalg.svd(flat, full_matrices=False)
    return left[:, sizes_of > 1e-6 * sizes_of[0]]


def rms_after_refit(basis: np.ndarray, change: np.ndarray) -> float:
    """Root mean square path error (m) that a change `(3, samples)` leaves after the refit."""
    flat = change.ravel()
    rest = (flat - basis @ (basis.T @ flat)).reshape(change.shape)
    return float(np.sqrt(np.mean(np.sum(rest[:2] ** 2, axis=0))))


def strength_for_path_error(
    recipe: Recipe, laws: HiddenLaws, chosen: ChosenEffect, trials: TimedCommands, *, noise_m: float
) -> tuple[float, float]:
    """Strength of a chosen effect, and the path error (m) that it leaves at that strength."""
    effect = effect_by_name(chosen.name)
    basis = refit_basis(recipe.body, laws, trials)
    base = simulated_paths(recipe.body, laws, trials)

    def error(strength: float) -> float:
        changed = simulated_paths(recipe.body, with_effect(laws, chosen, strength), trials)
        return rms_after_refit(basis, changed - base)

    return _secant_solve(error, chosen.ratio * noise_m, effect.usual, effect.most)


def _secant_solve(
    error: Callable[[float], float], wanted: float, start: float, most: float
) -> tuple[float, float]:
    """Strength whose error is the wanted one, or the largest plausible, by secants of logs."""
    strength, slope = start, 1.0
    found = error(strength)
    for _ in range(MAX_SECANT_STEPS):
        factor = (wanted / max(found, 1e-9)) ** (1 / slope)
        tried = float(np.clip(strength * np.clip(factor, 0.05, 8.0), 1e-6 * most, most))
        if abs(tried / strength - 1) < 0.03:
            break
        now = error(tried)
        rise = np.log(max(now, 1e-9) / max(found, 1e-9)) / np.log(tried / strength)
        slope = float(np.clip(rise, 0.3, 2.5)) if np.isfinite(rise) else 1.0
        strength, found = tried, now
    return strength, found
