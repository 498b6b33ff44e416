"""The hidden causes: registry of functional forms, and how a form changes a trial's inputs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.quasi_steady import laws
from validation.generators.quasi_steady.dynamics import STEP_S, Robot


@dataclass(frozen=True)
class Form:
    """One functional form of a cause; the strength is solved between `low` and `high`."""

    cause: str
    name: str
    code: int
    variant: int
    strength: tuple[str, str]  # name and unit
    start: float
    low: float
    high: float
    a: tuple[str, str, float, float] = ("", "", 0.0, 0.0)  # name, unit, range
    b: tuple[str, str, float, float] = ("", "", 0.0, 0.0)
    signed: bool = False
    kind: str = "physics"


@dataclass(frozen=True)
class Effect:
    """A form with its constants; `k` is the strength in the form's unit."""

    form: Form
    k: float
    a: float
    b: float

    def row(self) -> tuple[float, ...]:
        """Row of the compiled table: cause, variant, k, a, b."""
        return self.form.code, self.form.variant, self.k, self.a, self.b


def _forms(cause: str, code: int, strength: tuple, limits: tuple, names: Sequence, **rest) -> list:
    """Variants of a cause; a name may be (name, overrides)."""
    out = []
    for variant, item in enumerate(names):
        name, own = (item, {}) if isinstance(item, str) else item
        given = {"strength": strength, "limits": limits, **rest, **own}
        start, low, high = given.pop("limits")
        out.append(
            Form(cause, name, code, variant, given.pop("strength"), start, low, high, **given)
        )
    return out


ARM_RANGE = ("centre", "caudal base distance", 0.75, 1.05)
ASPECT_RATIO_RANGE = ("aspect_ratio", "1", 0.9, 1.6)
STALL_RANGES = {"a": ("angle_rad", "rad", 0.06, 0.14), "b": ("width_rad", "rad", 0.015, 0.03)}
PHASE_RANGE = ("phase_rad", "rad", 0.0, 2 * np.pi)
COEFF, METRE, SPEED = ("k", "1"), ("k_m", "m"), ("speed_m_s", "m/s")
TIME_UNIT = ("time_s", "s")
LENGTH_RANGE = ("length_m", "m", 0.1, 0.1)
NEWTON, NEWTON_METRE = ("force_n", "N"), ("moment_n_m", "N m")

