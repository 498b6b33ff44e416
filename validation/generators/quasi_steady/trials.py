"""The laboratory: robot, conditions, water and noise levels, and the simulation of its trials."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.quasi_steady import effects as fx
from validation.generators.quasi_steady.camera import Camera, draw_camera
from validation.generators.quasi_steady.dynamics import STATE_SIZE, STEP_S, Robot, simulate

LENGTH, WIDTH = 2.6, 1.6  # m
MAX_DURATION_S = 12.5  # s of gusts drawn for a trial
KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Trial:
    """One run: condition, true errors of servo and frequency, gusts and start."""

    name: str
    power: float  # %
    head_angle: float  # rad, commanded
    head: float  # m
    seconds: float
    flap: float  # Hz, as the log has it
    servo_error: float  # rad
    flap_error: float  # share
    late: float  # 0 to 2, scatters a time offset
    gusts: np.ndarray  # (rows, 2) m/s on the schedule's grid
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Noise:
    """Levels of the disturbances that every study has."""

    white_px: float
    drift_px: float
    drift_s: float  # correlation time of tracking errors
    gust_m_s: float  # rms of the water's velocity, each component
    gust_s: float  # its correlation time
    recoil_rad: float
    recoil_m: float
    outlier_share: float
    gap_share: float


@dataclass(frozen=True)
class Lab:
    """What a study is made of, apart from the hidden effects."""

    robot: Robot  # 1x head, as stated
    body: float  # m, nose to caudal base with the 1x head
    camera: Camera
    corner_error_px: np.ndarray
    mark_height: float
    depth: float  # m, of the keypoints as stated
    fps: float
    noise: Noise
    label_m: np.ndarray  # (5, 2) static label errors, body axes; zero for the centre of mass
    trials: tuple[Trial, ...]


def draw_robot(rng: np.random.Generator) -> tuple[Robot, float]:
    """Robot with coefficients 20 % about MODEL.md's, and its body length (m)."""

    def near(value: float, share: float) -> float:
        return float(value * rng.uniform(1 - share, 1 + share))

    head, span, hinge = (
        round(near(0.12, 0.1), 3),
        round(near(0.069, 0.1), 4),
        round(near(0.04, 0.15), 3),
    )
    body, tail = round(near(0.331, 0.06), 3), round(near(0.066, 0.15), 3)
    robot = Robot(
        rho=float(rng.choice([997.0, 998.2, 1000.0])), mass=round(near(0.68, 0.2), 3),
        inertia=round(near(0.0095, 0.2), 5), head=head, span=span, area=head * span,
        arm=head + hinge - body / 4, hinge=hinge, base=body - head - hinge, tail=tail,
        C_T=near(4.5e-3, 0.2), C_D0=near(0.5, 0.2), C_Da=near(2.5, 0.2), C_La=near(3.14, 0.2),
        C_Ma=near(0.1, 0.2), C_Md=near(0.12, 0.2), area_ref=head * span, added_surge=0.0,
        added_sway=0.0, added_yaw=0.0, shift_aft=0.0, shift_left=0.0, length=LENGTH, width=WIDTH,
    )  # fmt: skip
    return robot, body


def with_head(robot: Robot, head: float) -> Robot:
    """The robot with a head of another length: area and arm change (MODEL.md)."""
    arm = head + robot.hinge - (robot.base + robot.hinge + head) / 4
    return robot._replace(head=head, area=head * robot.span, arm=arm)


def draw_gusts(rng: np.random.Generator, rms: float, tau: float) -> np.ndarray:
    """Uniform water velocity (rows, 2): a random train of swelling and fading gusts.

    Bumps exp(-((t - t_j) / tau)^2) come as a Poisson process, six a correlation time.
    """
    t = np.arange(0, MAX_DURATION_S + STEP_S, STEP_S)
    span = MAX_DURATION_S + 6 * tau
    at = rng.uniform(-3 * tau, MAX_DURATION_S + 3 * tau, rng.poisson(6 * span / tau))
    bumps = np.exp(-(((t[:, None] - at) / tau) ** 2))
    return bumps @ rng.normal(0, 1, (len(at), 2)) * rms / np.sqrt(6 * np.sqrt(np.pi / 2))


