"""Faults of the measurement that may be concealed in a study, each put in where it arises.

`size`: scale, clock: share; lens: change of k1 as stated; refraction: true depth (m) of keypoints
whose refraction the study ignores; offset: seconds; camera, bias: metres.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["FAULTS", "MeasurementFault", "with_wrong_statement"]


@dataclass(frozen=True)
class MeasurementFault:
    """A fault: statement, sizes when faint and when clear, whether either sign occurs."""

    statement: str
    faint: tuple[float, float]
    clear: tuple[float, float]
    signed: bool = True


FAULTS: Mapping[str, MeasurementFault] = {
    "scale_error": MeasurementFault(
        "the pool is stated too long or short", (0.012, 0.02), (0.03, 0.08)
    ),
    "clock_error": MeasurementFault(
        "the frame rate is stated wrongly", (0.012, 0.02), (0.03, 0.10)
    ),
    "camera_shift": MeasurementFault(
        "the camera is displaced during a trial", (0.004, 0.006), (0.012, 0.03)
    ),
    "uncorrected_refraction": MeasurementFault(
        "refraction at the surface is ignored", (0.07, 0.09), (0.12, 0.2), signed=False
    ),
    "lens_error": MeasurementFault("the lens is stated wrongly", (0.02, 0.03), (0.05, 0.10)),
    "time_offset": MeasurementFault("the film starts early", (0.15, 0.3), (0.5, 1.0), signed=False),
    "keypoint_bias": MeasurementFault(
        "a keypoint sits beside its place", (0.003, 0.005), (0.008, 0.015)
    ),
}


def with_wrong_statement(contents: dict[str, Any], fault: str, size: float) -> dict[str, Any]:
    """study.yaml's contents with a fault of statement put in; as they are for other faults."""
    if fault == "scale_error":
        pool = contents["pool"]
        grown = {k: round(pool[k] * (1 + size), 5) for k in ("length_m", "width_m")}
        return contents | {"pool": pool | grown}
    if fault == "lens_error":
        camera = contents["camera"]
        k1, *rest = camera["distortion"]
        return contents | {"camera": camera | {"distortion": [k1 + size, *rest]}}
    if fault == "uncorrected_refraction":
        return contents | {"water": contents["water"] | {"refractive_index": 1.0}}
    return contents
