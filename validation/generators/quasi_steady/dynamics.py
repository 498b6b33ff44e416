"""Surge, sway and yaw of the robot in the head plate's axes, and their adaptive integration.

State (7): x, y (m, pool frame, centre of mass), theta (rad, head plate), u, v (m/s, velocity over
ground along and to the left of the head plate), r (rad/s), z (m^2/s^2, lagged value of -2 u v).
Signs as in MODEL.md: alpha = -atan2(v, u), so sin(2 alpha) V^2 = -2 u v.
"""

# ruff: noqa: PLR0917 - compiled laws share one signature and take no keywords

from typing import NamedTuple

import numpy as np
from numba import njit

from validation.generators.quasi_steady.laws import lag_rate, total_force, water_velocity

STEP_S = 0.005  # s, spacing of the schedule's rows
STATE_SIZE = 7
RK_NODES = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
RK_TABLEAU = np.array([
    [0, 0, 0, 0, 0, 0],
    [1 / 5, 0, 0, 0, 0, 0],
    [3 / 40, 9 / 40, 0, 0, 0, 0],
    [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
    [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
])  # fmt: skip
RK_ERROR_WEIGHTS = np.array(
    [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]
)


class Robot(NamedTuple):
    """Constants of one trial: fluid, geometry with this trial's head, the six coefficients."""

    rho: float  # kg/m3
    mass: float  # kg
    inertia: float  # kg m2
    head: float  # m, nose to hinge
    span: float  # m
    area: float  # m2, head plate
    arm: float  # m, centre of mass to aerodynamic centre
    hinge: float  # m, hinge to stated centre of mass
    base: float  # m, stated centre of mass to caudal base
    tail: float  # m, caudal base to tail tip
    C_T: float  # m2
    C_D0: float
    C_Da: float
    C_La: float
    C_Ma: float  # m
    C_Md: float  # kg m2
    area_ref: float  # m2, the 1x head
    added_surge: float  # kg, along the core
    added_sway: float  # kg, across the core
    added_yaw: float  # kg m2
    shift_aft: float  # m, true centre of mass behind the stated one
    shift_left: float  # m
    length: float  # m, pool
    width: float  # m, pool


class Flow(NamedTuple):
    """What a force law sees: time, pose, velocity relative to the water, head angle, thrust."""

    t: float
    x: float
    y: float
    theta: float
    u: float
    v: float
    r: float
    speed: float
    phi: float
    flap: float
    thrust: float
    z: float


@njit(cache=True)
def schedule_at(schedule, t):
    """Row of the schedule (phi, flap_hz, gust_x, gust_y) at time t, linear between rows."""
    at = max(t / STEP_S, 0.0)
    i = min(int(at), schedule.shape[0] - 2)
    w = min(at - i, 1.0)
    return schedule[i] * (1 - w) + schedule[i + 1] * w


@njit(cache=True)
def flow_at(t, s, robot, table, schedule, path):
    """Relative flow at the centre of mass and the water velocity in head axes."""
    phi, flap, wx, wy = schedule_at(schedule, t)
    dx, dy, spin = water_velocity(t, s[0], s[1], table, path, robot)
    wx, wy = wx + dx, wy + dy
    c, n = np.cos(s[2]), np.sin(s[2])
    bu, bv = c * wx + n * wy, c * wy - n * wx
    u, v = s[3] - bu, s[4] - bv
    thrust = robot.C_T * 0.5 * robot.rho * robot.area * flap * flap  # (1)
    speed = np.sqrt(u * u + v * v)
    flow = Flow(t, s[0], s[1], s[2], u, v, s[5] - spin, speed, phi, flap, thrust, s[6])
    return flow, bu, bv


@njit(cache=True)
def plate_force(flow, robot):
    """Head-plate force and moment, equations (1) to (7), about the true centre of mass."""
    q = 0.5 * robot.rho * robot.area
    u, v, speed = flow.u, flow.v, flow.speed + 1e-12
    lift = -2 * q * robot.C_La * u * v / speed  # times (-v, u)
    drag = q * (robot.C_D0 * speed + 2 * robot.C_Da * v * v / speed)  # times -(u, v)
    X, Y = -lift * v - drag * u, lift * u - drag * v
    c, n = np.cos(flow.phi), np.sin(flow.phi)
    px = robot.shift_aft * c + robot.shift_left * n  # stated from true centre of mass
    py = robot.shift_aft * n - robot.shift_left * c
    N = -2 * q * robot.C_Ma * u * v - robot.C_Md * flow.r * abs(flow.r)
    N += (robot.arm + px) * Y - py * X + flow.thrust * robot.shift_left
    return X + flow.thrust * c, Y + flow.thrust * n, N


@njit(cache=True)
def derivative(t, s, robot, table, schedule, path):
    """Time derivative of the state: Newton in rotating axes, Kirchhoff's added momentum."""
    flow, bu, bv = flow_at(t, s, robot, table, schedule, path)
    X, Y, N = plate_force(flow, robot)
    dX, dY, dN = total_force(flow, table, robot)
    u, v, r = s[3], s[4], s[5]
    c, n = np.cos(flow.phi), np.sin(flow.phi)
    auu = robot.added_surge * c * c + robot.added_sway * n * n
    avv = robot.added_surge * n * n + robot.added_sway * c * c
    auv = (robot.added_surge - robot.added_sway) * c * n
    pu, pv = auu * flow.u + auv * flow.v, auv * flow.u + avv * flow.v
    # the water's velocity turns in the body's axes: d(bu)/dt = r bv, d(bv)/dt = -r bu
    X += dX + robot.mass * v * r + r * pv + r * (auu * bv - auv * bu)
    Y += dY - robot.mass * u * r - r * pu + r * (auv * bv - avv * bu)
    N += dN - (flow.u * pv - flow.v * pu)
    a, b, d = robot.mass + auu, auv, robot.mass + avv
    det = a * d - b * b
    out = np.empty(STATE_SIZE)
    ct, nt = np.cos(s[2]), np.sin(s[2])
    out[0], out[1], out[2] = u * ct - v * nt, u * nt + v * ct, r
    out[3], out[4] = (d * X - b * Y) / det, (a * Y - b * X) / det
    out[5] = N / (robot.inertia + robot.added_yaw)
    out[6] = lag_rate(flow, table, robot)
    return out


@njit(cache=True)
def advance_adaptively(t, end, s, tolerance, robot, table, schedule, path):
    """State at `end` by the Dormand-Prince 5(4) pair with an elementary step controller.

    Dormand and Prince 1980, J. Comp. Appl. Math. 6, p. 23; Hairer et al. 1993, II.4.
    """
    h = min(end - t, 0.05)
    K = np.zeros((7, STATE_SIZE))
    first = 0
    new = s.copy()
    while end - t > 1e-10:
        h = min(h, end - t)
        for stage in range(first, 7):
            new = s.copy()
            for j in range(stage):
                new += h * RK_TABLEAU[stage, j] * K[j]
            K[stage] = derivative(t + RK_NODES[stage] * h, new, robot, table, schedule, path)
        error = 0.0
        for i in range(STATE_SIZE):
            gap = 0.0
            for j in range(7):
                gap += RK_ERROR_WEIGHTS[j] * K[j, i]
            error = max(error, abs(h * gap) / tolerance)
        first = 1  # K[0] stays valid after a refused step, and is K[6] after an accepted one
        if not error > 1 or h < 1e-4:
            t, s = t + h, new.copy()
            K[0] = K[6]
        h = h * min(4.0, max(0.2, 0.9 * max(error, 1e-8) ** -0.2))
    return s


@njit(cache=True)
def simulate(times, start, robot, table, schedule):
    """States at `times`, shape (times, 7), and the path (times, 5): t, x, y, core direction.

    `start` is the state at times[0]. The path that the robot leaves behind feeds its wake.
    """
    states = np.empty((times.size, STATE_SIZE))
    path = np.full((times.size, 5), np.inf)
    states[0] = start
    for i in range(times.size):
        if i > 0:
            states[i] = advance_adaptively(
                times[i - 1], times[i], states[i - 1], 1e-7, robot, table, schedule, path
            )
        psi = states[i, 2] + schedule_at(schedule, times[i])[0]
        path[i] = np.array([times[i], states[i, 0], states[i, 1], np.cos(psi), np.sin(psi)])
    return states, path


@njit(cache=True)
def single_steps(times, states, robot, table, schedule, path):
    """States one interval later from every row of `states`, shape (times - 1, 7)."""
    out = np.empty((times.size - 1, STATE_SIZE))
    for i in range(times.size - 1):
        out[i] = advance_adaptively(
            times[i], times[i + 1], states[i], 1e-6, robot, table, schedule, path
        )
    return out
