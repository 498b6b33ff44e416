"""What tuning writes: coefficients.json, Tables I and II, and the model's path for every trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data import Float, SteadyState
from ..fitting import TrialSeries, free_runs
from ..model import (
    HYDRODYNAMIC_COEFFICIENTS,
    PUBLISHED_FLAP_HZ,
    PUBLISHED_UNITS_NOTE,
    TABLE_1,
    TABLE_2_ERRORS_PCT,
)
from ..study import Study
from .draws import sample_parameters
from .identify import fisher_eigendirections, likelihood_profiles
from .joint_fit import JointFit, coefficient_table, fit_all_trials
from .paper_steps import fit_paper_steps
from .similar_robots import compiled_trial_system, downsampled
from .stability import stability_verdict, straight_swimming_growth_per_s, undetermined_stability
from .turning_trials import (
    count_turning_trials,
    depends_on_one_trial,
    joint_fit_outcome_text,
    no_trial_turns_head,
    undetermined_without_turns,
)
from .undetermined import combination_json, is_undetermined, undetermined_combinations

ENSEMBLE_DRAWS, STABILITY_DRAWS = 200, 60
"""Draws of the fitted coefficients: written to coefficients.json, and the first of them, for which
the stability of straight swimming is computed."""
MIN_TURNING_TRIALS = 2
"""Trials with the head turned, below which nothing is said of straight swimming: one cannot tell
how trials disagree.
"""


def coefficients_json_and_fit(
    study: Study, series: Sequence[TrialSeries], steady: Mapping[str, SteadyState], *, seed: int = 0
) -> tuple[dict[str, Any], JointFit]:
    """Content of coefficients.json, and the joint fit."""
    few = downsampled(series)
    steps, _, _ = fit_paper_steps(study, few, steady)
    joint = fit_all_trials(few)
    values = joint.fit.values_by_label()
    draws = sample_parameters(joint, ENSEMBLE_DRAWS, np.random.default_rng(seed))
    return {
        "unit_reading": PUBLISHED_UNITS_NOTE,
        "paper_steps": steps,
        "joint": {
            "coefficients": undetermined_without_turns(coefficient_table(joint), few),
            "outcome": joint_fit_outcome_text(joint, few),
            "trials": [s.name for s in series],
            "noise": {
                "disturbance": joint.noise.disturbance,
                "unit": ["N", "N", "N m"],
                "correlation_time_s": joint.noise.tau,
            },
            "ensemble": {"names": list(values), "values": draws},
            "undetermined": undetermined_combinations(few, joint, study.setup),
            "identifiability": identifiability(few, joint),
            "straight_swimming": straight_swimming_stability(
                study, steps, joint, draws[:STABILITY_DRAWS], series=few
            ),
        },
    }, joint


def straight_swimming_stability(
    study: Study,
    steps: Mapping[str, Any],
    joint: JointFit,
    draws: Float,
    *,
    series: Sequence[TrialSeries],
) -> dict[str, Any]:
    """Growth of a small turn at each power, and over draws of the fit where it is fastest.

    Nothing is stated if fewer than two trials turn.
    """

    def growth(values: Mapping[str, float], power: str) -> float:
        return straight_swimming_growth_per_s(
            values, setup=study.setup, flap_hz=steps[power]["flap_hz"]
        )

    names = list(joint.fit.values_by_label())
    by_power = {power: growth(joint.fit.values_by_label(), power) for power in steps}
    worst = max(by_power, key=lambda power: by_power[power])
    if count_turning_trials(series) < MIN_TURNING_TRIALS or depends_on_one_trial(joint):
        return undetermined_stability(by_power[worst]) | {"by_power": by_power}
    over = [growth(dict(zip(names, row, strict=True)), worst) for row in draws.tolist()]
    return stability_verdict(by_power[worst], over) | {"by_power": by_power}


def identifiability(series: Sequence[TrialSeries], joint: JointFit) -> dict[str, Any]:
    """Spectrum of combinations, the least determined first, and profiles by coefficient."""
    names = [f.label for f in joint.fit.free]
    return {
        "spectrum": [
            combination_json(names, one)
            | {"determined": not is_undetermined(names, one, straight=no_trial_turns_head(series))}
            for one in fisher_eigendirections(joint)
        ],
        "profiles": {
            name: {"values": p.values, "lost": p.lost, "lower": p.lower, "upper": p.upper}
            for name, p in zip(names, likelihood_profiles(series, joint), strict=True)
        },
    }


def table_1_coefficients(steps: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Columns of table1.csv: this study's coefficients at each power beside the paper's."""
    powers = list(steps)
    out: dict[str, list[Any]] = {"power_pct": [float(p) for p in powers]}
    out["flap_hz"] = [steps[p]["flap_hz"] for p in powers]
    out["paper_flap_hz"] = [PUBLISHED_FLAP_HZ.get(int(float(p)), np.nan) for p in powers]
    for parameter in HYDRODYNAMIC_COEFFICIENTS:
        name = parameter.name
        cells = [steps[p]["coefficients"][name] for p in powers]
        unit = "" if parameter.unit == "1" else "_" + parameter.unit.replace(" ", "_")
        out[f"{name}{unit}"] = [c["value"] for c in cells]
        out[f"{name}_std{unit}"] = [np.nan if c["std"] is None else c["std"] for c in cells]
        for k, end in enumerate(("lower", "upper")):
            out[f"{name}_{end}_95{unit}"] = [_none_to_nan(c["interval_95"][k]) for c in cells]
        out[f"{name}_determined"] = [c["determined"] for c in cells]
        out[f"paper_{name}{unit}"] = [
            TABLE_1.get(int(float(p)), {}).get(name, np.nan) for p in powers
        ]
    return out


