"""Baseline and extended model as they are compared on held-out trials.

Both are fitted by two criteria, one-step prediction errors and whole trajectories, and compared in
the fit with the smaller path error: a model that is fitted to another criterion than that of the
comparison loses accuracy by that alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fitting import TrialSeries, fit_trajectories
from ..fitting.paths import PREDICTION_ERRORS, TRAJECTORIES
from ..integrate import LANES, CompiledSystem
from ..study import Study
from ..tuning import JointFit
from .free_run_errors import PathErrors, path_errors, path_rmse_m

MAX_NUMBERS = LANES - 7
"""Numbers that a trajectory fit varies at once: sixteen simulations side by side are the one at the
point, those of the six starting states, and those of the numbers."""


@dataclass(frozen=True)
class ComparedModel:
    """A model, the criterion of its fit, and its rms path error on the held-out trials, m."""

    model: JointFit
    fitted_to: str
    path_rmse_m: float


def compare_models(
    study: Study, kernel: CompiledSystem, models: Mapping[str, JointFit],
    train: Sequence[TrialSeries], test: Sequence[TrialSeries],
) -> tuple[dict[str, ComparedModel], PathErrors]:  # fmt: skip
    """Each model in its better fit, and the path errors of the fits to prediction errors.

    models: name -> fit to prediction errors; the last one has the noise floor. A model whose error
    is not above that is not fitted a second time, except the first one, the baseline.
    """
    paths = path_errors(study, kernel, models, test)
    out = {}
    for k, (name, model) in enumerate(models.items()):
        out[name] = ComparedModel(model, PREDICTION_ERRORS, paths.rmse_m[name])
        again = paths.rmse_m[name] > paths.floor_m or k == 0
        by_paths = trajectory_fit(kernel, train, model) if again else None
        if by_paths is not None:
            rmse = path_rmse_m(kernel, by_paths, test, paths.horizon_s)
            if rmse < out[name].path_rmse_m:
                out[name] = ComparedModel(by_paths, TRAJECTORIES, rmse)
    return out, paths


def trajectory_fit(
    kernel: CompiledSystem, train: Sequence[TrialSeries], model: JointFit
) -> JointFit | None:
    """A model whose coefficients and strengths of causes are fitted to whole trajectories; the
    functional forms stay, and with more than `MAX_NUMBERS` the strengths as well. None where that
    fit diverges.
    """
    slot, base = kernel.system.slot, model.base.copy()
    for free, value in zip(model.fit.free, model.fit.values, strict=True):
        base[slot[free.name]] = value
    some = [f for f in model.fit.free if "." not in f.name or is_strength(kernel, f.name)]
    if len(some) > MAX_NUMBERS:
        some = [f for f in some if "." not in f.name]
    found = fit_trajectories(kernel, train, base, some, start=model.fit.by_label()).fit
    finite = np.isfinite(found.values).all() and np.isfinite(found.log_likelihood)
    return replace(model, fit=found, base=base) if finite else None


def is_strength(kernel: CompiledSystem, label: str) -> bool:
    """Whether a number of an effect is a strength, without which the effect is absent."""
    effect = kernel.system.effect(label.split(".", maxsplit=1)[0])
    return label in [f"{effect.name}.{p.name}" for p in effect.parameters[: effect.strengths]]
