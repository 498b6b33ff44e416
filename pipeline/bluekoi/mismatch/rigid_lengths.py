"""What the robot's rigid lengths, seen all over the pool, say of errors of camera and geometry.

A rigid length comes out too long or too short where an error stretches the picture. With y the
excess of the measured lengths (means over windows), P(theta) what the errors of the camera predict,
and Z b what else changes lengths,

    y = P(theta) + Z b + e,   b ~ N(0, S),   e ~ N(0, N),   N = nu^2 D + s^2 L^2

b holds each stated length (to 0.3 %), each keypoint's place along the body, each trial's scale, a
smooth relative error of the detector over pool and session, and the errors within which a camera
counts as calibrated. s L is the error of the detector that differs from one place and direction in
the picture to the next: keypoints that were fitted to stated lengths have a scatter far below it.
How far keypoints and trials are off, and how much wider the scatter is than independent frames
would have it (nu), is estimated by restricted maximum likelihood (Patterson and Thompson,
Biometrika 58 (1971), 545). The misfit y' C^-1 y, C = N + Z S Z', then compares all errors of the
camera and their mixtures in one measurement, however the keypoints are labelled.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from ..camera.geometry_hypotheses import SYSTEMATIC_LENGTH_ERROR_SHARE
from ..camera.rigid_distances import (
    STATED_LENGTH_STD_SHARE,
    RigidDistances,
    length_sensitivity_to_keypoint_shift,
)
from ..data import Float
from ..fitting import SharedMeasurement
from ..integrate import Effect, System, elementwise
from ..model.similarity import unit_dimensions
from .robot_problem import KEYPOINT_LABEL_STD_M, UNKNOWN_DEPTH_SCALE_ERROR_STD

CALIBRATION_ERROR_STD = {
    "lens_error": {"radial_distortion": 0.0005, "tangential_x": 0.00025, "tangential_y": 0.00025},
    "uncorrected_refraction": {"inward_shift": 0.001},
}
"""Strengths of errors that a careful calibration leaves: radial (1/m2) and tangential distortion
(1/m) that change lengths by `SYSTEMATIC_LENGTH_ERROR_SHARE`, 0.05 %, a metre from the middle, and a
depth wrong by 2 mm seen from 1.5 m; for the published robot, others are filmed from as many body
lengths."""
PRIOR_STD_OVER_PLAUSIBLE_MAGNITUDE = 3.0
"""While variances are estimated, strengths have normal priors of this many plausible magnitudes:
80 % of the Cauchy prior of a strength lies within tan(0.4 pi) = 3.1 of them."""
MAX_TRIALS = 60
"""Trials beyond which the study's own errors, not the noise, limit what lengths determine."""
MIN_INFORMATION_SHARE = 1e-6
"""Combinations of patterns with less than this share of the largest information are left out:
differences of patterns that rounding determines."""


def effects_that_change_lengths(system: System) -> tuple[Effect, ...]:
    """Effects that displace what is seen by an amount that varies over the picture, and so change
    the lengths seen.
    """
    return tuple(e for e in system.effects
                 if "observe" in e.hooks and {"x", "y"} <= set(_observe_arguments(e)))  # fmt: skip


def rigid_length_measurement(
    system: System, constants: Mapping[str, float], windows: RigidDistances, *, trials: int,
    depth_given: bool, systematic: float = SYSTEMATIC_LENGTH_ERROR_SHARE,
    session_places: Mapping[int, float] | None = None,
) -> SharedMeasurement | None:  # fmt: skip
    """`SharedMeasurement` of the lengths in `windows`; None where too few were seen.

    constants: of the study's view. trials: how many share it. systematic: relative error of the
    detector that is the same in all trials, and by which it may change over the session.
    session_places: number of a trial -> its place in the session (`CameraErrorInputs`); without,
    all trials have the place of the constants.
    """
    windows = _windows_limited_to_max_trials(windows)
    effects = effects_that_change_lengths(system)
    places = session_places or {}
    each = [places.get(int(t), constants["session_place"]) for t in windows.trial.round()]
    camera = _LengthExcess(effects, {**constants, "session_place": np.array(each)}, windows)
    patterns = camera.excess_by_strength()
    if len(windows.excess_m) <= 2 * patterns.shape[1]:
        return None
    others = _nuisance_patterns(camera, windows, depth_given=depth_given, systematic=systematic)
    whitener = _whitening_rows(patterns, others, windows)
    seen = whitener @ windows.excess_m

    @lru_cache(maxsize=256)
    def columns(effect: Effect, form: tuple[float, ...]) -> Float:
        units = np.eye(effect.strengths)
        return whitener @ np.column_stack([camera.excess(effect, (*u, *form)) for u in units])

    def errors(values: Float) -> Float:
        out, first = seen.copy(), 0
        for effect in effects:
            own = values[first : first + len(effect.parameters)]
            first += len(effect.parameters)
            strengths, form = own[: effect.strengths], own[effect.strengths :]
            if strengths.any():
                out -= columns(effect, tuple(map(float, form))) @ strengths
        return out

    names = tuple(f"{e.name}.{p.name}" for e in effects for p in e.parameters)
    return SharedMeasurement(names, errors, trials)


