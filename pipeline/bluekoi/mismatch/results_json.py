"""mismatch.json and mismatch_detail.json, from what the finder found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from ..engine import NamedCause
from ..engine.calibration import calibrated_probability
from ..engine.cause_selection import UNLISTED_FORCE_LABEL
from ..explain.results_json import rival_rows
from ..fitting import TrialSeries
from ..integrate import Effect
from ..model import is_residual, residual_channels, robot_scale_ratios, two_plate_system
from ..study import Study
from .extended_model import estimates_by_label
from .find import MismatchResult
from .missing_force_dependence import FORCE_CHANNELS
from .next_trial import next_trial_json
from .robot_problem import CAMERA_SHIFT_EFFECT
from .sentences import unexplained_sentence, verdict_sentence


def mismatch_json(
    found: MismatchResult, study: Study, series: Sequence[TrialSeries]
) -> dict[str, Any]:
    """Content of mismatch.json as the contract lists it."""
    named = causes_json(found)
    return {
        "verdict": found.verdict,
        "sentence": verdict_sentence(found, named),
        "causes": named,
        "rivals": rivals_json(found),
        "probabilities": probability_by_cause(found),
        "where": dependence_json(found),
        "held_out": {
            "trials": list(found.held_out),
            "baseline": dict(found.errors["baseline"]),
            "baseline_fitted_to": found.fitted_to["baseline"],
            "extended": dict(found.errors["extended"]),
            "extended_fitted_to": found.fitted_to["extended"],
            "noise_floor_path_rmse_m": found.floor_m,
            "stretch_s": found.stretch_s,
        },
        "robot_units": asdict(robot_scale_ratios(study.setup.robot)),
        "overdispersion": found.posterior.best.overdispersion,
        "warnings": list(found.warnings),
        "next_trial": next_trial_json(found, study, series),
    }


def probability_by_cause(found: MismatchResult) -> dict[str, float]:
    """Calibrated probability of every named candidate and of an unlisted force."""
    names = [e.name for e in two_plate_system().effects if e.kind in ("physics", "measurement")]
    inclusion = found.posterior.inclusion
    stated = {name: calibrated_probability(inclusion.get(name, 0.0)) for name in names}
    return stated | {UNLISTED_FORCE_LABEL: found.unexplained}


def causes_json(found: MismatchResult) -> list[dict[str, Any]]:
    """The named causes, the one that explains most first, and what is left unexplained."""
    out = [_cause_json(found, cause) for cause in found.named]
    return [*out, _unexplained_json(found)] if found.verdict == UNLISTED_FORCE_LABEL else out


def _cause_json(found: MismatchResult, cause: NamedCause) -> dict[str, Any]:
    effect = two_plate_system().effect(cause.name)
    return {
        "name": cause.name,
        "kind": effect.kind,
        "channels": list(effect.channels),
        "regime": _regime_text(found, effect),
        "parameters": _parameters_json(found, cause.name),
        "weight": cause.probability,
        "credible_set": cause.credible_set,
        "log_evidence_gain": found.gains[cause.name],
        "sentence": effect.statement,
    }


def _regime_text(found: MismatchResult, effect: Effect) -> str:
    """Where an effect acts; of a displaced camera, from when on in which trials."""
    if effect.name != CAMERA_SHIFT_EFFECT or not found.displacements:
        return effect.regime
    moments = (f"{d.time_s:.1f} s after the start of {d.trial}" for d in found.displacements)
    return f"from {', '.join(moments)} on"


def _parameters_json(found: MismatchResult, name: str) -> dict[str, dict[str, Any]]:
    """A cause's numbers; std such that value +- 1.96 std is their 95 % interval."""
    stated, rows = (
        estimates_by_label(found.extended),
        {p.name: p for p in two_plate_system().parameters},
    )
    return {
        label.split(".", 1)[1]: {
            "value": value,
            "std": std,
            "unit": rows[label].unit,
            "meaning": rows[label].meaning,
        }
        for label, (value, std) in stated.items()
        if label.startswith(name + ".")
    }


