"""Errors after two seconds as others published them; what each drop tells of ball and camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bluekoi.fitting import Series, filter_all
from bluekoi.mismatch import Trialled

from ..engine import Case, narrowed, refitted, values_of, with_own_noise
from ..forecasting import Forecast, forecast, state_of
from .model import GRAVITY

TRAINED_S = 2.0
PUBLISHED_M2 = {
    "Baseball": 0.300,
    "Blue Basketball": 0.620,
    "Green Basketball": 0.088,
    "Volleyball": 0.111,
    "Bowling Ball": 0.413,
    "Golf Ball": 0.009,
    "Tennis Ball": 0.091,
    "Whiffle Ball 1": 1.58,
    "Whiffle Ball 2": 1.175,
    "Yellow Whiffle Ball": 0.428,
    "Orange Whiffle Ball": 17.2,
}
"""Mean square errors (m2) over the frames after 2 s of each ball's first drop, of expressions found
in the frames until 2 s of that drop. Source: Sun, Liu, Wang and Sun, Symbolic Physics Learner, ICLR
(2023), experiment on ball drops; recordings of de Silva et al., Front. Artif. Intell. 3 (2020), 25.
"""

Balls = Mapping[str, tuple[Series, ...]]


@dataclass(frozen=True)
class Drop:
    """What one drop tells, each with its deviation: drag coefficient of the ball, share by which
    its lengths are seen too long, moment of release (s after the first frame).
    """

    name: str
    drag: tuple[float, float]
    scale: tuple[float, float]
    release_s: tuple[float, float]


def others(given: Case, effects: Sequence[str], like: Trialled, ball: str) -> Trialled:
    """The model with these effects and its noise, fitted to all balls but one."""
    rest = narrowed(given, [s for s in given.series if s.group != ball])
    return with_own_noise(rest, refitted(rest, effects, like), rounds=1)


def rest_of_fall(given: Case, model: Trialled, drop: Series) -> Forecast:
    """A drop after its first two seconds, told by these and a model of the other balls."""
    values = values_of(given, model, [drop])[0]
    return forecast(given.kernel, drop, values, model.noise, TRAINED_S)


def drag_gain(given: Case, model: Trialled, drops: Sequence[Series]) -> float:
    """Log likelihood that the others' drag adds to a ball's drops, which it was not fitted to."""
    values = values_of(given, model, drops)
    without = [v.copy() for v in values]
    for v in without:
        v[given.system.slot["air_drag.C"]] = 0.0
    both = (filter_all(given.kernel, drops, v, model.noise) for v in (values, without))
    with_drag, bare = (sum(f.log_likelihood for f in found) for found in both)
    return float(with_drag - bare)


def told(given: Case, model: Trialled, drops: Sequence[Series]) -> list[Drop]:
    """A `Drop` for each drop, from all of it."""
    return [_told(given, model, drop) for drop in drops]


def _told(given: Case, model: Trialled, drop: Series) -> Drop:
    values = values_of(given, model, [drop])[0]
    C = float(values[given.system.slot["air_drag.C"]])
    z, s, w = (state_of(given.kernel, drop, values, model.noise, n) for n in ("z", "s", "w"))
    release = (float(drop.times[0]) + w[0] / GRAVITY, w[1] / GRAVITY)
    return Drop(drop.name, (C * (1.0 + z[0]), C * z[1]), s, release)
