"""Registry of concealed effects: forms, strengths with bounds, shape parameters and sources.

Loads are compiled in forces.py; this module holds the table, the time courses of the inputs
(flapping frequency and head angle) and the depth of a sinking robot.
"""

from dataclasses import dataclass

import numpy as np

from .dynamics import EFFECT_ROW, STEP_S

Range = tuple[str, str, float, float]


@dataclass(frozen=True)
class Form:
    """One functional form: ``strength`` and ``shape`` are (name, unit, low, high)."""

    code: int
    name: str
    strength: Range
    shape: tuple[Range, ...] = ()
    signed: bool = False


@dataclass(frozen=True)
class Effect:
    """A drawn effect: strength and shape in SI units."""

    name: str
    form: Form
    strength: float
    shape: tuple[float, ...]

    def parameters(self) -> dict[str, dict[str, float | str]]:
        """Parameters by name with value and unit, for the truth file."""
        rows = zip(
            (self.form.strength, *self.form.shape), (self.strength, *self.shape), strict=True
        )
        unused = UNUSED_PARAMETERS.get((self.name, self.form.code), ())
        rows = (pair for pair in rows if pair[0][0] not in unused)
        return {row[0]: {"value": float(value), "unit": row[1]} for row, value in rows}


UNUSED_PARAMETERS = {
    ("uniform_current", 1): ("period",),
    ("linear_yaw_damping", 1): ("rate_scale",),
    ("pool_gyre", 4): ("x", "y", "core"),
    ("battery_sag", 2): ("time_scale",),
    ("battery_sag", 3): ("time_scale",),
    ("battery_sag", 4): ("time_scale",),
}


def _forms(names: str, strength: Range, *shape: Range, signed: bool = False) -> tuple[Form, ...]:
    return tuple(Form(i + 1, n, strength, shape, signed) for i, n in enumerate(names.split()))


_ARM_RANGE = ("arm_m", "m", 0.09, 0.17)
_WIDTH_RANGE = ("width_rad", "rad", 0.02, 0.05)
_DIRECTION_RANGE = ("direction_rad", "rad", -3.14, 3.14)

