"""The measurement plan: conditions, durations, placement in the basin, small errors per trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from .robots import Robot

KNOT = 0.5
"""Spacing of the knots between which the water's motion is linear, s."""
SHORTEST = 5.0
"""Shortest duration, s."""
LONGEST_BASIN = 14.0
"""m."""
POWERS = [[50, 75, 100], [60, 80, 100], [50, 100], [40, 70, 100], [55, 70, 85, 100]]
ANGLES_WITH_FIN = [[10, 20, 35], [15, 30, 45], [12, 25, 40], [20, 40]]
ANGLES_WITHOUT_FIN = [[15, 25, 40], [20, 30, 45], [16, 32], [18, 27, 36, 45]]
FRAME_RATES = [30000 / 1001, 30.0, 25.0, 60000 / 1001, 50.0]


@dataclass
class Trials:
    """Arrays over the trials.

    power: %; phi: commanded head angle, rad; head: length, m; flap: Hz; duration: s; area: m^2;
    arm: centre of mass to aerodynamic centre, m; servo_error: rad; thrust_error: relative; start:
    (trials, 6) as the state; water: (trials, knots), complex velocity, m/s; simulated: s; pool:
    length, width, depth, m.
    """

    power: np.ndarray
    phi: np.ndarray
    head: np.ndarray
    flap: np.ndarray
    duration: np.ndarray
    area: np.ndarray
    arm: np.ndarray
    servo_error: np.ndarray
    thrust_error: np.ndarray
    start: np.ndarray
    water: np.ndarray
    fps: float
    simulated: float
    noise: dict[str, float]
    pool: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _conditions(rng: Generator, robot: Robot, two_heads: bool, count: int) -> np.ndarray:
    """Power (%), head angle (deg) and head length (m) of every trial; both sides."""
    fin = robot.fin_strength > 0
    powers = POWERS[int(rng.integers(len(POWERS)))]
    angle_sets = ANGLES_WITH_FIN if fin else ANGLES_WITHOUT_FIN
    angles = angle_sets[int(rng.integers(len(angle_sets)))]
    signed = [side * angle for angle in angles for side in (1, -1)] + ([0] if fin else [])
    ratio = round(float(rng.uniform(1.25, 1.6)), 2)
    heads = [robot.head, round(robot.head * ratio, 4)] if two_heads else [robot.head]
    grid = [(power, angle, head) for power in powers for angle in signed for head in heads]
    rng.shuffle(grid)
    rows: list[tuple[float, float, float]] = []
    while len(rows) < count:
        rows += grid[: count - len(rows)]
    if fin and not any(angle == 0 for _, angle, _ in rows):
        rows[0] = (rows[0][0], 0.0, rows[0][2])
    return np.array(rows, float)


def _draw_noise(rng: Generator) -> dict[str, float]:
    """Sizes of the small errors of a study."""
    return {
        "servo_sd_deg": float(rng.uniform(0.2, 0.4)),
        "thrust_sd_rel": float(rng.uniform(0.002, 0.007)),
        "water_sd_m_s": float(rng.uniform(0.001, 0.0035)),
        "water_time_s": float(rng.uniform(0.8, 2.5)),
        "start_speed_sd_m_s": float(rng.uniform(0.0015, 0.004)),
        "start_yaw_rate_sd_rad_s": float(rng.uniform(0.005, 0.02)),
    }


def _slow_motion(rng: Generator, noise: dict[str, float], count: int, knots: int) -> np.ndarray:
    """Ornstein-Uhlenbeck motion of the water at the knots, of unit variance on each axis."""
    memory = np.exp(-KNOT / noise["water_time_s"])
    motion = rng.standard_normal((count, knots)) + 1j * rng.standard_normal((count, knots))
    for j in range(1, knots):
        motion[:, j] = memory * motion[:, j - 1] + np.sqrt(1 - memory * memory) * motion[:, j]
    return motion


