"""Table of the hidden effects: cause, functional form, strength and side parameters.

A row says which entry of P selects the form and which carries the strength, the plausible range of
the strength (SI) and the ranges of side parameters. Formulas and sources stand beside the compiled
forces in `dynamics` and `water`, and beside the series in `actuators` and `camera`.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.parameters import INDEX, UNITS

Ranges = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Form:
    """One functional form of one cause; `low` and `high` bound the strength."""

    cause: str
    form: str
    switch: str
    code: int
    strength: str
    low: float
    high: float
    sides: Ranges = field(default_factory=dict)
    signed: bool = False
    kind: str = "physics"
    channels: tuple[str, ...] = ()
    variable: str = ""

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Return the side parameters of one study, and the sign of the strength under `sign`."""
        sides = {name: float(rng.uniform(*bounds)) for name, bounds in self.sides.items()}
        return sides | {"sign": float(rng.choice((-1.0, 1.0))) if self.signed else 1.0}

    def put(self, P: NDArray[np.float64], s: float, sides: dict[str, float]) -> None:
        """Write strength `s` and the side parameters into `P`."""
        P[INDEX[self.switch]] = self.code
        P[INDEX[self.strength]] = s * sides["sign"]
        for name, value in sides.items():
            if name != "sign":
                P[INDEX[name]] = value

    def without(self, P: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a copy of `P` with this effect switched off."""
        off = P.copy()
        off[INDEX[self.strength]] = 0.0
        if self.switch == "U_FORM":
            off[INDEX[self.switch]] = 0.0
        return off

    def stated(self, s: float, sides: dict[str, float]) -> dict[str, dict[str, object]]:
        """Return strength and sides as the truth file states them."""
        values = {self.strength: s * sides["sign"]} | {
            k: v for k, v in sides.items() if k != "sign"
        }
        return {k.lower(): {"value": v, "unit": UNITS[k]} for k, v in values.items()}


ANGLE_RANGE = (-math.pi, math.pi)


def _form_rows(
    cause: str, switch: str, strength: str, span: tuple[float, float], *forms: str, **more: object
) -> list[Form]:
    """Return one row a form, coded 1, 2, ... in the order given."""
    return [
        Form(cause, form, switch, k + 1, strength, *span, **more)  # type: ignore[arg-type]
        for k, form in enumerate(forms)
    ]


FINS = _form_rows("tail_fin_lift", "FIN_FORM", "FIN_AREA", (3e-4, 2.5e-2),
             "whicker_fehlner", "polhamus", "lighthill", "hoerner",
             sides={"FIN_ASPECT": (0.7, 1.8), "FIN_VORTEX": (0.7, 1.0)})  # fmt: skip
_STALL_RANGES = {"STALL_A": (math.radians(12), math.radians(24)),
          "STALL_W": (math.radians(6), math.radians(14))}  # fmt: skip
_GYRE_RANGES = {"GYRE_X": (1.1, 1.5), "GYRE_Y": (0.7, 0.9), "GYRE_R": (0.3, 0.6)}
_WAKE_RANGES = {"WAKE_W": (0.06, 0.12), "WAKE_TAU": (4.0, 12.0)}
PHYSICS = [
    *_form_rows(
        "added_mass", "AM_FORM", "AM_SHARE", (0.02, 1.6), "elliptic_sections", "lamb_spheroid"
    ),
    *_form_rows(
        "viscous_drag", "VISC_FORM", "VISC", (0.003, 0.9), "linear", "blasius", "ittc57", "prandtl"
    ),
    *_form_rows(
        "linear_yaw_damping", "YAW_FORM", "YAW_LIN", (2e-4, 0.08), "linear", "stokes_layer"
    ),
    *_form_rows(
        "thrust_loss_with_speed",
        "LOSS_FORM",
        "LOSS",
        (0.01, 0.8),
        "advance_linear",
        "advance_quadratic",
        "bollard_linear",
        "momentum",
        sides={"LOSS_V": (0.6, 1.2)},
    ),
    *_form_rows(
        "uniform_current",
        "CUR_FORM",
        "CUR",
        (5e-4, 0.1),
        "steady",
        "dying_over_session",
        sides={"CUR_DIR": ANGLE_RANGE},
    ),
    *_form_rows(
        "pool_gyre",
        "GYRE_FORM",
        "GYRE",
        (5e-4, 0.1),
        "rankine",
        "basin_mode",
        "lamb_oseen",
        sides=_GYRE_RANGES,
        signed=True,
    ),
    *_form_rows(
        "wall_effect",
        "WALL_FORM",
        "WALL",
        (0.01, 6.0),
        "cushion",
        "suction",
        "drag_rise",
        sides={"WALL_D": (0.1, 0.25)},
    ),
    *_form_rows(
        "stall",
        "STALL_FORM",
        "STALL",
        (0.05, 1.0),
        "linear_loss",
        "sigmoid",
        "kirchhoff",
        "viterna",
        sides=_STALL_RANGES,
    ),
    *_form_rows(
        "servo_lag",
        "SERVO_FORM",
        "SERVO",
        (0.03, 2.0),
        "first_order",
        "rate_limited",
        "second_order",
        "dead_time",
    ),
    *_form_rows("motor_spin_up", "SPIN_FORM", "SPIN", (0.03, 2.0), "first_order", "ramp", "tanh"),
    *_form_rows(
        "battery_sag",
        "SAG_FORM",
        "SAG",
        (0.005, 0.35),
        "linear",
        "exponential",
        "square_root",
        "drop_and_recovery",
        sides={"SAG_TAU": (1.0, 3.0)},
    ),
    *_form_rows(
        "trim_moment",
        "TRIM_FORM",
        "TRIM",
        (5e-5, 0.03),
        "constant",
        "speed_squared",
        "with_thrust",
        signed=True,
    ),
    *_form_rows(
        "head_angle_offset", "OFF_FORM", "OFF", (2e-3, 0.15), "constant", "backlash", signed=True
    ),
    *_form_rows(
        "crossflow_drag",
        "CROSS_FORM",
        "CROSS_CD",
        (0.02, 4.0),
        "hoerner",
        "jorgensen",
        "faltinsen",
        "taylor",
    ),
    *_form_rows(
        "thrust_line_offset", "LINE_FORM", "LINE", (5e-4, 0.06), "head_mass", "linear", signed=True
    ),
    *_form_rows("thrust_area", "TAREA_FORM", "TAREA", (0.02, 1.0), "power", "blend"),
    *_form_rows("lift_lag", "LAG_FORM", "LAG", (0.01, 1.0), "first_order", "wagner_jones"),
    *_form_rows(
        "wave_drag",
        "WAVE_FORM",
        "WAVE",
        (0.003, 0.6),
        "fourth_power",
        "havelock",
        "hump",
        sides={"WAVE_V": (0.4, 0.6)},
    ),
    *_form_rows(
        "coulomb_friction",
        "COUL_FORM",
        "COUL",
        (5e-4, 0.15),
        "tanh",
        "stribeck",
        sides={"COUL_V": (0.08, 0.2)},
    ),
    *_form_rows(
        "wake_reentry",
        "WAKE_FORM",
        "WAKE",
        (0.002, 0.3),
        "jet",
        "spreading_jet",
        "far_wake",
        "top_hat",
        sides=_WAKE_RANGES,
    ),
    *_form_rows("sinking", "SINK_FORM", "SINK", (5e-4, 0.06), "constant_rate", "settling"),
    *_form_rows(
        "centre_of_mass_shift",
        "COM_FORM",
        "COM_SHIFT",
        (5e-4, 0.05),
        "lengthwise",
        "sideways",
        signed=True,
    ),
    *_form_rows(
        "port_starboard_asymmetry",
        "ASYM_FORM",
        "ASYM",
        (0.01, 0.6),
        "lift",
        "drag",
        "moment",
        signed=True,
    ),
]
MEASUREMENT = [
    Form(
        "scale_error",
        "isotropic",
        "SCALE_FORM",
        1,
        "SCALE",
        0.01,
        0.15,
        signed=True,
        kind="measurement",
    ),
    # a wrong length alone shows in the corners' reprojection: `bluekoi check` refuses about 8 %
    Form(
        "scale_error",
        "length_only",
        "SCALE_FORM",
        2,
        "SCALE",
        0.01,
        0.065,
        signed=True,
        kind="measurement",
    ),
    *_form_rows(
        "clock_error",
        "CLOCK_FORM",
        "CLOCK",
        (0.01, 0.15),
        "wrong_rate",
        "dropped_frames",
        signed=True,
        kind="measurement",
    ),
    *_form_rows(
        "camera_shift",
        "SHIFT_FORM",
        "SHIFT",
        (5e-4, 0.08),
        "step",
        "drift",
        sides={"SHIFT_B": (-0.03, 0.03)},
        signed=True,
        kind="measurement",
    ),
    *_form_rows(
        "uncorrected_refraction",
        "REFR_FORM",
        "REFR",
        (0.1, 1.0),
        "index",
        "depth",
        kind="measurement",
    ),
    *_form_rows(
        "lens_error",
        "LENS_FORM",
        "LENS",
        (0.005, 0.3),
        "radial",
        "principal_point",
        signed=True,
        kind="measurement",
    ),
    *_form_rows(
        "time_offset",
        "TIME_FORM",
        "TIME",
        (0.03, 1.5),
        "log_at_motor_start",
        "lead_in_shifted",
        kind="measurement",
    ),
    *_form_rows(
        "keypoint_bias",
        "BIAS_FORM",
        "BIAS",
        (0.002, 0.04),
        "core_lengthwise",
        "core_sideways",
        "hinge_sideways",
        signed=True,
        kind="measurement",
    ),
]


def _unlisted(code: int, form: str, moment: bool, sides: Ranges, *where: str) -> Form:
    """Return an unlisted force; `where` is channel and variable."""
    strength, high = ("U_MOMENT", 0.05) if moment else ("U_FORCE", 0.4)
    return Form("unlisted", form, "U_FORM", code, strength, high / 2000, high, sides,
                signed=form != "tether beyond a slack length", kind="unlisted",
                channels=tuple(where[0].split()), variable=where[1])  # fmt: skip


_PHASE_RANGES = {"U_A": ANGLE_RANGE}
_WAVE_RANGES = _PHASE_RANGES | {"U_B": (0.8, 1.6)}
_PERIOD_RANGES = _PHASE_RANGES | {"U_B": (1.5, 3.0)}
_SPEED_PEAK_RANGES = {"U_A": (0.25, 0.42), "U_B": (0.04, 0.09)}
UNLISTED = [
    _unlisted(1, "sin(3 theta + a)", True, _PHASE_RANGES, "yaw", "heading_rad"),
    _unlisted(2, "cos(2 theta + a)", False, _PHASE_RANGES, "surge", "heading_rad"),
    _unlisted(3, "sin(2 pi x/b + a)", False, _WAVE_RANGES, "sway", "x_m"),
    _unlisted(4, "sin(2 pi t/b + a)", True, _PERIOD_RANGES, "yaw", "time_s"),
    _unlisted(5, "sin(2 pi t/b + a)", False, _PERIOD_RANGES, "surge", "time_s"),
    _unlisted(6, "exp(-((V - a)/b)^2)", True, _SPEED_PEAK_RANGES, "yaw", "speed_m_s"),
    _unlisted(7, "-exp(-((V - a)/b)^2)", False, _SPEED_PEAK_RANGES, "surge", "speed_m_s"),
    _unlisted(8, "tether beyond a slack length", False, {"U_A": (0.2, 0.5)}, "surge sway", "x_m"),
    _unlisted(9, "cos(2 pi y/b + a)", True, _WAVE_RANGES, "yaw", "y_m"),
    _unlisted(10, "sin(theta + a)", False, _PHASE_RANGES, "sway", "heading_rad"),
]


def forms_of(cause: str) -> list[Form]:
    """Return all forms of `cause`."""
    return [row for row in (*FINS, *PHYSICS, *MEASUREMENT) if row.cause == cause]


PHYSICS_CAUSES = tuple(dict.fromkeys(row.cause for row in PHYSICS))
MEASUREMENT_CAUSES = tuple(dict.fromkeys(row.cause for row in MEASUREMENT))