def draw_noise(rng: np.random.Generator) -> Noise:
    """Levels of tracking noise, water motion and recoil."""
    return Noise(
        rng.uniform(0.2, 1.5), rng.uniform(0.2, 0.9), rng.uniform(0.05, 0.5),
        rng.uniform(3e-4, 1.5e-3), rng.uniform(0.8, 2.5), np.radians(rng.uniform(0.5, 2.0)),
        rng.uniform(5e-4, 2e-3), rng.uniform(0.001, 0.006), rng.uniform(0.002, 0.006),
    )  # fmt: skip


def draw_conditions(rng: np.random.Generator, count: int, heads: Sequence[float]) -> list[tuple]:
    """Power (%), head angle (deg) and head (m) of each trial, shuffled."""
    powers = [(50, 75, 100), (50, 75, 100), (55, 75, 100), (60, 80, 100)][rng.integers(4)]
    sets = [(0, 30, -30, 45), (0, 20, -20, 40, -40), (0, 30, -45, 15), (0, -25, 35, 45, -45),
            (0, 15, -30, 30, 45)]  # fmt: skip
    angles = sets[rng.integers(len(sets))]
    if count < 12:
        angles = (
            0,
            *rng.choice([a for a in angles if a > 0], 1),
            *[a for a in angles if a < 0][:1],
        )
    full = [(p, a, h) for h in heads for p in powers for a in angles]
    order = rng.permutation(len(full))
    picked = [full[order[i % len(full)]] for i in range(count)]
    return [picked[i] for i in rng.permutation(count)]


def draw_trials(
    rng: np.random.Generator, count: int, heads: Sequence[float], noise: Noise, seconds: tuple
) -> tuple[Trial, ...]:
    """Trials with wished durations (s, range) but not yet placed in the pool."""
    pace = rng.uniform(0.92, 1.1)
    out = []
    for i, (power, angle, head) in enumerate(draw_conditions(rng, count, heads)):
        flap = pace * (2.37 + 0.069 * (power - 50))
        out.append(Trial(
            f"T{i + 1:02d}", float(power), np.radians(angle), float(head), rng.uniform(*seconds),
            flap * (1 + rng.normal(0, 0.01)), np.radians(rng.normal(0, 0.3)), rng.normal(0, 0.003),
            rng.uniform(0, 2), draw_gusts(rng, noise.gust_m_s, noise.gust_s),
        ))  # fmt: skip
    return tuple(out)


def draw_lab(
    rng: np.random.Generator, count: int, *, two_heads: bool, long: bool, lens: str
) -> Lab:
    """A laboratory; `long` makes trials of 8 to 12 s for wakes."""
    robot, body = draw_robot(rng)
    noise = draw_noise(rng)
    heads = (
        (robot.head, round(robot.head * rng.uniform(1.35, 1.5), 3)) if two_heads else (robot.head,)
    )
    fps = float(rng.choice([30000 / 1001, 60000 / 1001, 25.0, 50.0], p=[0.45, 0.35, 0.1, 0.1]))
    labels = rng.normal(0, 5e-4, (5, 2))
    labels[2] = 0.0
    return Lab(
        robot, body, draw_camera(rng, LENGTH, WIDTH, lens), rng.normal(0, 0.3, (4, 2)),
        float(rng.choice([0.0, 0.0, 0.05, 0.1])), round(rng.uniform(0.03, 0.05), 3), fps, noise,
        labels, draw_trials(rng, count, heads, noise, (8.0, 12.0) if long else (3.5, 8.0)),
    )  # fmt: skip


Inputs = tuple[Robot, np.ndarray, np.ndarray]


def trial_inputs(
    lab: Lab, trial: Trial, effects: Sequence[fx.Effect], servo: float = 0.0, flap: float = 0.0
) -> Inputs:
    """Robot, table and schedule of a trial; `servo` (rad), `flap` (share) are extra errors."""
    schedule = np.empty((len(trial.gusts), 4))
    schedule[:, 0] = trial.head_angle + trial.servo_error + servo
    schedule[:, 1] = trial.flap * (1 + trial.flap_error + flap)
    schedule[:, 2:] = trial.gusts
    schedule = fx.schedule_with_effects(schedule, effects, trial.power, trial.late)
    robot = fx.robot_with_effects(with_head(lab.robot, trial.head), effects)
    return robot, fx.effect_table(effects), schedule


