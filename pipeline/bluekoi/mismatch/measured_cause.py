"""A cause that a direct measurement shows, and that was corrected before the search."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import ModuleType
from typing import Any


def measured_cause_json(
    effect: ModuleType,
    parameters: Mapping[str, Mapping[str, Any]],
    *,
    regime: str,
    sigmas: float,
    sentence: str,
) -> dict[str, Any]:
    """Entry of `causes` in mismatch.json, of the effect in a module of `measurement`.

    parameters: as of other causes. sigmas: distance of the measured value from 0 in standard
    errors, which gives the gain of log evidence sigmas^2 / 2. The entry states it as
    `measured_standard_errors`, which causes found by the search do not have.
    """
    name = effect.__name__.rsplit(".", 1)[1]
    return {
        "name": name,
        "kind": effect.EFFECT_KIND,
        "channels": list(effect.AFFECTED_CHANNELS),
        "regime": regime,
        "parameters": dict(parameters),
        "weight": 1.0,
        "credible_set": [name],
        "log_evidence_gain": 0.5 * sigmas**2,
        "measured_standard_errors": sigmas,
        "sentence": sentence,
    }


def with_measured_cause(
    content: Mapping[str, Any], cause: Mapping[str, Any], *, sentence: str,
    replaces: Collection[Mapping[str, Any]] = (),
) -> dict[str, Any]:  # fmt: skip
    """mismatch.json with this cause as its first, and with this sentence as its verdict.

    replaces: causes found by the search that it includes.
    """
    name = cause["name"]
    return {
        **content,
        "verdict": cause["kind"],
        "sentence": sentence,
        "causes": [cause, *(c for c in content["causes"] if c not in replaces)],
        "rivals": [r for r in content["rivals"] if r["name"] != name],
        "probabilities": {**content["probabilities"], name: 1.0},
    }
