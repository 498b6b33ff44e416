"""Which trials the reported errors refer to, and whether the fit saw them."""

from __future__ import annotations

from ...campaign import Campaign


def evaluated_trials(campaign: Campaign) -> tuple[str, ...]:
    """Ids of the trials whose errors mismatch.json reports."""
    found = (campaign.mismatch or {}).get("held_out") or {}
    return tuple(str(name) for name in found.get("trials") or ())


def evaluated_on_fitted_trials(campaign: Campaign) -> bool:
    """Whether the reported errors refer to the fitted trials.

    A study too small to hold trials out is evaluated on all of its trials: mismatch.json then
    lists every trial of the joint fit.
    """
    joint = campaign.coefficients.get("joint") or {}
    fitted = joint.get("trials") or [trial.trial_id for trial in campaign.analysed]
    return bool(fitted) and set(evaluated_trials(campaign)) >= {str(name) for name in fitted}


def noise_floor_m(campaign: Campaign) -> float | None:
    """Noise floor of the path error, m; None if not reported or wider than the pool."""
    floor = ((campaign.mismatch or {}).get("held_out") or {}).get("noise_floor_path_rmse_m")
    known = floor is not None and float(floor) < campaign.study.setup.pool.width_m
    return float(floor) if floor is not None and known else None
