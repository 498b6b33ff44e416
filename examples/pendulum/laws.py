"""Which friction: told by stretches of the run that the fit did not see, the swing followed on.

A stretch by itself loses a tenth of its swing, whatever the law; over the whole run the laws part:
amplitude falls as exp(-k t / 2) with viscous friction, in a straight line with dry friction, as
1 / (1 + c t) with friction of the rate squared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Series, filter_series, shoot
from bluekoi.mismatch import Trialled, try_effects

from ..engine import Case, case, refitted, values_of, with_own_noise
from .model import SYSTEM
from .reading import FIRST_NOISE, STRETCHES

START = {"w0": 1.164, "viscous_friction.k": 0.012, "coulomb_friction.k": 0.011,
         "quadratic_friction.k": 0.012, "rate_scale.k": -0.04}  # fmt: skip
"""Where fits begin: a run of sixteen swings is followed only by a model that keeps in step."""


@dataclass(frozen=True)
class Law:
    """A model of the whole run: its effects, its numbers, its free run (frames, 2), root mean
    square errors of that (rad, rad/s), log likelihood (stretches,) of each stretch foretold from
    the others, and how many numbers a stretch has.
    """

    effects: tuple[str, ...]
    numbers: dict[str, float]
    run: Float
    rms: tuple[float, float]
    worth: Float
    observations: float


def law(whole: Series, effects: Sequence[str], parts: int = STRETCHES) -> Law:
    """The model with these effects, fitted to the whole run and to all of it but each stretch."""
    given = case(SYSTEM, [whole], FIRST_NOISE)
    first = try_effects(given.kernel, [whole], given.base, given.coefficients, effects,
                        noise=FIRST_NOISE, start=START, iterations=40)  # fmt: skip
    model = with_own_noise(given, first)
    frames = np.array_split(np.arange(len(whole.times)), parts)
    worth = np.array([_foretold(given, model, whole, part) for part in frames])
    run = shoot(given.kernel, [whole], values_of(given, model, [whole]), open_states=2,
                iterations=30)[0].observed  # fmt: skip
    angle, rate = np.sqrt(np.mean((whole.seen - run) ** 2, axis=0))
    numbers = model.fit.by_label()
    return Law(tuple(effects), numbers, run, (float(angle), float(rate)), worth,
               whole.seen.size / parts)  # fmt: skip


def _foretold(given: Case, model: Trialled, whole: Series, part: np.ndarray) -> float:
    """Log p(stretch | all the rest), numbers fitted to the rest."""
    seen = whole.seen.copy()
    seen[part] = np.nan
    rest = replace(whole, seen=seen)
    fitted = refitted(given, model.effects, model, [rest])
    values = values_of(given, fitted, [rest])[0]
    all_, some = (filter_series(given.kernel, s, values, model.noise) for s in (whole, rest))
    return all_.log_likelihood - some.log_likelihood


def weights(laws: Sequence[Law]) -> Float:
    """Weight of each law, exp(total / inflation), summing to 1.

    inflation: how many times more the log likelihood of the best law's stretches varies than that
    of as many independent errors would (half their number), at least 1.
    """
    total = np.array([one.worth.sum() for one in laws])
    best = laws[int(np.argmax(total))]
    inflation = max(1.0, float(np.var(best.worth, ddof=1) / (0.5 * best.observations)))
    raw = np.exp((total - total.max()) / inflation)
    return np.asarray(raw / raw.sum())


def turning_points(times: Float, angles: Float) -> tuple[Float, Float]:
    """Times (k,) and angles (k,) at which the pendulum turns, by parabolas through five frames."""
    t, a = times, angles
    size = np.abs(a)
    top = np.flatnonzero((size[2:-2] >= size[1:-3]) & (size[2:-2] > size[3:-1])
                         & (size[2:-2] > 0.3)) + 2  # fmt: skip
    fits = [(k, np.polyfit(t[k - 2 : k + 3] - t[k], a[k - 2 : k + 3], 2)) for k in top]
    times = np.array([t[k] - q[1] / (2 * q[0]) for k, q in fits])
    return times, np.array([q[2] - q[1] ** 2 / (4 * q[0]) for _, q in fits])