FORMS: dict[str, tuple[Form, ...]] = {
    "tail_fin_lift": _forms(
        "polhamus jones helmbold ittc_normal_force",
        ("area_m2", "m2", 0.002, 0.06), _ARM_RANGE, ("aspect_ratio", "1", 0.4, 1.2)),
    "added_mass": _forms("lamb_ellipsoid lighthill_body head_plate", ("m_v", "kg", 0.02, 1.2)),
    "viscous_drag": (
        Form(1, "stokes_linear", ("X_u", "N s/m", 0.01, 1.2)),
        Form(2, "blasius_power_1_5", ("X_p", "N (s/m)^1.5", 0.02, 2.5)),
        Form(3, "ittc57", ("wetted_area_m2", "m2", 0.03, 0.9)),
        Form(4, "prandtl_power_1_8", ("X_p", "N (s/m)^1.8", 0.05, 4.0))),
    "linear_yaw_damping": _forms("linear saturating", ("N_r", "N m s", 0.0005, 0.08),
        ("rate_scale", "rad/s", 0.3, 0.9)),
    "thrust_loss_with_speed": _forms("advance_linear wageningen hyperbolic_slip ram_drag",
        ("loss", "1", 0.01, 0.9)),
    "uniform_current": _forms("steady pulsating", ("speed", "m/s", 0.001, 0.06), _DIRECTION_RANGE,
        ("period", "s", 8.0, 20.0)),
    "pool_gyre": _forms("lamb_oseen scully rankine taylor_green", ("speed", "m/s", 0.002, 0.09),
        ("x", "m", 1.0, 1.6), ("y", "m", 0.6, 1.0), ("core", "m", 0.25, 0.6), signed=True),
    "wall_effect": _forms("exponential_cushion image_suction bow_wave",
        ("level", "kg/m", 0.05, 8.0), ("length", "m", 0.12, 0.3)),
    "stall": _forms("kirchhoff viterna logistic linear_fall", ("depth", "1", 0.05, 1.2),
        ("stall_angle", "rad", 0.06, 0.13), _WIDTH_RANGE),
    "trim_moment": (
        Form(1, "thrust_offset", ("moment_at_5_hz", "N m", 5e-5, 0.02), signed=True),
        Form(2, "bent_plate", ("moment_at_0_3_m_s", "N m", 5e-5, 0.02), signed=True),
        Form(3, "constant_cable", ("moment", "N m", 5e-5, 0.012), signed=True)),
    "crossflow_drag": _forms("hoerner_strips tapered_strips plate_at_centroid reynolds_strips",
        ("C_dc", "1", 0.05, 4.0), ("depth", "m", 0.04, 0.07)),
    "thrust_line_offset": _forms("sine tanh double_sine",
        ("lever", "m", 0.0004, 0.05), signed=True),
    "thrust_area": _forms("power blend", ("share", "1", 0.02, 1.0)),
    "lift_lag": (
        Form(1, "kussner_jones", ("A1", "1", 0.02, 0.5), (("A2/A1", "1", 1.0, 1.0),
             ("b1", "1", 0.13, 0.13), ("b2", "1", 1.0, 1.0))),
        Form(2, "wagner_jones", ("A1", "1", 0.01, 0.32), (("A2/A1", "1", 2.03, 2.03),
             ("b1", "1", 0.0455, 0.0455), ("b2", "1", 0.3, 0.3))),
        Form(3, "first_order", ("A1", "1", 0.03, 1.0), (("A2/A1", "1", 0.0, 0.0),
             ("rate", "1/s", 1.5, 5.0), ("rate2", "1/s", 1.0, 1.0))),
        Form(4, "two_times", ("A1", "1", 0.02, 0.5), (("A2/A1", "1", 1.0, 1.0),
             ("rate", "1/s", 1.0, 3.0), ("rate2", "1/s", 5.0, 10.0)))),
    "wave_drag": (
        Form(1, "fourth_power", ("X_4", "N s4/m4", 0.1, 20.0)),
        Form(2, "havelock", ("X_w", "N s2/m2", 0.1, 25.0)),
        Form(3, "froude_hump", ("X_w", "N s2/m2", 0.05, 3.0), (("hump", "m/s", 0.3, 0.45),))),
    "coulomb_friction": (
        Form(1, "coulomb", ("force", "N", 0.001, 0.08)),
        Form(2, "stribeck", ("force", "N", 0.001, 0.06), (("breakaway", "1", 0.3, 1.0),
             ("stribeck_speed", "m/s", 0.05, 0.15)))),
    "wake_reentry": _forms("gaussian_decay momentumless top_hat spreading_jet",
        ("speed", "m/s", 0.003, 0.2), ("width", "m", 0.06, 0.15), ("decay", "s", 3.0, 8.0)),
    "centre_of_mass_shift": _forms("along across", ("shift", "m", 0.0003, 0.03), signed=True),
    "port_starboard_asymmetry": _forms("head_lift thrust_by_side yaw_damping",
        ("share", "1", 0.005, 0.6), signed=True),
    "servo_lag": _forms("first_order rate_limit second_order dead_time_rate",
        ("lag", "s", 0.005, 1.2)),
    "motor_spin_up": _forms("exponential linear raised_cosine", ("tau", "s", 0.01, 1.2)),
    "battery_sag": _forms("rc_cell linear_discharge warburg load_dependent",
        ("fall_at_5_s", "1", 0.002, 0.3), ("time_scale", "s", 1.0, 4.0)),
    "head_angle_offset": _forms("constant gain backlash", ("angle", "rad", 0.003, 0.2),
        signed=True),
    "sinking": _forms("steady settling speed_driven", ("fall_at_5_s", "m", 0.004, 0.2)),
}  # fmt: skip

MEASUREMENT: dict[str, tuple[Form, ...]] = {
    "scale_error": _forms("pool_lengths unequal_sides corners",
        ("factor", "1", 0.005, 0.2), signed=True),
    "clock_error": _forms("factor second_day lost_frames", ("factor", "1", 0.001, 0.25)),
    "camera_shift": _forms("step height_between_days loosening", ("shift", "m", 0.001, 0.4)),
    "uncorrected_refraction": (
        Form(1, "depth", ("deficit", "m", 0.01, 0.2)),
        Form(2, "index_and_depth", ("share_of_refraction_ignored", "1", 0.05, 1.0))),
    "lens_error": _forms("radial centre focal_aspect", ("deficit", "1", 0.002, 0.3)),
    "time_offset": _forms("video_first log_first", ("offset", "s", 0.005, 0.8)),
    "keypoint_bias": _forms("core_along core_across head_across", ("shift", "m", 0.0008, 0.04),
        signed=True),
}  # fmt: skip

UNLISTED: tuple[tuple[Form, tuple[str, ...], str], ...] = (
    (
        Form(1, "magnet sin(theta - t0)", ("moment", "N m", 5e-5, 0.02), (_DIRECTION_RANGE,)),
        ("yaw",),
        "heading_rad",
    ),
    (
        Form(2, "sin(3 theta + t0)", ("moment", "N m", 5e-5, 0.02), (_DIRECTION_RANGE,)),
        ("yaw",),
        "heading_rad",
    ),
    (
        Form(
            3,
            "spring to a point",
            ("stiffness", "N/m", 0.001, 0.15),
            (("x", "m", 0.9, 1.7), ("y", "m", 0.5, 1.1)),
        ),
        ("surge", "sway"),
        "position_m",
    ),
    (
        Form(4, "saddle potential", ("stiffness", "N/m", 0.001, 0.15)),
        ("surge", "sway"),
        "position_m",
    ),
    (
        Form(5, "periodic side force", ("force", "N", 0.0005, 0.15), (("period", "s", 1.5, 3.5),)),
        ("sway",),
        "time_s",
    ),
    (
        Form(
            6,
            "drag bump in speed",
            ("force", "N", 0.0005, 0.1),
            (("centre", "m/s", 0.2, 0.38), ("width", "m/s", 0.03, 0.06)),
        ),
        ("surge",),
        "speed_m_s",
    ),
    (
        Form(7, "side force cos(2 theta + t0)", ("force", "N", 0.0005, 0.15), (_DIRECTION_RANGE,)),
        ("sway",),
        "heading_rad",
    ),
    (
        Form(
            8,
            "moment pulses in time",
            ("moment", "N m", 5e-5, 0.03),
            (("period", "s", 2.0, 3.0), ("width", "s", 0.15, 0.3)),
        ),
        ("yaw",),
        "time_s",
    ),
    (
        Form(
            9,
            "moment with position",
            ("moment", "N m", 5e-5, 0.03),
            (("wave_length", "m", 0.9, 1.4),),
        ),
        ("yaw",),
        "position_m",
    ),
)


