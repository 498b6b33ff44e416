"""Forces beyond equations (1) to (8), each one compiled pure function.

An effect receives its row `p` = (form, strength, shape 1, shape 2, shape 3); form 0 is off.
Forces are complex numbers in pool axes (N), moments are counter-clockwise (N m). `k` is a `Flow`.
Sources are given per form. Strengths carry the unit stated in `catalogue.py`.
"""

from collections import namedtuple

import numpy as np
from numba import njit

RHO = 1000.0
# Robot array.
MASS, INERTIA, BODY, HEAD1, SPAN, HINGE, TAIL, C_T, C_D0, C_DA, C_LA, C_MA, C_MD = range(13)
# w: velocity relative to the water (m/s, pool axes); u, v: its components along and across the
# core; z: position (m); e_core: unit vector of the core; q: dynamic pressure times plate area (N).
Flow = namedtuple("Flow", "t z w speed alpha theta phi rate f head u v e_core q thrust")


@njit(cache=True)
def sway_force_in_pool_axes(k, side):
    """Pool-axes force of a side force (N) normal to the core."""
    return 1j * side * k.e_core


@njit(cache=True)
def tail_fin_lift(p, k, lag):
    """Side force and moment of core and tail; strength: area (m^2), shape 1: lever (m).

    1 Helmbold 1942 (attached, linear); 2 Polhamus 1966 (potential and vortex lift);
    3 Lighthill 1970 (momentum shed at the trailing edge, with its axial term);
    4 Jones 1938 (1 with Wagner's lag). `lag` is the downwash that is still missing (m/s).
    """
    if p[0] == 0 or k.u <= 0.0:
        return 0j, 0.0
    w = k.v - p[2] * k.rate
    half, ahead = 0.5 * RHO * p[1], 0.0
    if p[0] == 2:
        V = np.hypot(k.u, w)
        side = -half * (1.6 * k.u * k.u * w / max(V, 1e-6) + 3.1 * w * abs(w))
    elif p[0] == 3:
        side, ahead = -half * np.pi * 0.7 * k.u * w, half * 0.35 * np.pi * w * w
    elif p[0] == 4:
        side = -half * 2.6 * k.u * (w - lag)
    else:
        side = -half * 2.6 * k.u * w
    return sway_force_in_pool_axes(k, side) + ahead * k.e_core, -p[2] * side


@njit(cache=True)
def crossflow_drag(p, k, R):
    """Sideways drag along the core and tail; strength: sectional drag coefficient.

    1 uniform strips (Hoerner 1965); 2 depth tapering to the tail (Fossen 2011, sec. 6.4);
    3 one plate at mid core (Faltinsen 1990); 4 oblique cylinder (Taylor 1952, laminar part).
    """
    if p[0] == 0:
        return 0j, 0.0
    front, back = R[HINGE], -(R[BODY] - R[HEAD1] - R[HINGE])
    side, moment, n = 0.0, 0.0, 9
    for i in range(n):
        s = front + (back - front) * (i + 0.5) / n
        if p[0] == 3:
            s = 0.5 * (front + back)
        W = k.v + s * k.rate
        depth = R[SPAN] * ((1.2 - (i + 0.5) / n) if p[0] == 2 else 1.0)
        law = abs(W) * W
        if p[0] == 4:
            law = W * np.sqrt(abs(W) * np.hypot(k.u, W))
        strip = -0.5 * RHO * p[1] * depth * (front - back) / n * law
        side, moment = side + strip, moment + s * strip
    return sway_force_in_pool_axes(k, side), moment


@njit(cache=True)
def along_path_drag(viscous, wave, coulomb, k):  # noqa: C901
    """Forces against the motion through the water.

    Viscous (N at 0.4 m/s): 1 Stokes, linear; 2 Blasius 1908, U^1.5; 3 Prandtl 1927, U^1.8 and a
    linear part; 4 ITTC 1957 line. Wave (N at 0.4 m/s): 1 U^4 (Hoerner 1965); 2 Michell 1898
    exponential in 1/Fr^2; 3 from a threshold speed. Coulomb (N): 1 tanh-regularised;
    2 Stribeck 1902; 3 tether friction falling slowly with speed.
    """
    a, force = k.speed / 0.4, 0.0
    if viscous[0] == 1:
        force += viscous[1] * a
    elif viscous[0] == 2:
        force += viscous[1] * a**1.5
    elif viscous[0] == 3:
        force += viscous[1] * (0.5 * a**1.8 + 0.5 * a)
    elif viscous[0] == 4:
        Re = max(k.speed * 0.331 / 1e-6, 2e3)
        force += viscous[1] * a * a * ((np.log10(0.4 * 0.331e6) - 2) / (np.log10(Re) - 2)) ** 2
    if wave[0] == 1:
        force += wave[1] * a**4
    elif wave[0] == 2:
        Fr2 = max(k.speed**2 / (9.81 * 0.331), 1e-5)
        force += wave[1] * a * a * np.exp(-0.15 * (1.0 / Fr2 - 20.3))
    elif wave[0] == 3:
        force += wave[1] * (max(a - 0.5, 0.0) / 0.5) ** 2
    if coulomb[0] > 0:
        grip = np.tanh(k.speed / 0.01)
        if coulomb[0] == 2:
            grip *= 1.0 + 0.6 * np.exp(-((k.speed / 0.1) ** 2))
        elif coulomb[0] == 3:
            grip /= 1.0 + k.speed / 0.8
        force += coulomb[1] * grip
    return -force * k.w / max(k.speed, 1e-9)


