"""Keypoints displaced in the pool, which the rigid lengths showed, as a cause of the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..measurement import keypoint_bias
from .measured_cause import measured_cause, with_measured_cause

KEYPOINT_BIAS_CAUSE = "keypoint_bias"


def with_keypoint_bias_cause(
    content: Mapping[str, Any], displacements: Mapping[str, Mapping[str, float]]
) -> dict[str, Any]:
    """mismatch.json with `keypoint_bias` as its first cause; unchanged where no keypoint is
    displaced.

    displacements: `keypoint_displacements` of geometry.json, which the tracks do not contain.
    The cause includes an offset on the body that the search found.
    """
    if not displacements:
        return dict(content)
    texts, parameters = [], {}
    for keypoint, found in displacements.items():
        size_m = np.hypot(found["x_m"], found["y_m"])
        toward = np.degrees(np.arctan2(found["y_m"], found["x_m"]))
        texts.append(f"{keypoint} by {1000 * size_m:.0f} mm, {toward:.0f} degrees from the x axis")
        for axis in ("x", "y"):
            parameters[f"{keypoint}_{axis}"] = {
                "value": found[f"{axis}_m"],
                "std": found[f"{axis}_std_m"],
                "unit": "m",
                "meaning": f"displacement of {keypoint} along {axis} of the pool",
            }
    which = "a keypoint is" if len(texts) == 1 else "keypoints are"
    said = f"{which} displaced towards one side of the pool in all trials ({'; '.join(texts)})"
    found_on_body = [c for c in content["causes"] if c["name"] == KEYPOINT_BIAS_CAUSE]
    for cause in found_on_body:
        parameters |= cause["parameters"]
    cause = measured_cause(
        keypoint_bias,
        parameters,
        regime="all frames, fixed to the pool",
        sigmas=max(found["sigmas"] for found in displacements.values()),
        sentence=f"In the rigid lengths of the robot, {said}. Highlights and shadows displace "
        "keypoints in this way. The displacement was subtracted before the search.",
    )
    sentence = (f"Measurement error: keypoint_bias, {said}. With corrected keypoints: "
                f"{content['sentence']}")  # fmt: skip
    return with_measured_cause(content, cause, sentence=sentence, replaces=found_on_body)
