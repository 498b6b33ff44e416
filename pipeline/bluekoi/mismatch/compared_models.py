"""Baseline and extended model as they are compared on held-out trials.

Both are fitted by two criteria, one-step prediction errors and whole trajectories, and compared in
the fit with the smaller path error: a model that is fitted to another criterion than that of the
comparison loses accuracy by that alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..fitting import TrialSeries, fit_trajectories
from ..fitting.paths import MAX_TRAJECTORY_PARAMETERS, PREDICTION_ERRORS, TRAJECTORIES
from ..integrate import CompiledSystem
from ..study import Study
from ..tuning import JointFit
from .free_run_errors import PathErrors, path_errors, path_rmse_m


@dataclass(frozen=True)
class ComparedModel:
    """A model, the criterion of its fit, and its rms path error on the held-out trials, m."""

    model: JointFit
    fitted_to: str
    path_rmse_m: float


def compare_models(
    study: Study, kernel: CompiledSystem, baseline: JointFit, extended: JointFit | None, *,
    train: Sequence[TrialSeries], test: Sequence[TrialSeries],
) -> tuple[dict[str, ComparedModel], PathErrors]:  # fmt: skip
    """`baseline` and, where there is one, `extended` in the better fit of each, and the path errors
    of the fits to prediction errors, which both are.

    The extended model is fitted to trajectories only if its error is above the noise floor.
    """
    models = {"baseline": baseline} | ({"extended": extended} if extended else {})
    paths = path_errors(study, kernel, models, test)
    out = {}
    for name, model in models.items():
        out[name] = ComparedModel(model, PREDICTION_ERRORS, paths.rmse_m[name])
        if model is extended and paths.rmse_m[name] <= paths.floor_m:
            continue
        by_paths = trajectory_fit(kernel, train, model)
        if by_paths is not None:
            rmse = path_rmse_m(kernel, by_paths, test, paths.horizon_s)
            if rmse < np.nan_to_num(paths.rmse_m[name], nan=np.inf):
                out[name] = ComparedModel(by_paths, TRAJECTORIES, rmse)
    return out, paths


def trajectory_fit(
    kernel: CompiledSystem, train: Sequence[TrialSeries], model: JointFit
) -> JointFit | None:
    """A model whose coefficients and strengths of causes are fitted to whole trajectories; the
    functional forms stay. With the starting states, a trial has at most `MAX_TRAJECTORY_PARAMETERS`
    numbers; with more, the coefficients alone are fitted. None where that fit diverges. Covariances
    are not computed.
    """
    slot, base = kernel.system.parameter_index, model.base.copy()
    for free, value in zip(model.fit.free, model.fit.values, strict=True):
        base[slot[free.name]] = value
    some = [f for f in model.fit.free if "." not in f.name or is_strength_parameter(kernel, f.name)]
    if len(some) > MAX_TRAJECTORY_PARAMETERS - len(kernel.system.states):
        some = [f for f in some if "." not in f.name]
    try:
        found = fit_trajectories(kernel, train, base, some, start=model.fit.values_by_label()).fit
    except np.linalg.LinAlgError:
        return None
    finite = np.isfinite(found.values).all() and np.isfinite(found.log_likelihood)
    unknown = np.full((len(some), len(some)), np.nan)
    return JointFit(found, model.noise, unknown, base) if finite else None


def is_strength_parameter(kernel: CompiledSystem, label: str) -> bool:
    """Whether a number of an effect is a strength, without which the effect is absent."""
    effect = kernel.system.effect(label.split(".", maxsplit=1)[0])
    return label in [f"{effect.name}.{p.name}" for p in effect.parameters[: effect.strengths]]
