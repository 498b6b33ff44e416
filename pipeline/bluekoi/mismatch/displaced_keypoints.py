"""Keypoints displaced in the pool, which the rigid lengths showed, as a cause of the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..measurement import keypoint_bias
from .measured_cause import measured_cause, with_measured_cause

KEYPOINT_BIAS_CAUSE = "keypoint_bias"


def with_keypoint_bias_cause(
    content: Mapping[str, Any],
    displacements: Sequence[Mapping[str, Any]],
    fitted: Sequence[str],
) -> dict[str, Any]:
    """mismatch.json with `keypoint_bias` as its first cause; unchanged where no keypoint is
    displaced.

    displacements: `Campaign.keypoint_displacements`, which the tracks do not contain.
    fitted: names of the trials of the fits. The cause includes an offset on the body that the
    search found.
    """
    parts = [(names, part["keypoints"]) for part in displacements
             if (names := [n for n in fitted if n in part["trials"]])]  # fmt: skip
    if not parts:
        return dict(content)
    texts, regimes = [], []
    parameters: dict[str, Any] = {}
    for number, (names, keypoints) in enumerate(parts, 1):
        suffix = "" if len(parts) == 1 else f"_part_{number}"
        where = f"in all {len(fitted)} trials" if len(names) == len(fitted) else (
            f"in {len(names)} trials from {names[0]} to {names[-1]}"
        )  # fmt: skip
        descriptions = [_displacement_text(name, one) for name, one in keypoints.items()]
        texts.append(f"{where}, {', '.join(descriptions)}")
        regimes.append(f"all frames {where}, fixed to the pool")
        for name, one in keypoints.items():
            parameters |= _parameters_of_keypoint(name, one, suffix)
    summary = f"keypoints are displaced in the pool ({'; '.join(texts)})"
    found_on_body = [c for c in content["causes"] if c["name"] == KEYPOINT_BIAS_CAUSE]
    for cause in found_on_body:
        parameters |= cause["parameters"]
    cause = measured_cause(
        keypoint_bias,
        parameters,
        regime="; ".join(regimes),
        sigmas=max(one["sigmas"] for _, keypoints in parts for one in keypoints.values()),
        sentence=f"The rigid lengths of the robot show that {summary}. {_possible_reasons(parts)} "
        "The displacement was subtracted before the search.",
    )
    sentence = (f"Measurement error: keypoint_bias, {summary}. With corrected keypoints: "
                f"{content['sentence']}")  # fmt: skip
    return with_measured_cause(content, cause, sentence=sentence, replaces=found_on_body)


def _possible_reasons(parts: Sequence[tuple[Sequence[str], Mapping[str, Any]]]) -> str:
    found = [one for _, keypoints in parts for one in keypoints.values()]
    reasons = []
    if any(one["x_m"] or one["y_m"] for one in found):
        reasons.append("Highlights and shadows displace keypoints towards one side.")
    if any(one["growth"] for one in found):
        reasons.append("The displacement of a keypoint that lies higher or lower than the others "
                       "grows with the distance from the point below the camera.")  # fmt: skip
    return " ".join(reasons)


def _displacement_text(keypoint: str, found: Mapping[str, Any]) -> str:
    size_m = np.hypot(found["x_m"], found["y_m"])
    toward = np.degrees(np.arctan2(found["y_m"], found["x_m"]))
    x, y = found["middle_m"]
    place = f"({x:.2f}, {y:.2f}) m"
    texts = []
    if size_m:
        texts.append(f"{1000 * size_m:.1f} mm, {toward:.0f} degrees from the x axis")
    if found["growth"]:
        way = "away from it" if found["growth"] > 0 else "towards it"
        texts.append(f"{100 * abs(found['growth']):.1f} % of the distance from {place}, {way}")
    return f"{keypoint} by {', and by '.join(texts)}"


def _parameters_of_keypoint(
    keypoint: str, found: Mapping[str, Any], suffix: str
) -> dict[str, dict[str, Any]]:
    x, y = found["middle_m"]
    parameters = {}
    if found["x_m"] or found["y_m"]:
        parameters = {
            f"{keypoint}_{axis}{suffix}": {
                "value": found[f"{axis}_m"],
                "std": found[f"{axis}_std_m"],
                "unit": "m",
                "meaning": f"displacement of {keypoint} along {axis} of the pool",
            }
            for axis in ("x", "y")
        }
    if found["growth"]:
        parameters[f"{keypoint}_growth{suffix}"] = {
            "value": found["growth"],
            "std": found["growth_std"],
            "unit": "m/m",
            "meaning": f"displacement of {keypoint} away from ({x:.2f}, {y:.2f}) m over the "
            "distance from there",
        }
    return parameters