@njit(cache=True)
def yaw_moments(damping, trim, line, k):
    """Moments without a force (N m).

    Damping (N m s): 1 linear; 2 power 1.5 (laminar, White 2006); 3 saturating at 1 rad/s.
    Trim (N m): 1 constant; 2 grows with thrust (a bent tail); 3 grows with U^2 (a bent plate).
    Thrust line (m): 1 lever as sin phi; 2 lever as phi; 3 (1 - cos phi) with phi's sign.
    """
    N, r = 0.0, k.rate
    if damping[0] == 1:
        N -= damping[1] * r
    elif damping[0] == 2:
        N -= damping[1] * r * np.sqrt(abs(r))
    elif damping[0] == 3:
        N -= damping[1] * np.tanh(r)
    if trim[0] == 1:
        N += trim[1]
    elif trim[0] == 2:
        N += trim[1] * k.thrust / 0.3
    elif trim[0] == 3:
        N += trim[1] * (k.speed / 0.4) ** 2
    if line[0] == 1:
        N += line[1] * k.thrust * np.sin(k.phi)
    elif line[0] == 2:
        N += line[1] * k.thrust * k.phi
    elif line[0] == 3:
        N += line[1] * k.thrust * np.sign(k.phi) * (1 - np.cos(k.phi)) * 3.0
    return N


@njit(cache=True)
def wall_effect(p, k):
    """Force between the robot and the four walls; strength: coefficient on q.

    1 image repulsion 1/d^2 (Lamb 1932, art. 137); 2 suction decaying over shape 1 (m)
    (Norrbin 1974); 3 drag raised near a wall (blockage, Hoerner 1965).
    """
    if p[0] == 0:
        return 0j
    F = 0j
    for side in range(4):
        d = (k.z.real, 2.6 - k.z.real, k.z.imag, 1.6 - k.z.imag)[side]
        normal = (1.0 + 0j, -1.0 + 0j, 1j, -1j)[side]
        d = max(d, 0.04)
        if p[0] == 1:
            F += p[1] * k.q * normal * (p[2] / (d + p[2])) ** 2
        elif p[0] == 2:
            F -= p[1] * k.q * normal * np.exp(-d / p[2])
        else:
            F -= p[1] * k.q * np.exp(-d / p[2]) * k.w / max(k.speed, 1e-9)
    return F


@njit(cache=True)
def water_velocity(current, gyre, t, z, order):
    """Velocity of the water (m/s). Shape 1 of the current: direction (rad); `order`: 0 to 1.

    Current: 1 steady; 2 dying away over the session; 3 slow seiche about a mean, 9 s.
    Gyre: 1 solid body; 2 Lamb-Oseen 1912, core radius shape 1 (m); 3 cell sin x sin y.
    """
    c = 0j
    if current[0] > 0:
        c += current[1] * np.exp(1j * current[2])
        if current[0] == 2:
            c *= np.exp(-1.5 * order) * 1.5
        elif current[0] == 3:
            c *= 1.0 + 0.6 * np.sin(2 * np.pi * t / 9.0 + 6.0 * order)
    if gyre[0] > 0:
        d = z - (1.3 + 0.8j)
        r2 = d.real**2 + d.imag**2 + 1e-9
        if gyre[0] == 1:
            c += gyre[1] * 1j * d / 0.8
        elif gyre[0] == 2:
            c += gyre[1] * 1j * d * gyre[2] / r2 * (1 - np.exp(-1.26 * r2 / gyre[2] ** 2)) / 0.64
        else:
            a, b = np.pi * z.real / 2.6, np.pi * z.imag / 1.6
            c += gyre[1] * (-np.sin(a) * np.cos(b) + 0.615j * np.cos(a) * np.sin(b))
    return c


@njit(cache=True)
def step_response(form, tau, zeta, t):
    """Response at time t (s) to a unit step at 0, time scale tau (s).

    1 first order; 2 second order, damping zeta, omega = 1.7/tau (Ogata, sec. 5-3);
    3 rate limit, 2 tau long; 4 dead time of tau/2, then first order.
    """
    if form == 0:
        return 1.0
    if t <= 0.0:
        return 0.0
    if form == 2:
        w = 1.7 / tau
        wd = w * np.sqrt(1 - zeta * zeta)
        decay = np.exp(-zeta * w * t)
        return 1 - decay * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
    if form == 3:
        return min(t / (2 * tau), 1.0)
    if form == 4:
        return 1 - np.exp(-max(t - 0.5 * tau, 0.0) / tau)
    return 1 - np.exp(-t / tau)


