"""Resistances, moments and added mass of the body; `k` is the size of the law."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .form import HALF_DENSITY, AddedMass, HiddenLaw, Quantity, Situation


def viscous_drag(now: Situation, law: HiddenLaw) -> None:
    """Resistance k g(V / 0.3 m/s): linear, to the power 1.25, or a boundary layer.

    abraham: (2 s^1.5 + 0.3 s^2) / 2.3, a boundary layer of finite thickness (Abraham 1970).
    """
    s = now.speed / 0.3
    curve = {"linear": s, "abraham": (2 * s**1.5 + 0.3 * s**2) / 2.3, "power_1.25": s**1.25}
    now.resist(law.size * curve[law.form])


def wave_drag(now: Situation, law: HiddenLaw) -> None:
    """Wave resistance, k at 0.4 m/s.

    lamb_cylinder: V^-4 exp(-2 g d / V^2) of a submerged cylinder (Lamb 1932, art. 247).
    fifth_power: V^5. kelvin_onset: (V^2 - c^2)^1.5 above the slowest wave, c = 0.23 m/s.
    """
    v = np.maximum(now.speed, 0.05)
    if law.form == "lamb_cylinder":
        depth = 0.025 + 0.015 * law.shape[0]
        size = (0.4 / v) ** 4 * np.exp(-2 * 9.81 * depth * (1 / v**2 - 1 / 0.16))
    elif law.form == "fifth_power":
        size = (v / 0.4) ** 5
    else:
        size = (np.maximum(v**2 - 0.053, 0) / (0.16 - 0.053)) ** 1.5
    now.resist(law.size * size)


def coulomb_friction(now: Situation, law: HiddenLaw) -> None:
    """Dry friction that tends to k: arctangent, V / (V + 0.025), or with a Stribeck excess."""
    v = now.speed
    if law.form == "arctan":
        size = 2 / np.pi * np.arctan(v / 0.012)
    elif law.form == "hyperbolic":
        size = v / (v + 0.025)
    else:
        size = np.tanh(v / 0.01) * (1 + 0.7 / (1 + (v / 0.09) ** 2))
    now.resist(law.size * size)


def linear_yaw_damping(now: Situation, law: HiddenLaw) -> None:
    """Moment against the yaw rate, k at 1 rad/s: -k r, saturating, or -k r |r|^0.25."""
    r = now.r
    curve = {
        "plain": r,
        "saturating": r * np.sqrt(2 / (1 + r * r)),
        "power_1.25": r * np.abs(r) ** 0.25,
    }
    now.N = now.N - law.size * curve[law.form]


def crossflow_drag(now: Situation, law: HiddenLaw) -> None:
    """Drag across core and tail: -rho/2 k d w |w| of nine strips, w = v + x r.

    The depth d is elliptic or a wedge. low_reynolds: a coefficient that falls as |w|^-0.4.
    """
    robot = now.robot
    edges = np.linspace(robot.hinge_to_com, -robot.tail_reach(), 10)
    for x0, x1 in pairwise(edges):
        s = (x0 + x1 - edges[0] - edges[-1]) / (edges[0] - edges[-1])
        elliptic = law.form == "elliptic"
        depth = robot.head_span * (1.27 * np.sqrt(1 - s * s) if elliptic else 1 + 0.6 * s)
        w = now.v + (x0 + x1) / 2 * now.r
        rise = (0.15 / (0.03 + np.abs(w))) ** 0.4 if law.form == "low_reynolds" else 1.0
        load = HALF_DENSITY * law.size * depth * (x0 - x1) * w * np.abs(w) * rise
        now.Y = now.Y - load
        now.N = now.N - load * (x0 + x1) / 2


def added_mass(now: Situation, law: HiddenLaw) -> None:
    """Added masses; k is that of sway over the mass of the robot."""
    sway = law.size * now.robot.mass
    length = now.robot.body_length
    square = length**2
    surge, skew, yaw, munk = {
        "prolate": (0.09, 0.0, 0.6, 1.0),
        "skewed_plate": (0.03, -0.06, 1.1, 0.8),
        "partial_munk": (0.15, 0.0, 0.8, 0.4),
    }[law.form]
    now.added = AddedMass(surge * sway, sway, skew * sway * length, yaw * sway * square / 12, munk)


def trim_moment(now: Situation, law: HiddenLaw) -> None:
    """Moment on a straight robot, k at 0.3 m/s and 3.5 Hz: V f, V^1.5, or 0.4 + 0.6 f^2."""
    v, f = now.speed / 0.3, now.f / 3.5
    curve = {"speed_times_rate": v * f, "power_1.5": v**1.5, "idle_and_thrust": 0.4 + 0.6 * f * f}
    now.N = now.N + law.size * curve[law.form]


def thrust_line_offset(now: Situation, law: HiddenLaw) -> None:
    """Thrust that misses the centre of mass by 2 k tan(phi/2), or by k phi |phi| / 0.6, m."""
    phi = now.phi
    curve = 2 * np.tan(phi / 2) if law.form == "tan_half" else phi * np.abs(phi) / 0.6
    now.N = now.N + now.thrust * law.size * curve


def wake_reentry(now: Situation, law: HiddenLaw) -> None:
    """Resistance that falls by the share k of q A / 2 after 0.4 to 0.7 circles, in its own wake."""
    past = np.maximum(np.abs(now.turned) / (2 * np.pi) - (0.4 + 0.3 * law.shape[0]), 0)
    gaussian = law.form == "gaussian"
    share = 1 - np.exp(-((past / 0.3) ** 2)) if gaussian else past**2 / (past**2 + 0.06)
    now.resist(-law.size * share * 0.5 * HALF_DENSITY * now.area * now.speed**2)


def depth_gained(t: Quantity, law: HiddenLaw) -> Quantity:
    """Depth (m) gained at the time t (s): k t, from rest, or with 5 s to the end of sinking."""
    if law.form == "terminal":
        return law.size * (t - 1.5 * (1 - np.exp(-t / 1.5)))
    return law.size * t if law.form == "steady" else law.size * 5 * (1 - np.exp(-t / 5))


def sinking(now: Situation, law: HiddenLaw) -> None:
    """Resistance that grows by 8 q A per metre of depth; the camera sees the depth as well."""
    depth = depth_gained(np.maximum(now.t, 0), law)
    now.resist(8 * depth * HALF_DENSITY * now.area * now.speed**2)
