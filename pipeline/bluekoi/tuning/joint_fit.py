"""One set of coefficients for all powers, from whole trajectories of all trials at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Float
from ..fitting import (
    Z_95,
    ClusterCovariance,
    ClusterInfluence,
    FreeParameter,
    Noise,
    ParameterFit,
    TrialRandomEffect,
    TrialSeries,
    cluster_covariance,
    estimate_noise_model,
    fit_parameters_jointly,
    off_bounds,
    trial_normal_equations,
    trial_parameter_vector,
)
from ..fitting.sandwich import MIN_NAIVE_VARIANCE_SHARE
from ..integrate import CompiledSystem
from ..integrate.system import Parameter
from ..model import HYDRODYNAMIC_COEFFICIENTS
from .bounds import LOWER, UPPER, bound_sides, intervals_at_bounds
from .similar_robots import (
    HEAD_ANGLE_COLUMN,
    compiled_trial_system,
    noise_scaled_to_robot,
    robot_units_of_trials,
)

SERVO_ERROR_PARAMETER = "servo_error.angle"
"""The parameter that a servo's error in one trial changes."""
UNDETERMINED_ABOVE_RELATIVE_STD = 0.3
"""A parameter is not determined where its standard deviation exceeds this share of its size."""
RESTART_COEFFICIENT_SCALES = (0.3, 0.1, 0.03, 0.0)
"""Shares of the usual coefficients from which a fit begins where the model runs away at those. The
yaw damping, which calms the model, stays as it is."""
YAW_DAMPING_COEFFICIENT_NAME = "C_Md"
START_NOISE = Noise(
    np.array([0.005, 0.005, 0.0005, 3e-4, 3e-4, 3e-3]),
    np.array([0.5, 0.5, 0.5, 0.2, 0.2, 0.2]),
    np.ones(4),
    fixed_scales=(HEAD_ANGLE_COLUMN,),
)
"""Before it is fitted, for the published robot: 5 mN, 5 mN, 0.5 mN m of water, forgotten within
0.5 s; tracking errors of 0.3 mm and 0.17 degrees, forgotten within 0.2 s; white noise as stated.
The scale of the head angle is not estimated: its variance contains the error that is constant
within a trial."""


@dataclass(frozen=True)
class JointFit:
    """A joint fit, its noise, and its covariance (p, p) from how its trials disagree.

    df (p,): degrees of freedom of each variance, None for the normal law. influence: for
    the degrees of freedom of combinations.
    """

    fit: ParameterFit
    noise: Noise
    cov: Float
    base: Float
    df: Float | None = None
    influence: ClusterInfluence | None = None

    @property
    def covariance(self) -> ClusterCovariance:
        """Covariance and degrees of freedom together."""
        many = np.full(len(self.cov), 1e9) if self.df is None else self.df
        return ClusterCovariance(self.cov, many, self.influence)

    @property
    def std(self) -> Float:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.cov))

    @property
    def interval_95(self) -> Float:
        """Bounds (p, 2) that hold the truth in 95 of 100 studies; infinite where the trials do not
        determine them; of numbers at a bound as in `intervals_at_bounds`.
        """
        half = self.covariance.half_widths(0.95)
        out = self.fit.values[:, None] + half[:, None] * np.array([-1.0, 1.0])
        for i, ends in intervals_at_bounds(self.fit).items():
            out[i] = ends
        return out

    def parameter_vectors_by_trial(
        self, kernel: CompiledSystem, series: Sequence[TrialSeries]
    ) -> list[Float]:
        """Full parameter vector for each trial."""
        return [
            trial_parameter_vector(kernel, self.base, self.fit.free, self.fit.values, s.group)
            for s in series
        ]


def fit_all_trials(
    series: Sequence[TrialSeries],
    free: Sequence[FreeParameter] | None = None,
    *,
    base: Float | None = None,
    noise: Noise | None = None,
    start: dict[str, float] | None = None,
    min_share: float = MIN_NAIVE_VARIANCE_SHARE,
) -> JointFit:
    """Joint fit of the free numbers (default: the six coefficients); without `noise` that too.

    min_share: share of the naive variance below which none is stated, however well trials agree.

    Raises: FloatingPointError where the model runs away from these trials at every start.
    """
    kernel = compiled_trial_system(series)
    free = tuple(free or (FreeParameter(p.name) for p in HYDRODYNAMIC_COEFFICIENTS))
    base = kernel.system.parameter_vector({}) if base is None else base
    begin = noise or noise_scaled_to_robot(robot_units_of_trials(series), START_NOISE)
    found = _first_fit(kernel, series, base, free, noise=begin, start=start)
    if noise is None:
        points = [trial_parameter_vector(kernel, base, free, found.values, s.group) for s in series]
        noise = estimate_noise_model(kernel, series, points, begin, rounds=5).noise
        found = fit_parameters_jointly(
            kernel, series, base, free, noise, start=found.values_by_label()
        )
    own = servo_error_information(kernel, series, found, base, noise=noise)
    spread = cluster_covariance(found.normal, off_bounds(found), own, min_share=min_share)
    return JointFit(found, noise, spread.cov, base, spread.df, spread.influence)