def _windows_limited_to_max_trials(windows: RigidDistances) -> RigidDistances:
    """Windows of `MAX_TRIALS` trials, evenly spread: more would determine nothing better."""
    labels = np.unique(windows.trial)
    if len(labels) <= MAX_TRIALS:
        return windows
    chosen = labels[np.linspace(0, len(labels) - 1, MAX_TRIALS).round().astype(int)]
    return windows.select(np.isin(windows.trial, chosen))


@dataclass(frozen=True)
class _LengthExcess:
    """Excess of lengths by each effect.

    constants: of the view, one number or (n,) numbers, one for each length.
    """

    effects: tuple[Effect, ...]
    constants: Mapping[str, float | Float]
    windows: RigidDistances

    def excess(self, effect: Effect, values: Sequence[float]) -> Float:
        """Excess (n,) of the lengths, m, by an effect: difference of the ends' displacements along
        the length.

        The ends lie at the known length about the centre: those seen contain the errors that are to
        be explained.
        """
        w = self.windows
        along = w.front_m - w.back_m
        along = along / np.linalg.norm(along, axis=1)[:, None]
        half = 0.5 * w.known_m[:, None] * along
        front, back = (_observed_displacement_m(effect, end, w.time_s, self.constants, values)
                       for end in (w.centers_m + half, w.centers_m - half))  # fmt: skip
        return np.asarray(np.sum((front - back) * along, axis=1))

    def excess_by_strength(self) -> Float:
        """Excess (n, m) by each strength at its prior standard deviation, for the leading form and
        for other ones.
        """
        return np.column_stack([
            PRIOR_STD_OVER_PLAUSIBLE_MAGNITUDE
            * strength.typical_magnitude
            * self.excess(effect, (*unit, *form))
            for effect in self.effects
            for form in _tried_shape_values(effect)
            for strength, unit in zip(effect.parameters, np.eye(effect.strengths), strict=False)
        ])  # fmt: skip


def _tried_shape_values(effect: Effect) -> list[tuple[float, ...]]:
    """The leading form, and forms in which one parameter is a standard deviation or more off."""
    own = effect.parameters[effect.strengths :]
    leading = tuple(p.start for p in own)
    out = [leading]
    for k, p in enumerate(own):
        for value in {*p.tries, *np.clip([p.start - p.spread, p.start + p.spread],
                                         p.lower, p.upper)}:  # fmt: skip
            out.append((*leading[:k], float(value), *leading[k + 1 :]))
    return out


def _observed_displacement_m(
    effect: Effect, places: Float, time_s: Float, constants: Mapping[str, float | Float],
    values: Sequence[float],
) -> Float:  # fmt: skip
    """Displacement (n, 2) of places (n, 2) seen at times (n,)."""
    still = {"cpsi": 0.0, "spsi": 0.0, **constants, "ahead": 0.0}
    given = dict(zip((p.argument_name for p in effect.parameters), values, strict=True))
    known = {**still, **given, "x": places[:, 0], "y": places[:, 1], "t": time_s}
    observe = elementwise(effect.hooks["observe"])
    dx, dy, *_ = observe(*(known[a] for a in _observe_arguments(effect)))
    return np.column_stack([dx, dy])


@lru_cache(maxsize=32)
def _observe_arguments(effect: Effect) -> tuple[str, ...]:
    return tuple(inspect.signature(effect.hooks["observe"]).parameters)


@dataclass(frozen=True)
class _NuisancePatterns:
    """Patterns Z (n, z) of what else changes lengths, with variances (z,) where known: those of
    labels and of trials are estimated (`labels`, `trials`: which columns). local_std: error (n,) of
    the detector that differs from window to window, m.
    """

    columns: Float
    variance: Float
    labels: np.ndarray
    trials: np.ndarray
    local_std: Float