FORMS: list[Form] = [
    *_forms(
        "tail_fin_lift",
        laws.FIN,
        ("area_m2", "m2"),
        (0.006, 1e-4, 0.08),
        [
            ("polhamus", {"b": ("potential_lift", "1", 1.4, 2.2)}),
            ("jones_slender", {"b": ASPECT_RATIO_RANGE}),
            ("helmbold_stall", {"b": ASPECT_RATIO_RANGE}),
            ("flat_plate", {"b": ("slope", "1", 1.6, 3.0)}),
        ],
        a=ARM_RANGE,
    ),
    *_forms(
        "viscous_drag",
        laws.VISCOUS,
        ("k_n_s_m", "N s/m"),
        (0.06, 1e-4, 0.8),
        [
            "stokes",
            ("blasius", {"strength": ("k", "N (s/m)^1.5")}),
            ("axial_linear", {"b": ("across_ratio", "1", 1.0, 4.0)}),
            ("ittc_1957", {"strength": ("wetted_area_m2", "m2"), "limits": (0.1, 1e-3, 0.8)}),
        ],
    ),
    *_forms(
        "linear_yaw_damping",
        laws.YAW_LINEAR,
        ("N_r", "N m s"),
        (0.006, 1e-4, 0.08),
        ["linear", ("levelling_off", {"a": ("rate_rad_s", "rad/s", 0.8, 1.6)})],
    ),
    *_forms(
        "thrust_loss_with_speed",
        laws.THRUST_LOSS,
        COEFF,
        (0.2, 0.005, 0.6),
        [
            "advance_linear",
            ("advance_square", {"strength": ("k", "1")}),
            ("speed_linear", {"strength": ("k_s_m", "s/m"), "limits": (0.4, 0.01, 1.6)}),
            ("speed_exponential", {"strength": ("k_s_m", "s/m"), "limits": (0.4, 0.01, 2.5)}),
        ],
        b=LENGTH_RANGE,
    ),
    *_forms(
        "wall_effect",
        laws.WALL,
        COEFF,
        (0.5, 0.01, 30.0),
        [
            ("image_suction", {"b": ("moment_arm_m", "m", 0.01, 0.04)}),
            ("blockage", {"limits": (0.5, 0.01, 4.0), "a": ("range_m", "m", 0.12, 0.25)}),
        ],
    ),
    *_forms(
        "stall",
        laws.STALL,
        ("lost_share", "1"),
        (0.3, 0.01, 0.95),
        ["logistic", "kirchhoff", ("viterna_cap", {"limits": (0.5, 0.01, 1.0)}), "linear_fall"],
        **STALL_RANGES,
    ),
    *_forms(
        "trim_moment",
        laws.TRIM,
        METRE,
        (2e-3, 2e-5, 0.05),
        ["with_speed_squared", "with_thrust"],
        signed=True,
    ),
    *_forms(
        "crossflow_drag",
        laws.CROSSFLOW,
        ("C_d", "1"),
        (0.8, 0.01, 6.0),
        ["strips", "tapered", "lumped", "coupled"],
        b=("height_m", "m", 0.05, 0.075),
    ),
    *_forms(
        "thrust_line_offset",
        laws.THRUST_LINE,
        METRE,
        (5e-3, 1e-4, 0.06),
        ["sine", ("one_minus_cosine", {"limits": (0.01, 1e-4, 0.15)})],
        signed=True,
    ),
    *_forms("thrust_area", laws.THRUST_AREA, ("share", "1"), (0.6, 0.02, 1.2), ["power", "mix"]),
    *_forms(
        "lift_lag",
        laws.LIFT_LAG,
        ("chords", "1"),
        (1.0, 0.02, 8.0),
        [
            ("wagner_half", {"a": ("lagged_share", "1", 0.5, 0.6)}),
            (
                "constant_time",
                {
                    "strength": TIME_UNIT,
                    "limits": (0.2, 0.01, 1.2),
                    "a": ("lagged_share", "1", 0.9, 1.0),
                },
            ),
        ],
    ),
    *_forms(
        "wave_drag",
        laws.WAVE,
        ("k", "N (s/m)^4"),
        (0.4, 0.005, 8.0),
        [
            "fourth_power",
            (
                "froude_hump",
                {
                    "strength": ("C_w", "1"),
                    "limits": (0.2, 0.005, 2.5),
                    "a": ("froude", "1", 0.22, 0.28),
                    "b": ("width", "1", 0.02, 0.04),
                },
            ),
        ],
    ),
    *_forms(
        "coulomb_friction",
        laws.COULOMB,
        NEWTON,
        (0.01, 1e-4, 0.07),
        ["coulomb", ("stribeck", {"a": ("speed_m_s", "m/s", 0.08, 0.15)})],
    ),
    *_forms(
        "sinking",
        laws.SINKING,
        ("rate_m_s", "m/s"),
        (0.006, 2e-4, 0.035),
        ["steady", "accelerating", "levelling_off"],
    ),
    *_forms(
        "port_starboard_asymmetry",
        laws.ASYMMETRY,
        ("share", "1"),
        (0.1, 0.002, 0.7),
        ["lift", "yaw_damping"],
        signed=True,
    ),
    *_forms(
        "uniform_current",
        laws.CURRENT,
        SPEED,
        (0.01, 2e-4, 0.08),
        ["constant", ("decaying", {"b": ("decay_s", "s", 4.0, 10.0)})],
        a=("direction_rad", "rad", 0.0, 2 * np.pi),
    ),
    *_forms(
        "pool_gyre",
        laws.GYRE,
        SPEED,
        (0.015, 2e-4, 0.1),
        ["single_cell", "lamb_oseen"],
        a=("core_radius_m", "m", 0.3, 0.5),
        signed=True,
    ),
    *_forms(
        "wake_reentry",
        laws.WAKE,
        SPEED,
        (0.08, 1e-3, 0.6),
        ["thrust_jet", "drag_wake", "uniform_jet", "vortex_street"],
        a=("half_width_m", "m", 0.1, 0.18),
    ),
    *_forms(
        "servo_lag",
        laws.NO_FORCE,
        TIME_UNIT,
        (0.2, 0.005, 1.5),
        ["first_order", "slew", "second_order", "delayed"],
    ),
    *_forms(
        "motor_spin_up",
        laws.NO_FORCE,
        TIME_UNIT,
        (0.2, 0.005, 1.5),
        ["first_order", "ramp", "smooth_step"],
    ),
    *_forms(
        "battery_sag",
        laws.NO_FORCE,
        ("loss_per_s", "1/s"),
        (0.01, 2e-4, 0.06),
        ["linear", "exponential", "square_root", "with_power"],
    ),
    *_forms(
        "head_angle_offset",
        laws.NO_FORCE,
        ("offset_deg", "deg"),
        (1.0, 0.02, 10.0),
        [
            "constant",
            ("gain", {"strength": ("gain_error", "1"), "limits": (0.04, 1e-3, 0.3)}),
            "backlash",
        ],
        signed=True,
    ),
    *_forms(
        "added_mass",
        laws.NO_FORCE,
        ("sway_share_of_mass", "1"),
        (0.3, 0.01, 1.5),
        [("lamb_ellipsoid", {"a": ("slenderness", "1", 4.0, 6.0)}), "sway_only"],
    ),
    *_forms(
        "centre_of_mass_shift",
        laws.NO_FORCE,
        METRE,
        (5e-3, 1e-4, 0.04),
        ["aft", "sideways"],
        signed=True,
    ),
    *_forms(
        "unlisted",
        laws.UNLISTED,
        NEWTON_METRE,
        (2e-3, 2e-5, 0.03),
        [
            "sin 3 theta",
            "compass needle",
            ("moment along x", {"b": ("wavelength_m", "m", 0.8, 1.4)}),
            ("moment in time", {"b": ("period_s", "s", 1.5, 3.0)}),
            (
                "surge in time",
                {
                    "strength": NEWTON,
                    "limits": (0.02, 2e-4, 0.15),
                    "b": ("period_s", "s", 1.5, 3.0),
                },
            ),
            (
                "drag band",
                {
                    "strength": NEWTON,
                    "limits": (0.03, 2e-4, 0.2),
                    "b": ("speed_m_s", "m/s", 0.2, 0.4),
                },
            ),
            ("tether", {"strength": ("k_n_m", "N/m"), "limits": (0.03, 2e-4, 0.25)}),
            ("sway sin 2 theta", {"strength": NEWTON, "limits": (0.02, 2e-4, 0.2)}),
            ("moment in a speed band", {"b": ("speed_m_s", "m/s", 0.2, 0.4)}),
        ],
        a=PHASE_RANGE,
        signed=True,
    ),
    *_forms(
        "scale_error",
        laws.NO_FORCE,
        ("share", "1"),
        (0.05, 1e-3, 0.2),
        ["both_sides", "long_side"],
        signed=True,
        kind="measurement",
    ),
    *_forms(
        "clock_error",
        laws.NO_FORCE,
        ("share", "1"),
        (0.02, 1e-3, 0.2),
        ["rate", "lost_frames"],
        kind="measurement",
    ),
    *_forms(
        "camera_shift",
        laws.NO_FORCE,
        ("angle_deg", "deg"),
        (0.2, 1e-3, 3.0),
        ["step", "drift"],
        a=("axis_rad", "rad", 0.0, 6.28),
        b=("share_of_trial", "1", 0.4, 0.7),
        kind="measurement",
    ),
    *_forms(
        "uncorrected_refraction",
        laws.NO_FORCE,
        ("depth_beyond_stated_m", "m"),
        (0.1, 1e-3, 0.22),
        [
            "depth",
            ("index", {"strength": ("index_beyond_stated", "1"), "limits": (0.25, 0.01, 0.333)}),
        ],
        kind="measurement",
    ),
    *_forms(
        "lens_error",
        laws.NO_FORCE,
        ("k1_error", "1"),
        (0.03, 1e-3, 0.3),
        [
            "radial",
            ("principal_point", {"strength": ("offset_px", "px"), "limits": (40.0, 1.0, 200.0)}),
        ],
        signed=True,
        kind="measurement",
    ),
    *_forms(
        "time_offset",
        laws.NO_FORCE,
        TIME_UNIT,
        (0.2, 0.005, 1.2),
        ["constant", "scattered"],
        kind="measurement",
    ),
    *_forms(
        "keypoint_bias",
        laws.NO_FORCE,
        METRE,
        (8e-3, 2e-4, 0.04),
        ["aft", "sideways"],
        signed=True,
        kind="measurement",
    ),
]
CAUSES = {c: [f for f in FORMS if f.cause == c] for c in dict.fromkeys(f.cause for f in FORMS)}
PHYSICS = [
    c
    for c, f in CAUSES.items()
    if f[0].kind == "physics" and c not in ("tail_fin_lift", "unlisted")
]
MEASUREMENTS = [c for c, f in CAUSES.items() if f[0].kind == "measurement"]


