"""Manoeuvring in dimensionless (prime) form: linear, with drag across the flow.

    v' = U/L (Y_v v + Y_r r L) + U^2/L Y_d delta - Y_vv v |v| / L
    r' = U/L^2 (N_v v + N_r r L) + U^2/L^2 N_d delta - N_rr r |r|
    u' = X_0 (U_0^2 - u^2) / L

The propeller holds up the speed. The ship is unstable on a straight course: without the quadratic
terms it has no steady turn, and simulated turning circles run away.

Accelerations are taken in the ship's frame, the turning of the frame is in Y_r. Positions in the
tank, x ahead and y to starboard, heading and rudder clockwise positive (rad).
Source: Fossen (2011), sec. 7.1 (linear manoeuvring theory, prime system), 7.1.2 (second-order
modulus and cubic terms); single-screw asymmetry as constant force and moment.
"""

# ruff: noqa: PLR0913, PLR0917 -- arguments are named after what an equation needs
from __future__ import annotations

import numpy as np

from bluekoi.data import Float
from bluekoi.explain import Cause, Constant, Input, Model, Observation, Parameter, Stage, State
from bluekoi.integrate.branchless import sin_cos

from .reading import read_folder

LENGTH_M = 7.0
Three = tuple[float, float, float]

COEFFICIENTS = (
    Parameter("X_0", "1", 0.05, 0.0, 2.0, "return to the speed of straight course"),
    Parameter("U_0", "m/s", 1.18, 0.8, 1.6, "speed of straight course"),
    Parameter("Y_v", "1", -0.7, -10.0, 5.0, "sway damping"),
    Parameter("Y_r", "1", -0.3, -10.0, 5.0, "sway from turning, centripetal part included"),
    Parameter("Y_d", "1", 0.1, -5.0, 5.0, "sway from the rudder"),
    Parameter("N_v", "1", -2.0, -30.0, 30.0, "yaw from drift"),
    Parameter("N_r", "1", -2.0, -30.0, 5.0, "yaw damping"),
    Parameter("N_d", "1", 1.0, -10.0, 10.0, "yaw from the rudder"),
    Parameter("Y_vv", "1", 0.3, -20.0, 40.0, "drag across the flow in sway"),
    Parameter("N_rr", "1", 0.3, -20.0, 40.0, "drag across the flow in yaw"),
)


def steer(rudder: float) -> tuple[float]:
    """Rudder angle (rad)."""
    return (rudder,)


def sailed(u: float, v: float) -> tuple[float]:
    """Speed through the water (m/s)."""
    return ((u * u + v * v + 1e-9) ** 0.5,)


def acceleration(
    u: float,
    v: float,
    r: float,
    U: float,
    delta: float,
    L: float,
    X_0: float,
    U_0: float,
    Y_v: float,
    Y_r: float,
    Y_d: float,
    N_v: float,
    N_r: float,
    N_d: float,
    Y_vv: float,
    N_rr: float,
) -> Three:
    """Surge, sway (m/s2) and yaw (rad/s2)."""
    X = X_0 * (U_0 * U_0 - u * u) / L
    Y = (U * (Y_v * v + Y_r * r * L) + U * U * Y_d * delta - Y_vv * v * abs(v)) / L
    N = (U * (N_v * v + N_r * r * L) + U * U * N_d * delta) / (L * L) - N_rr * r * abs(r)
    return X, Y, N


def motion(
    psi: float, u: float, v: float, r: float, wx: float, wy: float, X: float, Y: float, N: float
) -> tuple[float, float, float, float, float, float]:
    """Derivatives of x, y, psi, u, v, r; water that moves (wx, wy) carries the ship along."""
    s, c = sin_cos(psi)
    return u * c - v * s + wx, u * s + v * c + wy, r, X, Y, N


def seen(x: float, y: float, psi: float) -> Three:
    """Place (m) and heading (rad)."""
    return x, y, psi


def speed_loss(v: float, r: float, L: float, X_vv: float, X_vr: float, X_rr: float) -> Three:
    """X = (X_vv v^2 + X_vr v r L + X_rr r^2 L^2) / L."""
    rl = r * L
    return (X_vv * v * v + X_vr * v * rl + X_rr * rl * rl) / L, 0.0, 0.0


