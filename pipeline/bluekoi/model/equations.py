"""The paper's equations 1 to 8, written without angles where a product of velocities will do.

Symbols are the paper's (docs/conventions.md). The state is kept in the frame of the core, whose
direction is psi = theta + phi: x, y (centre of mass, pool frame, m), psi (rad), u, v (velocity of
the centre of mass along and across the core, to the left, m/s), r (yaw rate, rad/s). With the head
angle phi constant this is Eq. 8 exactly. While the head is being turned the core keeps its
direction and the head turns, or the core turns by itself (`core_turn_rate`), as Eq. 8 has it,
whose state is the direction of the head.

With (u_h, v_h) the velocity relative to the water along and across the head plate,
alpha = -atan2(v_h, u_h) and V^2 = u_h^2 + v_h^2:

    V^2 sin 2 alpha = -2 u_h v_h        V^2 (1 - cos 2 alpha) = 2 v_h^2
"""

from __future__ import annotations

import math

from ..integrate.branchless import sin_cos

MIN_SPEED_SQUARED = (
    1e-12  # m2/s2 beside V^2, so that directions exist at rest, where every force is zero
)


def actuation_inputs(head_angle: float, flap_hz: float) -> tuple[float, float]:
    """Head angle phi (rad) and flapping frequency f (Hz) as commanded or measured."""
    return head_angle, flap_hz


def head_angle_cos_sin(phi: float) -> tuple[float, float]:
    """Cosine and sine of the head angle."""
    s, c = sin_cos(phi)
    return c, s


def relative_flow_velocities(
    l: float, psi: float, u: float, v: float, r: float, cphi: float, sphi: float, wx: float, wy:
    float, wr: float, wd: float,
) -> tuple[float, float, float, float, float, float, float, float, float]:  # fmt: skip
    """Directions and velocities relative to water that moves with (wx, wy), m/s, and turns a line
    along the core at wr, rad/s; the head plate, a distance l ahead, meets the water there.

    Out: cos and sin of psi, velocity along and across the core, yaw rate, velocity along and across
    the head plate, speed.
    """
    s, c = sin_cos(psi)
    uc = u - (wx * c + wy * s)
    vc = v - (wy * c - wx * s)
    vl = vc - l * wr
    uh = uc * cphi - vl * sphi
    vh = uc * sphi + vl * cphi
    return c, s, uc, vc, r - wr, r - wd, uh, vh, math.sqrt(uc * uc + vc * vc + MIN_SPEED_SQUARED)


def thrust(rho: float, A: float, f: float, C_T: float) -> tuple[float]:
    """Thrust along the core, N: T = C_T (1/2 rho A f^2)  (Eq. 1), C_T in m2."""
    return (C_T * 0.5 * rho * A * f * f,)


def head_plate_force(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float, C_D0: float, C_Da: float
) -> tuple[float, float]:
    """Lift and drag of the head plate, in its own frame, N.

    L = q C_L v_hat i,  C_L = C_La sin 2 alpha                  (2, 5)
    D = -q C_D v_hat,   C_D = C_D0 + C_Da (1 - cos 2 alpha)      (3, 6)
    """
    k = 0.5 * rho * A
    L = k * C_La * (-2.0 * uh * vh) / V
    D = k * (C_D0 * V * V + C_Da * 2.0 * vh * vh) / V
    return -L * vh - D * uh, L * uh - D * vh


def force(
    rho: float, A: float, l: float, rd: float, uh: float, vh: float, cphi: float, sphi: float, T:
    float, Xh: float, Yh: float, C_Ma: float, C_Md: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway force (N) in the core's frame and yaw moment (N m).

    M = q C_Ma sin 2 alpha - C_Md r |r|  (4, 7), r against the water;
    moment M + N l, N = Re[(L + D) conj(n)]  (8)
    """
    M = 0.5 * rho * A * C_Ma * (-2.0 * uh * vh) - C_Md * rd * abs(rd)
    return T + Xh * cphi + Yh * sphi, Yh * cphi - Xh * sphi, M + Yh * l


def inertia(m: float, I: float) -> tuple[float, float, float]:
    """Mass against surge and sway (kg) and yaw inertia (kg m2)."""
    return m, m, I


def inverse_inertias(mx: float, my: float, J: float) -> tuple[float, float, float]:
    """Acceleration by a unit force: 1/mx, 1/my (1/kg), 1/J (1/(kg m2))."""
    return 1.0 / mx, 1.0 / my, 1.0 / J


def core_turn_rate() -> tuple[float]:
    """Rate at which the core turns beside the body's yaw rate, while the head is being turned."""
    return (0.0,)


def rigid_body_state_derivatives(
    u: float, v: float, r: float, core_turn_rate: float, cpsi: float, spsi: float, X: float, Y:
    float, N: float, mx: float, my: float, bx: float, by: float, bJ: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Derivatives of x, y, psi, u, v, r: Newton and Euler in the frame of the core (Eq. 8).

    mx u' = X + my v w;  my v' = Y - mx u w;  J r' = N - (my - mx) u v;  b is 1/m and 1/J, and
    w = psi' = r + core_turn_rate
    """
    w = r + core_turn_rate
    return (
        u * cpsi - v * spsi,
        u * spsi + v * cpsi,
        w,
        (X + my * v * w) * bx,
        (Y - mx * u * w) * by,
        (N - (my - mx) * u * v) * bJ,
    )
