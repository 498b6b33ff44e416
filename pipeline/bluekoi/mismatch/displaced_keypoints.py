"""Keypoints displaced in the pool, which the rigid lengths showed, as a cause of the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..measurement import keypoint_bias
from .measured_cause import measured_cause_json, with_measured_cause

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
    cause = measured_cause_json(
        keypoint_bias,
        parameters,
        regime="; ".join(regimes),
        sigmas=max(one["sigmas"] for _, keypoints in parts for one in keypoints.values()),
        sentence=f"The rigid lengths of the robot show that {summary}. {_reasons_text(parts)} "
        "Lengths show only how keypoints are displaced relative to each other. The displacements "
        "were subtracted before the search.",
    )
    sentence = (f"Measurement error: keypoint_bias, {summary}. With corrected keypoints: "
                f"{content['sentence']}")  # fmt: skip
    return with_measured_cause(content, cause, sentence=sentence, replaces=found_on_body)


def _reasons_text(parts: Sequence[tuple[Sequence[str], Mapping[str, Any]]]) -> str:
    found = [one["parallax"] != 0 for _, keypoints in parts for one in keypoints.values()]
    reasons = []
    if not all(found):
        reasons.append("Highlights and shadows displace keypoints towards one side.")
    if any(found):
        reasons.append("A keypoint that lies higher or lower than the others is displaced in "
                       "proportion to its distance from the point below the camera.")  # fmt: skip
    return " ".join(reasons)


def _displacement_text(keypoint: str, found: Mapping[str, float]) -> str:
    x, y, parallax = found["x_m"], found["y_m"], found["parallax"]
    if parallax:
        way = "away from it" if parallax > 0 else "towards it"
        share = f"{100 * abs(parallax):.1f} % of its distance"
        return f"{keypoint} by {share} from {_undisplaced_position_text(found)}, {way}"
    toward = np.degrees(np.arctan2(y, x))
    return f"{keypoint} by {1000 * np.hypot(x, y):.1f} mm, {toward:.0f} degrees from the x axis"


def _undisplaced_position_text(found: Mapping[str, float]) -> str:
    """The position without displacement, of a keypoint with a parallax."""
    return f"({-found['x_m'] / found['parallax']:.2f}, {-found['y_m'] / found['parallax']:.2f}) m"


def _parameters_of_keypoint(
    keypoint: str, found: Mapping[str, float], suffix: str
) -> dict[str, dict[str, Any]]:
    if found["parallax"]:
        return {
            f"{keypoint}_parallax{suffix}": {
                "value": found["parallax"],
                "std": found["parallax_std"],
                "unit": "m/m",
                "meaning": f"displacement of {keypoint} away from "
                f"{_undisplaced_position_text(found)}, over the distance from there",
            }
        }
    return {
        f"{keypoint}_{axis}{suffix}": {
            "value": found[f"{axis}_m"],
            "std": found[f"{axis}_std_m"],
            "unit": "m",
            "meaning": f"displacement of {keypoint} along {axis} of the pool",
        }
        for axis in ("x", "y")
    }
