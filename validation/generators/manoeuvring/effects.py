"""Hidden physics: one law a cause, its functional forms, and the range of its strength.

A law takes (flow, s, form, p): the flow at C, the strength s, the form's name, the fixed shape
values p. Every law gives the base model at s = 0. Force laws return X, Y (N) and N (N m) about C
in body axes, v to port, positive yaw counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from validation.generators.manoeuvring.dynamics import POOL, RHO, Array, Flow, HiddenEffect

Force = tuple[Any, Any, Any]
Shape = dict[str, float]


# --- motor and servo -------------------------------------------------------------------------
def _step_response(t: Array, s: Array, form: str) -> Array:
    """Share of the final value reached at time t, 0 to 1, for a time scale s."""
    tau = np.maximum(s, 1e-5)
    t = np.maximum(t, 0.0)
    if form == "ramp":  # constant rate
        return np.minimum(t / tau, 1.0)
    if form == "second_order":  # critically damped (Ogata 2010, sec. 5.3)
        return 1 - (1 + t / tau) * np.exp(-t / tau)
    if form == "dead_time":  # Fossen 2011, sec. 9.5: delay and first order
        return 1 - np.exp(-np.maximum(t - tau / 2, 0) / tau)
    if form == "s_curve":
        w = np.minimum(t / tau, 1.0)
        return w * w * (3 - 2 * w)
    return 1 - np.exp(-t / tau)


def servo_lag(flow: Flow, s: Array, form: str, _p: Shape) -> Array:
    """Head angle, rad, that reaches its command with time scale s from 0 at motor start."""
    return flow.phi * _step_response(flow.t, s, form)


def motor_spin_up(flow: Flow, s: Array, form: str, _p: Shape) -> Array:
    """Flapping frequency, Hz, that reaches its steady value with time scale s."""
    return flow.f * _step_response(flow.t, s, form)


def battery_sag(flow: Flow, s: Array, form: str, p: Shape) -> Array:
    """Flapping frequency f (1 - s g), Hz.

    g: linear t/10 s; exponential (Shepherd 1965); peukert, linear and growing as f^1.2 (Peukert
    1897); warburg, sqrt(t) diffusion (Bard and Faulkner 2001, sec. 10.3).
    """
    t = np.maximum(flow.t, 0)
    g = {
        "linear": lambda: t / 10,
        "exponential": lambda: 1 - np.exp(-t / p["time_s"]),
        "peukert": lambda: (flow.f / 4) ** 1.2 * t / 10,
        "warburg": lambda: np.sqrt(t / 10),
    }[form]()
    return flow.f * (1 - s * g)


def head_angle_offset(flow: Flow, s: Array, form: str, _p: Shape) -> Array:
    """Head angle with a lasting error, rad: constant s, gain s phi / 0.5, play s sign(phi)."""
    return flow.phi + s * {"constant": 1.0, "gain": flow.phi / 0.5, "play": np.sign(flow.phi)}[form]


# --- thrust ----------------------------------------------------------------------------------
def thrust_loss_with_speed(flow: Flow, s: Array, form: str, p: Shape) -> Array:
    """Thrust factor 1 - s g with U along the core, J = U (1 - w) / (f b), tail stroke b.

    advance: J (K_T line; Carlton 2018, ch. 6). parabola: 0.4 J + 0.6 J^2 (MMG K_T; Yasukawa and
    Yoshimura 2015, eq. 9). reactive: J^2 (Lighthill 1971). deduction: U / 0.5, without f.
    """
    u = flow.core_velocity()[0]
    J = u * (1 - p["wake_fraction"]) / (np.maximum(flow.f, 0.5) * 0.12)
    g = {"advance": J, "parabola": 0.4 * J + 0.6 * J**2, "reactive": J**2, "deduction": u / 0.5}
    return 1 - s * g[form]


def thrust_area(flow: Flow, s: Array, form: str, _p: Shape) -> Array:
    """Thrust factor taking away the growth with head area: (A1/A)^s or 1 - s + s A1/A."""
    ratio = flow.robot.head_1x / flow.head
    return ratio**s if form == "power" else 1 - s + s * ratio


def thrust_line_offset(flow: Flow, s: Array, form: str, _p: Shape) -> Force:
    """Yaw moment T e(phi): e = s sin phi, s phi, or s 2 sign(phi) (1 - cos phi)."""
    phi = flow.phi
    e = {"sine": np.sin(phi), "linear": phi, "cosine": 2 * np.sign(phi) * (1 - np.cos(phi))}[form]
    return 0.0, 0.0, s * e * flow.thrust


def trim_moment(flow: Flow, s: Array, form: str, _p: Shape) -> Force:
    """Yaw moment: constant s, s (U / 0.4)^2 (hull, N'_0 of Abkowitz 1964), or s T / 0.3 N."""
    g = {"constant": 1.0, "hull": (flow.speed / 0.4) ** 2, "thrust": flow.thrust / 0.3}[form]
    return 0.0, 0.0, s * g * (flow.f > 0)


# --- resistance ------------------------------------------------------------------------------
def _opposing_force(flow: Flow, R: Array) -> tuple[Array, Array]:
    """Force of magnitude R against the relative velocity, body axes."""
    U = np.maximum(flow.speed, 1e-6)
    return -R * flow.u / U, -R * flow.v / U


def viscous_drag(flow: Flow, s: Array, form: str, _p: Shape) -> Force:
    """Resistance growing slower than U^2.

    linear s U; blasius s U^1.5; kuo 1/2 rho s U^2 (1.328 Re^-1/2 + 4.12/Re) (Kuo 1953);
    ittc57 1/2 rho s U^2 0.075 / (log10 Re - 2)^2 (ITTC 7.5-02-02-01). s: N s/m, N (s/m)^1.5, m2.
    """
    U = flow.speed
    Re = np.maximum(U * flow.robot.body_length / 1.0e-6, 2000.0)
    R = {
        "linear": lambda: U,
        "blasius": lambda: U**1.5,
        "kuo": lambda: 0.5 * RHO * U**2 * (1.328 / np.sqrt(Re) + 4.12 / Re),
        "ittc57": lambda: 0.5 * RHO * U**2 * 0.075 / (np.log10(Re) - 2) ** 2,
    }[form]()
    return *_opposing_force(flow, s * R), 0.0


def wave_drag(flow: Flow, s: Array, form: str, p: Shape) -> Force:
    """Wave resistance, s in N at 0.5 m/s (asymptote for havelock).

    havelock (U/0.5)^2 exp(-a / Fn^2) (Havelock 1909); hump (U/0.5)^4 (1 + 0.4 cos(1/Fn^2))
    (Havelock 1914); power4, power6 (U/0.5)^n (Lewis 1988, vol. II, sec. 4).
    """
    w = flow.speed / 0.5
    invF2 = 9.81 * flow.robot.body_length / np.maximum(flow.speed, 0.02) ** 2
    R = {
        "havelock": w**2 * np.exp(-p["a"] * invF2),
        "hump": w**4 * (1 + 0.4 * np.cos(invF2)),
        "power4": w**4,
        "power6": w**6,
    }[form]
    return *_opposing_force(flow, s * R), 0.0


def coulomb_friction(flow: Flow, s: Array, form: str, _p: Shape) -> Force:
    """Dry friction of a tether or guide, s in N: constant, or times 0.6 + 0.4 exp(-(U/0.1)^2).

    The latter is stribeck (1902). with_yaw adds a constant moment s 0.03 m against the yaw rate.
    """
    level = np.tanh(flow.speed / 0.02)
    if form == "stribeck":
        level = level * (0.6 + 0.4 * np.exp(-((flow.speed / 0.1) ** 2)))
    N = -0.03 * s * np.tanh(flow.r / 0.05) if form == "with_yaw" else 0.0
    return *_opposing_force(flow, s * level), N


# --- hull and fin ----------------------------------------------------------------------------
def linear_yaw_damping(flow: Flow, s: Array, form: str, p: Shape) -> Force:
    """N_r r (Abkowitz 1964) with N_r = -s N m s; saturating: N_r r / (1 + |r| / r0)."""
    soft = 1 + np.abs(flow.r) / p["rate_rad_s"] if form == "saturating" else 1.0
    return 0.0, 0.0, -s * flow.r / soft


def crossflow_drag(flow: Flow, s: Array, form: str, _p: Shape) -> Force:
    """Sideways drag along core and tail, -1/2 rho integral C_D h |v + xi r| (v + xi r) dxi; s: C_D.

    strip: height h = span; taper: h falling to 0.4 span aft (Faltinsen 1990, ch. 6); hooft: C_D
    larger aft (Hooft 1994); modulus: Y_vv, Y_vr, Y_rr, N_vr, N_rr (Norrbin 1971; MMG 1977).
    """
    v, r = flow.core_velocity()[1], flow.r
    fore, aft = flow.robot.hinge_to_com, -flow.robot.aft - flow.robot.tail_length
    length, mid, k = fore - aft, (fore + aft) / 2, 0.5 * RHO * s * flow.robot.span
    if form == "modulus":
        Y = -k * length * (v * np.abs(v) + 1.2 * mid * np.abs(v) * r + 0.01 * r * np.abs(r))
        N = mid * Y - k * length**3 / 12 * (1.5 * np.abs(v) * r + 0.05 * r * np.abs(r))
        return *flow.from_core(0.0, Y), N
    nodes = fore - length * (np.arange(5) + 0.5) / 5
    sigma = (fore - nodes) / length
    weight = {"strip": 1 + 0 * sigma, "taper": 1 - 0.6 * sigma, "hooft": 0.7 + 0.9 * sigma**2}[form]
    Y = N = 0.0
    for xi, w in zip(nodes, weight * length / 5, strict=True):
        dY = -k * w * np.abs(v + xi * r) * (v + xi * r)
        Y, N = Y + dY, N + xi * dY
    return *flow.from_core(0.0, Y), N


def tail_fin_lift(flow: Flow, s: Array, form: str, p: Shape) -> Force:
    """Side force of core and tail as a rudder of area s (m2), x_f behind C, flow straightened.

    Drift at the fin: v_f = gamma (v - x_f r), u_f = (1 - w) u. fujii: 6.13 L/(L + 2.25) sin b
    (Fujii and Tsuda 1961; MMG f_alpha); polhamus: K_p sin b cos^2 b + K_v sin^2 b cos b (1966);
    whicker: a b + C_Dc b|b| / L (Whicker and Fehlner 1958); jones: pi/2 L u v (Jones 1946).
    """
    u, v = flow.core_velocity()
    u, v = (1 - p["wake_fraction"]) * u, p["straightening"] * (v - p["arm_m"] * flow.r)
    U, L = np.hypot(u, v), p["aspect_ratio"]
    sb, cb = v / np.maximum(U, 1e-9), u / np.maximum(U, 1e-9)
    c_n = {
        "fujii": lambda: 6.13 * L / (L + 2.25) * sb,
        "polhamus": lambda: (
            1.5 * L / (1 + 0.3 * L) * sb * cb * np.abs(cb) + 3.1 * sb * np.abs(sb * cb)
        ),
        "whicker": lambda: (
            5.65 * L / (1.8 + np.hypot(L, 2)) * sb * np.abs(cb) + 0.8 / L * sb * np.abs(sb)
        ),
        "jones": lambda: np.pi / 2 * L * sb * cb,
    }[form]()
    Y = -0.5 * RHO * s * U**2 * c_n
    return *flow.from_core(0.0, Y), -p["arm_m"] * Y


def added_mass(flow: Flow, s: Array, form: str, _p: Shape) -> tuple[Array, ...]:
    """(m11, m22, m66, m26) about C, core axes, as a share s of the theory's value.

    lamb: prolate spheroid of 6:1, k1 0.045, k2 0.918, k' 0.764 (Lamb 1932, art. 114);
    strip: pi/4 rho h^2 a strip, with sway-yaw coupling (Newman 1977, sec. 4.13);
    clarke: empirical sway and yaw of slender hulls (Clarke, Gedling and Hine 1983).
    """
    rb = flow.robot
    length = rb.body_length + flow.head - rb.head_1x
    mid = length / 2 - rb.aft  # centre of the body ahead of C
    a22 = np.pi / 4 * RHO * rb.span**2 * length * {"lamb": 0.45, "strip": 0.6, "clarke": 0.5}[form]
    a66 = a22 * length**2 / 12 * {"lamb": 0.8, "strip": 1.0, "clarke": 0.7}[form]
    coupling = 0.0 if form == "lamb" else a22 * mid
    return s * 0.08 * a22, s * a22, s * (a66 + coupling * mid), s * coupling


def centre_of_mass_shift(flow: Flow, s: Array, form: str, _p: Shape) -> tuple[Array, Array]:
    """Shift of the mass from C along and across the core, m; the flow forces stay."""
    a, b = {"longitudinal": (1.0, 0.0), "lateral": (0.0, 1.0), "diagonal": (0.8, 0.6)}[form]
    return s * a + 0 * flow.r, s * b + 0 * flow.r


# --- lift ------------------------------------------------------------------------------------
def stall(flow: Flow, s: Array, form: str, p: Shape) -> Array:
    """Lift factor 1 - s g(|alpha|), stall angle a and width w (rad).

    kirchhoff: trailing edge separation ((1 + sqrt X)/2)^2 (Leishman and Beddoes 1989); logistic;
    ramp (Viterna and Corrigan 1982, linearised); gaussian: 1 - exp(-(over/w)^2).
    """
    over = (np.abs(flow.alpha) - p["stall_angle_rad"]) / p["width_rad"]
    X = 1 / (1 + np.exp(np.clip(2 * over, -40, 40)))
    g = {
        "kirchhoff": (1 - ((1 + np.sqrt(X)) / 2) ** 2) / 0.75,
        "logistic": 1 - X,
        "ramp": np.clip(over / 2, 0, 1),
        "gaussian": 1 - np.exp(-(np.maximum(over, 0) ** 2)),
    }[form]
    return 1 - s * g


LAG_CONSTANTS = {  # (A1, b1, A2, b2) of 1 - A1 exp(-b1 tau) - A2 exp(-b2 tau)
    "wagner": (0.165, 0.0455, 0.335, 0.3),  # Jones 1940
    "kussner": (0.5, 0.13, 0.5, 1.0),  # Sears 1940
    "low_aspect": (0.4, 0.2, 0.0, 1.0),  # one lag, after Jones 1940 for aspect ratio 3
}


def lift_lag(flow: Flow, s: Array, form: str, p: Shape) -> tuple[Array, Array]:
    """Lagged lift C_L - s sum A_i (C_L - z_i) and lag rates z' = b (C_L - z) U / chord; constant:

    z' = (C_L - z) / tau (Goman and Khrabrov 1994). `chords` scales the lag length.
    """
    if form == "constant":
        a1, a2, k1, k2 = 0.5, 0.0, 1 / p["time_s"], 1.0
    else:
        a1, b1, a2, b2 = LAG_CONSTANTS[form]
        k = 2 * flow.speed / (flow.head * p["chords"])
        k1, k2 = b1 * k, b2 * k
    d1, d2 = flow.lift - flow.lags[0], flow.lift - flow.lags[1]
    return flow.lift - s * (a1 * d1 + a2 * d2), np.stack([k1 * d1, k2 * d2])


def port_starboard_asymmetry(flow: Flow, s: Array, form: str, _p: Shape) -> Any:
    """Sides that differ: lift factor 1 + s tanh(alpha/0.05), thrust factor 1 + s tanh(phi/0.1),

    or yaw damping that is larger in one turning direction, N = -s 0.1 (r^2 + r|r|) / 2.
    """
    if form == "damping":
        return 0.0, 0.0, -s * 0.05 * (flow.r**2 + flow.r * np.abs(flow.r))
    return 1 + s * (np.tanh(flow.alpha / 0.05) if form == "lift" else np.tanh(flow.phi / 0.1))


# --- surroundings ----------------------------------------------------------------------------
def uniform_current(flow: Flow, s: Array, form: str, p: Shape) -> tuple[Array, Array]:
    """Current s (m/s) toward a direction; constant, weakly sheared across the pool, or settling."""
    g = {
        "constant": 1.0,
        "sheared": 1 + p["shear"] * (flow.y / POOL[1] - 0.5),
        "settling": np.exp(-np.maximum(flow.t, 0) / p["settling_s"]),
    }[form]
    return s * g * np.cos(p["direction_rad"]), s * g * np.sin(p["direction_rad"]) + 0 * flow.r


def pool_gyre(flow: Flow, s: Array, form: str, p: Shape) -> tuple[Array, Array]:
    """Circulation about the middle, s in m/s: solid body, Kaufmann vortex, or a basin cell.

    cell: stream function sin(pi x/L) sin(pi y/W) (Stommel 1948 without bottom friction).
    """
    x, y = flow.x - POOL[0] / 2, flow.y - POOL[1] / 2
    if form == "cell":
        kx, ky = np.pi / POOL[0], np.pi / POOL[1]
        return (
            s * np.sin(kx * flow.x) * np.cos(ky * flow.y),
            -s * kx / ky * np.cos(kx * flow.x) * np.sin(ky * flow.y),
        )
    a2 = p["core_m"] ** 2
    k = 1 / 0.8 if form == "solid" else 2 * p["core_m"] / (x**2 + y**2 + a2)
    return -s * k * y, s * k * x


def wall_effect(flow: Flow, s: Array, form: str, p: Shape) -> Force:
    """Bank force of the four walls at gap d: toward the wall s q (b/d)^2 (Norrbin 1974) or

    s q exp(-d/b) with bow-out moment (Vantorre et al. 2003), or added drag s q sum exp(-d/b);
    q = 1/2 rho A U^2.
    """
    q = 0.5 * RHO * flow.area * flow.speed**2
    gaps = [flow.x, POOL[0] - flow.x, flow.y, POOL[1] - flow.y]
    b = p["reach_m"]
    g = [(b / np.maximum(d, 0.08)) ** 2 if form == "norrbin" else np.exp(-d / b) for d in gaps]
    if form == "drag":
        return *_opposing_force(flow, s * q * sum(g)), 0.0
    X, Y = flow.from_world(s * q * (g[1] - g[0]), s * q * (g[3] - g[2]))
    return X, Y, (-0.05 * Y if form == "vantorre" else 0.0)


def wake_reentry(flow: Flow, s: Array, _form: str, _p: Shape) -> tuple[Array, Array]:
    """Water velocity of the robot's own old wake: s (m/s) times the jet of dynamics.own_wake."""
    return s * flow.wake[0], s * flow.wake[1]


def sinking(flow: Flow, s: Array, form: str, _p: Shape) -> Array:
    """Added keypoint depth, m: s t, squat s (U/0.4)^2 (Barrass 1979), or s (1 - exp(-t/3))."""
    t = np.maximum(flow.t, 0)
    return s * {"rate": t, "squat": (flow.speed / 0.4) ** 2, "settling": 1 - np.exp(-t / 3)}[form]


# --- forces that no named cause states ---------------------------------------------------------
def unlisted(flow: Flow, s: Array, form: str, p: Shape) -> Force:
    """A force (N) or moment (N m) outside the list of causes; UNLISTED says where it acts."""
    a, w, moving = p["phase_rad"], 2 * np.pi / p["period_s"], np.tanh(flow.speed / 0.03)
    patch = np.exp(-((flow.x - p["x_m"]) ** 2 + (flow.y - p["y_m"]) ** 2) / 0.3**2)
    spring = flow.from_world(-(flow.x - POOL[0] / 2), -(flow.y - POOL[1] / 2))
    zone = np.exp(-(((flow.speed - p["speed_m_s"]) / 0.06) ** 2))
    table: dict[str, Callable[[], Force]] = {
        "sin 3 theta": lambda: (0.0, 0.0, s * moving * np.sin(3 * flow.psi + a)),
        "surge cos 2 theta": lambda: (s * moving * np.cos(2 * flow.psi + a), 0.0, 0.0),
        "sway sin 4 theta": lambda: (0.0, s * moving * np.sin(4 * flow.psi + a), 0.0),
        "spring to pool centre": lambda: (s * spring[0], s * spring[1], 0.0),
        "yaw patch": lambda: (0.0, 0.0, s * moving * patch),
        "surge patch": lambda: (s * moving * patch, 0.0, 0.0),
        "yaw sin t": lambda: (0.0, 0.0, s * moving * np.sin(w * flow.t + a)),
        "surge sin t": lambda: (s * moving * np.sin(w * flow.t + a), 0.0, 0.0),
        "sway speed zone": lambda: (0.0, s * zone, 0.0),
    }
    return table[form]()


UNLISTED: dict[str, tuple[list[str], str]] = {  # channels, variable
    "sin 3 theta": (["yaw"], "heading_rad"),
    "surge cos 2 theta": (["surge"], "heading_rad"),
    "sway sin 4 theta": (["sway"], "heading_rad"),
    "spring to pool centre": (["surge", "sway"], "position_m"),
    "yaw patch": (["yaw"], "position_m"),
    "surge patch": (["surge"], "position_m"),
    "yaw sin t": (["yaw"], "time_s"),
    "surge sin t": (["surge"], "time_s"),
    "sway speed zone": (["sway"], "speed_m_s"),
}


@dataclass(frozen=True)
class Cause:
    """Registry row: hook, law, unit, forms with strength (low, start, high), shape ranges."""

    hook: str
    law: Callable[..., Any]
    unit: str
    forms: dict[str, tuple[float, float, float]]
    shape: dict[str, tuple[float, float]]
    signed: bool = False


def _forms_with_same_strength(
    names: str, low: float, start: float, high: float
) -> dict[str, tuple]:
    return dict.fromkeys(names.split(), (low, start, high))


LAG_FORMS = "first_order ramp second_order dead_time"
FIN_SHAPE = {
    "arm_m": (0.15, 0.21),
    "aspect_ratio": (0.6, 2.0),
    "straightening": (0.55, 1.0),
    "wake_fraction": (0.0, 0.25),
}
CAUSES: dict[str, Cause] = {
    "tail_fin_lift": Cause(
        "force",
        tail_fin_lift,
        "m2",
        _forms_with_same_strength("fujii polhamus whicker jones", 1e-4, 4e-3, 0.04),
        FIN_SHAPE,
    ),
    "added_mass": Cause(
        "added_mass",
        added_mass,
        "1",
        _forms_with_same_strength("lamb strip clarke", 0.02, 0.4, 1.5),
        {},
    ),
    "viscous_drag": Cause(
        "force",
        viscous_drag,
        "SI",
        {
            **_forms_with_same_strength("linear", 0.003, 0.05, 1.0),
            **_forms_with_same_strength("blasius", 0.005, 0.1, 2.0),
            **_forms_with_same_strength("kuo", 0.005, 0.08, 1.2),
            **_forms_with_same_strength("ittc57", 0.005, 0.08, 1.2),
        },
        {},
    ),
    "linear_yaw_damping": Cause(
        "force",
        linear_yaw_damping,
        "N m s",
        _forms_with_same_strength("linear saturating", 5e-4, 0.01, 0.15),
        {"rate_rad_s": (0.5, 1.5)},
    ),
    "thrust_loss_with_speed": Cause(
        "thrust",
        thrust_loss_with_speed,
        "1",
        _forms_with_same_strength("advance parabola reactive deduction", 0.01, 0.2, 0.75),
        {"wake_fraction": (0.0, 0.3)},
    ),
    "uniform_current": Cause(
        "water",
        uniform_current,
        "m/s",
        _forms_with_same_strength("constant sheared settling", 5e-4, 0.008, 0.08),
        {"direction_rad": (-3.1, 3.1), "shear": (-0.6, 0.6), "settling_s": (12.0, 30.0)},
    ),
    "pool_gyre": Cause(
        "water",
        pool_gyre,
        "m/s",
        _forms_with_same_strength("solid kaufmann cell", 5e-4, 0.01, 0.08),
        {"core_m": (0.25, 0.5)},
        True,
    ),
    "wall_effect": Cause(
        "force",
        wall_effect,
        "1",
        {
            **_forms_with_same_strength("norrbin vantorre", 0.005, 0.2, 4.0),
            **_forms_with_same_strength("drag", 0.005, 0.3, 3.0),
        },
        {"reach_m": (0.12, 0.3)},
    ),
    "stall": Cause(
        "lift",
        stall,
        "1",
        _forms_with_same_strength("kirchhoff logistic ramp gaussian", 0.01, 0.3, 0.95),
        {"stall_angle_rad": (0.12, 0.28), "width_rad": (0.03, 0.09)},
    ),
    "servo_lag": Cause(
        "angle", servo_lag, "s", _forms_with_same_strength(LAG_FORMS, 0.02, 0.2, 1.5), {}
    ),
    "motor_spin_up": Cause(
        "frequency",
        motor_spin_up,
        "s",
        _forms_with_same_strength("exponential ramp s_curve", 0.02, 0.2, 2.0),
        {},
    ),
    "battery_sag": Cause(
        "frequency",
        battery_sag,
        "1",
        _forms_with_same_strength("linear exponential peukert warburg", 0.002, 0.05, 0.3),
        {"time_s": (1.0, 4.0)},
    ),
    "trim_moment": Cause(
        "force",
        trim_moment,
        "N m",
        _forms_with_same_strength("constant hull thrust", 3e-5, 5e-4, 0.02),
        {},
        True,
    ),
    "head_angle_offset": Cause(
        "angle",
        head_angle_offset,
        "rad",
        _forms_with_same_strength("constant gain play", 0.004, 0.03, 0.2),
        {},
        True,
    ),
    "crossflow_drag": Cause(
        "force",
        crossflow_drag,
        "1",
        _forms_with_same_strength("strip taper hooft modulus", 0.01, 0.3, 3.0),
        {},
    ),
    "thrust_line_offset": Cause(
        "force",
        thrust_line_offset,
        "m",
        _forms_with_same_strength("sine linear cosine", 3e-4, 3e-3, 0.04),
        {},
        True,
    ),
    "thrust_area": Cause(
        "thrust", thrust_area, "1", _forms_with_same_strength("power blend", 0.02, 0.3, 1.0), {}
    ),
    "lift_lag": Cause(
        "lag",
        lift_lag,
        "1",
        _forms_with_same_strength("wagner kussner low_aspect constant", 0.02, 0.5, 1.9),
        {"chords": (1.0, 5.0), "time_s": (0.15, 0.6)},
    ),
    "wave_drag": Cause(
        "force",
        wave_drag,
        "N",
        {
            **_forms_with_same_strength("hump power4 power6", 0.001, 0.05, 0.6),
            **_forms_with_same_strength("havelock", 0.001, 0.1, 1.5),
        },
        {"a": (0.12, 0.3)},
    ),
    "coulomb_friction": Cause(
        "force",
        coulomb_friction,
        "N",
        _forms_with_same_strength("constant stribeck with_yaw", 4e-4, 0.01, 0.07),
        {},
    ),
    "wake_reentry": Cause(
        "water",
        wake_reentry,
        "m/s",
        _forms_with_same_strength("exponential similarity spreading top_hat", 0.002, 0.05, 0.5),
        {"decay_s": (5.0, 15.0), "width_m": (0.08, 0.16)},
    ),
    "sinking": Cause(
        "depth",
        sinking,
        "m",
        {
            **_forms_with_same_strength("rate", 4e-4, 0.005, 0.025),
            **_forms_with_same_strength("squat settling", 0.002, 0.02, 0.12),
        },
        {},
    ),
    "centre_of_mass_shift": Cause(
        "mass",
        centre_of_mass_shift,
        "m",
        _forms_with_same_strength("longitudinal lateral diagonal", 3e-4, 3e-3, 0.03),
        {},
        True,
    ),
    "port_starboard_asymmetry": Cause(
        "lift",
        port_starboard_asymmetry,
        "1",
        _forms_with_same_strength("lift thrust damping", 0.003, 0.05, 0.7),
        {},
        True,
    ),
}
UNLISTED_SHAPE = {
    "phase_rad": (-3.0, 3.0),
    "period_s": (1.8, 4.0),
    "x_m": (0.9, 1.7),
    "y_m": (0.6, 1.0),
    "speed_m_s": (0.2, 0.4),
}
UNLISTED_CAUSE = Cause(
    "force",
    unlisted,
    "N or N m",
    {k: (1e-5, 1e-3, 0.03) if v[0] == ["yaw"] else (3e-4, 0.01, 0.2) for k, v in UNLISTED.items()},
    UNLISTED_SHAPE,
    True,
)
HOOKS = {"lift": "lift", "thrust": "thrust", "damping": "force"}  # of port_starboard_asymmetry


def draw_effect(name: str, rng: np.random.Generator) -> tuple[HiddenEffect, tuple[float, float]]:
    """An effect of a cause with a random form at its start strength, and its bounds."""
    cause = CAUSES.get(name, UNLISTED_CAUSE)
    form = str(rng.choice(list(cause.forms)))
    low, start, high = cause.forms[form]
    shape = {k: round(float(rng.uniform(a, b)), 4) for k, (a, b) in cause.shape.items()}
    sign = float(rng.choice([-1, 1])) if cause.signed else 1.0
    hook = HOOKS[form] if name == "port_starboard_asymmetry" else cause.hook
    return HiddenEffect(name, form, "physics", hook, cause.law, sign * start, cause.unit, shape), (
        low,
        high,
    )
