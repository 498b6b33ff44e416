"""Numbers that measurement errors of one trial depend on."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ..camera.camera_error_displacement import camera_error_field_coefficients
from ..study import StudySettings

TIME_OF_NO_CAMERA_SHIFT_S = 1e9
"""Time of a displacement of the camera that never comes, s."""
POOL_DIMENSION_ERROR_CONSTANTS = (
    "length_to_x", "length_to_y", "length_tilt_x", "length_tilt_y",
    "width_to_x", "width_to_y", "width_tilt_x", "width_tilt_y",
)  # fmt: skip
"""Constants of a view that an error of the pool's length or width depends on."""


@dataclass(frozen=True)
class CameraErrorInputs:
    """How one trial is seen; the defaults are an error-free view without a camera.

    x_cam, y_cam: point of the pool below the camera (m). bend: growth of the displacement by
    refraction, `1 + bend rho^2` (1/m2). x_lens, y_lens (m), Q_lens (m2), ax_lens, ay_lens (m3):
    `camera.error_displacement.CameraErrorFieldCoefficients`. t_shift: time from which the camera is
    displaced (s). x_shift, y_shift: displacement beside that of the most clearly displaced trial
    (1, as a complex number). ahead: distance of the observed nose from the core's centre (m).
    clock_part: share of an error of the frame rate that the trial has. inward_min, inward_max:
    range of what refraction can draw in (1); not known where both are 0. session_place: place of
    the trial in the session, from 0, the first one, to 1, the last. length_to_x, length_to_y (1),
    length_tilt_x, length_tilt_y (1/m), and the same of the width: `length_error_field` and
    `width_error_field` of `camera.error_displacement.CameraErrorFieldCoefficients`.
    """

    x_cam: float = 0.0
    y_cam: float = 0.0
    bend: float = 0.0
    x_lens: float = 0.0
    y_lens: float = 0.0
    Q_lens: float = 0.0
    ax_lens: float = 0.0
    ay_lens: float = 0.0
    t_shift: float = TIME_OF_NO_CAMERA_SHIFT_S
    x_shift: float = 1.0
    y_shift: float = 0.0
    ahead: float = 0.0
    clock_part: float = 1.0
    inward_min: float = 0.0
    inward_max: float = 0.0
    session_place: float = 0.5
    length_to_x: float = 1.0
    length_to_y: float = 0.0
    length_tilt_x: float = 0.0
    length_tilt_y: float = 0.0
    width_to_x: float = 0.0
    width_to_y: float = 1.0
    width_tilt_x: float = 0.0
    width_tilt_y: float = 0.0


def camera_error_constant_names() -> tuple[str, ...]:
    """Names of the constants of a view, in order."""
    return tuple(field.name for field in fields(CameraErrorInputs))


def camera_error_inputs(setup: StudySettings, session_place: float = 0.5) -> CameraErrorInputs:
    """The view of a study's camera; session_place: as in `CameraErrorInputs`."""
    seen = camera_error_field_coefficients(setup)
    low, high = seen.inward_shift_range
    return CameraErrorInputs(
        *seen.below_m,
        seen.bend_1_m2,
        *seen.lens_m,
        seen.lens_rest_m2,
        *seen.lens_pull_m3,
        inward_min=low,
        inward_max=high,
        session_place=session_place,
        **dict(
            zip(
                POOL_DIMENSION_ERROR_CONSTANTS,
                (*seen.length_error_field, *seen.width_error_field),
                strict=True,
            )
        ),
    )