def _nuisance_patterns(
    camera: _LengthExcess, windows: RigidDistances, *, depth_given: bool, systematic: float
) -> _NuisancePatterns:
    known, pair = windows.known_m, windows.pair.round()
    groups: list[tuple[str, Float, float]] = []
    for length in sorted(set(zip(pair, known.round(4), strict=True))):
        stated = (pair == length[0]) & (known.round(4) == length[1])
        groups.append(("stated", np.where(stated, known, 0.0), STATED_LENGTH_STD_SHARE))
    across = np.where(pair == 0, np.sin(windows.bend_rad), 0.0)  # a hinge marked beside the core
    groups += [("label", column, 1.0)
               for column in (*length_sensitivity_to_keypoint_shift(windows).values(), across)
               if column.any()]  # fmt: skip
    groups += [("trial", np.where(windows.trial == t, known, 0.0), 1.0)
               for t in np.unique(windows.trial)]  # fmt: skip
    centers = windows.centers_m
    reach = np.maximum(np.ptp(centers, axis=0), known.max())
    x, y = ((centers - centers.mean(axis=0)) / reach).T * 2.0
    trend = 2.0 * camera.constants["session_place"] - 1.0
    groups += [("smooth", known * term, systematic)
               for term in (1.0, x, y, x * x, x * y, y * y, trend)]  # fmt: skip
    for own, k, std in _calibration_errors(camera, depth_given=depth_given):
        unit = (*np.eye(own.strengths)[k], *_tried_shape_values(own)[0])
        groups.append(("calibrated", camera.excess(own, unit), std))
    kind = np.array([g[0] for g in groups])
    columns, stds = (np.array([g[k] for g in groups]) for k in (1, 2))
    return _NuisancePatterns(
        columns.T, stds**2, kind == "label", kind == "trial", SYSTEMATIC_LENGTH_ERROR_SHARE * known
    )


def _calibration_errors(
    camera: _LengthExcess, *, depth_given: bool
) -> Iterator[tuple[Effect, int, float]]:
    """Effect, place of one of its strengths, and standard deviation of that strength after a
    careful calibration.
    """
    unit_m = float(camera.constants["length_unit"])
    for own in camera.effects:
        for k, strength in enumerate(own.parameters[: own.strengths]):
            if (std := CALIBRATION_ERROR_STD.get(own.name, {}).get(strength.name)) is None:
                continue
            if own.name == "uncorrected_refraction" and not depth_given:
                std = UNKNOWN_DEPTH_SCALE_ERROR_STD
            yield own, k, std * unit_m ** unit_dimensions(strength.unit)[1]


def _whitening_rows(basis: Float, others: _NuisancePatterns, windows: RigidDistances) -> Float:
    """Rows (m, n) that turn excesses into independent numbers of unit variance, in the space of the
    patterns (n, k), each as large as is plausible.
    """
    stack = np.column_stack([basis, windows.excess_m])

    def covariance_parts(values: Float) -> tuple[Float, Float, Float, Float]:
        """Precision 1 / n^2 of the noise (n,) and prior precision of b (z,), then Z' N^-1 Z + S^-1
        and Z' N^-1 [P, y].
        """
        label, trial, nu = values
        precision = 1.0 / (nu**2 * windows.std_m**2 + others.local_std**2)
        known = np.where(others.trials, trial**2, others.variance)
        prior = 1.0 / np.where(others.labels, label**2, known)
        weighted = (others.columns * precision[:, None]).T
        return precision, prior, weighted @ others.columns + np.diag(prior), weighted @ stack

    def misfit(logs: Float) -> float:
        precision, prior, A, cross = covariance_parts(np.exp(logs))
        left = (stack.T * precision) @ stack - cross.T @ np.linalg.solve(A, cross)
        H, g = left[:-1, :-1] + np.eye(len(left) - 1), left[:-1, -1]
        squares = left[-1, -1] - g @ np.linalg.solve(H, g)
        determinants = (np.linalg.slogdet(A)[1] - np.log(prior).sum() + np.linalg.slogdet(H)[1]
                        - np.log(precision).sum())  # fmt: skip
        return 0.5 * float(squares + determinants)

    start = np.log([KEYPOINT_LABEL_STD_M, STATED_LENGTH_STD_SHARE, 1.0])
    simplex = start + np.vstack([np.zeros(3), np.eye(3)])
    tolerance = {"initial_simplex": simplex, "xatol": 0.05, "fatol": 0.05}
    found = minimize(misfit, start, method="Nelder-Mead", options=tolerance)
    precision, _, A, cross = covariance_parts(np.exp(found.x))
    precise = (basis - others.columns @ np.linalg.solve(A, cross[:, :-1])) * precision[:, None]
    H = basis.T @ precise  # P' C^-1 P
    size, vectors = np.linalg.eigh(0.5 * (H + H.T))
    keep = size > MIN_INFORMATION_SHARE * size[-1]
    out: Float = (precise @ vectors[:, keep] / np.sqrt(size[keep])).T
    return out
