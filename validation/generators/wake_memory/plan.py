"""Random choices of a study: composition, robot, trials, camera; everything but the strength."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import dynamics as dy
from .camera import corner_points, draw_camera, project
from .catalogue import CAUSE_ROW, CAUSES, MEASUREMENT, PHYSICS
from .effects import HEAD1, MASS
from .noise import Noise, draw_noise, water_motion
from .observation import Optics

Array = NDArray[np.float64]
GROUP_COUNTS = (
    ("null", 8),
    ("clear", 8),
    ("faint", 6),
    ("pair", 6),
    ("measurement", 6),
    ("unlisted", 6),
)
NINE_TRIALS = frozenset({2, 7, 8, 13, 19, 20, 25, 30, 33, 38})  # five with a fin, five without
INTEGRATION_RATE_HZ = 480.0
WALL_MARGIN_M = 0.26


@dataclass(frozen=True)
class StudyPlan:
    """A study without its strengths. `trials`: (n, 7), `starts`: (n, 3), `power`: (n,), %."""

    group: str
    fin: bool
    names: tuple[str, ...]
    R: Array
    trials: Array
    commanded: Array
    power: Array
    starts: Array
    durations: Array
    fps: float
    noise: Noise
    optics: Optics
    gust: tuple[Array, ...]
    fin_row: Array


def study_slot(seed: int, index: int) -> tuple[str, int, int]:
    """Group, slot in the group and place in the block of 40 of a study."""
    block = index // 40
    order = np.random.default_rng([seed, 40, 17]).permutation(40)
    place, first = int(order[index % 40]), 0
    for group, size in GROUP_COUNTS:
        if place < first + size:
            return group, place - first + size * block, place
        first += size
    raise AssertionError(place)


def card_from_deck(seed: int, deck: tuple[str, ...], count: int, salt: int) -> str:
    """Card number `count` of repeatedly shuffled decks, so that all names come equally often."""
    rng = np.random.default_rng([seed, salt, count // len(deck)])
    return deck[rng.permutation(len(deck))[count % len(deck)]]


def effect_names_of_study(seed: int, group: str, slot: int) -> tuple[str, ...]:
    """Names of the effects of a study; physics groups share one deck, 26 cards per block."""
    block, size = divmod(slot, dict(GROUP_COUNTS)[group])
    if group == "measurement":
        return (card_from_deck(seed, MEASUREMENT, slot, 3),)
    if group == "unlisted":
        return ("unlisted",)
    if group in {"clear", "faint"}:
        card = 26 * block + size + (8 if group == "faint" else 0)
        return (card_from_deck(seed, PHYSICS, card, 5),)
    if group == "pair":
        card = 26 * block + 14 + 2 * size
        first, second = (
            card_from_deck(seed, PHYSICS, card, 5),
            card_from_deck(seed, PHYSICS, card + 1, 5),
        )
        if first == second:
            second = card_from_deck(seed, PHYSICS, card + 9, 5)
        return (first, second)
    return ()


def draw_robot(rng: np.random.Generator) -> Array:
    """Robot array: geometry and coefficients within 20 % of plausible values."""
    base = np.array(
        [0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 4.5e-3, 0.5, 2.3, 3.14, 0.1, 0.12]
    )
    spread = np.array([0.15, 0.15, 0.08, 0.08, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2])
    R = base * (1 + spread * rng.uniform(-1, 1, 13))
    R[:7] = np.round(R[:7], 5)
    return R


def draw_conditions(
    rng: np.random.Generator, count: int, R: Array, names: tuple[str, ...]
) -> tuple:
    """Power (%), flapping frequency (Hz), commanded angle (rad), head length (m), all (count,)."""
    powers = np.array([[50, 75, 100], [40, 70, 100], [60, 80, 100], [50, 70, 90]][rng.integers(4)])
    scale = rng.uniform(5.2, 6.2) * (powers / 100.0) ** rng.uniform(1.0, 1.3)
    big = rng.choice([30, 35, 40, 45, 50])
    small = rng.choice([10, 15, 20, 25])
    angles = np.array([0, small, -small, big, -big, 0, rng.choice([5, 12, 22]), -big])
    long_head = round(R[HEAD1] * rng.uniform(1.3, 1.55), 4)
    two = rng.random() < 0.75 or "thrust_area" in names
    k = np.arange(count)
    which, angle = k % 3, np.radians(angles[(k // 3) % 8 if count > 9 else (k * 2) % 5])
    if count == 9:
        angle = np.radians(np.array([0, small, -small, -big, 0, big, big, -big, 0.0]))
    head = np.where(two & ((k + k // 3) % 2 == 1), long_head, R[HEAD1])
    mix = rng.permutation(count)
    return powers[which][mix], scale[which][mix], angle[mix], head[mix]


def start_pose_in_pool(path: Array, wanted: int, rng: np.random.Generator) -> tuple[Array, int]:
    """Start pose (3,) and frames so that a path from the origin fits into the pool."""
    room, best = np.array([2.6, 1.6]) - 2 * WALL_MARGIN_M, (np.zeros(3), 0)
    z = path[:, 0] + 1j * path[:, 1]
    for turn in rng.uniform(-np.pi, np.pi, 40):
        p = z * np.exp(1j * turn)
        low = np.stack([np.minimum.accumulate(p.real), np.minimum.accumulate(p.imag)], axis=1)
        high = np.stack([np.maximum.accumulate(p.real), np.maximum.accumulate(p.imag)], axis=1)
        frames = min(int(np.sum(np.all(high - low <= room, axis=1))), wanted)
        if frames > best[1]:
            slack = room - (high - low)[frames - 1]
            start = WALL_MARGIN_M + rng.uniform(0, 1, 2) * slack - low[frames - 1]
            best = (np.array([start[0], start[1], turn]), frames)
    return best


def draw_optics(rng: np.random.Generator, names: tuple[str, ...]) -> Optics:
    """Camera, depth and imaged corners; one study in six has a strongly tilted camera."""
    deep = "uncorrected_refraction" in names
    camera = draw_camera(rng, low=deep, tilted=rng.random() < 1 / 6)
    height = round(float(rng.choice([0.0, rng.uniform(0.0, 0.08)])), 3)
    depth = round(float(rng.uniform(0.12, 0.2) if deep else rng.uniform(0.02, 0.07)), 3)
    corners = project(camera, corner_points(2.6, 1.6, height)) + rng.normal(0, 0.2, (4, 2))
    return Optics(camera, depth, np.round(corners, 2), height, float(rng.uniform(-np.pi, np.pi)))


def effect_rows(rng: np.random.Generator, names: tuple[str, ...]) -> Array:
    """Rows (25, 5) of form, start strength with its sign, shape 1 and two spare shapes."""
    E = np.zeros((25, 5))
    for name in names:
        cause = CAUSES[CAUSE_ROW[name]]
        if CAUSE_ROW[name] < len(E):
            sign = -1.0 if cause.signed and rng.random() < 0.5 else 1.0
            form = rng.integers(1, len(cause.forms) + 1)
            jitter = np.exp(rng.uniform(-0.7, 0.4))
            E[CAUSE_ROW[name]] = [
                form,
                sign * jitter * cause.start,
                rng.uniform(*cause.shape),
                0.0,
                0.0,
            ]
    return E


def draw_trials(
    rng: np.random.Generator, count: int, R: Array, names: tuple[str, ...], noise: Noise
) -> tuple[Array, Array, Array]:
    """Trial rows (count, 7) with servo and frequency errors, commanded angles, powers."""
    power, f, angle, head = draw_conditions(rng, count, R, names)
    trials = np.zeros((count, 7))
    trials[:, dy.PHI] = angle + rng.normal(0, noise.servo_rad, count)
    trials[:, dy.F] = f * (1 + rng.normal(0, 0.01, count))
    trials[:, dy.HEAD], trials[:, dy.ORDER] = head, np.arange(count) / count
    trials[:, dy.PULSE] = rng.uniform(0.2, 0.6)
    trials[:, dy.RECOIL] = rng.uniform(1.0, 4.0) * 0.68 / R[MASS]
    return trials, angle, power


def fin_row(rng: np.random.Generator, R: Array, trials: Array, fps: float) -> Array:
    """Row (5,) of a tail fin of 1.05 to 4 times the area that just stabilises straight swimming."""
    row = np.array([rng.integers(1, 5), 0.0, rng.uniform(0.15, 0.2), 0.0, 0.0])
    trial = trials[np.argmax(trials[:, dy.F])].copy()
    trial[dy.PHI] = 0.0
    low, high = 0.0, 0.02
    for _ in range(12):
        row[1] = 0.5 * (low + high)
        low, high = (low, row[1]) if is_stable(row, R, trial, fps) else (row[1], high)
    row[1] = high * np.exp(rng.uniform(np.log(1.05), np.log(4.0)))
    return row


def is_stable(row: Array, R: Array, trial: Array, fps: float) -> bool:
    """True if a small yaw rate dies out in 4 s of straight swimming at full speed."""
    frames, E = int(8 * fps), np.zeros((25, 5))
    E[dy.FIN] = row
    gust = np.zeros((frames, 3))
    gust[frames // 2 : frames // 2 + 3, 2] = 1e-6
    path, _ = dy.simulate_trial(trial, R, E, np.zeros(3), gust, fps, 8)
    rate = np.abs(path[:, 5])
    return bool(rate[-1] < 0.5 * rate[frames // 2 : frames // 2 + 8].max())


def draw_plan(seed: int, index: int, names: tuple[str, ...], rng: np.random.Generator) -> StudyPlan:
    """Everything random about a study apart from effects and their strengths."""
    group, slot, place = study_slot(seed, index)
    count = 9 if place in NINE_TRIALS else 24
    R, noise = draw_robot(rng), draw_noise(rng)
    trials, commanded, power = draw_trials(rng, count, R, names, noise)
    fps = float(rng.choice([30000 / 1001, 60000 / 1001, 25.0, 50.0], p=[0.55, 0.3, 0.1, 0.05]))
    long = "wake_reentry" in names
    wanted = rng.uniform(9, 12, count) if long else rng.uniform(3.5, 8, count)
    if rng.random() < 0.3:
        wanted[: count // 5] = rng.uniform(8, 12, count // 5)
    base, starts = np.zeros((25, 5)), np.zeros((count, 3))
    if slot % 2 == 1:
        base[dy.FIN] = fin_row(rng, R, trials, fps)
    for i in range(count):
        frames = int(wanted[i] * fps)
        path, _ = dy.simulate_trial(trials[i], R, base, np.zeros(3), np.zeros((frames, 3)), fps, 8)
        starts[i], fit = start_pose_in_pool(path, frames, rng)
        wanted[i] = max(fit / fps, 3.15)
    water = tuple(water_motion(rng, noise, int(d * fps) + 1, fps) for d in wanted)
    return StudyPlan(group, slot % 2 == 1, names, R, trials, commanded, power, starts, wanted, fps,
                noise, draw_optics(rng, names), water, base[dy.FIN])  # fmt: skip
