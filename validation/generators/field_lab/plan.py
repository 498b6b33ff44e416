"""Plan of a study: group, causes, laboratory, conditions and trials."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from . import camera as cam
from . import dynamics as dyn
from . import effects as eff
from . import world as wd

GROUP_COUNTS = (
    ("null", 8),
    ("clear", 8),
    ("faint", 6),
    ("pair", 6),
    ("measurement", 6),
    ("unlisted", 6),
)
SLOT_PERMUTATION = np.random.default_rng(2957).permutation(40)
NINE_TRIAL_SLOTS = frozenset(np.random.default_rng(1163).permutation(40)[:10].tolist())
TARGET_SIGMAS = {"clear": (20, 45), "faint": (8, 14), "pair": (14, 35), "measurement": (12, 40),
          "unlisted": (14, 40)}  # fmt: skip
PHYSICS = tuple(name for name in eff.FORMS if name != "tail_fin_lift")


class StudySlot(NamedTuple):
    """Group of a study, place within the group, whether it has a fin, number of trials."""

    group: str
    place: int
    fin: bool
    trials: int


def study_slot(index: int) -> StudySlot:
    """Slot of study ``index``: modulo 40 through a fixed permutation."""
    j = int(SLOT_PERMUTATION[index % 40])
    nine = 9 if j in NINE_TRIAL_SLOTS else 24
    for group, size in GROUP_COUNTS:
        if j < size:
            return StudySlot(group, j, j % 2 == 0, nine)
        j -= size
    raise AssertionError(index)


def causes_from_deck(seed: int, index: int) -> tuple[str, ...]:
    """Names of causes to try, in order; one deck per seed deals all causes equally often."""
    s, block = study_slot(index), index // 40
    rng = np.random.default_rng([seed, 77])
    if s.group == "null":
        return ()
    if s.group == "measurement":
        deck, place, need = tuple(eff.MEASUREMENT), block * 6 + s.place, 1
    elif s.group == "unlisted":
        deck, place, need = tuple(f"u{i}" for i in range(len(eff.UNLISTED))), block * 6 + s.place, 1
    else:
        offset = {"clear": 0, "faint": 8, "pair": 14}[s.group]
        need = 2 if s.group == "pair" else 1
        deck, place = PHYSICS, block * 26 + offset + s.place * need
    many = np.concatenate([rng.permutation(len(deck)) for _ in range(place // len(deck) + 3)])
    names = [deck[i] for i in many[place:]]
    return tuple(dict.fromkeys(names))


def draw_form(rng: np.random.Generator, name: str) -> eff.Effect:
    """Effect called ``name`` with a form at random; ``u3`` is the unlisted load 3."""
    if name in eff.MEASUREMENT:
        return eff.draw_effect(
            rng, name, eff.MEASUREMENT[name][rng.integers(len(eff.MEASUREMENT[name]))]
        )
    if name in eff.FORMS:
        return eff.draw_effect(rng, name, eff.FORMS[name][rng.integers(len(eff.FORMS[name]))])
    return eff.draw_effect(rng, "unlisted", eff.UNLISTED[int(name[1:])][0])


def draw_robot(rng: np.random.Generator) -> tuple[dict[str, float], dyn.Coefficients]:
    """Geometry of study.yaml and coefficients, +-20 % (lengths less) about plausible values."""
    s = rng.uniform(0.93, 1.07)
    robot = {
        "mass_kg": 0.68 * s**3 * rng.uniform(0.9, 1.1),
        "yaw_inertia_kg_m2": 0.0095 * s**5 * rng.uniform(0.85, 1.15),
        "body_length_m": 0.331 * s,
        "head_length_m": 0.12 * s,
        "head_span_m": 0.069 * s * rng.uniform(0.95, 1.05),
        "hinge_to_com_m": 0.04 * rng.uniform(0.85, 1.15),
        "tail_length_m": 0.066 * s,
        "keypoint_depth_m": float(rng.uniform(0.02, 0.06)),
    }
    c = np.array([4.5e-3, 0.5, 2.5, 3.14, 0.1, 0.12]) * rng.uniform(0.8, 1.2, 6)
    return {k: round(v, 5) for k, v in robot.items()}, dyn.Coefficients(*c.tolist())


def draw_noise(rng: np.random.Generator) -> dict[str, float]:
    """Levels of tracking, water, servo and frequency errors (SI, px)."""
    return {
        "fps": float(
            rng.choice([30000 / 1001, 60000 / 1001, 25.0, 50.0], p=[0.5, 0.35, 0.1, 0.05])
        ),
        "white_px": float(rng.uniform(0.2, 0.9)),
        "track_px": float(rng.uniform(0.15, 0.7)),
        "track_tau_s": float(np.exp(rng.uniform(math.log(0.05), math.log(0.5)))),
        "water_m_s": float(rng.uniform(4e-4, 1.6e-3)),
        "water_tau_s": float(rng.uniform(1.0, 3.0)),
        "swirl_per_s": float(rng.uniform(0.0, 1.5e-3)),
        "servo_rad": math.radians(0.3),
        "flap_share": 0.003,
        "recoil_rad": math.radians(rng.uniform(0.6, 2.5)),
        "recoil_m": float(rng.uniform(0.5e-3, 2e-3)),
        "tail_flap_rad": math.radians(rng.uniform(3, 10)),
        "outlier_share": float(rng.uniform(0.003, 0.015)),
        "swap_share": float(rng.uniform(0.0, 0.004)),
        "frozen_share": float(rng.choice([0.0, 0.003])),
        "gaps_per_s": float(rng.uniform(0.02, 0.2)),
        "likelihood_use": float(rng.uniform(0.3, 1.0)),
    }


def draw_conditions(rng: np.random.Generator, n: int, heads: tuple[float, ...]) -> list[tuple]:
    """(power %, head angle rad, head length m) of every trial, repeats grouped at random."""
    powers = ((50, 75, 100), (45, 70, 95), (55, 80, 110), (60, 80, 100))[rng.integers(4)]
    pick = ((0, 20, -30, 40), (0, -15, 30, 45), (0, 25, -25), (0, 15, -20, 35, -45), (0, 30, -45))
    angles = pick[rng.integers(len(pick))]
    sign = rng.choice([-1, 1])
    count = int(rng.integers(4, 6)) if n == 9 else int(rng.integers(9, 14))
    some = list(itertools.product(powers, angles, heads))
    first = [(powers[i % 3], angles[i % len(angles)], heads[i % len(heads)]) for i in range(5)]
    rest = [some[i] for i in rng.permutation(len(some))]
    rows = list(dict.fromkeys([*first[: max(3, len(angles))], *rest]))[:count]
    count = len(rows)
    order = np.concatenate([np.arange(count), rng.integers(0, count, n - count)])
    rng.shuffle(order)
    return [(rows[i][0], math.radians(float(sign * rows[i][1])), rows[i][2]) for i in order]


def random_water_velocity(rng: np.random.Generator, n: int, std: float, tau: float) -> np.ndarray:
    """Random water velocity (n,) m/s per millisecond, complex, Ornstein-Uhlenbeck."""
    a = math.exp(-dyn.STEP_S / tau)
    kick = (rng.normal(size=n) + 1j * rng.normal(size=n)) * std * math.sqrt(1 - a * a)
    kick[0] /= math.sqrt(1 - a * a)
    return lfilter([1.0], [1.0, -a], kick)


def draw_trials(
    rng: np.random.Generator,
    n: int,
    robot: dict[str, float],
    noise: dict[str, float],
    names: tuple[str, ...],
) -> list[wd.Trial]:
    """Trials without start poses: conditions, durations, hidden errors and water."""
    longer = round(robot["head_length_m"] * rng.uniform(1.35, 1.55), 4)
    long = "wake_reentry" in names
    two = "thrust_area" in names or rng.random() < 0.85
    heads = (robot["head_length_m"], longer)[: 1 + two]
    out = []
    for i, (power, phi, head) in enumerate(draw_conditions(rng, n, heads)):
        span = rng.uniform(8, 12) if long or rng.random() < 0.06 else rng.uniform(3.2, 8)
        f = 5.82 * (power / 100) ** 1.296 * rng.normal(1, 0.015)
        swirl = rng.choice([-1, 1]) * noise["swirl_per_s"] * rng.uniform(0.4, 1.4)
        out.append(
            wd.Trial(
                f"run{i + 1:02d}",
                int(i >= n // 2),
                power,
                phi,
                head,
                round(f, 4),
                round(span, 2),
                (1.3, 0.8, 0.0),
                rng.normal(0, noise["servo_rad"]),
                rng.normal(0, noise["flap_share"]),
                swirl,
                random_water_velocity(
                    rng, round(1000 * span) + 6, noise["water_m_s"], noise["water_tau_s"]
                ),
                float(np.clip(np.exp(rng.normal(0, 0.35)), 0.5, 1.6)),
            )
        )
    return out


def with_start_pose(rng: np.random.Generator, world: wd.StudyWorld, trial: wd.Trial) -> wd.Trial:
    """``trial`` with the start pose, of 60 at random, that keeps its path longest in the pool.

    The free path is turned and shifted; the best four poses are simulated.
    """
    free = wd.trial_path(world, wd.replace(trial, start=(1.3, 0.8, 0.0)), walls=False)
    z = free[::50, 0] + 1j * free[::50, 1] - (1.3 + 0.8j)
    nose = z + (trial.head_length + 0.06) * np.exp(1j * free[::50, 2])
    tries = []
    for _ in range(60):
        turn, z0 = rng.uniform(-np.pi, np.pi), complex(rng.uniform(0.3, 2.3), rng.uniform(0.3, 1.3))
        both = np.stack([z, nose]) * np.exp(1j * turn) + z0
        out = ((np.abs(both.real - 1.3) > 1.17) | (np.abs(both.imag - 0.8) > 0.67)).any(0)
        n = float(np.argmax(out)) if out.any() else len(z) + rng.random()
        tries.append((n, (z0.real, z0.imag, float(turn))))
    poses = [wd.replace(trial, start=pose) for _, pose in sorted(tries, reverse=True)[:4]]
    return max(poses, key=lambda t: len(wd.trial_path(world, t)))


def with_stable_fin(rng: np.random.Generator, world: wd.StudyWorld, fin: eff.Effect) -> eff.Effect:
    """``fin`` sized from marginally to strongly stable for the longest head, straight at 100 %."""
    head = max(t.head_length for t in world.trials)
    low, high = fin.form.strength[2:]
    for _ in range(30):
        area = math.sqrt(low * high)
        k, p = eff.effect_table((wd.replace(fin, strength=area),))
        growth = dyn.straight_growth_rate_per_s(world.body(head), world.coefficients, 5.8, k, p)
        low, high = (area, high) if growth > 0 else (low, area)
    return wd.replace(fin, strength=math.sqrt(low * high) * rng.uniform(1.02, 1.9))


def draw_study(
    rng: np.random.Generator, s: StudySlot, names: tuple[str, ...]
) -> tuple[wd.StudyWorld, dict]:
    """World without concealed effects (but with start poses) and facts about the file layout."""
    robot, c = draw_robot(rng)
    noise = draw_noise(rng)
    flat = s.group not in ("measurement",) and rng.random() < 0.12
    trials = draw_trials(rng, s.trials, robot, noise, names)
    world = wd.StudyWorld(
        robot, c, cam.draw_camera(rng, not flat), noise, tuple(trials), (),
        robot["keypoint_depth_m"], float(rng.choice([0.0, 0.05, 0.1])),
    )  # fmt: skip
    clocks = {"time_offset", "clock_error"}
    layout = {
        "homography": flat and rng.random() < 0.5,
        "individuals": rng.random() < 0.15,
        "renamed": rng.random() < 0.25,
        "motor_log": bool(rng.random() < 0.75) or bool(clocks & set(names)),
        "dead_zone": str(rng.choice(["hold", "zero", "empty"])),
        "pre_roll": bool(rng.random() < 0.3) and not clocks & set(names),
    }
    if layout["homography"]:
        world = wd.replace(world, corner_height=0.0)
    return world, layout
