"""How far from the recordings a model ends when it runs freely, and how far a true one would.

A model that does not swim straight by itself cannot be run freely for long: a millimetre at the
start has grown to metres at the end, whatever the model is worth. Paths are therefore compared over
stretches as long as the best model bears, each started where it suits best. A worse model that
bears less than that is charged with it: the robot did swim so.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Noise, Series, filter_all, filter_series, shoot
from ..fitting.filtering import disturbance_slots, with_noise
from ..integrate import LANES, Kernel
from ..integrate.batch import each, propagate
from ..study import Study
from ..tuning import Tuned
from ..tuning.stability import growth_per_s
from .setting import split

GROWTH = 6.0
"""Small differences may grow by e^6 = 400 over a stretch: from 0.1 mm to 40 mm."""
SHORTEST_S = 1.0
FLOOR_SEED = 20240517
FLOOR_DRAWS = 3
OWN_SHARES = (0.06, 0.12, 0.25, 0.5, 2.0)
HARDLY_SEEN = 5.0
"""Where a keypoint was off for a frame the track states 20 to 40 mm in place of 0.4: one such frame
is not to make up half of the error of six paths.
"""
STATE_STD = np.array([0.1, 0.1, 0.1, 0.2, 0.2, 1.0])
"""Deviations of a state told from nearby frames: m, m, rad, m/s, m/s, rad/s; of the place as
much as the centre of mass may be off the keypoint."""


@dataclass(frozen=True)
class PathErrors:
    """Model -> root mean square path error, m; the floor, m; length of the stretches, s."""

    rmse_m: Mapping[str, float]
    floor_m: float
    horizon_s: float


def path_errors(
    study: Study, kernel: Kernel, models: Mapping[str, Tuned], series: Sequence[Series]
) -> PathErrors:
    """`PathErrors` of models on trials, over stretches that the last of them, the best, bears.

    The floor is the error of the last model on data made by itself with its random forces and its
    measuring noise: what remains where nothing is wrong; NaN where that model runs away.
    """
    longest = max(float(s.times[-1] - s.times[0]) for s in series)
    last = list(models.values())[-1]
    horizon = min(longest, bearable_s(study, kernel, last, series))
    pieces = {n: begun(kernel, tuned, series, horizon) for n, tuned in models.items()}
    rmse = {name: _rmse(kernel, tuned, pieces[name]) for name, tuned in models.items()}
    rng, own = np.random.default_rng(FLOOR_SEED), list(pieces.values())[-1]
    still = stillness(kernel, last, own)
    floors = [_rmse(kernel, last, imitated(kernel, last, own, still, rng))
              for _ in range(FLOOR_DRAWS)]  # fmt: skip
    floor = float(np.sqrt(np.mean(np.square(floors))))
    return PathErrors(rmse, floor if floor < study.setup.pool.width_m else np.nan, horizon)


def bearable_s(study: Study, kernel: Kernel, tuned: Tuned, series: Sequence[Series]) -> float:
    """Longest stretch a model bears: `GROWTH` over its growth in straight swimming, s."""
    times = [np.inf]
    flap = {s.group: float(s.inputs[-1, 1]) for s in series}
    values = tuned.trial_values(kernel, series)
    for group, hz in flap.items():
        point = next(v for s, v in zip(series, values, strict=True) if s.group == group)
        coefficients, effects = split(kernel, point)
        growth = growth_per_s(coefficients, setup=study.setup, flap_hz=hz, effects=effects)
        if growth > 0:
            times.append(GROWTH / growth)
    return max(SHORTEST_S, min(times))


def begun(kernel: Kernel, tuned: Tuned, series: Sequence[Series], horizon_s: float) -> list[Series]:
    """Stretches of all trials; states of the effects' own (a lag, a servo) begin where the model's
    filter had them at that moment.
    """
    slots = _own_states(kernel)
    passed = filter_all(kernel, series, tuned.trial_values(kernel, series), tuned.noise)
    out = []
    for one, result in zip(series, passed, strict=True):
        for piece in stretches(one, horizon_s):
            frame = int(np.searchsorted(one.times, piece.times[0]))
            mean = piece.mean.copy()
            mean[slots] = result.filtered[frame, slots] if frame else mean[slots]
            out.append(replace(piece, mean=mean))
    return out


def _own_states(kernel: Kernel) -> list[int]:
    """Places of the states that effects have beside the model's, but for the random ones."""
    random = set(disturbance_slots(kernel))
    first, count = len(kernel.system.states), len(kernel.system.all_states)
    return [k for k in range(first, count) if k not in random]


