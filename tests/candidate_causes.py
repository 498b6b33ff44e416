"""Names of the causes that a generator must be able to hide, from STUDY.md."""

PHYSICS = {
    "tail_fin_lift", "added_mass", "viscous_drag", "linear_yaw_damping", "thrust_loss_with_speed",
    "uniform_current", "pool_gyre", "wall_effect", "stall", "servo_lag", "motor_spin_up",
    "battery_sag", "trim_moment", "head_angle_offset", "crossflow_drag", "thrust_line_offset",
    "thrust_area", "lift_lag", "wave_drag", "coulomb_friction", "wake_reentry", "sinking",
    "centre_of_mass_shift", "port_starboard_asymmetry",
}  # fmt: skip
MEASUREMENT = {"scale_error", "clock_error", "camera_shift", "uncorrected_refraction",
               "lens_error", "time_offset", "keypoint_bias"}  # fmt: skip
LEFT_RIGHT_ASYMMETRIC_CAUSES = {
    "trim_moment", "port_starboard_asymmetry", "head_angle_offset", "uniform_current", "pool_gyre",
    "wall_effect", "unexplained",
}  # fmt: skip
"""Causes in whose presence a turn to the left is no mirror image of one to the right."""
