"""Errors of free-running simulations against the recordings, and of a true model (noise floor).

A model that is unstable in straight swimming cannot run freely for long: a millimetre at the start
grows to metres, whatever the model is worth. Paths are therefore compared over segments as long as
the predictability horizon of the best model, each with its best initial state. A worse model with a
shorter horizon is charged with that: the robot did swim so.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import (
    Noise,
    TrialSeries,
    filter_all,
    filter_series,
    free_runs,
    parametric_bootstrap,
    random_state_indices,
)
from ..fitting.trial_effects import (
    most_probable_trial_effects,
    parameter_vectors_with_trial_effects,
    sample_trial_effects,
)
from ..integrate import CompiledSystem
from ..integrate.batch import threaded_map
from ..model import robot_scale_ratios_of_trial
from ..study import Study
from ..tuning import JointFit
from ..tuning.similar_robots import state_std_scaled_to_robot
from ..tuning.stability import predictability_horizon_s

NOISE_FLOOR_SEED = 20240517
NOISE_FLOOR_DRAWS = 10
"""Simulated sets of the trials. The rms of N draws of n independent paths has a relative standard
deviation of (2 N n)^-1/2 if their errors are normally distributed: 9 % for six trials held out."""
RANDOM_FORCE_SCALES = (0.06, 0.12, 0.25, 0.5, 2.0)
"""Factors on a random force that are tried for each segment."""
MAX_POSITION_STD_OVER_MEDIAN = 5.0
"""Where a keypoint was off for a frame, the track states 20 to 40 mm instead of 0.4: one such frame
must not make up half of the error of six paths. Only for path errors of the report; no probability
depends on it.
"""
PARABOLA_STATE_STD = np.array([0.1, 0.1, 0.1, 0.2, 0.2, 1.0])
"""Standard deviations of a state estimated from nearby frames, for the published robot: m, m, rad,
m/s, m/s, rad/s; of the position as much as the centre of mass may be off the keypoint."""
START_STATE_HALF_WINDOW_S = 0.25
"""Half the duration, for the published robot, of the frames that a state is estimated from: 15 at
30 frames/s, a tail beat at 2 Hz. The state is the mean of a start whose deviations are far wider;
half of the duration changes no path error of two studies by 1e-3 mm, twice that of one neither."""


@dataclass(frozen=True)
class PathErrors:
    """Model -> root mean square path error, m; noise floor, m; length of the segments, s."""

    rmse_m: Mapping[str, float]
    floor_m: float
    horizon_s: float


def path_errors(
    study: Study,
    kernel: CompiledSystem,
    models: Mapping[str, JointFit],
    series: Sequence[TrialSeries],
) -> PathErrors:
    """`PathErrors` of models on trials, over the predictability horizon of the last, the best one.

    The noise floor is the error of the last model on data made by itself with its random forces,
    the trial effects and its measuring noise; NaN where that model diverges.
    """
    longest = max(float(s.times[-1] - s.times[0]) for s in series)
    last = list(models.values())[-1]
    horizon = min(longest, predictability_horizon_s(study, kernel, last, series))
    segments = {n: trial_segments(kernel, tuned, series, horizon) for n, tuned in models.items()}
    rmse = {name: _path_rmse_m(kernel, tuned, segments[name]) for name, tuned in models.items()}
    floors = _bootstrap_path_errors_m(kernel, last, list(segments.values())[-1])
    floor = float(np.sqrt(np.mean(np.square(floors))))
    return PathErrors(rmse, floor if floor < study.setup.pool.width_m else np.nan, horizon)


def path_rmse_m(
    kernel: CompiledSystem, tuned: JointFit, series: Sequence[TrialSeries], horizon_s: float
) -> float:
    """Root mean square distance between seen and simulated over segments of the trials, m."""
    return _path_rmse_m(kernel, tuned, trial_segments(kernel, tuned, series, horizon_s))


def _bootstrap_path_errors_m(
    kernel: CompiledSystem, tuned: JointFit, segments: Sequence[TrialSeries]
) -> list[float]:
    """Path errors of a model on data made by itself, segment by segment, m."""
    rng, values = (
        np.random.default_rng(NOISE_FLOOR_SEED),
        tuned.parameter_vectors_by_trial(kernel, segments),
    )
    runs = free_runs(kernel, segments, values)
    starts = np.array([np.where(np.isfinite(run.start), run.start, one.mean)
                       for one, run in zip(segments, runs, strict=True)])  # fmt: skip
    passes = filter_all(kernel, segments, values, tuned.noise)
    own = most_probable_trial_effects(kernel, passes, values, tuned.noise)
    near = parameter_vectors_with_trial_effects(kernel, values, own, tuned.noise)
    noises = threaded_map(lambda job: segment_noise(kernel, job[0], job[1], tuned.noise),
                  list(zip(segments, near, strict=True)))  # fmt: skip
    names, known = [one.name for one in segments], tuned.fit.normal.effects.values

    def draw() -> list[TrialSeries]:
        effects = sample_trial_effects(known, names, rng)
        at = parameter_vectors_with_trial_effects(kernel, values, effects, tuned.noise)
        return parametric_bootstrap(kernel, segments, at, noises, starts, rng)

    return [_path_rmse_m(kernel, tuned, draw()) for _ in range(NOISE_FLOOR_DRAWS)]


def trial_segments(
    kernel: CompiledSystem, tuned: JointFit, series: Sequence[TrialSeries], horizon_s: float
) -> list[TrialSeries]:
    """Segments of all trials; the states of effects (a lag, a servo) start at the values that the
    model's filter has at that time.
    """
    slots = _effect_state_slots(kernel)
    filtered = filter_all(
        kernel, series, tuned.parameter_vectors_by_trial(kernel, series), tuned.noise
    )
    out = []
    for one, result in zip(series, filtered, strict=True):
        for segment in cut_trial_into_segments(one, horizon_s):
            frame = int(np.searchsorted(one.times, segment.times[0]))
            mean = segment.mean.copy()
            mean[slots] = result.filtered[frame, slots] if frame else mean[slots]
            out.append(replace(segment, mean=mean))
    return out


def _effect_state_slots(kernel: CompiledSystem) -> list[int]:
    """Places of the states of effects, without the random ones."""
    random = set(random_state_indices(kernel))
    first, count = len(kernel.system.states), len(kernel.system.all_states)
    return [k for k in range(first, count) if k not in random]


def cut_trial_into_segments(series: TrialSeries, horizon_s: float) -> list[TrialSeries]:
    """A trial cut into equal segments not longer than `horizon_s`; the first keeps its start."""
    length = float(series.times[-1] - series.times[0])
    count = max(1, int(np.ceil(length / horizon_s - 1e-6)))
    edges = np.linspace(0, len(series.times), count + 1).astype(int)
    return [_cut_segment(series, a, b) for a, b in itertools.pairwise(edges)]


def _cut_segment(series: TrialSeries, first: int, last: int) -> TrialSeries:
    if first == 0:
        return series.slice_frames(first, last)
    mean, cov = series.mean.copy(), series.cov.copy()
    mean[:6] = _state_by_parabola(series, first)
    std = state_std_scaled_to_robot(
        robot_scale_ratios_of_trial(series.constants), PARABOLA_STATE_STD
    )
    cov[np.arange(6), np.arange(6)] = std**2
    return replace(series.slice_frames(first, last), mean=mean, cov=cov)


def _state_by_parabola(series: TrialSeries, frame: int) -> Float:
    """x, y, heading, surge, sway and yaw rate at a frame, by a parabola over nearby frames."""
    time = series.times[frame]
    known = np.all(np.isfinite(series.seen), axis=1)
    half_window = START_STATE_HALF_WINDOW_S * robot_scale_ratios_of_trial(series.constants).time
    near = known & (np.abs(series.times - time) < half_window)
    if near.sum() < 4:
        near = known
    c = np.polynomial.polynomial.polyfit(series.times[near] - time, series.seen[near][:, :3], 2)
    (x, y, psi), (vx, vy, r) = c[0], c[1]
    return np.array([x, y, psi, vx * np.cos(psi) + vy * np.sin(psi),
                     vy * np.cos(psi) - vx * np.sin(psi), r])  # fmt: skip


def _path_rmse_m(kernel: CompiledSystem, tuned: JointFit, segments: Sequence[TrialSeries]) -> float:
    """Root mean square distance between seen and simulated over all segments, m; infinite where a
    simulation diverges.
    """
    runs = free_runs(kernel, segments, tuned.parameter_vectors_by_trial(kernel, segments))
    precise = precisely_seen_frames(segments)
    squares = [np.sum((p.seen[:, :2] - run.observed[:, :2]) ** 2, axis=1)[frames]
               for p, run, frames in zip(segments, runs, precise, strict=True)]  # fmt: skip
    seen = [np.all(np.isfinite(p.seen[:, :2]), axis=1)[frames]
            for p, frames in zip(segments, precise, strict=True)]  # fmt: skip
    known = np.nan_to_num(np.concatenate(squares)[np.concatenate(seen)], nan=np.inf)
    return float(np.sqrt(known.mean())) if len(known) else float("nan")


def precisely_seen_frames(segments: Sequence[TrialSeries]) -> list[np.ndarray]:
    """Frames (n,) of each segment that are seen, with a position std of at most
    `MAX_POSITION_STD_OVER_MEDIAN` times the median of the trial.
    """
    variances = [np.where(np.isfinite(p.seen[:, 0]), p.noise[:, 0, 0] + p.noise[:, 1, 1], np.nan)
                 for p in segments]  # fmt: skip
    of: dict[str, list[Float]] = {}
    for segment, variance in zip(segments, variances, strict=True):
        of.setdefault(segment.name, []).append(variance[np.isfinite(variance)])
    median = {name: np.median(known) if len(known := np.concatenate(parts)) else 0.0
             for name, parts in of.items()}  # fmt: skip
    return [
        v <= MAX_POSITION_STD_OVER_MEDIAN**2 * median[p.name]
        for p, v in zip(segments, variances, strict=True)
    ]


def segment_noise(kernel: CompiledSystem, one: TrialSeries, values: Float, noise: Noise) -> Noise:
    """The noise with its random forces, one by one, as strong as makes this segment most likely:
    water is calmer in one trial than in the next. values: with the trial effects of the segment,
    which are not to be counted as forces as well.
    """
    acting = set(random_state_indices(kernel, acting=True))
    slots = random_state_indices(kernel)[: len(noise.disturbance)]
    best, likelihood = noise, filter_series(kernel, one, values, noise).log_likelihood
    for k in (k for k, slot in enumerate(slots) if slot in acting):
        for scale in RANDOM_FORCE_SCALES:
            disturbance = best.disturbance.copy()
            disturbance[k] = scale * noise.disturbance[k]
            candidate = replace(noise, disturbance=disturbance)
            found = filter_series(kernel, one, values, candidate).log_likelihood
            if found > likelihood:
                best, likelihood = candidate, found
    return best