@njit(cache=True)
def battery_sag(p, t, order, f):
    """Frequency ratio; strength: relative loss over 6 s.

    1 linear (discharge at constant current); 2 exponential (double layer, Shepherd 1965);
    3 growing with load, f^2 (Peukert 1897); 4 worse from trial to trial (Tremblay 2007).
    """
    if p[0] == 0:
        return 1.0
    if p[0] == 2:
        return 1 - p[1] * (1 - np.exp(-t / 1.8)) / 0.964
    rate = p[1] * t / 6.0
    if p[0] == 3:
        rate *= (f / 4.5) ** 2
    elif p[0] == 4:
        rate *= 0.4 + 1.2 * order
    return 1 - min(rate, 0.8)


@njit(cache=True)
def thrust_ratio(loss, area, k_u, f, head, R):  # noqa: PLR0917
    """Thrust relative to equation (1).

    Loss: 1 linear slip U/(f lambda) (propeller, Carlton 2007); 2 Lighthill 1960, 1 - slip^2;
    3 fixed jet speed 1.2 m/s (momentum theory); 4 exponential inflow.
    Area: 1 power law of head length; 2 blend with the 1x head; 3 logarithmic.
    """
    ratio, ahead = 1.0, max(k_u, 0.0)
    if loss[0] > 0 and f > 0:
        slip = ahead / (f * 0.2)
        if loss[0] == 1:
            ratio -= loss[1] * slip
        elif loss[0] == 2:
            ratio -= loss[1] * slip**2
        elif loss[0] == 3:
            ratio -= loss[1] * ahead / 0.6
        else:
            ratio *= np.exp(-loss[1] * slip)
    longer = head / R[HEAD1]
    if area[0] == 1:
        ratio *= longer ** (-area[1])
    elif area[0] == 2:
        ratio *= 1 - area[1] + area[1] / longer
    elif area[0] == 3:
        ratio /= 1 + area[1] * np.log(longer)
    return max(ratio, 0.0)


@njit(cache=True)
def lift_memory(p):
    """Indicial constants (A1, A2, b1, b2) of the lift's growth.

    1 Jones 1940 for Wagner; 2 Sears 1940 for Kuessner; 3 Beddoes 1984; 4 one lag (Theodorsen).
    """
    if p[0] == 1:
        return 0.165, 0.335, 0.0455, 0.3
    if p[0] == 2:
        return 0.5, 0.5, 0.13, 1.0
    if p[0] == 3:
        return 0.3, 0.7, 0.14, 0.53
    return 1.0, 0.0, 0.3, 1.0


@njit(cache=True)
def attached_fraction(p, a):
    """Static attached fraction X0 (0 to 1) at angle of attack a (rad); shape 1: stall angle.

    1, 3 hyperbolic (Goman and Khrabrov 1994); 2 two exponentials (Leishman and Beddoes 1989).
    """
    if p[0] == 2:
        if a < p[2]:
            return 1 - 0.3 * np.exp((a - p[2]) / 0.06)
        return 0.04 + 0.66 * np.exp((p[2] - a) / 0.08)
    return 0.5 * (1 - np.tanh((a - p[2]) / 0.07))


@njit(cache=True)
def stall_ratio(p, X, alpha):
    """Lift relative to attached flow: Kirchhoff's ((1 + sqrt X)/2)^2, blended by the strength.

    1 static; 2 Leishman-Beddoes lags; 3 Goman-Khrabrov; 4 Viterna 1982, linear beyond shape 1.
    """
    if p[0] == 0:
        return 1.0
    a = abs(alpha)
    if p[0] == 4:
        return 1 - p[1] * min(max((a - p[2]) / 0.35, 0.0), 1.0) * 0.75
    if p[0] == 1:
        X = attached_fraction(p, a)
    return 1 - p[1] * (1 - (0.5 + 0.5 * np.sqrt(min(max(X, 0.0), 1.0))) ** 2)


@njit(cache=True)
def unlisted_force(p, k):  # noqa: PLR0911
    """Force (N) and moment (N m) of no named cause; strength: amplitude; shape 1: phase (rad).

    1 moment sin(3 theta); 2 moment along x; 3 standing wave force along x; 4 periodic side gust;
    5 elastic tether to the pool's middle; 6 surge cos(2 theta) (surface film); 7 moment periodic
    in speed (vortex lock-in).
    """
    form, S = p[0], p[1]
    if form == 1:
        return 0j, S * np.sin(3 * k.theta + p[2])
    if form == 2:
        return 0j, S * np.sin(2 * np.pi * k.z.real / 1.3 + p[2])
    if form == 3:
        return S * np.sin(2 * np.pi * k.z.real / 0.9 + p[2]) + 0j, 0.0
    if form == 4:
        return 1j * S * np.sin(2 * np.pi * k.t / 1.7 + p[2]), 0.0
    if form == 5:
        d = (1.3 + 0.8j) - k.z
        return S * d * max(abs(d) - 0.25, 0.0) / max(abs(d), 1e-6), 0.0
    if form == 6:
        return S * np.cos(2 * k.theta + p[2]) * k.e_core, 0.0
    if form == 7:
        return 0j, S * np.sin(2 * np.pi * k.speed / 0.25 + p[2])
    return 0j, 0.0
