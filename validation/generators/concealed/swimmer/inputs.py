"""Inputs of the compiled laws: the body, the hidden laws' numbers, the command of one trial.

All SI and radians. A law is absent where its strength is 0. `*_law` chooses between forms that
the literature gives for the same physical statement; the functions say which.
"""

from typing import NamedTuple

import numpy as np

__all__ = ["NO_EDDIES", "BodyParameters", "HiddenLaws", "TrialCommand"]

NO_EDDIES = np.zeros((0, 7))


class BodyParameters(NamedTuple):
    """Robot, coefficients of eqs. 1 to 7, water and pool.

    `pulse`: thrust swings by this share twice a beat.
    """

    mass_kg: float
    yaw_inertia_kg_m2: float
    body_length_m: float
    head_1x_m: float
    head_span_m: float
    hinge_to_com_m: float
    tail_length_m: float
    C_T: float
    C_D0: float
    C_Da: float
    C_La: float
    C_Ma: float
    C_Md: float
    pulse: float = 0.4
    density_kg_m3: float = 1000.0
    pool_length_m: float = 2.6
    pool_width_m: float = 1.6


class HiddenLaws(NamedTuple):
    """Numbers of every law that the published model has not; all absent by default.

    `com_shift_m`: the true centre of mass lies this far ahead of the keypoint `core_center`.
    """

    fin_m2: float = 0.0
    fin_arm_m: float = 0.15
    fin_spread_m: float = 0.0
    added_sway_kg: float = 0.0
    added_surge_share: float = 0.1
    added_yaw_share: float = 1.0
    friction: float = 0.0
    friction_power: float = 1.5
    yaw_friction: float = 0.0
    slip_per_m: float = 0.0
    slip_law: int = 0
    current_x: float = 0.0
    current_y: float = 0.0
    gyre: float = 0.0
    gyre_core_m: float = 0.5
    gyre_law: int = 0
    wall: float = 0.0
    wall_reach_m: float = 0.15
    wall_law: int = 0
    stall: float = 0.0
    stall_onset: float = 0.5
    stall_width: float = 0.15
    stall_law: int = 0
    servo_s: float = 0.0
    servo_law: int = 0
    spin_s: float = 0.0
    spin_law: int = 0
    sag_per_s: float = 0.0
    sag_law: int = 0
    trim_kg: float = 0.0
    trim_law: int = 0
    head_offset: float = 0.0
    cross: float = 0.0
    cross_law: int = 0
    thrust_arm_m: float = 0.0
    thrust_arm_law: int = 0
    thrust_area: float = 0.0
    lag: float = 0.0
    lag_lengths: float = 4.0
    lag_law: int = 0
    wave: float = 0.0
    wave_law: int = 0
    coulomb_n: float = 0.0
    coulomb_law: int = 0
    wake: float = 0.0
    wake_law: int = 0
    sink_per_s: float = 0.0
    sink_law: int = 0
    com_shift_m: float = 0.0
    side: float = 0.0
    side_law: int = 0
    tether_n_m: float = 0.0
    tether_x_m: float = 0.0
    tether_y_m: float = 0.0
    hump: float = 0.0
    hump_m_s: float = 0.4
    hump_width_m_s: float = 0.05
    seiche_m_s: float = 0.0
    seiche_period_s: float = 4.0
    jet: float = 0.0
    moment_wave_m: float = 0.0


class TrialCommand(NamedTuple):
    """One trial: what the operator sets, and the state to start from (core frame).

    By default at rest at release; `time_s` after release and `turned` (rad) by then otherwise.
    """

    flap_hz: float
    head_angle: float
    head_length_m: float
    x: float = 0.0
    y: float = 0.0
    psi: float = 0.0
    u: float = 0.0
    v: float = 0.0
    r: float = 0.0
    beat: float = 0.0
    time_s: float = 0.0
    turned: float = 0.0