def draw_effect(form: Form, rng: np.random.Generator) -> Effect:
    """Effect at half to twice the form's starting strength, random sign and constants."""
    sign = rng.choice([-1.0, 1.0]) if form.signed else 1.0
    a, b = (rng.uniform(c[2], c[3]) for c in (form.a, form.b))
    size = min(form.start * float(np.exp(rng.uniform(-0.7, 0.7))), form.high)
    return Effect(form, sign * size, a, b)


def with_strength(effect: Effect, size: float) -> Effect:
    """The effect at |k| = size within the form's limits, sign kept."""
    return replace(effect, k=np.sign(effect.k) * np.clip(size, effect.form.low, effect.form.high))


def effect_table(effects: Sequence[Effect]) -> np.ndarray:
    """Rows of the compiled laws, shape (effects, 5)."""
    return np.array([e.row() for e in effects], float).reshape(-1, 5)


def parameters_json(effect: Effect) -> dict[str, dict]:
    """Name, value and unit of the strength and of the constants."""
    f = effect.form
    items = [(*f.strength, effect.k), (*f.a[:2], effect.a), (*f.b[:2], effect.b)]
    return {n: {"value": float(x), "unit": u} for n, u, x in items if n}


def robot_with_effects(robot: Robot, effects: Sequence[Effect]) -> Robot:
    """Robot with added mass (Lamb 1932, 114; Fossen 2011, 6.3) and the true centre of mass."""
    for e in effects:
        if e.form.cause == "added_mass":
            sway, slender = e.k * robot.mass, e.a
            reach = robot.hinge + robot.base
            yaw = sway * reach**2 / 12
            surge = sway / slender**1.5 if e.form.variant == 0 else 0.0
            robot = robot._replace(added_surge=surge, added_sway=sway, added_yaw=yaw)
        if e.form.cause == "centre_of_mass_shift":
            key = "shift_aft" if e.form.variant == 0 else "shift_left"
            robot = robot._replace(**{key: e.k})
    return robot


