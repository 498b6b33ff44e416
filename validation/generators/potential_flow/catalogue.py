"""All functional forms: of the causes in STUDY.md, and the forces that no cause describes."""

from __future__ import annotations

from . import faults as fa
from . import motors
from . import surroundings as su
from .form import Form
from .form import forms as _forms
from .physical import DIRECTION_RANGES, MOTION_FORMS, TURNS_UNTIL_WAKE_RANGES

UNLISTED_NAME = "unexplained"

PHYSICS = [
    *MOTION_FORMS,
    *_forms(
        "wake_reentry",
        "thrust",
        "1",
        ("surge",),
        [
            ("logistic", motors.wake_logistic, 4e-3, 0.7, TURNS_UNTIL_WAKE_RANGES),
            ("ramp", motors.wake_ramp, 4e-3, 0.6, TURNS_UNTIL_WAKE_RANGES),
            ("saturating", motors.wake_saturating, 4e-3, 0.7, {"turn": (2.0, 4.0)}),
            ("aged", motors.wake_decay_with_age, 4e-3, 0.8, TURNS_UNTIL_WAKE_RANGES),
        ],
    ),
    *_forms(
        "sinking",
        "depth",
        "m",
        ("surge",),
        [
            ("linear", fa.sink_linear, 2e-3, 0.25),
            ("square", fa.sink_square, 2e-3, 0.25),
            ("saturating", fa.sink_saturating, 2e-3, 0.25, {"tau": (2.0, 5.0)}),
        ],
    ),
]

MEASUREMENT = [
    *_forms(
        "scale_error",
        "stated",
        "1",
        (),
        [
            ("uniform", fa.scale_uniform, 2e-3, 0.2),
            ("one_axis", fa.scale_one_axis, 2e-3, 0.15),
            ("rim", fa.scale_corner_marks, 2e-3, 0.2),
        ],
    ),
    *_forms(
        "clock_error",
        "exposure",
        "1",
        (),
        [
            ("constant", fa.clock_constant, 1e-3, 0.2),
            ("part", fa.clock_some_trials, 1e-3, 0.2, {"first": (0.3, 0.6)}),
            ("drift", fa.clock_drift, 1e-3, 0.15),
        ],
    ),
    *_forms(
        "camera_shift",
        "picture",
        "px",
        (),
        [
            ("translation", fa.shift_translation, 0.05, 30, {**DIRECTION_RANGES, "at": (1.2, 3.2)}),
            ("drift", fa.shift_drift, 0.02, 20, DIRECTION_RANGES),
            ("several", fa.shift_several, 0.02, 20, DIRECTION_RANGES),
        ],
    ),
    *_forms(
        "camera_shift",
        "picture",
        "rad",
        (),
        [("rotation", fa.shift_rotation, 1e-4, 0.06, {"at": (1.2, 3.2)})],
    ),
    *_forms(
        "uncorrected_refraction",
        "stated",
        "m",
        (),
        [("depth", fa.refraction_depth, 4e-3, 0.085), ("both", fa.refraction_both, 3e-3, 0.08)],
    ),
    *_forms(
        "uncorrected_refraction", "stated", "1", (), [("index", fa.refraction_index, 0.01, 0.249)]
    ),
    *_forms(
        "lens_error",
        "stated",
        "1",
        (),
        [
            ("k1", fa.lens_first, 1e-3, 0.25),
            ("k2", fa.lens_second, 1e-3, 0.3),
            ("tangential", fa.lens_tangential, 3e-4, 0.08),
            ("focal", fa.lens_focal, 1e-3, 0.25),
        ],
    ),
    *_forms(
        "time_offset",
        "exposure",
        "s",
        (),
        [
            ("video_first", fa.offset_video_first, 2e-3, 1.0),
            ("log_first", fa.offset_log_first, 2e-3, 1.0),
            ("per_trial", fa.offset_per_trial, 2e-3, 0.8, {"c": (1.0, 2.0)}),
        ],
    ),
    *_forms(
        "keypoint_bias",
        "label",
        "m",
        (),
        [
            ("all_labels", fa.bias_all_labels, 5e-4, 0.03),
            ("one_label", fa.bias_core_center, 5e-4, 0.03, {"label": (0.0, 2.99)}),
            ("head_tip", fa.bias_head_tip, 5e-4, 0.03),
        ],
    ),
    *_forms(
        "keypoint_bias", "label", "m/rad", (), [("turning", fa.bias_with_head_angle, 5e-4, 0.08)]
    ),
]


def _unlisted_form(name, law, unit, high, channel, *, variable, **ranges):
    return Form(
        UNLISTED_NAME,
        name,
        "force",
        law,
        unit,
        high / 1000,
        high,
        (channel,),
        ranges,
        variable=variable,
    )


UNLISTED_FORMS = [
    _unlisted_form(
        "heading", su.unlisted_heading, "N m", 0.02, "yaw", variable="heading_rad", c=(0, 6.28)
    ),
    _unlisted_form(
        "place",
        su.unlisted_place,
        "N",
        0.2,
        "surge",
        variable="x_m",
        length=(0.5, 1.2),
        c=(0, 6.28),
    ),
    _unlisted_form(
        "time", su.unlisted_time, "N", 0.3, "sway", variable="time_s", period=(0.8, 2.5)
    ),
    _unlisted_form("beat", su.unlisted_beat, "N m", 0.03, "yaw", variable="beat_phase_rad"),
    _unlisted_form(
        "rate_angle",
        su.unlisted_rate_angle,
        "N s/rad^2",
        0.5,
        "surge",
        variable="yaw_rate_rad_s*head_angle_rad",
    ),
    _unlisted_form(
        "compass", su.unlisted_compass, "N s/m", 0.5, "sway", variable="heading_rad", c=(0, 6.28)
    ),
    _unlisted_form("saddle", su.unlisted_saddle, "N s", 0.06, "yaw", variable="x_m*y_m"),
    _unlisted_form(
        "speed", su.unlisted_speed, "N", 0.2, "surge", variable="speed_m_s", scale=(0.15, 0.3)
    ),
]
CATALOGUE = [*PHYSICS, *MEASUREMENT, *UNLISTED_FORMS]
