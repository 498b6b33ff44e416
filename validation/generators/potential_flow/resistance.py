"""Laws of resistance of the whole body: force (complex, head's axes, N) and moment (N m)."""

from __future__ import annotations

import numpy as np

from .craft import RHO

KINEMATIC_VISCOSITY = 1.0e-6
"""Kinematic viscosity of water, m^2/s."""
GRAVITY = 9.81


def _opposing_force(s, size):
    """Force of the given size (N) against the velocity through the water."""
    return -size * s.v / (s.V + 1e-9), 0.0


def yaw_damping_stokes(s, k, _):
    """N = -k r (viscous friction in yaw, k in N m s)."""
    return 0.0, -k * s.r


def yaw_damping_boundary_layer(s, k, _):
    """N = -k r |r|^0.5: laminar boundary layer of a turning plate (k in N m s^1.5)."""
    return 0.0, -k * s.r * np.sqrt(np.abs(s.r))


def yaw_damping_with_speed(s, k, _):
    """N = -k V r, linear yaw damping of a ship under way (Fossen 2011, N_r)."""
    return 0.0, -k * s.V * s.r


def viscous_stokes(s, k, _):
    """R = k V (k in N s/m)."""
    return _opposing_force(s, k * s.V)


def viscous_blasius(s, k, _):
    """R = k V^1.5: laminar plate, C_f = 1.328 / sqrt(Re)."""
    return _opposing_force(s, k * s.V**1.5)


def viscous_prandtl(s, k, _):
    """R = k V^1.8: turbulent plate, C_f = 0.074 / Re^(1/5)."""
    return _opposing_force(s, k * s.V**1.8)


def viscous_ittc(s, k, _):
    """R = k rho/2 S V^2 0.075 / (log10 Re - 2)^2 (ITTC 1957), k a multiple of the hull's side."""
    Re = np.maximum(s.V * s.craft.body_length / KINEMATIC_VISCOSITY, 2e3)
    S = 2 * s.craft.span * s.craft.body_length
    return _opposing_force(s, k * RHO / 2 * S * s.V**2 * 0.075 / (np.log10(Re) - 2) ** 2)


def wave_quartic(s, k, _):
    """R = k V^4 (k in N s^4/m^4)."""
    return _opposing_force(s, k * s.V**4)


def wave_sixth(s, k, _):
    """R = k V^6."""
    return _opposing_force(s, k * s.V**6)


def wave_havelock(s, k, _):
    """R = k 4 pi^2 rho g a^4 (g/V^2)^2 e^(-2 g d / V^2): submerged cylinder (Lamb, section 247).

    Radius a of a fifth of the span, k its length (m), depth d of the keypoints.
    """
    kappa = GRAVITY / (s.V**2 + 1e-4)
    size = 4 * np.pi**2 * RHO * GRAVITY * (s.craft.span / 5) ** 4
    return _opposing_force(s, k * size * kappa**2 * np.exp(-2 * kappa * s.craft.depth))


def wave_onset(s, k, p):
    """R = k (V - V_0)^2 above V_0."""
    return _opposing_force(s, k * np.maximum(s.V - p["V_0"], 0) ** 2)


def coulomb_sign(s, k, _):
    """R = k at any speed above about 1 cm/s (N)."""
    return _opposing_force(s, k * s.V / np.sqrt(s.V**2 + 0.006**2))


def coulomb_tanh(s, k, p):
    """R = k tanh(V/V_0)."""
    return _opposing_force(s, k * np.tanh(s.V / p["V_0"]))


def coulomb_stribeck(s, k, p):
    """R = k (1 + e^(-(V/V_s)^2)) tanh(V/2 cm/s) (Stribeck)."""
    return _opposing_force(s, k * (1 + np.exp(-((s.V / p["V_s"]) ** 2))) * np.tanh(s.V / 0.02))


def coulomb_saturating(s, k, p):
    """R = k V/(V + V_0)."""
    return _opposing_force(s, k * s.V / (s.V + p["V_0"]))


def trim_square(s, k, _):
    """N = k V^2 (N s^2/m)."""
    return 0.0, k * s.V**2


def trim_forward(s, k, _):
    """N = k u |u|."""
    return 0.0, k * s.u * np.abs(s.u)


def trim_thrust(s, k, _):
    """N = k T: thrust besides the centre line by k (m) at any head angle."""
    return 0.0, k * s.thrust


def trim_motor(s, k, _):
    """N = k f: torque of the motor's rotor (N m s)."""
    return 0.0, k * s.flap


def thrust_line_sine(s, k, _):
    """N = T k sin phi (k in m): thrust misses the centre of mass when the head is turned."""
    return 0.0, s.thrust * k * np.sin(s.phi)


def thrust_line_linear(s, k, _):
    """N = T k phi."""
    return 0.0, s.thrust * k * s.phi


def thrust_line_double_angle(s, k, _):
    """N = T k sin 2 phi."""
    return 0.0, s.thrust * k * np.sin(2 * s.phi)