def rudder_drag(U: float, delta: float, L: float, X_dd: float) -> Three:
    """X = -X_dd U^2 delta^2 / L."""
    return -X_dd * U * U * delta * delta / L, 0.0, 0.0


def single_screw(U: float, L: float, Y_0: float, N_0: float) -> Three:
    """Y = Y_0 U^2 / L, N = N_0 U^2 / L^2, to one side whatever the ship does."""
    return 0.0, Y_0 * U * U / L, N_0 * U * U / (L * L)


def slipstream(U: float, delta: float, L: float, U_0: float, k: float, k_y: float) -> Three:
    """The rudder's moment and side force grow by k and k_y times (U_0 / U - 1), in units of
    U^2 / L^2 delta and U^2 / L delta: the screw keeps blowing on the rudder as speed falls.
    """
    blown = (U_0 / U - 1.0) * U * U / L * delta
    return 0.0, k_y * blown, k * blown / L


def cubic(v: float, r: float, U: float, L: float, N_vvr: float, N_vrr: float) -> Three:
    """N = (N_vvr v^2 r L + N_vrr v r^2 L^2) / (U L^2)."""
    rl = r * L
    return 0.0, 0.0, (N_vvr * v * v * rl + N_vrr * v * rl * rl) / (U * L * L)


def drift_asymmetry(v: float, L: float, k: float) -> Three:
    """N = k v^2 / L^2: drift to one side turns the ship more than to the other."""
    return 0.0, 0.0, k * v * v / (L * L)


def rudder_zero(d: float) -> tuple[float]:
    """Delta = read + d."""
    return (d,)


def stalled(rudder: float, k: float) -> tuple[float]:
    """Delta = read - k read^3: the rudder stalls at large angles."""
    return (-k * rudder * rudder * rudder,)


def set_by(c_x: float, c_y: float) -> tuple[float, float]:
    """Velocity of the water in the tank (m/s)."""
    return c_x, c_y


def heading_zero(d: float) -> Three:
    """The heading reads d beside the ship's axis."""
    return 0.0, 0.0, d


CAUSES = (
    Cause(
        "speed_loss",
        "Drifting and turning cost speed.",
        {"force": speed_loss},
        (
            Parameter("X_vv", "1", -0.1, -10.0, 10.0, "from drift"),
            Parameter("X_vr", "1", 0.1, -10.0, 10.0, "from drift and turn"),
            Parameter("X_rr", "1", -0.02, -10.0, 10.0, "from turn"),
        ),
        strengths=3,
    ),
    Cause(
        "rudder_drag",
        "A rudder put over costs speed.",
        {"force": rudder_drag},
        (Parameter("X_dd", "1", 0.02, -2.0, 5.0, "per rudder angle squared"),),
    ),
    Cause(
        "single_screw",
        "The single screw pushes the stern to one side.",
        {"force": single_screw},
        (
            Parameter("Y_0", "1", 0.001, -0.5, 0.5, "side force"),
            Parameter("N_0", "1", 0.005, -0.5, 0.5, "moment"),
        ),
        strengths=2,
    ),
    Cause(
        "rudder_zero",
        "The rudder's zero is not amidships.",
        {"steer": rudder_zero},
        (Parameter("d", "rad", 0.005, -0.2, 0.2, "offset"),),
        kind="measurement",
    ),
    Cause(
        "rudder_stall",
        "The rudder loses force at large angles.",
        {"steer": stalled},
        (Parameter("k", "1/rad2", 0.2, -2.5, 2.5, "share lost per angle squared"),),
    ),
    Cause(
        "slipstream",
        "The screw keeps blowing on the rudder as the ship slows down.",
        {"force": slipstream},
        (
            Parameter("k", "1", 0.2, -10.0, 10.0, "of the moment"),
            Parameter("k_y", "1", 0.05, -5.0, 5.0, "of the side force"),
        ),
        strengths=2,
    ),
    Cause(
        "drift_and_turn",
        "The yaw moment of drifting and turning at once is not linear.",
        {"force": cubic},
        (
            Parameter("N_vvr", "1", -1.0, -300.0, 300.0, "drift squared times turn"),
            Parameter("N_vrr", "1", 1.0, -300.0, 300.0, "drift times turn squared"),
        ),
        strengths=2,
    ),
    Cause(
        "drift_asymmetry",
        "Drift to port and to starboard turn the ship unequally.",
        {"force": drift_asymmetry},
        (Parameter("k", "1", 0.2, -50.0, 50.0, "per drift squared"),),
    ),
    Cause(
        "current",
        "The water in the tank moves.",
        {"water": set_by},
        (
            Parameter("c_x", "m/s", 0.003, -0.3, 0.3, "along x"),
            Parameter("c_y", "m/s", 0.003, -0.3, 0.3, "along y"),
        ),
        strengths=2,
        site=True,
    ),
    Cause(
        "heading_zero",
        "The heading is read beside the ship's axis.",
        {"observe": heading_zero},
        (Parameter("d", "rad", 0.003, -0.2, 0.2, "offset"),),
        kind="measurement",
    ),
)


