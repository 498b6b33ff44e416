"""Trials of a study: powers, head angles, durations, first poses, ends; strength of the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .detector import FLAP_SD, SERVO_SD
from .form import Array, HiddenCause, Lanes
from .gusts import Gusts, random_series
from .motion import acting, first_states, simulate
from .robots import DENSITY, Robot

MARGIN_M = 0.25


@dataclass(frozen=True)
class Plan:
    """power: %. commanded: rad. stated: Hz, frequency of log or table. duration: s. starts: m."""

    lanes: Lanes
    power: Array
    commanded: Array
    stated: Array
    duration: Array
    starts: Array


def draw_plan(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], *, two_heads: bool
) -> Plan:
    """9 to 24 trials, two or three powers, head angles of both signs and straight."""
    count = int(rng.integers(9, 25))
    powers = np.sort(rng.choice([40.0, 50, 60, 75, 90, 100], int(rng.integers(2, 4)), False))
    sizes = rng.choice([12, 15, 20, 25, 30, 35, 40], int(rng.integers(1, 3)), replace=False)
    angles = np.array([0, *sizes, *-sizes])
    pairs = [(p, a) for p in powers for a in angles]
    order = np.concatenate([rng.permutation(len(pairs)) for _ in range(4)])[:count]
    power, angle = np.array([pairs[k] for k in order]).T
    keep = np.lexsort((angle, power))
    power, angle = power[keep], np.radians(angle[keep].astype(float))
    head = np.full(count, robot.head_length)
    if two_heads:
        head[rng.permutation(count)[: count // 2]] = round(robot.head_length * 1.45, 3)
    stated = np.round((2.37 + (power - 50) * 0.069) * (1 + rng.normal(0, 0.01, count)), 3)
    lanes = Lanes(
        phi=angle + rng.normal(0, SERVO_SD, count),
        flap=stated * (1 + rng.normal(0, FLAP_SD, count)),
        head=head,
        heading=np.zeros(count),
        luck=rng.random(count),
        pool=pool,
    )
    duration = np.round(rng.uniform(9, 20, count), 1)
    return Plan(lanes, power, angle, stated, duration, np.zeros(count, complex))


def draw_gusts(rng: np.random.Generator, robot: Robot, plan: Plan) -> Gusts:
    """Random accelerations of 0.7 to 3 % of those of the mean thrust and of the head's moment."""
    lanes, c = plan.lanes, robot.coefficients
    thrust = float(np.mean(c.C_T * 0.5 * DENSITY * robot.area(lanes.head) * lanes.flap**2))
    level = float(np.exp(rng.uniform(np.log(0.007), np.log(0.03))))
    moment = thrust * (c.C_Ma / c.C_D0 + float(robot.arm(lanes.head).mean())) * 0.5
    return Gusts(
        float(f"{level * thrust / robot.mass:.3g}"),
        float(f"{level * rng.uniform(0.5, 1.2) * moment / robot.inertia:.3g}"),
        round(float(2 * np.pi * rng.uniform(0.15, 0.7)), 3),
    )


def draw_series(rng: np.random.Generator, gusts: Gusts, plan: Plan, dt: float) -> Array:
    """Random accelerations at half steps dt / 2 for the longest trial and two seconds more."""
    steps = int(np.ceil((plan.duration.max() + 2) / dt / 16)) * 16
    return random_series(rng, gusts, 2 * steps + 1, dt / 2, plan.power.size)


def run(
    plan: Plan,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    series: Array,
    *,
    dt: float,
    every: int,
) -> tuple[Array, Array]:
    """Times and states with steps of `every` times dt."""
    series = _thinned(series, every)
    first = first_states(plan.starts, plan.lanes)
    states = simulate(first, plan.lanes, robot, hidden, gusts=series, dt=every * dt)
    return np.arange(len(states)) * dt * every, states


def _thinned(series: Array, every: int) -> Array:
    few = series[::every]
    return few if len(few) % 2 else few[:-1]


def with_starts(
    rng: np.random.Generator,
    plan: Plan,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    series: Array,
    *,
    dt: float,
    margin: float,
) -> Plan:
    """First poses that keep the paths, as swum in open water, in the pool."""
    local = {"water", "view"}
    free = [h for h in hidden if h.form.acts_on not in local and h.form.cause != "wall_effect"
            and h.form.variable not in {"position", "heading"}]  # fmt: skip
    open_plan = replace(plan, starts=0 * plan.starts)
    grid, states = run(open_plan, robot, free, series, dt=dt, every=max(1, round(1 / 30 / dt)))
    length, width = plan.lanes.pool
    starts, headings = plan.starts.copy(), np.zeros(plan.power.size)
    for k, end in enumerate(plan.duration):
        live = grid <= end
        path = states[live, 0, k] + 1j * states[live, 1, k]
        best = (np.inf, 0j, 0.0)
        for heading in rng.uniform(-np.pi, np.pi, 60):
            turned = path * np.exp(1j * heading)
            low = complex(turned.real.min(), turned.imag.min())
            box = complex(np.ptp(turned.real), np.ptp(turned.imag))
            room = complex(length - 2 * margin, width - 2 * margin) - box
            over = max(-room.real, -room.imag, 0.0)
            if over < best[0]:
                a, b = rng.uniform(0, 1, 2)
                corner = complex(margin + a * room.real, margin + b * room.imag)
                best = (over, corner - low, heading)
            if over == 0:
                break
        starts[k] = complex(np.clip(best[1].real, margin, length - margin),
                            np.clip(best[1].imag, margin, width - margin))  # fmt: skip
        headings[k] = best[2]
    return replace(plan, starts=starts, lanes=replace(plan.lanes, heading=headings))


def trial_ends(plan: Plan, grid: Array, states: Array) -> Array:
    """The planned duration, or earlier where the robot comes too near a wall, s."""
    length, width = plan.lanes.pool
    x, y = states[:, 0], states[:, 1]
    near = np.min([x, length - x, y, width - y], axis=0) < 0.6 * MARGIN_M
    near |= ~np.isfinite(x)
    first = np.where(near.any(axis=0), grid[np.argmax(near, axis=0)], np.inf)
    return np.minimum(plan.duration, np.floor(first * 10) / 10)


def local_margin(hidden: Sequence[HiddenCause]) -> float:
    """Room left at the walls, m; little where the walls act."""
    walls = any(h.form.cause == "wall_effect" for h in acting(hidden, "force"))
    return 0.19 if walls else MARGIN_M + 0.05