def simulate_trial(
    lab: Lab, trial: Trial, effects: Sequence[fx.Effect], rate: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (n,), states (n, 7) and path (n, 5) of a trial at `rate` samples a second."""
    times = np.arange(int(trial.seconds * rate) + 1) / rate
    start = np.zeros(STATE_SIZE)
    start[:3] = trial.start
    return times, *simulate(times, start, *trial_inputs(lab, trial, effects))


def actual_head_angle(given: Inputs, times: np.ndarray) -> np.ndarray:
    """Actual head angle (rad) at `times`."""
    schedule = given[2]
    return np.interp(times, np.arange(len(schedule)) * STEP_S, schedule[:, 0])


def body_points(states: np.ndarray, phi: np.ndarray, robot: Robot) -> np.ndarray:
    """Keypoints (n, 5, 2) in PARTS' order, without recoil, metres in the pool frame."""
    head, core = np.exp(1j * states[:, 2]), np.exp(1j * (states[:, 2] + phi))
    com = states[:, 0] + 1j * states[:, 1] + (robot.shift_aft - 1j * robot.shift_left) * core
    hinge = com + robot.hinge * core
    base = com - robot.base * core
    z = np.stack([hinge + robot.head * head, hinge, com, base, base - robot.tail * core], axis=1)
    return np.stack([z.real, z.imag], axis=2)


def wall_clearance(points: np.ndarray) -> np.ndarray:
    """Least distance (m) of each frame's keypoints (n, 5, 2) to the walls; negative outside."""
    gaps = np.concatenate([points, [LENGTH, WIDTH] - points], axis=2)
    return gaps.min(axis=(1, 2))


def _fit_in_pool(rng: np.random.Generator, points: np.ndarray, margin: float) -> tuple | None:
    """Start pose (x, y, theta) that keeps points (n, 5, 2), started at the origin, in the pool."""
    z = points.reshape(-1, 2) @ [1, 1j]
    room = np.array([LENGTH, WIDTH]) - 2 * margin
    for theta in rng.uniform(-np.pi, np.pi, 60):
        turned = z * np.exp(1j * theta)
        low = np.array([turned.real.min(), turned.imag.min()])
        size = np.array([turned.real.max(), turned.imag.max()]) - low
        if np.all(size < room):
            x, y = margin - low + rng.uniform(0, 1, 2) * (room - size)
            return float(x), float(y), float(theta)
    return None


def with_start_pose(
    rng: np.random.Generator, lab: Lab, trial: Trial, effects: Sequence[fx.Effect]
) -> Trial:
    """The trial at a start pose, and of a length, that keep it in the pool.

    The pose comes from a run around the origin; effects that depend on place are then checked.
    """
    homeless = [e for e in effects if e.form.cause not in ("wall_effect", "pool_gyre", "unlisted")]
    here = replace(trial, start=(0.0, 0.0, 0.0))
    given = trial_inputs(lab, here, homeless)
    times, states, _ = simulate_trial(lab, here, homeless, 15)
    points = body_points(states, actual_head_angle(given, times), given[0])
    for _ in range(12):
        stay = times <= here.seconds
        pose = _fit_in_pool(rng, points[stay], 0.1)
        if pose is not None:
            placed = replace(here, start=pose)
            seconds = time_inside_pool(lab, placed, effects)
            if seconds > min(2.9, here.seconds) - 0.1:
                return replace(placed, seconds=seconds)
        here = replace(here, seconds=max(0.88 * here.seconds, 2.5))
    return replace(here, start=(0.45, 0.4, 0.45), seconds=2.5)


def time_inside_pool(lab: Lab, trial: Trial, effects: Sequence[fx.Effect]) -> float:
    """Seconds of the trial before a keypoint comes within 3 cm of a wall."""
    given = trial_inputs(lab, trial, effects)
    times, states, _ = simulate_trial(lab, trial, effects, 15)
    near = wall_clearance(body_points(states, actual_head_angle(given, times), given[0])) < 0.03
    return float(times[np.argmax(near)] - 0.1) if near.any() else trial.seconds


def place_all_trials(rng: np.random.Generator, lab: Lab, effects: Sequence[fx.Effect]) -> Lab:
    """The laboratory with every trial in the pool, those that leave it shortened or moved."""
    out = []
    for trial in lab.trials:
        seconds = time_inside_pool(lab, trial, effects)
        if seconds < min(trial.seconds, 3.0) - 1e-9:
            out.append(with_start_pose(rng, lab, trial, effects))
        else:
            out.append(replace(trial, seconds=seconds))
    return replace(lab, trials=tuple(out))