def start(times: Float, seen: Float) -> tuple[float, ...]:
    """State at the first frame, from the first seconds."""
    first = times <= times[min(len(times) - 1, 4)] + 1.0
    (x, y, psi), (vx, vy, r) = np.polynomial.polynomial.polyfit(
        times[first] - times[0], seen[first], 1
    )
    c, s = np.cos(psi), np.sin(psi)
    return x, y, psi, vx * c + vy * s, vy * c - vx * s, r


def measures(_: Float, seen: Float, inputs: Float) -> dict[str, float]:
    """Of a turning circle: advance at a change of heading by 90 degrees, tactical diameter at 180
    degrees (m), from where the rudder is put over, along and across the approach.

    Source: ITTC 7.5-04-02-01 (2021), Full scale manoeuvring trials, sec. 2.3.
    """
    rudder = np.abs(inputs[:, 0])
    order = int(np.argmax(rudder > 0.5 * rudder.max()))
    turned = np.abs(seen[:, 2] - seen[order, 2])
    c, s = np.cos(seen[order, 2]), np.sin(seen[order, 2])
    along = (seen[:, 0] - seen[order, 0]) * c + (seen[:, 1] - seen[order, 1]) * s
    across = (seen[:, 1] - seen[order, 1]) * c - (seen[:, 0] - seen[order, 0]) * s
    out = {}
    for name, degrees, way in (("advance_m", 90.0, along), ("tactical_diameter_m", 180.0, across)):
        past = np.flatnonzero(turned >= np.radians(degrees))
        if len(past) and past[0] > order:
            pair = [past[0] - 1, past[0]]
            out[name] = abs(float(np.interp(np.radians(degrees), turned[pair], way[pair])))
    return out


MODEL = Model(
    name="ship_zigzag",
    states=(
        State("x", "m", 0.05),
        State("y", "m", 0.05),
        State("psi", "rad", 0.02),
        State("u", "m/s", 0.05),
        State("v", "m/s", 0.05),
        State("r", "rad/s", 0.01),
    ),
    inputs=(Input("rudder", "rad"),),
    observations=(
        Observation("x_seen", "m", 0.003),
        Observation("y_seen", "m", 0.003),
        Observation("heading", "rad", 0.001, angle=True),
    ),
    constants=(Constant("L", "m", LENGTH_M),),
    coefficients=COEFFICIENTS,
    stages=(
        Stage("steer", ("delta",), steer, open=True),
        Stage("sailed", ("U",), sailed),
        Stage("force", ("X", "Y", "N"), acceleration, open=True),
        Stage("water", ("wx", "wy"), None, open=True),
        Stage("rates", ("x", "y", "psi", "u", "v", "r"), motion),
        Stage("observe", ("x_seen", "y_seen", "heading"), seen),
    ),
    causes=CAUSES,
    random_force_s=(2.0, 0.2, 5.0),
    error_s=(1.0, 0.1, 5.0),
    path=("x_seen", "y_seen"),
    start=start,
    measures=measures,
    most_hz=1.0,
    read=read_folder,
)
"""A towing tank is still: random forces are forgotten within 5 s at most."""
