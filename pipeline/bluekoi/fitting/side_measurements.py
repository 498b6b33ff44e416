"""Side measurements: numbers measured beside the motion, such as a scale or a motor's lost time.

Each is a further prediction error of its trial; the effects say what they predict
(`SIDE_MEASUREMENT_PREDICTIONS`).
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..data import Float
from ..integrate import CompiledSystem, Effect, System
from ..integrate.system import Function
from .series import FreeParameter, SharedMeasurement, TrialSeries

UNINFORMATIVE_VALUE_AND_STD = (0.0, np.inf)
"""A side measurement without information."""
FINITE_DIFFERENCE_SHARE_OF_RANGE = 1e-4
"""Difference by which slopes of predictions are taken, as a share of a parameter's range."""


def side_measurement_terms(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    free: Sequence[FreeParameter],
    points: Sequence[Float],
) -> tuple[Float, Float, Float]:
    """Information (t, p, p), gradient (t, p) and log likelihood (t,) of the side measurements in
    the free numbers; points: full parameter vectors of the trials.
    """
    n, p = len(series), len(free)
    hessian, gradient, logl = np.zeros((n, p, p)), np.zeros((n, p)), np.zeros(n)
    slots = np.array([kernel.system.parameter_index[f.name] for f in free], dtype=int)
    own = np.array([[f.group in (None, s.group) for f in free] for s in series]).reshape(n, p)
    names = sorted({name for s in series for name in s.evidence})
    at = (np.array(points), mean_inputs_and_constants(series)) if names else ()
    for name in names:
        value, std = np.array([s.evidence.get(name, UNINFORMATIVE_VALUE_AND_STD) for s in series]).T
        found, slopes = predict_side_measurement(kernel.system, name, *at)
        error = (value - found) / std
        rows = slopes[:, slots] * own / std[:, None]
        hessian += rows[:, :, None] * rows[:, None, :]
        gradient += rows * error[:, None]
        known = np.isfinite(std)
        logl[known] -= 0.5 * error[known] ** 2 + np.log(std[known]) + 0.5 * np.log(2 * np.pi)
    for shared in {s.shared for s in series if s.shared is not None}:
        rows = np.array([s.shared is shared for s in series])
        H, g, value = _shared_measurement_terms(
            kernel.system, shared, slots, points[int(np.argmax(rows))]
        )
        hessian[rows] += H / shared.trials
        gradient[rows] += g / shared.trials
        logl[rows] += value / shared.trials
    return hessian, gradient, logl


def _shared_measurement_terms(
    system: System, shared: SharedMeasurement, slots: np.ndarray, point: Float
) -> tuple[Float, Float, float]:
    """Information (p, p), gradient (p,) and log likelihood of a shared measurement, with e its
    errors and J their slopes in the free numbers at `slots` (p,): J'J, -J'e and -1/2 e'e.
    """
    places = np.array([system.parameter_index[name] for name in shared.parameters])
    values = point[places]
    error = shared.errors(values)
    J = np.zeros((len(error), len(slots)))
    for k, place in enumerate(places):
        columns = np.flatnonzero(slots == place)
        if len(columns):
            row = system.parameters[place]
            step = (
                FINITE_DIFFERENCE_SHARE_OF_RANGE * (row.upper - row.lower) * np.eye(len(values))[k]
            )
            slope = shared.errors(values + step) - shared.errors(values - step)
            J[:, columns] = (slope / (2 * step[k]))[:, None]
    return J.T @ J, -J.T @ error, -0.5 * float(error @ error)


def mean_inputs_and_constants(series: Sequence[TrialSeries]) -> Float:
    """Means of the inputs and of the time in the trials, and their constants (t, inputs + 1 +
    constants).
    """
    return np.array([[*s.inputs.mean(axis=0), s.times.mean(), *s.constants] for s in series])


def predict_side_measurement(
    system: System, name: str, points: Float, arguments: Float
) -> tuple[Float, Float]:
    """Prediction of a side measurement (t,) at parameters (t, parameters), and its slopes;
    arguments: `trial_arguments`.
    """
    weights = _linear_weights(system, name)
    value, slopes = points @ weights, np.tile(weights, (len(points), 1))
    for effect in system.effects:
        function = effect.evidence.get(name)
        if callable(function):
            at = _prediction_arguments(system, effect, function, points, arguments)
            added, by_parameter = _nonlinear_prediction_part(
                system, effect.name, name, function, at.tobytes()
            )
            value += added
            for slot, slope in by_parameter.items():
                slopes[:, slot] += slope
    return value, slopes


@lru_cache(maxsize=256)
def _nonlinear_prediction_part(
    system: System, effect_name: str, name: str, function: Function, rows: bytes
) -> tuple[Float, dict[int, Float]]:
    """What an effect's function adds to a prediction (t,), and its slopes (t,) by the place of the
    parameter; rows: `_prediction_arguments`. Cached, since the parameters of most effects do not
    change between calls.
    """
    effect = system.effect(effect_name)
    names = list(inspect.signature(function).parameters)
    at = np.frombuffer(rows).reshape(-1, len(names))
    slopes = {}
    for row in (
        p for p in effect.parameters if p.name in effect.parameters_by_auxiliary_measurement[name]
    ):
        step = np.zeros(len(names))
        step[names.index(row.argument_name)] = FINITE_DIFFERENCE_SHARE_OF_RANGE * (
            row.upper - row.lower
        )
        change = _evaluate_rows(function, at + step) - _evaluate_rows(function, at - step)
        slopes[system.parameter_index[f"{effect.name}.{row.name}"]] = change / (2 * step.sum())
    return _evaluate_rows(function, at), slopes


def _prediction_arguments(
    system: System, effect: Effect, function: Function, points: Float, arguments: Float
) -> Float:
    """Arguments (t, arguments) of a prediction: parameters of the effect, inputs, the time t and
    constants.
    """
    slots = {
        p.argument_name: system.parameter_index[f"{effect.name}.{p.name}"]
        for p in effect.parameters
    }
    names = (*system.inputs, "t", *system.constants)
    return np.column_stack([
        points[:, slots[a]] if a in slots else arguments[:, names.index(a)]
        for a in inspect.signature(function).parameters
    ])  # fmt: skip


def _evaluate_rows(function: Function, rows: Float) -> Float:
    return np.array([function(*row) for row in rows])


@lru_cache(maxsize=64)
def _linear_weights(system: System, name: str) -> Float:
    """Linear part of a prediction as a sum over parameters (parameters,)."""
    weights = np.zeros(len(system.parameters))
    for effect in system.effects:
        by = effect.evidence.get(name, {})
        if not callable(by):
            for parameter, weight in by.items():
                weights[system.parameter_index[f"{effect.name}.{parameter}"]] += weight
    return weights