def _servo_lag(variant: int, k: float, t: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Head angle on its way from zero: first order, slew (45 deg in k s), second order, delay."""
    final = phi[-1]
    if variant == 1:
        return np.sign(final) * np.minimum(np.abs(phi), np.pi / 4 * t / (2 * k))
    s = t / k if variant != 3 else np.maximum(t - 0.7 * k, 0) / (0.5 * k)
    return phi * (1 - np.exp(-s)) if variant != 2 else phi * (1 - (1 + 2 * s) * np.exp(-2 * s))


def _spin_up(variant: int, k: float, t: np.ndarray) -> np.ndarray:
    """Share of the steady frequency: exponential, ramp over 2 k, smooth step over 2.5 k."""
    if variant == 0:
        return 1 - np.exp(-t / k)
    s = np.clip(t / (2 * k if variant == 1 else 2.5 * k), 0, 1)
    return s if variant == 1 else s * s * (3 - 2 * s)


def _sag(variant: int, k: float, t: np.ndarray, power: float) -> np.ndarray:
    """Share of the frequency left: linear, exponential to 0.7, square root, rate with power."""
    if variant == 1:
        return 0.7 + 0.3 * np.exp(-k * t / 0.3)
    if variant == 2:
        return 1 - k * np.sqrt(3 * t)
    return np.maximum(1 - k * t * ((power / 75) ** 1.5 if variant == 3 else 1.0), 0.4)


def schedule_with_effects(
    schedule: np.ndarray, effects: Sequence[Effect], power: float, late: float
) -> np.ndarray:
    """Schedule (rows, 4) with lag, offset, spin-up, sag and a late motor; `late` scatters it."""
    out = schedule.copy()
    t = np.arange(len(out)) * STEP_S
    for e in effects:
        cause, variant, k = e.form.cause, e.form.variant, e.k
        if cause == "head_angle_offset":
            phi = out[0, 0]
            change = [np.radians(k), k * phi, np.radians(k) * np.sign(round(phi, 1))][variant]
            out[:, 0] += change
        if cause == "motor_spin_up":
            out[:, 1] *= _spin_up(variant, k, t)
        if cause == "battery_sag":
            out[:, 1] *= _sag(variant, k, t, power)
        if cause == "time_offset":
            out[t < k * (1.0 if variant == 0 else late), 1] = 0.0
    for e in effects:
        if e.form.cause == "servo_lag":
            out[:, 0] = _servo_lag(e.form.variant, e.k, t, out[:, 0])
    return out