def draw_trials(rng: Generator, robot: Robot, two_heads: bool) -> Trials:
    """Conditions from a grid with both sides; finless robots never get a straight head."""
    count = int(rng.integers(10, 25))
    conditions = _conditions(rng, robot, two_heads, count)
    power, phi, head = conditions[:, 0], np.deg2rad(conditions[:, 1]), conditions[:, 2]
    rising = robot.full_flap * (power / 100) ** robot.flap_exponent
    flap = np.round(rising * (1 + 0.006 * rng.standard_normal(count)), 4)
    duration = np.round(rng.uniform(5.0, 15.0, count), 2)
    noise = _draw_noise(rng)
    simulated = float(duration.max() + 1.5)
    water = _slow_motion(rng, noise, count, int(np.ceil(simulated / KNOT)) + 4)
    start = np.zeros((count, 6))
    start[:, 3:5] = noise["start_speed_sd_m_s"] * rng.standard_normal((count, 2))
    start[:, 5] = noise["start_yaw_rate_sd_rad_s"] * rng.standard_normal(count)
    return Trials(
        power=power,
        phi=phi,
        head=head,
        flap=flap,
        duration=duration,
        area=head * robot.span,
        arm=np.asarray(robot.arm(head)),
        servo_error=np.deg2rad(noise["servo_sd_deg"]) * rng.standard_normal(count),
        thrust_error=noise["thrust_sd_rel"] * rng.standard_normal(count),
        start=start,
        water=noise["water_sd_m_s"] * water,
        fps=float(FRAME_RATES[int(rng.integers(len(FRAME_RATES)))]),
        simulated=simulated,
        noise=noise,
    )


@dataclass(frozen=True)
class _Room:
    """Where robots may start. size: length and width (m); margin: kept free at the walls (m)."""

    size: np.ndarray
    margin: float
    near_wall: bool


@dataclass(frozen=True)
class _Release:
    """until: time that fits into the basin, s; position: m; turn: of the whole path, rad."""

    until: float
    position: np.ndarray
    turn: float


def _fitting(room: _Room, path: np.ndarray, time: np.ndarray, duration: float
             ) -> tuple[float, np.ndarray, np.ndarray] | None:  # fmt: skip
    """Longest of three times for which the path fits, its lowest x and y, and the room left."""
    whole = duration + 0.3
    for until in (whole, 0.7 * whole + 1.5, SHORTEST + 0.3):
        part = path[time <= until]
        lowest = np.array([part.real.min(), part.imag.min()])
        left = room.size - 2 * room.margin - np.array([np.ptp(part.real), np.ptp(part.imag)])
        if (left > 0).all():
            return until, lowest, left
    return None


def _best_release(
    rng: Generator, room: _Room, path: np.ndarray, time: np.ndarray, duration: float
) -> _Release | None:
    """The release that leaves the most time, of up to 40 tried; path: complex, from 0."""
    away = np.angle(path[time <= SHORTEST + 0.3][-1])
    best = None
    for _ in range(40):
        turn = -away + rng.choice([0.0, np.pi]) + rng.normal(0, 0.35)
        if abs(path).max() < 0.6 * room.size[1]:
            turn = rng.uniform(-np.pi, np.pi)
        found = _fitting(room, path * np.exp(1j * turn), time, duration)
        if found is None:
            continue
        until, lowest, left = found
        if best is None or until > best.until:
            share = rng.uniform(0, 1, 2)
            if room.near_wall:
                share[int(rng.integers(2))] = rng.choice([0.0, 1.0])
            best = _Release(until, room.margin - lowest + share * left, turn)
        if until == duration + 0.3:
            break
    return best


def place(rng: Generator, robot: Robot, trials: Trials, paths: np.ndarray, near_wall: bool) -> bool:
    """Choose the basin and each trial's start; False where no basin is long enough.

    paths: (instants, trials) complex, started at 0. Straight runs go along the basin; durations
    are cut (not below `SHORTEST`) where the basin ends.
    """
    time = np.arange(len(paths)) * (trials.simulated / (len(paths) - 1))
    margin = 0.75 * robot.length + 0.1
    farthest = np.abs(paths[time <= SHORTEST + 0.3]).max()
    length = max(farthest * 1.12 + 2 * margin, rng.uniform(6.0, 9.0) * robot.length + 1.2)
    width = max(0.62 * length, rng.uniform(4.0, 6.0) * robot.length + 0.8)
    length, width = np.ceil(length * 10) / 10, np.ceil(width * 10) / 10
    if length > LONGEST_BASIN:
        return False
    room = _Room(np.array([length, width]), margin, near_wall)
    for j, start in enumerate(trials.start):
        release = _best_release(rng, room, paths[:, j], time, trials.duration[j])
        if release is None:
            return False
        possible = min(trials.duration[j], release.until - 0.3)
        trials.duration[j] = np.round(max(possible, SHORTEST), 2)
        start[:2], start[2] = release.position, release.turn
        velocity = (start[3] + 1j * start[4]) * np.exp(1j * release.turn)
        start[3], start[4] = velocity.real, velocity.imag
    trials.pool = (float(length), float(width), 0.0)
    return True