def stretches(series: Series, horizon_s: float) -> list[Series]:
    """A trial cut into equal stretches not longer than `horizon_s`; the first keeps its start."""
    length = float(series.times[-1] - series.times[0])
    count = max(1, int(np.ceil(length / horizon_s - 1e-6)))
    edges = np.linspace(0, len(series.times), count + 1).astype(int)
    return [_stretch(series, a, b) for a, b in itertools.pairwise(edges)]


def _stretch(series: Series, first: int, last: int) -> Series:
    if first == 0:
        return series.frames(first, last)
    mean, cov = series.mean.copy(), series.cov.copy()
    mean[:6] = _state_at(series, first)
    cov[np.arange(6), np.arange(6)] = STATE_STD**2
    return replace(series.frames(first, last), mean=mean, cov=cov)


def _state_at(series: Series, frame: int) -> Float:
    """x, y, heading, surge, sway and yaw rate at a frame, by a parabola over nearby frames."""
    time = series.times[frame]
    known = np.all(np.isfinite(series.seen), axis=1)
    near = known & (np.abs(series.times - time) < 0.25)
    if near.sum() < 4:
        near = known
    c = np.polynomial.polynomial.polyfit(series.times[near] - time, series.seen[near][:, :3], 2)
    (x, y, psi), (vx, vy, r) = c[0], c[1]
    return np.array([x, y, psi, vx * np.cos(psi) + vy * np.sin(psi),
                     vy * np.cos(psi) - vx * np.sin(psi), r])  # fmt: skip


def _rmse(kernel: Kernel, tuned: Tuned, pieces: Sequence[Series]) -> float:
    """Root mean square distance between seen and simulated over all stretches, m."""
    shots = shoot(kernel, pieces, tuned.trial_values(kernel, pieces))
    squares = [np.sum((p.seen[:, :2] - s.observed[:, :2]) ** 2, axis=1)[well]
               for p, s, well in zip(pieces, shots, well_seen(pieces), strict=True)]  # fmt: skip
    together = np.concatenate(squares)
    known = together[np.isfinite(together)]
    return float(np.sqrt(known.mean())) if len(known) else float("nan")


def well_seen(pieces: Sequence[Series]) -> list[np.ndarray]:
    """Frames (n,) of each stretch that are seen, and whose place is not stated `HARDLY_SEEN` times
    less surely than is usual in its trial.
    """
    variances = [np.where(np.isfinite(p.seen[:, 0]), p.noise[:, 0, 0] + p.noise[:, 1, 1], np.nan)
                 for p in pieces]  # fmt: skip
    of: dict[str, list[Float]] = {}
    for piece, variance in zip(pieces, variances, strict=True):
        of.setdefault(piece.name, []).append(variance[np.isfinite(variance)])
    usual = {name: np.median(known) if len(known := np.concatenate(parts)) else 0.0
             for name, parts in of.items()}  # fmt: skip
    return [v <= HARDLY_SEEN**2 * usual[p.name] for p, v in zip(pieces, variances, strict=True)]


@dataclass(frozen=True)
class Stillness:
    """How each stretch was: starts (stretches, states), and the noise its recording tells of."""

    starts: Float
    noises: Sequence[Noise]


def stillness(kernel: Kernel, tuned: Tuned, pieces: Sequence[Series]) -> Stillness:
    """Where a model's stretches begin best, and how strongly it was pushed at random in each."""
    values = tuned.trial_values(kernel, pieces)
    shots = shoot(kernel, pieces, values)
    starts = [np.where(np.isfinite(shot.start), shot.start, one.mean)
              for one, shot in zip(pieces, shots, strict=True)]  # fmt: skip
    noises = each(lambda job: stillest(kernel, job[0], job[1], tuned.noise),
                  list(zip(pieces, values, strict=True)))  # fmt: skip
    return Stillness(np.array(starts), noises)


