# ruff: noqa: ARG001 - laws of one channel share their arguments
"""Hidden effects: one pure law a physical idea, one row of ``FORMS`` a functional form.

Leading arguments of a law by channel: force, thrust, thrust_moment, lift, lag, mass_centre take
(flow, s, c); mass (robot, phi, s, c); water (place, t, (trials, pool), s, c); head_angle and
frequency (value, t, trials, s, c). Laws of channels observe and report are in observe.py. ``s`` is
the strength in the form's unit and ``c`` its constants (SI). The rows give the sources.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .dynamics import DENSITY, Flow, Robot, Trials, planar_moment


@dataclass(frozen=True)
class Form:
    """A form of a named cause with bounds of its strength and ranges of its constants."""

    name: str
    form: str
    channel: str
    law: Callable
    parameter: str
    unit: str
    low: float
    high: float
    source: str
    ranges: dict = field(default_factory=dict)  # constant: (low, high), drawn uniformly
    signed: bool = False  # the strength takes either sign

    def draw(self, rng: np.random.Generator) -> dict:
        """Constants of one instance, uniform over their ranges; ``side`` is -1 or 1."""
        drawn = {k: float(rng.uniform(*v)) for k, v in self.ranges.items()}
        return drawn | {"side": float(rng.choice([-1, 1])) if self.signed else 1.0}


def smoothstep(x: np.ndarray) -> np.ndarray:
    """3 x^2 - 2 x^3 between 0 and 1."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


# ----------------------------------------- core and tail as a lifting surface


