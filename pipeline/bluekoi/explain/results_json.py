"""explanation.json: what was found, with the keys of the robot's mismatch.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..engine import NamedCause
from ..engine.cause_selection import UNLISTED_FORCE_LABEL
from ..fitting import MAX_OVERDISPERSION
from .cause_search import CauseSearchResult
from .estimated_noise import estimated_errors, estimated_random_forces
from .numbers import FittedNumber
from .prediction import PredictedTrials

MIN_RIVAL_PROBABILITY = 0.02
"""Probability from which an alternative is listed."""
MAX_NOISE_FLOOR_RATIO = 1.5
"""Ratio of errors of free runs to the noise floor above which they are reported as excessive."""


def explanation_json(found: CauseSearchResult) -> dict[str, Any]:
    """Verdict, causes, probabilities, held-out errors, warnings; None where unknown."""
    held = found.held_out
    return {
        "model": found.model.name,
        "verdict": found.verdict,
        "sentence": verdict_sentence(found),
        "causes": causes_json(found),
        "rivals": rivals_json(found),
        "probabilities": {**found.probabilities, UNLISTED_FORCE_LABEL: found.unexplained},
        "held_out": {
            "trials": list(held.trials),
            "baseline": _finite_values(held.baseline),
            "extended": _finite_values(held.extended),
            "noise_floor": _finite_values(held.noise_floor),
            "baseline_fitted_to": held.fitted_to[0],
            "extended_fitted_to": held.fitted_to[1],
            "stretch_s": held.stretch_s,
        },
        "coefficients": {"baseline": _fitted_parameters_json(found.baseline_numbers),
                         "extended": _fitted_parameters_json(found.numbers)},
        "noise": {"observations": [asdict(e) for e in estimated_errors(found)],
                  "random_forces": [asdict(f) for f in estimated_random_forces(found)]},
        "residual_terms": residual_term_probabilities(found),
        "overdispersion": _finite_or_none(found.best.overdispersion),
        "fit": {"rate_hz": _finite_or_none(found.prepared.rate_hz), "step_s": found.prepared.step_s,
                "trials": [s.name for s in found.prepared.series],
                "samples": sum(len(s.times) for s in found.prepared.series)},
        "sets": _cause_sets_json(found),
        "compared": [
            {"causes": list(c.causes), "log_posterior": _finite_or_none(c.log_posterior),
             "fitted_to": c.fitted_to, "numbers": _fitted_parameters_json(c.numbers),
             "errors": _finite_values(c.errors)}
            for c in found.compared
        ],
        "warnings": list(found.warnings),
    }  # fmt: skip


def verdict_sentence(found: CauseSearchResult) -> str:
    """The verdict in a sentence or two."""
    if (
        found.verdict == "none"
        and (excess := max_error_over_noise_floor(found)) > MAX_NOISE_FLOOR_RATIO
    ):
        return (
            f"No candidate has a probability above 1/2, but free runs are wrong by {excess:.1f} "
            "times the noise floor: something is missing that no candidate describes, or a unit, a "
            "sign or the time of the recordings is wrong."
        )
    if found.verdict == "none" and (c := found.best.overdispersion) > MAX_OVERDISPERSION:
        return (
            f"No candidate has a probability above 1/2, but parameters vary between trials {c:.1f} "
            "times more (in variance) than their standard errors allow: something is missing that "
            "no candidate describes, or a trial is wrong (see the warnings)."
        )
    if found.verdict == "none":
        return "No mismatch beyond the noise: no candidate has a probability above 1/2."
    said = [f"{c.name} ({c.probability:.2f}{_inseparable_alternatives_text(c)}): "
            f"{found.model.by_name[c.name].statement}" for c in found.named]  # fmt: skip
    if found.verdict == UNLISTED_FORCE_LABEL:
        said.append(f"A force acts that no candidate describes ({found.unexplained:.2f}).")
    return " ".join(said)


def _inseparable_alternatives_text(cause: NamedCause) -> str:
    others = [n for n in cause.credible_set if n != cause.name]
    return f"; or {', '.join(others)}: these trials cannot separate them" if others else ""


def max_error_over_noise_floor(found: CauseSearchResult) -> float:
    """Largest ratio of the error of free runs of the baseline to the noise floor; 0 unknown."""
    held = found.held_out
    ratios = [held.baseline[n] / floor for n, floor in held.noise_floor.items()
              if n in held.baseline and floor > 0 and np.isfinite(held.baseline[n])]  # fmt: skip
    return max(ratios, default=0.0)


def causes_json(found: CauseSearchResult) -> list[dict[str, Any]]:
    """The named causes with their numbers."""
    return [_cause_json(found, c) for c in found.named]


def _cause_json(found: CauseSearchResult, named: NamedCause) -> dict[str, Any]:
    cause = found.model.by_name[named.name]
    effect = found.prepared.assembly.system.effect(named.name)
    own = [n for n in found.numbers if n.label.startswith(named.name + ".")]
    return {
        "name": named.name,
        "kind": cause.kind,
        "site": cause.site,
        "channels": list(effect.channels),
        "variables": list(effect.variables),
        "regime": cause.regime,
        "parameters": {k.split(".", 1)[1]: v for k, v in _fitted_parameters_json(own).items()},
        "weight": named.probability,
        "credible_set": named.credible_set,
        "log_evidence_gain": _finite_or_none(found.gains[named.name]),
        "sentence": cause.statement,
    }


def rivals_json(found: CauseSearchResult) -> list[dict[str, Any]]:
    """Candidates that may act in the place of a named cause, or beside the named ones."""
    return rival_rows(found.named, found.probabilities)


def rival_rows(
    named: Sequence[NamedCause], probabilities: Mapping[str, float]
) -> list[dict[str, Any]]:
    """Rivals of named causes: name, in_place_of (empty: beside them) and weight; all members of
    credible sets, and other candidates with a posterior of `MIN_RIVAL_PROBABILITY` at least.
    """
    taken, out = {c.name for c in named}, list[dict[str, Any]]()
    members = {n for c in named for n in c.credible_set}
    rows = [(c.name, n, p, c.alternatives[n])
            for c in named for n, p in c.alternative_probabilities.items()]  # fmt: skip
    rows += [("", n, p, p) for n, p in probabilities.items()]
    for place, name, p, posterior in rows:
        if name not in taken and (posterior >= MIN_RIVAL_PROBABILITY or name in members):
            taken.add(name)
            out.append({"name": name, "in_place_of": place, "weight": p})
    return sorted(out, key=lambda r: -float(r["weight"]))


def residual_term_probabilities(found: CauseSearchResult) -> dict[str, float]:
    """Residual terms with their probabilities, the largest first."""
    rest = {n: p for n, p in found.posterior.inclusion.items()
            if n not in found.model.by_name and p >= MIN_RIVAL_PROBABILITY}  # fmt: skip
    return dict(sorted(rest.items(), key=lambda x: -x[1]))


def _cause_sets_json(found: CauseSearchResult) -> list[dict[str, Any]]:
    pairs = zip(found.posterior.probability, found.posterior.sets, strict=True)
    best = found.posterior.best.log_posterior
    return [
        {"causes": list(s.causes), "probability": float(p),
         "log_posterior": s.log_posterior - best,
         "overdispersion": _finite_or_none(s.overdispersion)}
        for p, s in sorted(pairs, key=lambda x: -x[0]) if p >= 1e-3
    ]  # fmt: skip


def _fitted_parameters_json(given: Sequence[FittedNumber]) -> dict[str, dict[str, Any]]:
    return {
        n.label: {
            "value": n.value,
            "std": _finite_or_none(n.std),
            "unit": n.unit,
            **({"at_bound": n.at_bound} if n.at_bound else {}),
        }
        for n in given
    }


def _finite_or_none(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _finite_values(given: dict[str, float]) -> dict[str, float | None]:
    return {k: _finite_or_none(v) for k, v in given.items()}


def prediction_json(found: PredictedTrials) -> dict[str, Any]:
    """Errors and measures of every predicted trial."""
    return {
        "known_s": found.known_s,
        "not_applied": list(found.not_applied),
        "messages": list(found.messages),
        "measured": [_finite_values(m) for m in found.measured],
        "runs": [
            {"model": model, "start": start, "trial": r.trial, "errors": _finite_values(r.errors),
             "measures": _finite_values(r.measures)}
            for (model, start), runs in found.runs.items() for r in runs
        ],
    }  # fmt: skip