def draw_effect(rng: np.random.Generator, name: str, form: Form) -> Effect:
    """Effect with shape drawn uniformly and strength at the geometric middle of its bounds."""
    low, high = form.strength[2:]
    sign = -1.0 if form.signed and rng.random() < 0.5 else 1.0
    shape = tuple(float(rng.uniform(s[2], s[3])) for s in form.shape)
    return Effect(name, form, sign * float(np.sqrt(low * high)), shape)


def effect_table(effects: tuple[Effect, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Form codes (effects,) and strengths (effects, 6) for the compiled loads."""
    k, p = np.zeros(len(EFFECT_ROW), np.int64), np.zeros((len(EFFECT_ROW), 6))
    for e in effects:
        if e.name in EFFECT_ROW:
            k[EFFECT_ROW[e.name]] = e.form.code
            p[EFFECT_ROW[e.name], 0] = e.strength
            p[EFFECT_ROW[e.name], 1 : 1 + len(e.shape)] = e.shape
    return k, p


def head_angle(effects: dict[str, Effect], t: np.ndarray, command: float) -> np.ndarray:
    """Head angle (rad) at ``t`` (s): the command after offset (gain, backlash) and servo lag."""
    phi = command
    if (e := effects.get("head_angle_offset")) is not None:
        side = np.sign(command) if command else 0.0
        phi += e.strength * (1.0, command / 0.5, side)[e.form.code - 1]
    if (e := effects.get("servo_lag")) is None:
        return np.full(len(t), phi)
    lag = e.strength
    if e.form.code == 1:
        return phi * (1 - np.exp(-t / lag))
    if e.form.code == 2:
        return np.clip(t / (2 * lag), 0, abs(phi)) * np.sign(phi)
    if e.form.code == 3:
        x = 2 * t / lag
        return phi * (1 - np.exp(-x) * (1 + x))
    return np.clip((t - 0.6 * lag) / lag, 0, abs(phi)) * np.sign(phi)


def frequency(effects: dict[str, Effect], t: np.ndarray, f: float) -> np.ndarray:
    """Flapping frequency (Hz) at ``t`` (s) after spin-up, sag and a late motor start.

    Spin-up: first-order DC motor, ramp, raised cosine (soft starter). Sag: RC cell (Chen &
    Rincon-Mora 2006), linear discharge, Warburg sqrt(t), discharge growing with load (Peukert).
    """
    gain = np.ones(len(t))
    if (e := effects.get("motor_spin_up")) is not None:
        x = t / e.strength
        ramp = 0.5 - 0.5 * np.cos(np.pi * np.clip(x / 3, 0, 1))
        gain = (1 - np.exp(-x), np.clip(x / 2, 0, 1), ramp)[e.form.code - 1]
    if (e := effects.get("battery_sag")) is not None:
        T = e.shape[0]
        rc = (1 - np.exp(-t / T)) / (1 - np.exp(-5 / T))
        course = (rc, t / 5, np.sqrt(t / 5), t / 5 * (f / 5) ** 1.2)[e.form.code - 1]
        gain = gain * np.maximum(1 - e.strength * course, 0.4)
    if (e := effects.get("time_offset")) is not None:
        gain = gain * (t >= e.strength)
    return f * gain


def keypoint_depth(effects: dict[str, Effect], t: np.ndarray, f: float, still: float) -> np.ndarray:
    """Depth (m) of the keypoints: ``still`` plus steady, settling or speed-driven sinking."""
    e = effects.get("sinking")
    if e is None:
        return np.full(len(t), still)
    settle = (1 - np.exp(-t / 2)) / (1 - np.exp(-2.5))
    course = (t / 5, settle, t / 5 * (f / 5) ** 2)[e.form.code - 1]
    return np.minimum(still + e.strength * course, 0.26)


def step_times(n: int) -> np.ndarray:
    """Times (s) of ``n + 1`` steps."""
    return STEP_S * np.arange(n + 1)
