"""Path errors of a fitted model, and how well the recordings repeat themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Series, shoot
from bluekoi.mismatch import Trialled

from ..engine import Case, refitted, values_of
from .reading import Recording, series

FRAME_S = 1.0 / 30.0
LONGEST_SHIFT_S = 1.5
LEAST_OVERLAP_S = 1.5


def path_errors(
    given: Case, model: Trialled, trials: Sequence[Series], known_s: float = np.inf
) -> Float:
    """Root mean square path error (trials,) of free runs, m, frame by frame over whole trials.

    The six numbers of the start (place, heading, surge, sway, yaw rate) are those that suit the
    first `known_s` seconds best; what comes after is foretold.
    """
    seen = [replace(t, seen=np.where(t.times[:, None] <= known_s, t.seen, np.nan)) for t in trials]
    shots = shoot(given.kernel, seen, values_of(given, model, trials))
    return np.array([
        np.sqrt(np.mean(np.sum((t.seen[:, :2] - s.observed[:, :2]) ** 2, axis=1)))
        for t, s in zip(trials, shots, strict=True)
    ])  # fmt: skip


def left_out(
    given: Case, model: Trialled, trials: Sequence[Series], known_s: Sequence[float]
) -> dict[float, Float]:
    """`path_errors` with each condition foretold by the model fitted to the other conditions."""
    out = {known: np.zeros(len(trials)) for known in known_s}
    for condition in dict.fromkeys(t.condition for t in trials):
        own = [i for i, t in enumerate(trials) if t.condition == condition]
        rest = [s for s in given.series if s.condition != condition]
        fitted = refitted(given, model.effects, model, rest)
        for known in known_s:
            out[known][own] = path_errors(given, fitted, [trials[i] for i in own], known)
    return out


def paths_left_out(given: Case, model: Trialled, trials: Sequence[Series]) -> list[Float]:
    """Free-run paths (n, 2) of trials, each by the model fitted to the other conditions."""
    out: list[Float] = [np.zeros((0, 2))] * len(trials)
    for condition in dict.fromkeys(t.condition for t in trials):
        own = [i for i, t in enumerate(trials) if t.condition == condition]
        rest = [s for s in given.series if s.condition != condition]
        fitted, seen = refitted(given, model.effects, model, rest), [trials[i] for i in own]
        for i, shot in zip(own, shoot(given.kernel, seen, values_of(given, fitted, seen)),
                           strict=True):  # fmt: skip
            out[i] = shot.observed[:, :2]
    return out


def total(errors: Float) -> float:
    """Root mean square over trials."""
    return float(np.sqrt(np.mean(np.asarray(errors) ** 2)))


def repeatability(recordings: Sequence[Recording], known_s: float = np.inf) -> Float:
    """Distance (pairs,) between repeats of a condition, m: one laid on the other by place, heading
    and time so that the first `known_s` seconds fit best. No model of the condition alone can
    foretell one from the other better than that.
    """
    pairs = [
        (a, b) for a, b in combinations([series(r) for r in recordings], 2)
        if a.condition == b.condition
    ]  # fmt: skip
    return np.array([_apart(a, b, known_s) for a, b in pairs])


def _apart(a: Series, b: Series, known_s: float) -> float:
    shifts = np.arange(-LONGEST_SHIFT_S, LONGEST_SHIFT_S + FRAME_S / 2, FRAME_S)
    tried = [_laid_on(a, b, float(shift), known_s) for shift in shifts]
    fit, apart = min(tried)
    return apart if np.isfinite(fit) else float("nan")


def _laid_on(a: Series, b: Series, shift: float, known_s: float) -> tuple[float, float]:
    """Misfit over the known stretch, and distance over the whole overlap, of b laid on a."""
    first, last = max(a.times[0], b.times[0] + shift), min(a.times[-1], b.times[-1] + shift)
    if last - first < LEAST_OVERLAP_S:
        return float("inf"), float("nan")
    times = np.arange(first, last, FRAME_S)
    p, q = _plane(a, times), _plane(b, times - shift)
    known = times <= first + known_s
    turn = np.vdot(q[known] - q[known].mean(), p[known] - p[known].mean())
    turn /= max(abs(turn), 1e-12)
    laid = turn * (q - q[known].mean()) + p[known].mean()
    square = np.abs(p - laid) ** 2
    return float(np.sqrt(square[known].mean())), float(np.sqrt(square.mean()))


def _plane(one: Series, times: Float) -> np.ndarray:
    """Path as complex numbers at given times."""
    return np.interp(times, one.times, one.seen[:, 0]) + 1j * np.interp(
        times, one.times, one.seen[:, 1]
    )