def residual_terms_of_extended_model(found: MismatchResult) -> list[str]:
    """Names of the residual terms in the extended model."""
    return [f.name for f in found.extended.fit.free if is_residual(f.name)]


def _unexplained_json(found: MismatchResult) -> dict[str, Any]:
    terms = residual_terms_of_extended_model(found)
    channels = sorted({c for t in terms for c in _term_channels(t)}, key=FORCE_CHANNELS.index)
    depends = [d for d in found.dependences if FORCE_CHANNELS[d.channel] in channels] or list(
        found.dependences
    )
    variable = depends[0].variable if depends else "nothing that was tried"
    parameters: dict[str, Any] = {}
    for effect in sorted({t.split(".")[0] for t in terms}):
        parameters |= _parameters_json(found, effect)
    return {
        "name": UNLISTED_FORCE_LABEL,
        "kind": "physics",
        "channels": channels,
        "regime": f"depends on {variable}",
        "parameters": parameters,
        "weight": found.unexplained,
        "sentence": unexplained_sentence(variable),
    }


def _term_channels(term: str) -> tuple[str, ...]:
    effect, number = term.split(".", 1)
    return (
        residual_channels(number)
        if effect == "residual"
        else two_plate_system().effect(effect).channels
    )


def rivals_json(found: MismatchResult) -> list[dict[str, Any]]:
    """Candidates that may act in the place of a named cause, or beside the named ones."""
    listed = {n: p for n, p in probability_by_cause(found).items() if n != UNLISTED_FORCE_LABEL}
    return [
        r | {"how_to_tell_apart": _trials_to_distinguish_text(r["in_place_of"], r["name"])}
        for r in rival_rows(found.named, listed)
    ]


def _trials_to_distinguish_text(name: str, other: str) -> str:
    """Where to film to distinguish a rival from the cause in whose place it may act, or at all."""
    if not name:
        return f"{other} would act in {_regime_or_all_trials(other)}: film more trials there"
    first = _regime_or_all_trials(name)
    if other == UNLISTED_FORCE_LABEL:
        return (
            f"an unlisted force describes these trials about as well as {name}: film where {name} "
            f"should be strongest ({first}) and where it should vanish"
        )
    return (f"{name} acts in {first}, {other} in {_regime_or_all_trials(other)}: film where only "
            "one of them should act")  # fmt: skip


def _regime_or_all_trials(name: str) -> str:
    return two_plate_system().effect(name).regime or "all trials"


def dependence_json(found: MismatchResult) -> list[dict[str, Any]]:
    """Channels and variables that explain the missing force, the largest share first."""
    if found.verdict == "none":
        return []
    strong = sorted((d for d in found.dependences if d.adds > 0), key=lambda d: -d.adds)
    return [{"channel": FORCE_CHANNELS[d.channel], "variable": d.variable, "share": d.adds,
             "trials": list(d.trials)} for d in strong]  # fmt: skip


def mismatch_detail_json(found: MismatchResult) -> dict[str, Any]:
    """Content of mismatch_detail.json: forces along the paths, candidate sets, coefficients."""
    best = found.posterior.best.log_posterior
    return {
        "forces": {
            f.name: {
                "time_s": f.times,
                "x_m": f.states[:, 0],
                "y_m": f.states[:, 1],
                "heading_rad": f.states[:, 2],
                **{f"{c}_{u}": f.force[:, i]
                   for i, (c, u) in enumerate((("surge", "N"), ("sway", "N"), ("yaw", "Nm")))},
                **{f"{c}_std": f.std[:, i] for i, c in enumerate(FORCE_CHANNELS)},
            }
            for f in found.forces
        },
        "sets": [
            {"causes": list(s.causes), "probability": float(p),
             "log_posterior": s.log_posterior - best,
             "log_likelihood": s.model.log_likelihood, "overdispersion": s.overdispersion}
            for p, s in sorted(zip(found.posterior.probability, found.posterior.sets, strict=True),
                               key=lambda x: -x[0])
        ],
        "coefficients": {
            name: {label: {"value": value, "std": std}
                   for label, (value, std) in estimates_by_label(tuned).items()}
            for name, tuned in (("before", found.baseline), ("after", found.extended))
        },
    }  # fmt: skip
