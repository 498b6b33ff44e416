"""The paper's robot and a camera above it."""

from __future__ import annotations

from bluekoi.study import StudySettings

PAPER_ROBOT = {
    "mass_kg": 0.68,
    "yaw_inertia_kg_m2": 0.0095,
    "body_length_m": 0.331,
    "head_length_m": 0.12,
    "head_span_m": 0.069,
    "hinge_to_com_m": 0.04,
    "tail_length_m": 0.066,
}
"""The section `robot` of its study.yaml."""
PAPER_SETUP = StudySettings.model_validate(
    {
        "robot": PAPER_ROBOT,
        "camera": {"pool_corners_px": [[300, 900], [1600, 900], [1600, 100], [300, 100]]},
    }
)