def _first_fit(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    free: Sequence[FreeParameter],
    *,
    noise: Noise,
    start: dict[str, float] | None,
) -> ParameterFit:
    """The fit from `start`; where the model runs away there, from smaller and smaller numbers."""
    slots = kernel.system.parameter_index
    given = start or {}
    values = {f.label: given.get(f.label, given.get(f.name, base[slots[f.name]])) for f in free}
    for share in (1.0, *RESTART_COEFFICIENT_SCALES):
        begin = {
            label: float(value if label.startswith(YAW_DAMPING_COEFFICIENT_NAME) else share * value)
            for label, value in values.items()
        }
        found = fit_parameters_jointly(
            kernel, series, base, free, noise, start=start if share == 1.0 else begin
        )
        if found.normal.all_finite:
            return found
    raise FloatingPointError("the model runs away from these trials, whatever its coefficients")


def servo_error_information(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    found: ParameterFit,
    base: Float,
    *,
    noise: Noise,
) -> TrialRandomEffect | None:
    """What an error of the servo in each trial does to the normal equations of a fit, which does
    not have it; None where the fit ran away.
    """
    free = (*found.free, FreeParameter(SERVO_ERROR_PARAMETER))
    at = np.append(found.values, base[kernel.system.parameter_index[SERVO_ERROR_PARAMETER]])
    normal = trial_normal_equations(kernel, series, base, free, at, noise=noise)
    if not normal.all_finite:
        return None
    return TrialRandomEffect(
        normal.hessian[:, :-1, -1], normal.hessian[:, -1, -1], normal.gradient[:, -1]
    )


def coefficient_table(tuned: JointFit) -> dict[str, dict[str, Any]]:
    """Label -> `coefficient_cell` of every fitted number."""
    return {f.label: coefficient_cell(tuned, i) for i, f in enumerate(tuned.fit.free)}


def coefficient_cell(tuned: JointFit, index: int) -> dict[str, Any]:
    """value, std, interval_95, naive_std, unit, whether determined, and why not, of one number.

    At a bound `at_bound` says which, there is no std, and the interval has the bound at one end.
    Where trials cannot disagree, since one alone informs on the number, std and interval are None.
    """
    parameter, side = tuned.fit.definitions[index], bound_sides(tuned.fit)[index]
    value, interval = float(tuned.fit.values[index]), tuned.interval_95[index]
    half = float(0.5 * (interval[1] - interval[0]))
    naive = float(np.sqrt(tuned.fit.naive_cov[index, index]))
    judged = not side and bool(np.isfinite(half))
    if side:
        why = _reason_at_bound(parameter, side, interval)
    else:
        why = _reason_undetermined(half, naive, value=value, usual=abs(parameter.start))
    return {
        "value": value,
        "std": float(tuned.std[index]) if judged else None,
        "interval_95": [float(end) if np.isfinite(end) else None for end in interval],
        "naive_std": None if side else naive,
        "unit": parameter.unit,
        "determined": not why,
        "why": why,
    } | ({"at_bound": side} if side else {})


def _reason_at_bound(parameter: Parameter, side: str, interval: Float) -> str:
    """Why a number at its bound is not determined."""
    bound, other = parameter.lower, interval[1]
    if side == UPPER:
        bound, other = parameter.upper, interval[0]
    if not np.isfinite(other):
        return (
            f"at its bound of {bound:g}, the edge of what is plausible: the data ask for physics "
            "that is not in the model"
        )
    to = "up to" if side == LOWER else "down to"
    return f"at its bound of {bound:g}; values {to} {other:.3g} agree with these trials"


def _reason_undetermined(half: float, naive: float, *, value: float, usual: float) -> str:
    """Why a number is not determined; empty where it is: where the deviation of a normal law with
    its interval, and the naive one, are below 30 % of it or of its usual size.
    """
    if not np.isfinite(half):
        return "only one trial determines it: variation between trials cannot show its error"
    size = max(abs(value), usual)
    of = "its size" if abs(value) >= usual else f"its usual size of {usual:g}"
    if half >= Z_95 * UNDETERMINED_ABOVE_RELATIVE_STD * size:
        share = f"half of its 95 % interval is {100 * half / size:.0f} % of {of}"
    elif naive >= UNDETERMINED_ABOVE_RELATIVE_STD * size:
        share = f"its naive deviation is {100 * naive / size:.0f} % of {of}"
    else:
        return ""
    return f"{share}: these trials hardly depend on it"