def table_2_radius_errors(study: Study, steps: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Columns of table2.csv: model minus data in radius, %, for every turning condition."""
    rows = [
        (p, c)
        for p in steps
        for c in steps[p]["steps"].values()
        if c["step"] != 1 and c["radius_m"] is not None and c["head_angle_deg"] > 0
    ]
    one_x = study.setup.robot.head_length_m

    def published(p: str, c: Mapping[str, Any]) -> float:
        key = (round(c["head_angle_deg"]), 1.0 if abs(c["head_length_m"] - one_x) < 1e-6 else 1.5)
        return TABLE_2_ERRORS_PCT.get(key, {}).get(int(float(p)), np.nan)

    return {
        "power_pct": [float(p) for p, _ in rows],
        "head_angle_deg": [c["head_angle_deg"] for _, c in rows],
        "head_length_m": [c["head_length_m"] for _, c in rows],
        "used_in_tuning": [c["step"] == 2 for _, c in rows],
        "radius_m": [c["radius_m"] for _, c in rows],
        "model_radius_m": [_none_to_nan(c["model_radius_m"]) for _, c in rows],
        "difference_pct": [_none_to_nan(c["radius_difference_pct"]) for _, c in rows],
        "paper_difference_pct": [published(p, c) for p, c in rows],
    }


def _none_to_nan(value: float | None) -> float:
    return np.nan if value is None else value


def simulation_columns_by_trial(
    series: Sequence[TrialSeries], joint: JointFit, steps: Mapping[str, Any]
) -> dict[str, dict[str, Float]]:
    """Trial -> columns of simulations/ID.csv: joint and per-power model from fitted starts."""
    kernel = compiled_trial_system(series)
    per_power = [
        kernel.system.parameter_vector(
            {n: c["value"] for n, c in steps[s.group]["coefficients"].items()}
        )
        for s in series
    ]
    by_model = {
        "joint": free_runs(kernel, series, joint.parameter_vectors_by_trial(kernel, series)),
        "paper": free_runs(kernel, series, per_power),
    }
    out: dict[str, dict[str, Float]] = {}
    for i, s in enumerate(series):
        out[s.name] = {"time_s": s.times}
        for label, runs in by_model.items():
            for k, name in enumerate(("x_m", "y_m", "heading_rad")):
                out[s.name][f"{label}_{name}"] = runs[i].observed[:, k]
    return out
