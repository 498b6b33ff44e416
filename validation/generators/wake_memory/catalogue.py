"""Named causes: forms, units, trial strength and bound of each strength."""
# A table is read by row and by place: one row a line.
# ruff: noqa: E501, PLR0917

from typing import NamedTuple


class Cause(NamedTuple):
    """A named cause; `start` and `bound` are strengths in `unit`, `shape` the range of shape 1."""

    name: str
    kind: str
    forms: tuple[str, ...]
    parameter: str
    unit: str
    start: float
    bound: float
    shape: tuple[float, float] = (0.0, 0.0)
    signed: bool = False


def _physical_cause(name: str, forms: str, parameter: str, unit: str, start: float, bound: float,
             shape: tuple[float, float] = (0.0, 0.0), *, signed: bool = False) -> Cause:  # fmt: skip
    return Cause(
        name, "physics", tuple(forms.split()), parameter, unit, start, bound, shape, signed
    )


def _measurement_cause(name: str, forms: str, parameter: str, unit: str, start: float, bound: float,
             *, signed: bool = True) -> Cause:  # fmt: skip
    return Cause(name, "measurement", tuple(forms.split()), parameter, unit, start, bound,
                 (0.0, 0.0), signed)  # fmt: skip


# fmt: off
CAUSES = (
    _physical_cause("tail_fin_lift", "helmbold polhamus lighthill wagner_jones", "area", "m2", 0.004, 0.03, (0.15, 0.2)),
    _physical_cause("added_mass", "lamb_ellipsoid lighthill_slender korotkin_head_plate", "ratio", "1", 0.3, 2.5),
    _physical_cause("viscous_drag", "stokes blasius prandtl ittc57", "drag_at_0.4", "N", 0.05, 0.6),
    _physical_cause("linear_yaw_damping", "linear laminar_1.5 saturating", "N_r", "N m s", 0.005, 0.15),
    _physical_cause("thrust_loss_with_speed", "linear_slip lighthill_slip jet_speed exponential", "loss", "1", 0.2, 1.5),
    _physical_cause("uniform_current", "steady decaying seiche", "speed", "m/s", 0.01, 0.08, (-3.1, 3.1)),
    _physical_cause("pool_gyre", "solid_body lamb_oseen cell", "speed", "m/s", 0.01, 0.1, (0.2, 0.5), signed=True),
    _physical_cause("wall_effect", "image_repulsion suction blockage_drag", "coefficient", "1", 0.2, 4.0, (0.1, 0.25)),
    _physical_cause("stall", "kirchhoff_static leishman_beddoes goman_khrabrov viterna", "share", "1", 0.3, 1.0, (0.15, 0.3)),
    _physical_cause("servo_lag", "first_order second_order rate_limit dead_time", "tau", "s", 0.1, 1.2, (0.4, 0.8)),
    _physical_cause("motor_spin_up", "first_order second_order ramp", "tau", "s", 0.1, 1.5, (0.5, 0.85)),
    _physical_cause("battery_sag", "linear shepherd_exponential peukert session_growth", "loss_6s", "1", 0.05, 0.5),
    _physical_cause("trim_moment", "constant bent_tail bent_plate", "moment", "N m", 0.001, 0.02, signed=True),
    _physical_cause("head_angle_offset", "constant gain backlash", "angle", "rad", 0.02, 0.2, signed=True),
    _physical_cause("crossflow_drag", "uniform_strips tapered_strips lumped taylor_oblique", "C_d", "1", 0.3, 4.0),
    _physical_cause("thrust_line_offset", "sine linear cosine", "lever", "m", 0.005, 0.08, signed=True),
    _physical_cause("thrust_area", "power_law blend logarithmic", "exponent", "1", 0.3, 1.5),
    _physical_cause("lift_lag", "jones_wagner sears_kuessner beddoes single_lag", "time_factor", "1", 1.0, 15.0),
    _physical_cause("wave_drag", "quartic michell threshold", "drag_at_0.4", "N", 0.04, 0.5),
    _physical_cause("coulomb_friction", "tanh stribeck tether", "force", "N", 0.02, 0.25),
    _physical_cause("wake_reentry", "gaussian_jet similarity_jet drag_wake vortex_pair", "speed", "m/s", 0.05, 0.6, (0.06, 0.14)),
    _physical_cause("sinking", "constant_rate terminal_depth squat", "depth_6s", "m", 0.05, 0.22),
    _physical_cause("centre_of_mass_shift", "longitudinal lateral payload", "shift", "m", 0.005, 0.04, signed=True),
    _physical_cause("port_starboard_asymmetry", "lift drag yaw_damping", "share", "1", 0.1, 0.6, signed=True),
    _physical_cause("unlisted", "sin_3_theta moment_sin_x standing_wave_x gust_t tether_spring film_cos_2_theta lock_in_speed",
             "amplitude", "N or N m", 0.004, 0.3, (-3.1, 3.1)),
    _measurement_cause("scale_error", "tape one_side corners", "factor", "1", 0.04, 0.15),
    _measurement_cause("clock_error", "constant session_drift", "factor", "1", 0.01, 0.05),
    _measurement_cause("camera_shift", "step drift sway", "shift", "px", 3.0, 60.0, signed=False),
    _measurement_cause("uncorrected_refraction", "index depth", "share", "1", 0.6, 1.0, signed=False),
    _measurement_cause("lens_error", "radial decentering principal_point", "edge_displacement", "px", 8.0, 120.0),
    _measurement_cause("time_offset", "constant session_drift alternating", "offset", "s", 0.05, 0.8, signed=False),
    _measurement_cause("keypoint_bias", "core_center_along core_center_across head_tip_across", "offset", "m", 0.004, 0.05),
)
# fmt: on
CAUSE_ROW = {cause.name: row for row, cause in enumerate(CAUSES)}
PHYSICS = tuple(c.name for c in CAUSES[1:24])
MEASUREMENT = tuple(c.name for c in CAUSES[25:])
UNLISTED = {
    1: (["yaw"], "heading_rad"), 2: (["yaw"], "x_m"), 3: (["surge", "sway"], "x_m"),
    4: (["surge", "sway"], "time_s"), 5: (["surge", "sway"], "position_m"),
    6: (["surge"], "heading_rad"), 7: (["yaw"], "speed_m_s"),
}  # fmt: skip