def fin_force(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Side force Y = -1/2 rho S |v|^2 C(beta) at the fin; beta = its sideslip; ``s`` = S (m^2)."""
    u, w = flow.behind(c["arm_m"])
    beta, q = np.arctan2(w, np.maximum(u, 1e-9)), 0.5 * DENSITY * (u * u + w * w)
    AR, sin, cos = c["aspect"], np.sin(beta), np.cos(beta)
    slope = {"jones": np.pi * AR / 2, "helmbold": 2 * np.pi * AR / (2 + np.sqrt(AR * AR + 4))}
    if c["law"] == "polhamus":
        C = slope["jones"] * 0.9 * sin * cos**2 + np.pi * cos * sin * np.abs(sin)
    else:
        C = slope[c["law"]] * sin * cos
    force = -q * s * C * 1j * flow.core * (u > 0)
    return force, planar_moment(-c["arm_m"] * flow.core, force)


def fin_slender_body(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Y = -pi/4 rho b^2 u w at the trailing edge; ``s`` = b^2 (m^2)."""
    u, w = flow.behind(c["arm_m"])
    force = -np.pi / 4 * DENSITY * s * np.maximum(u, 0) * w * 1j * flow.core
    return force, planar_moment(-c["arm_m"] * flow.core, force)


def fin_jones(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Fin with C = (pi AR / 2) sin beta cos beta."""
    return fin_force(flow, s, c | {"law": "jones"})


def fin_helmbold(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Fin with the slope 2 pi AR / (2 + sqrt(AR^2 + 4))."""
    return fin_force(flow, s, c | {"law": "helmbold"})


def fin_polhamus(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Fin with K_p sin beta cos^2 beta + K_v cos beta sin^2 beta."""
    return fin_force(flow, s, c | {"law": "polhamus"})


def crossflow_strips(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-1/2 rho C_d integral b(x) w |w| dx over core and tail, or its variants; ``s`` = C_d."""
    robot, total, M = flow.world.robot, 0.0, 0.0
    front, back = -robot.hinge_to_com, robot.tail_base + robot.tail_length
    count = int(c.get("count", 6))
    for x in front + (np.arange(count) + 0.5) / count * (back - front):
        u, w = flow.behind(x)
        span = robot.head_span * (1 + c.get("taper", 0) * (x - front) / (back - front))
        normal = np.abs(w) if not c.get("inclined") else w * w / np.hypot(u, w).clip(1e-6)
        total = total - 0.5 * DENSITY * s * span * (back - front) / count * w * normal
        M = M + 0.5 * DENSITY * s * span * (back - front) / count * w * normal * x
    return total * 1j * flow.core, M


# ------------------------------------------------ drag, damping and friction


def power_law_drag(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-s |v|^n along the motion; ``s`` in N/(m/s)^n."""
    return -s * flow.U ** c["n"] * flow.v_hat, 0 * flow.U


def ittc_drag(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-1/2 rho S U^2 0.075 / (log10 Re - 2)^2; ``s`` = wetted surface S (m^2)."""
    Re = np.maximum(flow.U * c["length_m"] / 1e-6, 2e3)
    C_f = 0.075 / (np.log10(Re) - 2) ** 2
    return -0.5 * DENSITY * s * C_f * flow.U**2 * flow.v_hat, 0 * flow.U


def wave_drag_hump(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-s U^2 exp(-(U_h / U)^2): submerged-body wave resistance; ``s`` in N s^2/m^2."""
    strength = np.exp(-((c["hump_m_s"] / flow.U.clip(1e-3)) ** 2))
    return -s * flow.U**2 * strength * flow.v_hat, 0 * flow.U


def yaw_damping(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-s r |r|^(n-1); ``s`` in N m s^n."""
    return 0 * flow.v, -s * flow.r * (np.abs(flow.r) + 1e-6) ** (c["n"] - 1)


def yaw_damping_strips(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Linear strip resistance that turns with the body about its pivot; ``s`` = N_r (N m s)."""
    return -1j * flow.core * s * flow.r / c["lever_m"] * 0.2, -s * flow.r


def coulomb_friction(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """-s tanh(U / U_0) (1 + a exp(-(U/U_s)^2)) along the motion: dry friction of a tether; ``s``

    in N.
    """
    stribeck = 1 + c.get("stribeck", 0) * np.exp(-((flow.U / 0.08) ** 2))
    return -s * np.tanh(flow.U / 0.01) * stribeck * flow.v_hat, 0 * flow.U


def coulomb_friction_with_yaw(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Dry friction of a tether on translation (N) and, at a radius, on rotation (N m)."""
    force, _ = coulomb_friction(flow, s, {})
    return force, -s * c["radius_m"] * np.tanh(flow.r / 0.05)


# ----------------------------------------------------------- thrust and lift


def thrust_loss_power(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 - s J^n with advance ratio J = U / (f c); ``s`` = fraction lost at J = 1."""
    J = flow.U / (flow.f.clip(0.2) * c["stride_m"])
    return np.maximum(1 - s * J ** c["n"], 0.0)


def thrust_loss_actuator_disc(flow: Flow, s: float, c: dict) -> np.ndarray:
    """sqrt(1 + x^2) - x with x = s U / (f c): momentum theory of an actuator at fixed power."""
    x = s * flow.U / (flow.f.clip(0.2) * c["stride_m"])
    return np.sqrt(1 + x * x) - x


def thrust_loss_exponential(flow: Flow, s: float, c: dict) -> np.ndarray:
    """exp(-s U / U_0); ``s`` dimensionless, U_0 fixed: independent of the frequency."""
    return np.exp(-s * flow.U / c["U0_m_s"])


def thrust_area_power(flow: Flow, s: float, c: dict) -> np.ndarray:
    """(A / A_1x)^-s: s = 1 makes thrust independent of head size."""
    return (flow.trials.head / flow.world.robot.head_length) ** -s


def thrust_area_blend(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 - s + s A_1x / A."""
    return 1 - s + s * flow.world.robot.head_length / flow.trials.head


def asymmetric_thrust(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 + s tanh(phi / 10 deg)."""
    return 1 + s * c["side"] * np.tanh(flow.phi / np.radians(10))


def thrust_line_offset(flow: Flow, s: float, c: dict) -> np.ndarray:
    """Lever (m) of the thrust: s sin phi, s phi or s (1 - cos phi) sign phi; positive opposes the

    turn.
    """
    shapes = {
        0: np.sin(flow.phi),
        1: flow.phi,
        2: np.sin(flow.phi) * np.abs(np.sin(flow.phi)) ** 0.5,
    }
    return s * c["side"] * shapes[int(c["shape"])]


def trim_with_thrust(flow: Flow, s: float, c: dict) -> np.ndarray:
    """Lever (m) of an asymmetric tail beat: moment grows with f^2."""
    return s * c["side"] * np.ones_like(flow.f)


def trim_with_flow(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """M = s rho/2 A U^n: a bent fin; ``s`` in m (n = 2)."""
    return 0 * flow.v, s * c["side"] * 0.5 * DENSITY * flow.area * flow.U ** c["n"]


def stall_sigmoid(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 - s sigma(|alpha|), sigma logistic about alpha_s."""
    return 1 - s / (1 + np.exp(-(np.abs(flow.alpha) - c["alpha_s"]) / c["width"]))


def stall_linear(flow: Flow, s: float, c: dict) -> np.ndarray:
    """Linear loss above alpha_s, s at alpha_s + 15 degrees and constant beyond."""
    return 1 - s * np.clip((np.abs(flow.alpha) - c["alpha_s"]) / 0.26, 0, 1)


def stall_separation(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 - s + s ((1 + sqrt(f_sep)) / 2)^2 with an exponential separation point f_sep(alpha)."""
    excess = np.abs(flow.alpha) - c["alpha_s"]
    below = 1 - 0.3 * np.exp(np.minimum(excess, 0) / 0.05)
    f_sep = np.where(excess < 0, below, 0.04 + 0.66 * np.exp(-np.maximum(excess, 0) / 0.08))
    return 1 - s + s * ((1 + np.sqrt(f_sep)) / 2) ** 2


def stall_viterna(flow: Flow, s: float, c: dict) -> np.ndarray:
    """Post-stall lift falls as sin alpha_s / sin alpha, blended by ``s``."""
    ratio = np.sin(c["alpha_s"]) / np.maximum(np.abs(np.sin(flow.alpha)), np.sin(c["alpha_s"]))
    return 1 - s + s * ratio


def asymmetric_lift(flow: Flow, s: float, c: dict) -> np.ndarray:
    """1 + s tanh(alpha / 2 deg): the plate is cambered or bent."""
    return 1 + s * c["side"] * np.tanh(flow.alpha / np.radians(2))


def lag_time(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """First-order lag of C_L; ``s`` in seconds."""
    k = np.full((2, len(flow.U)), 1 / s)
    return k, np.array([[1.0], [0.0]])


def lag_chords(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """First-order lag of C_L over a distance; ``s`` in m."""
    k = np.repeat((flow.U / s)[None], 2, 0)
    return k, np.array([[1.0], [0.0]])


def lag_wagner(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Wagner: 1 - 0.165 e^(-0.0455 S) - 0.335 e^(-0.3 S), S = 2 U t / s; ``s`` = chord (m)."""
    k = np.array([[0.0455], [0.3]]) * 2 * flow.U / s
    return k, np.array([[0.165], [0.335]])


# -------------------------------------------------------------- water and mass


def current_velocity(
    place: np.ndarray, t: np.ndarray, where: tuple, s: float, c: dict
) -> np.ndarray:
    """Uniform current s (m/s) in direction ``toward``; with ``tau_s`` it decays in a trial."""
    return s * np.exp(1j * c["toward"] - t / c.get("tau_s", np.inf)) * np.ones_like(place)


def gyre_rigid(place: np.ndarray, t: np.ndarray, where: tuple, s: float, c: dict) -> np.ndarray:
    """Rigid rotation about the pool's centre, ``s`` m/s at 0.8 m."""
    return 1j * c["side"] * s * (place - complex(*where[1]) / 2) / 0.8


def gyre_lamb(place: np.ndarray, t: np.ndarray, where: tuple, s: float, c: dict) -> np.ndarray:
    """Lamb-Oseen vortex of core radius ``core_m`` near the centre; peak speed s (m/s)."""
    d = place - complex(*where[1]) / 2 - (c["dx"] + 1j * c["dy"])
    radius = np.abs(d).clip(1e-6)
    swirl = (1 - np.exp(-1.256 * (radius / c["core_m"]) ** 2)) * c["core_m"] / radius / 0.7153
    return 1j * c["side"] * s * swirl * d / radius


def gyre_cell(place: np.ndarray, t: np.ndarray, where: tuple, s: float, c: dict) -> np.ndarray:
    """Taylor-Green cell that fills the pool; maximum speed s (m/s) along the long walls."""
    L, W = where[1]
    X, Y = np.pi * place.real / L, np.pi * place.imag / W
    return c["side"] * s * (-np.sin(X) * np.cos(Y) + 1j * W / L * np.cos(X) * np.sin(Y))


def wake_force(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Drag change s (-) times 1/2 rho A U^2 after one lap; fades with the age T = 2 pi / |r| of

    the wake.
    """
    turned = np.abs(flow.theta - flow.trials.theta0) / (2 * np.pi)
    age = 2 * np.pi / np.abs(flow.r).clip(0.2)
    fade = {0: np.exp(-age / 8), 1: (age / 4) ** (-2 / 3), 2: (age / 4) ** (-4 / 5), 3: 1.0}
    entered = smoothstep((turned - c["from_turns"]) / 0.12)
    laps = (
        1 + 0.5 * smoothstep((turned - c["from_turns"] - 1) / 0.12) if int(c["shape"]) == 3 else 1
    )
    size = s * c["side"] * 0.5 * DENSITY * flow.area * flow.U**2 * entered * laps
    return size * fade[int(c["shape"])] * flow.v_hat, 0 * flow.U


def rotated_added_mass(a: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Added mass (3, 3) of the core frame in the head frame (B, 3, 3): R(phi) A R(phi)^T."""
    R = np.zeros((len(phi), 3, 3))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(phi)
    R[:, 1, 0], R[:, 0, 1], R[:, 2, 2] = np.sin(phi), -np.sin(phi), 1
    return R @ a @ np.swapaxes(R, 1, 2)


def added_mass_spheroid(robot: Robot, phi: np.ndarray, s: float, c: dict) -> np.ndarray:
    """Prolate spheroid of aspect ratio 5 about the centre of mass: k_1 = 0.059, k_2 = 0.895, k' =

    0.70.
    """
    second = robot.mass * robot.body_length**2 / 20
    diagonal = np.array([0.059 * robot.mass, 0.895 * robot.mass, 0.70 * second])
    return rotated_added_mass(s * np.diag(diagonal), phi)


def added_mass_strips(robot: Robot, phi: np.ndarray, s: float, c: dict) -> np.ndarray:
    """Strips pi/4 rho b^2 dx of core and tail behind the hinge, with the sway-yaw coupling."""
    front, back = -robot.hinge_to_com, robot.tail_base + robot.tail_length
    m = s * np.pi / 4 * DENSITY * robot.head_span**2
    powers = [m * (back**n - front**n) / n for n in (1, 2, 3)]
    a = np.zeros((3, 3))
    a[1, 1], a[1, 2], a[2, 1], a[2, 2] = powers[0], -powers[1], -powers[1], powers[2]
    return rotated_added_mass(a, phi)


def added_mass_head_plate(robot: Robot, phi: np.ndarray, s: float, c: dict) -> np.ndarray:
    """Head plate alone, pi/4 rho b^2 h, its centre half a head ahead of the hinge."""
    m = s * np.pi / 4 * DENSITY * robot.head_span**2 * robot.head_length
    x = robot.hinge_to_com + robot.head_length / 2
    a = np.zeros((len(phi), 3, 3))
    a[:, 1, 1], a[:, 1, 2], a[:, 2, 1] = m, m * x, m * x
    a[:, 2, 2] = m * (x * x + robot.head_length**2 / 12)
    return a


def wall_force(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Force from the four walls: attraction ~ (b/d)^2 of the image, or drag ~ exp(-d/lambda)."""
    L, W = flow.world.pool
    x, y = flow.place.real, flow.place.imag
    d = np.maximum(np.stack([x, L - x, y, W - y]), 0.06)
    q = 0.5 * DENSITY * flow.area * flow.U**2
    if int(c["shape"]) == 0:
        pull = (c["size_m"] / d) ** 2
        return s * q * (-pull[0] + pull[1] - 1j * pull[2] + 1j * pull[3]), 0 * q
    near = np.exp(-d / c["size_m"])
    if int(c["shape"]) == 1:
        return -s * q * near.sum(0) * flow.v_hat, 0 * q
    inward = np.array([1, -1, 1j, -1j])[:, None]
    away = planar_moment(flow.head, (near * inward).sum(0))
    return 0 * flow.v, s * 0.1 * q * away


def centre_of_mass_shift(flow: Flow, s: float, c: dict) -> np.ndarray:
    """Vector (m) from ``core_center`` to the true centre of mass: backward or leftward by ``s``."""
    return s * c["side"] * flow.core * (-1 if int(c["shape"]) == 0 else 1j)


# --------------------------------------------------------- functions of time


def step_response(t: np.ndarray, s: float, kind: int) -> np.ndarray:
    """Answer to a step: first order, ramp, critically damped, or dead time and first order."""
    x = t / s
    late = np.maximum(x - 1, 0)
    return [1 - np.exp(-x), np.minimum(x, 1), 1 - (1 + x) * np.exp(-x), 1 - np.exp(-3 * late)][kind]


def servo_lag(phi: np.ndarray, t: np.ndarray, trials: Trials, s: float, c: dict) -> np.ndarray:
    """Head swings from straight to the command; ``s`` in seconds."""
    return phi * step_response(t, s, int(c["shape"]))


def motor_spin_up(f: np.ndarray, t: np.ndarray, trials: Trials, s: float, c: dict) -> np.ndarray:
    """Motor runs up from standstill; ``s`` in seconds."""
    return f * step_response(t + 1e-3, s, int(c["shape"]))


def battery_sag(f: np.ndarray, t: np.ndarray, trials: Trials, s: float, c: dict) -> np.ndarray:
    """Frequency falls within a trial: linear, to a plateau, as sqrt(t), or with power squared."""
    x = t / 5
    shapes = [x, 1.6 * (1 - np.exp(-2 * x)) / 1.6, np.sqrt(x), x * (trials.power / 75) ** 2]
    return f * (1 - s * np.minimum(shapes[int(c["shape"])], 0.9 / max(s, 0.9)))


def head_angle_offset(
    phi: np.ndarray, t: np.ndarray, trials: Trials, s: float, c: dict
) -> np.ndarray:
    """Lasting error of the head angle: constant, gain, or play of the hinge; ``s`` in degrees at

    30.
    """
    shapes = [1.0, phi / np.radians(30), np.tanh(phi / np.radians(5))]
    return phi + np.radians(s * c["side"]) * shapes[int(c["shape"])]


# ----------------------------------------------------------- unlisted forces


def random_feature_force(flow: Flow, s: float, c: dict) -> tuple[np.ndarray, np.ndarray]:
    """Force s sum a_j cos(w_j z + b_j) on one state variable z (Rahimi & Recht 2007)."""
    z = {
        "heading_rad": flow.theta, "x_m": flow.place.real, "y_m": flow.place.imag,
        "time_s": flow.t, "speed_m_s": flow.U,
    }[c["variable"]]  # fmt: skip
    g = sum(a * np.cos(w * z + b) for a, w, b in zip(c["a"], c["w"], c["b"], strict=True))
    g = s * g * flow.U**2 / (flow.U**2 + 0.05**2)
    direction = {"surge": flow.head, "sway": 1j * flow.head, "yaw": 0 * flow.head}[c["axis"]]
    return g * direction, g * (c["axis"] == "yaw")


def draw_unlisted(rng: np.random.Generator) -> tuple[Form, dict]:
    """Form and constants of an unlisted force; frequencies avoid what a named cause can imitate."""
    variable = str(rng.choice(["heading_rad", "x_m", "y_m", "time_s", "speed_m_s"]))
    axis = str(rng.choice(["sway", "yaw"] if variable == "speed_m_s" else ["surge", "sway", "yaw"]))
    count = int(rng.integers(2, 5))
    scale = {"heading_rad": None, "x_m": (0.6, 1.2), "y_m": (0.5, 0.9)}
    scale |= {"time_s": (1.5, 3.5), "speed_m_s": (0.12, 0.3)}
    if variable == "heading_rad":  # whole harmonics above those of a current
        w = rng.choice([2, 3, 4], min(count, 3), replace=False).astype(float)
    else:
        w = 2 * np.pi / rng.uniform(*scale[variable], count)
    a, b = rng.normal(size=len(w)), rng.uniform(0, 2 * np.pi, len(w))
    a = a * np.sqrt(2 / np.sum(a * a))
    bounds, unit = ((2e-4, 0.03), "N m") if axis == "yaw" else ((2e-3, 0.4), "N")
    form = Form(
        "unlisted",
        "random Fourier features",
        "force",
        random_feature_force,
        "amplitude",
        unit,
        *bounds,
        "Rahimi & Recht 2007",
    )
    return form, {"variable": variable, "axis": axis, "a": a, "w": w, "b": b, "side": 1.0}


def no_force(*_: object) -> None:
    """Law of an effect that acts on the observation only."""


def variant_ranges(k: float, **others: tuple) -> dict:
    """Ranges with the discrete variant ``k`` and others."""
    return {"shape": (k, k)} | others


FIN_RANGES = {"arm_m": (0.12, 0.20), "aspect": (0.6, 1.6)}
STALL_RANGES = {"alpha_s": (0.05, 0.12), "width": (0.02, 0.05)}
STRIDE_RANGES = {"stride_m": (0.13, 0.18)}
DIRECTION_RANGES = {"toward": (-np.pi, np.pi)}

FORMS: tuple[Form, ...] = (
    Form(
        "tail_fin_lift",
        "jones",
        "force",
        fin_jones,
        "area",
        "m2",
        5e-4,
        0.05,
        "Jones 1946, NACA 835",
        FIN_RANGES,
    ),
    Form(
        "tail_fin_lift",
        "helmbold",
        "force",
        fin_helmbold,
        "area",
        "m2",
        5e-4,
        0.05,
        "Helmbold 1942",
        FIN_RANGES,
    ),
    Form(
        "tail_fin_lift",
        "polhamus",
        "force",
        fin_polhamus,
        "area",
        "m2",
        5e-4,
        0.05,
        "Polhamus 1966",
        FIN_RANGES,
    ),
    Form(
        "tail_fin_lift",
        "slender",
        "force",
        fin_slender_body,
        "span_squared",
        "m2",
        5e-4,
        0.05,
        "Lighthill 1960, J. Fluid Mech. 9",
        {"arm_m": (0.16, 0.235)},
    ),
    Form(
        "added_mass",
        "spheroid",
        "mass",
        added_mass_spheroid,
        "factor",
        "1",
        0.02,
        1.3,
        "Lamb 1932 art. 114",
    ),
    Form(
        "added_mass",
        "strip",
        "mass",
        added_mass_strips,
        "factor",
        "1",
        0.02,
        1.3,
        "Newman 1977 ch. 4",
    ),
    Form(
        "added_mass",
        "head_plate",
        "mass",
        added_mass_head_plate,
        "factor",
        "1",
        0.02,
        1.3,
        "Newman 1977 ch. 4",
    ),
    Form(
        "viscous_drag",
        "stokes",
        "force",
        power_law_drag,
        "k",
        "N s/m",
        5e-3,
        0.8,
        "Fossen 2011 sec. 6.4",
        {"n": (1, 1)},
    ),
    Form(
        "viscous_drag",
        "blasius",
        "force",
        power_law_drag,
        "k",
        "N/(m/s)^1.5",
        5e-3,
        1.2,
        "Blasius 1908",
        {"n": (1.5, 1.5)},
    ),
    Form(
        "viscous_drag",
        "low_reynolds",
        "force",
        power_law_drag,
        "k",
        "N/(m/s)^1.25",
        5e-3,
        1.0,
        "White 2006 sec. 3-8",
        {"n": (1.25, 1.25)},
    ),
    Form(
        "viscous_drag",
        "ittc57",
        "force",
        ittc_drag,
        "wetted_area",
        "m2",
        0.02,
        0.5,
        "ITTC 1957",
        {"length_m": (0.3, 0.3)},
    ),
    Form(
        "linear_yaw_damping",
        "linear",
        "force",
        yaw_damping,
        "N_r",
        "N m s",
        5e-4,
        0.08,
        "Fossen 2011 sec. 6.4",
        {"n": (1, 1)},
    ),
    Form(
        "linear_yaw_damping",
        "boundary_layer",
        "force",
        yaw_damping,
        "N_r",
        "N m s^1.3",
        5e-4,
        0.1,
        "Schlichting 1979 ch. 7",
        {"n": (1.3, 1.3)},
    ),
    Form(
        "linear_yaw_damping",
        "strips",
        "force",
        yaw_damping_strips,
        "N_r",
        "N m s",
        5e-4,
        0.08,
        "Lewandowski 2004 ch. 5",
        {"lever_m": (0.08, 0.15)},
    ),
    Form(
        "thrust_loss_with_speed",
        "linear",
        "thrust",
        thrust_loss_power,
        "loss",
        "1",
        0.05,
        0.9,
        "Carlton 2012 ch. 6",
        STRIDE_RANGES | {"n": (1, 1)},
    ),
    Form(
        "thrust_loss_with_speed",
        "lighthill",
        "thrust",
        thrust_loss_power,
        "loss",
        "1",
        0.05,
        0.9,
        "Lighthill 1971, Proc. R. Soc. B 179",
        STRIDE_RANGES | {"n": (2, 2)},
    ),
    Form(
        "thrust_loss_with_speed",
        "actuator_disc",
        "thrust",
        thrust_loss_actuator_disc,
        "loading",
        "1",
        0.05,
        2.0,
        "Froude 1889; Rankine 1865",
        STRIDE_RANGES,
    ),
    Form(
        "thrust_loss_with_speed",
        "exponential",
        "thrust",
        thrust_loss_exponential,
        "loss",
        "1",
        0.05,
        2.0,
        "Oosterveld 1975, fits",
        {"U0_m_s": (0.4, 0.6)},
    ),
    Form(
        "uniform_current",
        "steady",
        "water",
        current_velocity,
        "speed",
        "m/s",
        5e-4,
        0.08,
        "Fossen 2011 ch. 8",
        DIRECTION_RANGES,
    ),
    Form(
        "uniform_current",
        "decaying",
        "water",
        current_velocity,
        "speed",
        "m/s",
        5e-4,
        0.1,
        "Fossen 2011 ch. 8",
        DIRECTION_RANGES | {"tau_s": (3, 8)},
    ),
    Form(
        "pool_gyre",
        "rigid",
        "water",
        gyre_rigid,
        "speed",
        "m/s",
        5e-4,
        0.1,
        "Batchelor 1967",
        {},
        True,
    ),
    Form(
        "pool_gyre",
        "lamb_oseen",
        "water",
        gyre_lamb,
        "speed",
        "m/s",
        5e-4,
        0.12,
        "Lamb 1932 art. 334a",
        {"core_m": (0.3, 0.6), "dx": (-0.3, 0.3), "dy": (-0.15, 0.15)},
        True,
    ),
    Form(
        "pool_gyre",
        "taylor_green",
        "water",
        gyre_cell,
        "speed",
        "m/s",
        5e-4,
        0.1,
        "Taylor & Green 1937",
        {},
        True,
    ),
    Form(
        "wall_effect",
        "image_attraction",
        "force",
        wall_force,
        "factor",
        "1",
        0.02,
        3,
        "Newman 1965",
        variant_ranges(0, size_m=(0.08, 0.15)),
    ),
    Form(
        "wall_effect",
        "drag_rise",
        "force",
        wall_force,
        "factor",
        "1",
        0.02,
        3,
        "Hoerner 1965 ch. 10",
        variant_ranges(1, size_m=(0.12, 0.3)),
    ),
    Form(
        "wall_effect",
        "turning_moment",
        "force",
        wall_force,
        "factor",
        "1",
        0.02,
        3,
        "Norrbin 1974",
        variant_ranges(2, size_m=(0.12, 0.3)),
    ),
    Form(
        "stall",
        "sigmoid",
        "lift",
        stall_sigmoid,
        "loss",
        "1",
        0.05,
        0.95,
        "Beard & McLain 2012 p. 47",
        STALL_RANGES,
    ),
    Form(
        "stall",
        "linear",
        "lift",
        stall_linear,
        "loss",
        "1",
        0.05,
        0.95,
        "Hoerner 1975 ch. 4",
        STALL_RANGES,
    ),
    Form(
        "stall",
        "separation_point",
        "lift",
        stall_separation,
        "weight",
        "1",
        0.05,
        1.3,
        "Leishman & Beddoes 1989",
        STALL_RANGES,
    ),
    Form(
        "stall",
        "viterna",
        "lift",
        stall_viterna,
        "weight",
        "1",
        0.05,
        1.3,
        "Viterna & Corrigan 1982",
        STALL_RANGES,
    ),
    *(
        Form(
            "servo_lag",
            name,
            "head_angle",
            servo_lag,
            "time",
            "s",
            0.02,
            1.5,
            source,
            variant_ranges(k),
        )
        for k, (name, source) in enumerate(
            [
                ("first_order", "Franklin 2010 sec. 3.3"),
                ("rate_limit", "Fossen 2011 sec. 9.5"),
                ("second_order", "Franklin 2010 sec. 3.4"),
                ("dead_time", "Astrom & Hagglund 1995 ch. 2"),
            ]
        )
    ),
    Form(
        "motor_spin_up",
        "first_order",
        "frequency",
        motor_spin_up,
        "time",
        "s",
        0.02,
        2.5,
        "Krause 2013 ch. 3",
        variant_ranges(0),
    ),
    Form(
        "motor_spin_up",
        "ramp",
        "frequency",
        motor_spin_up,
        "time",
        "s",
        0.02,
        3,
        "Krause 2013 ch. 3",
        variant_ranges(1),
    ),
    Form(
        "motor_spin_up",
        "second_order",
        "frequency",
        motor_spin_up,
        "time",
        "s",
        0.02,
        1.5,
        "Franklin 2010 sec. 3.4",
        variant_ranges(2),
    ),
    *(
        Form(
            "battery_sag",
            name,
            "frequency",
            battery_sag,
            "fall_in_5_s",
            "1",
            5e-3,
            0.3,
            source,
            variant_ranges(k),
        )
        for k, (name, source) in enumerate(
            [
                ("linear", "Tremblay 2009"),
                ("plateau", "Shepherd 1965"),
                ("square_root", "Doyle 1993"),
                ("load", "Peukert 1897"),
            ]
        )
    ),
    Form(
        "trim_moment",
        "flow",
        "force",
        trim_with_flow,
        "C_M0",
        "m",
        5e-5,
        0.02,
        "Etkin 1996 ch. 2",
        {"n": (2, 2)},
        True,
    ),
    Form(
        "trim_moment",
        "tail_beat",
        "thrust_moment",
        trim_with_thrust,
        "lever",
        "m",
        5e-5,
        0.02,
        "Lighthill 1971",
        {},
        True,
    ),
    Form(
        "head_angle_offset",
        "constant",
        "head_angle",
        head_angle_offset,
        "offset",
        "deg",
        0.1,
        8,
        "rig geometry",
        variant_ranges(0),
        True,
    ),
    Form(
        "head_angle_offset",
        "gain",
        "head_angle",
        head_angle_offset,
        "offset",
        "deg",
        0.1,
        10,
        "linkage ratio",
        variant_ranges(1),
        True,
    ),
    Form(
        "head_angle_offset",
        "play",
        "head_angle",
        head_angle_offset,
        "offset",
        "deg",
        0.1,
        8,
        "backlash, Nordin 2002",
        variant_ranges(2),
        True,
    ),
    Form(
        "crossflow_drag",
        "strips",
        "force",
        crossflow_strips,
        "C_d",
        "1",
        0.02,
        4,
        "Taylor 1952; Hoerner 1965 ch. 3",
    ),
    Form(
        "crossflow_drag",
        "tapered",
        "force",
        crossflow_strips,
        "C_d",
        "1",
        0.02,
        4,
        "Faltinsen 1990 ch. 6",
        {"taper": (0.4, 1.0)},
    ),
    Form(
        "crossflow_drag",
        "lumped",
        "force",
        crossflow_strips,
        "C_d",
        "1",
        0.02,
        4,
        "Fossen 2011 sec. 6.4",
        {"count": (1, 1)},
    ),
    Form(
        "crossflow_drag",
        "inclined",
        "force",
        crossflow_strips,
        "C_d",
        "1",
        0.02,
        6,
        "Hoerner 1965 p. 3-11",
        {"inclined": (1, 1)},
    ),
    *(
        Form(
            "thrust_line_offset",
            name,
            "thrust_moment",
            thrust_line_offset,
            "lever",
            "m",
            1e-4,
            0.1,
            source,
            variant_ranges(k),
            True,
        )
        for k, (name, source) in enumerate(
            [
                ("sine", "hinge geometry"),
                ("proportional", "first order in phi"),
                ("root", "soft joint"),
            ]
        )
    ),
    Form(
        "thrust_area",
        "power",
        "thrust",
        thrust_area_power,
        "exponent",
        "1",
        0.05,
        1.6,
        "dimensional analysis",
    ),
    Form(
        "thrust_area",
        "blend",
        "thrust",
        thrust_area_blend,
        "weight",
        "1",
        0.05,
        1.4,
        "momentum theory",
    ),
    Form("lift_lag", "fixed_time", "lag", lag_time, "time", "s", 0.03, 1.2, "Fossen 2011 sec. 9.5"),
    Form(
        "lift_lag",
        "convective",
        "lag",
        lag_chords,
        "distance",
        "m",
        0.005,
        0.6,
        "Leishman 2006 ch. 8",
    ),
    Form(
        "lift_lag", "wagner", "lag", lag_wagner, "chord", "m", 0.01, 1.0, "Wagner 1925; Jones 1938"
    ),
    Form(
        "wave_drag",
        "fourth_power",
        "force",
        power_law_drag,
        "k",
        "N/(m/s)^4",
        0.05,
        20,
        "Newman 1977 ch. 6",
        {"n": (4, 4)},
    ),
    Form(
        "wave_drag",
        "sixth_power",
        "force",
        power_law_drag,
        "k",
        "N/(m/s)^6",
        0.05,
        60,
        "Michell 1898, thin ships at low Froude",
        {"n": (6, 6)},
    ),
    Form(
        "wave_drag",
        "hump",
        "force",
        wave_drag_hump,
        "k",
        "N s2/m2",
        0.02,
        12,
        "Havelock 1917",
        {"hump_m_s": (0.4, 0.7)},
    ),
    Form(
        "coulomb_friction",
        "translation",
        "force",
        coulomb_friction,
        "force",
        "N",
        5e-4,
        0.1,
        "Coulomb 1785",
    ),
    Form(
        "coulomb_friction",
        "stribeck",
        "force",
        coulomb_friction,
        "force",
        "N",
        5e-4,
        0.1,
        "Stribeck 1902",
        {"stribeck": (0.5, 1.5)},
    ),
    Form(
        "coulomb_friction",
        "with_yaw",
        "force",
        coulomb_friction_with_yaw,
        "force",
        "N",
        5e-4,
        0.1,
        "Goyal 1991",
        {"radius_m": (0.03, 0.1)},
    ),
    *(
        Form(
            "wake_reentry",
            name,
            "force",
            wake_force,
            "factor",
            "1",
            0.02,
            1.5,
            source,
            variant_ranges(k, from_turns=(0.85, 0.98)),
            True,
        )
        for k, (name, source) in enumerate(
            [
                ("decaying", "Tennekes & Lumley 1972 ch. 4"),
                ("momentum", "Tennekes & Lumley 1972 sec. 4.2"),
                ("momentumless", "Birkhoff & Zarantonello 1957"),
                ("laps", "Tritton 1988 ch. 11"),
            ]
        )
    ),
    *(
        Form(
            "sinking",
            name,
            "observe",
            no_force,
            "rate",
            "m/s",
            2e-4,
            0.03,
            source,
            variant_ranges(k),
        )
        for k, (name, source) in enumerate(
            [("steady", "Stokes 1851"), ("from_rest", "Newton"), ("settling", "ballast leak")]
        )
    ),
    Form(
        "centre_of_mass_shift",
        "longitudinal",
        "mass_centre",
        centre_of_mass_shift,
        "shift",
        "m",
        5e-4,
        0.05,
        "ballast",
        variant_ranges(0),
        True,
    ),
    Form(
        "centre_of_mass_shift",
        "lateral",
        "mass_centre",
        centre_of_mass_shift,
        "shift",
        "m",
        2e-4,
        0.02,
        "ballast",
        variant_ranges(1),
        True,
    ),
    Form(
        "port_starboard_asymmetry",
        "lift",
        "lift",
        asymmetric_lift,
        "fraction",
        "1",
        5e-3,
        0.5,
        "cambered plate",
        {},
        True,
    ),
    Form(
        "port_starboard_asymmetry",
        "thrust",
        "thrust",
        asymmetric_thrust,
        "fraction",
        "1",
        5e-3,
        0.5,
        "uneven stroke",
        {},
        True,
    ),
    *(
        Form(
            name,
            form,
            "report",
            no_force,
            parameter,
            unit,
            low,
            high,
            source,
            variant_ranges(k),
            True,
        )
        for name, k, form, parameter, unit, low, high, source in (
            ("scale_error", 0, "pool_lengths", "factor", "1", 3e-3, 0.12, "tape"),
            ("scale_error", 1, "length_only", "factor", "1", 3e-3, 0.12, "tape"),
            ("scale_error", 2, "corners", "factor", "1", 3e-3, 0.12, "marks on the inner rim"),
            ("clock_error", 0, "all_trials", "factor", "1", 1e-3, 0.08, "wrong frame rate"),
            ("clock_error", 1, "half_of_trials", "factor", "1", 1e-3, 0.08, "two cameras"),
            ("camera_shift", 0, "step_within_trials", "shift", "px", 0.3, 60, "displaced mount"),
            ("camera_shift", 1, "drift", "shift", "px", 0.3, 80, "slow mount, px in 5 s"),
            ("camera_shift", 2, "roll_drift", "roll", "deg", 0.02, 5, "slow mount, degrees in 5 s"),
            ("uncorrected_refraction", 0, "index_one", "depth", "m", 0.03, 0.2, "dry calibration"),
            (
                "uncorrected_refraction",
                1,
                "depth_understated",
                "depth_error",
                "m",
                0.01,
                0.2,
                "ruler",
            ),
            (
                "lens_error",
                0,
                "radial",
                "k1_error",
                "1",
                2e-3,
                0.25,
                "Brown 1966; Kannala & Brandt 2006",
            ),
            ("lens_error", 1, "second_radial", "k2_error", "1", 2e-3, 0.4, "Brown 1966"),
            ("lens_error", 2, "principal_point", "shift", "px", 3, 250, "cropped calibration"),
            ("time_offset", 0, "video_early", "delay", "s", 5e-3, 0.6, "trigger"),
            ("time_offset", 1, "jittered", "delay", "s", 5e-3, 0.6, "manual start"),
            (
                "keypoint_bias",
                0,
                "core_along",
                "shift",
                "m",
                5e-4,
                0.04,
                "label placed off the centre",
            ),
            (
                "keypoint_bias",
                1,
                "core_across",
                "shift",
                "m",
                5e-4,
                0.03,
                "label placed off the centre",
            ),
            (
                "keypoint_bias",
                2,
                "head_across",
                "shift",
                "m",
                5e-4,
                0.02,
                "parallax of the head's edge",
            ),
        )
    ),
)


def forms_of(name: str) -> list[Form]:
    """All functional forms of a named cause."""
    return [form for form in FORMS if form.name == name]


def cause_names(kind: str) -> list[str]:
    """Names of the ``physics`` causes (without the fin) or of the ``measurement`` causes."""
    chosen = (f.name for f in FORMS if (f.channel == "report") == (kind == "measurement"))
    return [name for name in dict.fromkeys(chosen) if name != "tail_fin_lift"]