def imitated(
    kernel: Kernel, tuned: Tuned, pieces: Sequence[Series], still: Stillness,
    rng: np.random.Generator,
) -> list[Series]:  # fmt: skip
    """Stretches as the model would have given them, with its random forces and errors drawn.

    Water is stiller in one trial than in the next: the random forces of each stretch are as strong
    as its own recording makes most likely.
    """
    clean = _random_runs(kernel, tuned, pieces, still.starts.copy(), noises=still.noises, rng=rng)
    return [replace(one, seen=_with_white(one, tuned.noise, y[: len(one.times)], rng))
            for one, y in zip(pieces, clean, strict=True)]  # fmt: skip


def stillest(kernel: Kernel, one: Series, values: Float, noise: Noise) -> Noise:
    """The noise with its forces, one by one, as strong as makes this recording most likely."""
    acting = set(disturbance_slots(kernel, acting=True))
    slots = disturbance_slots(kernel)[: len(noise.disturbance)]
    best, likelihood = noise, filter_series(kernel, one, values, noise).log_likelihood
    for k in (k for k, slot in enumerate(slots) if slot in acting):
        for share in OWN_SHARES:
            own = best.disturbance.copy()
            own[k] = share * noise.disturbance[k]
            trial = Noise(own, noise.tau, noise.scale)
            found = filter_series(kernel, one, values, trial).log_likelihood
            if found > likelihood:
                best, likelihood = trial, found
    return best


def _random_runs(
    kernel: Kernel, tuned: Tuned, pieces: Sequence[Series], state: Float, *,
    noises: Sequence[Noise], rng: np.random.Generator,
) -> Float:  # fmt: skip
    """Observations (stretches, frames, observations) of runs pushed at random, without white noise.

    Between frames everything moves as modelled; at each frame the random states of correlation
    time tau get a kick of variance sigma^2 (1 - exp(-2 dt / tau)).
    """
    longest = max(len(p.times) for p in pieces)
    times = np.array([np.pad(p.times, (0, longest - len(p.times)), mode="edge") for p in pieces])
    values = np.array([with_noise(kernel, v, tuned.noise)
                       for v in tuned.trial_values(kernel, pieces)])  # fmt: skip
    slots = disturbance_slots(kernel)[: len(tuned.noise.disturbance)]
    sigma, tau = np.array([n.disturbance for n in noises]), tuned.noise.tau
    keep = np.zeros((len(pieces), 1))
    out = np.zeros((len(pieces), longest, len(kernel.system.observations)))
    for k in range(longest):
        kick = rng.standard_normal((len(pieces), len(slots)))
        state[:, slots] += sigma * np.sqrt(1 - keep**2) * kick
        ahead = min(k + 1, longest - 1)
        seen, states = propagate(
            kernel, _lanes(state), _lanes(values), _lanes(np.array([p.constants for p in pieces])),
            times=times[:, [k, ahead]], keep_states=True,
            inputs=np.array([p.inputs[[min(i, len(p.times) - 1) for i in (k, ahead)]]
                             for p in pieces]),
        )  # fmt: skip
        out[:, k], state = seen[:, 0, :, 0], states[:, 1, :, 0].copy()
        keep = np.exp(-(times[:, ahead] - times[:, k])[:, None] / tau)
    return out


def _lanes(rows: Float) -> Float:
    return np.repeat(rows[:, :, None], LANES, axis=2)


def _with_white(one: Series, noise: Noise, clean: Float, rng: np.random.Generator) -> Float:
    root = np.linalg.cholesky(one.noise + 1e-18 * np.eye(one.noise.shape[1]))
    white = np.einsum("nij,nj->ni", root, rng.standard_normal(clean.shape)) * noise.scale
    return np.where(np.isfinite(one.seen), clean + white, np.nan)
