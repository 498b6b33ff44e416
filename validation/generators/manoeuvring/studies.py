"""From a seed and an index to a study folder and its truth."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict, dataclass, replace
from pathlib import Path as Folder
from typing import Any

import numpy as np

from validation.generators.manoeuvring import (
    detector,
    dynamics,
    effects,
    measurement,
    noise,
    writing,
)
from validation.generators.manoeuvring.camera import Camera, draw_camera
from validation.generators.manoeuvring.dynamics import (
    POOL,
    Array,
    Flow,
    HiddenEffect,
    Robot,
    SimulatedPath,
    TrialInputs,
)

GENERATOR_NAME = "manoeuvring"
GROUP_COUNTS = {"null": 8, "clear": 8, "faint": 6, "pair": 6, "measurement": 6, "unlisted": 6}
TARGET_SIGMA_RANGES = {
    "clear": (20, 45),
    "faint": (8, 14),
    "pair": (14, 35),
    "measurement": (12, 40),
    "unlisted": (14, 40),
}
CAUSES_NOT_DRAWN = ("tail_fin_lift",)  # half of all studies have it


@dataclass(frozen=True)
class StudyTank:
    """Everything of a study but its hidden effects."""

    robot: Robot
    camera: Camera
    lab: measurement.StatedLab
    drive: TrialInputs
    noise: noise.Noise
    power: Array
    command: Array  # rad, the commanded head angle
    fps: float
    pose: Array  # (3, n)
    wanted: Array  # frames wanted
    frames: tuple[int, ...]  # frames kept
    margin: float
    has_log: bool
    layout: str

    @property
    def trials(self) -> int:
        """Number of trials."""
        return len(self.power)

    def actuation(self, t: Array, effs: list[HiddenEffect]) -> tuple[Array, Array]:
        """Actual flapping frequency (Hz) and head angle (rad) at times t, each (K, n)."""
        t = t[:, None] + 0 * self.drive.phi
        z = 0 * t
        flow = Flow(self.robot, self.drive.head, t - self.drive.start, z, z, z, z, z, z, z)
        dynamics.apply_drive(t, self.drive, flow, effs)
        return flow.f, flow.phi

    def added_depth(self, path: SimulatedPath, effs: list[HiddenEffect]) -> Array:
        """Depth that sinking adds, m, (K, n)."""
        z = 0 * path.S[:, 0]
        flow = Flow(
            self.robot, self.drive.head, path.t[:, None] - self.drive.start, z, z, z, z, z, z, z
        )
        flow.speed = np.hypot(path.S[:, 3], path.S[:, 4])
        return z + sum(e(flow) for e in effs if e.hook == "depth")


@dataclass(frozen=True)
class StudySlot:
    """What index K of a seed holds."""

    group: str
    fin: bool
    trials: int
    causes: tuple[str, ...]


def study_slot(seed: int, index: int) -> StudySlot:
    """Composition by index modulo 40: fixed group and fin, causes dealt from a shuffled pack."""
    table = [(g, i % 2 == 1) for g, n in GROUP_COUNTS.items() for i in range(n)]
    order = np.random.default_rng(4020).permutation(40)
    place = int(order[index % 40])
    group, fin = table[place]
    small = np.random.default_rng(4021).permutation(40)[:10]
    deck = np.random.default_rng([seed, index // 40, 5])
    physics = [c for c in effects.CAUSES if c not in CAUSES_NOT_DRAWN]
    pack = list(deck.permutation(physics)) + list(deck.permutation(physics))
    errors = list(deck.permutation(list(measurement.FORMS)))
    start = {"clear": 0, "faint": 8, "pair": 14}.get(group, 0)
    i = [k for k, (g, _) in enumerate(table) if g == group].index(place)
    causes: tuple[str, ...] = ()
    if group in ("clear", "faint"):
        causes = (pack[start + i],)
    elif group == "pair":
        causes = (pack[14 + 2 * i], pack[15 + 2 * i])
    elif group == "measurement":
        causes = (errors[i],)
    return StudySlot(group, fin, 9 if index % 40 in small else 24, tuple(map(str, causes)))


def draw_robot(rng: np.random.Generator, causes: tuple[str, ...]) -> Robot:
    """A robot within 20 % of the published coefficients and of the paper-default geometry."""

    def near(value: float, spread: float = 0.2) -> float:
        return float(value * rng.uniform(1 - spread, 1 + spread))

    coefficients = np.array([near(c) for c in (4.5e-3, 3.14, 0.5, 2.0, 0.1, 0.12)])
    deep = (0.2, 0.27) if "uncorrected_refraction" in causes else (0.02, 0.08)
    deep = (0.08, 0.15) if "sinking" in causes else deep
    return Robot(
        mass=round(near(0.68), 3),
        yaw_inertia=round(near(0.0095), 5),
        body_length=round(near(0.331, 0.08), 3),
        head_1x=round(near(0.12, 0.06), 3),
        span=round(near(0.069, 0.1), 4),
        hinge_to_com=round(near(0.04, 0.15), 4),
        tail_length=round(near(0.066), 3),
        depth=round(float(rng.uniform(*deep)), 3),
        coefficients=coefficients,
    )


def draw_conditions(
    rng: np.random.Generator, robot: Robot, trials: int, causes: tuple[str, ...]
) -> tuple:
    """Power (%), head angle (deg) and head length (m) of each trial, in random order."""
    powers = np.array([[50, 75, 100], [45, 70, 95], [55, 80, 100], [50, 70, 90]])[rng.integers(4)]
    low, top = (28, 50) if "wake_reentry" in causes else (8, 42)
    two = trials == 24 and (rng.random() < 0.8 or "thrust_area" in causes)
    count = (trials // 3) // (2 if two else 1)
    angles = np.round(rng.uniform(low, top, count - 1)) * np.where(np.arange(count - 1) % 2, -1, 1)
    angles = np.r_[0, angles * rng.choice([-1, 1])]
    heads = [robot.head_1x, round(robot.head_1x * rng.uniform(1.3, 1.6), 3)]
    rows = [(p, a, h) for p in powers for a in angles for h in heads[: 2 if two else 1]]
    rows = np.array(rows)[rng.permutation(len(rows))]
    if not two and (trials == 9 and (rng.random() < 0.6 or "thrust_area" in causes)):
        rows[rng.permutation(9)[:4], 2] = heads[1]
    return rows[:, 0], rows[:, 1], rows[:, 2]


def draw_layout(rng: np.random.Generator, s: StudySlot) -> str:
    """Lens model; homography alone only where neither depth nor lens is in question."""
    if s.group == "measurement" or "sinking" in s.causes:
        return str(rng.choice(["pinhole", "fisheye"], p=[0.6, 0.4]))
    return str(rng.choice(["pinhole", "fisheye", "homography"], p=[0.5, 0.35, 0.15]))


def draw_tank(rng: np.random.Generator, s: StudySlot) -> StudyTank:
    """Robot, camera, trials and noise of a study; poses are provisional."""
    robot, level = draw_robot(rng, s.causes), noise.draw_noise(rng)
    if {"uncorrected_refraction", "scale_error"} & set(s.causes):  # seen in sharp pictures only
        level = replace(
            level, white_px=0.18 + 0.1 * level.white_px, coloured_px=0.07, water_m_s=4e-4
        )
    power, angle, head = draw_conditions(rng, robot, s.trials, s.causes)
    n, fps = (
        s.trials,
        float(rng.choice([30000 / 1001, 60000 / 1001, 25.0, 50.0], p=[0.45, 0.3, 0.15, 0.1])),
    )
    has_log = "time_offset" in s.causes or bool(rng.random() < 0.7)
    lead = rng.uniform(0.4, 1.0, n) if "time_offset" in s.causes else np.zeros(n)
    if has_log and rng.random() < 0.25:
        lead = np.maximum(lead, rng.uniform(0.1, 0.6, n))
    model = draw_layout(rng, s)
    low = "uncorrected_refraction" in s.causes  # oblique rays
    camera = draw_camera(rng, model, (1.5, 1.7) if low else (2.1, 3.0))
    if model == "homography":  # keypoints so near the surface that refraction is below 0.1 px
        robot = replace(robot, depth=round(float(rng.uniform(0.002, 0.006)), 4))
    height = 0.0 if model == "homography" else float(rng.choice([0.0, 0.03, 0.08]))
    flap = 5.82 * rng.uniform(0.9, 1.1) * (power / 100) ** rng.uniform(1.15, 1.4)
    drive = TrialInputs(
        np.radians(angle + rng.normal(0, level.servo_deg, n)),
        flap * (1 + rng.normal(0, 0.008, n)),
        head,
        np.round(lead * fps) / fps,
        noise.draw_vortices(rng, n, level.water_m_s),
        np.zeros((2, n)),
        np.zeros((2, n)),
    )
    long = "wake_reentry" in s.causes
    seconds = rng.uniform(9, 12, n) if long else np.clip(rng.gamma(12, 0.5, n), 3.5, 11) + lead
    return StudyTank(
        robot, camera, measurement.measure_lab(rng, camera, robot.depth, height), drive, level,
        power, np.radians(angle), fps, np.tile([[POOL[0] / 2], [POOL[1] / 2], [0.0]], n),
        np.round(seconds * fps).astype(int), (), 0.2 if "wall_effect" in s.causes else 0.24,
        has_log, model,
    )  # fmt: skip


def fit_in_pool(rel: Array, margin: float, rng: np.random.Generator) -> tuple[Array, int]:
    """Start pose (3,) that keeps a complex path rel (frames,) in the pool, and the frames kept.

    The path rel starts at 0 along x. Tries 24 directions; the path is cut where its bounding box
    outgrows the pool less the margin.
    """
    best, kept = np.zeros(3), -1
    room = np.array(POOL) - 2 * margin
    for a in np.r_[
        rng.uniform(-np.pi, np.pi, 20), rng.normal(0, 0.15, 4) + np.pi * rng.integers(0, 2, 4)
    ]:
        z = rel * np.exp(1j * a)
        low = np.minimum.accumulate(np.stack([z.real, z.imag]), axis=1)
        high = np.maximum.accumulate(np.stack([z.real, z.imag]), axis=1)
        count = int(((high - low) <= room[:, None]).all(0).sum())
        if count > kept:
            slack = room - (high - low)[:, count - 1]
            best = np.r_[margin - low[:, count - 1] + slack * rng.random(2), a]
            kept = count
    return best, kept


def frames_inside_pool(tank: StudyTank, path: SimulatedPath) -> Array:
    """Frames until each trial comes too near a wall (or its wanted end)."""
    x, y, _ = path.core(tank.robot, tank.drive.head)
    gap = np.minimum.reduce([x, POOL[0] - x, y, POOL[1] - y])
    out = (gap < tank.margin - 0.04) | ~np.isfinite(gap)
    first = np.where(out.any(0), out.argmax(0), len(out))
    return np.minimum(first, tank.wanted)


def simulate_in_pool(
    tank: StudyTank, effs: list[HiddenEffect], rng: np.random.Generator, rounds: int = 3
) -> tuple[StudyTank, SimulatedPath]:
    """Simulated trials, after new start poses for those that leave the pool too early."""
    frames = int(tank.wanted.max())
    for i in range(rounds + 1):
        path = dynamics.simulate(
            tank.pose, tank.robot, tank.drive, effs, fps=tank.fps, frames=frames
        )
        kept = frames_inside_pool(tank, path)
        early = kept < np.minimum(0.75 * tank.wanted, 4 * tank.fps)
        if i == rounds or not (early.any() or not tank.frames):
            break
        x, y, psi = path.core(tank.robot, tank.drive.head)
        pose, wanted = tank.pose.copy(), tank.wanted.copy()
        for j in np.flatnonzero(early | (not tank.frames)):
            rel = ((x[:, j] - x[0, j]) + 1j * (y[:, j] - y[0, j])) * np.exp(-1j * psi[0, j])
            pose[:, j], n = fit_in_pool(rel[: wanted[j]], tank.margin, rng)
            wanted[j] = max(min(wanted[j], n), int(3 * tank.fps))
        tank = replace(tank, pose=pose, wanted=wanted, frames=tuple(kept))
    return replace(tank, frames=tuple(int(k) for k in kept)), path


def draw_fin(rng: np.random.Generator, robot: Robot) -> HiddenEffect:
    """A tail fin from 1.1 to 3 times the area that just makes straight swimming stable."""
    effect, (low, high) = effects.draw_effect("tail_fin_lift", rng)
    one = np.ones(1)
    drive = TrialInputs(
        0 * one, 4 * one, robot.head_1x * one, 0 * one, np.zeros((5, 0, 1)), *np.zeros((2, 2, 1))
    )
    U = 4 * np.sqrt(robot.coefficients[0] / robot.coefficients[2])

    def growth(area: float) -> float:
        S = np.zeros((8, 1))
        S[3] = U
        J = np.zeros((2, 2))
        for i, row in enumerate((4, 5)):
            dS = S.copy()
            dS[row] += 1e-5
            d = dynamics.rates(one, dS, robot, drive, [effect.scaled(area)])
            J[:, i] = d[4:6, 0] / 1e-5
        return float(np.linalg.eigvals(J).real.max())

    for _ in range(25):
        mid = np.sqrt(low * high)
        low, high = (mid, high) if growth(mid) > 0 else (low, mid)
    return effect.scaled(float(high * np.exp(rng.uniform(np.log(1.1), np.log(3.0)))))


def solve_strengths(
    tank: StudyTank, drawn: list, fixed: list[HiddenEffect], goal: tuple, rng: np.random.Generator
) -> tuple:
    """Strengths that bring each effect into the range: ok, tank, path, effects, sigma."""
    low, high = goal
    target = np.exp(rng.uniform(np.log(low * 1.1), np.log(high * 0.9), len(drawn)))
    effs, bounds = [e for e, _ in drawn], [b for _, b in drawn]
    path, sigma = None, np.zeros(0)
    for _ in range(7):
        tank, path = simulate_in_pool(tank, [*effs, *fixed], rng, 2)
        if min(tank.frames) < 2 * tank.fps:
            return False, tank, path, effs, sigma
        sigma = detector.detectability(tank, path, [*effs, *fixed])[0]
        s = sigma[: len(effs)]
        if ((s >= low) & (s <= high) & (abs(np.log(s / target)) < 0.25)).all():
            return True, tank, path, effs, sigma
        old = np.array([e.strength for e in effs])
        new = np.abs(old) * np.clip(target / np.maximum(s, 1e-3), 0.15, 6)
        new = np.sign(old) * np.clip(new, *np.array(bounds).T)
        if np.allclose(new, old, rtol=1e-6):  # at the bounds of what is plausible
            return bool(((s >= low) & (s <= high)).all()), tank, path, effs, sigma
        effs = [e.scaled(float(v)) for e, v in zip(effs, new, strict=True)]
    return False, tank, path, effs, sigma


def candidate_effects(s: StudySlot, attempt: int, rng: np.random.Generator) -> list:
    """Effects to tune: the dealt causes (three attempts, each its own form), then other causes."""
    if s.group == "unlisted":
        return [effects.draw_effect("unlisted", rng)]
    names = list(s.causes)
    if attempt >= 3 and names:
        pool = list(measurement.FORMS) if s.group == "measurement" else list(effects.CAUSES)[1:]
        others = [
            c for c in pool if c not in (*names, "thrust_area", "wake_reentry", "time_offset")
        ]
        names = [str(c) for c in rng.choice(others, len(names), replace=False)]
    return [
        (measurement.draw_error if c in measurement.FORMS else effects.draw_effect)(c, rng)
        for c in names
    ]


def compose_study(
    seed: int, index: int
) -> tuple[StudySlot, StudyTank, SimulatedPath, list[HiddenEffect], Array]:
    """The study in memory: what is asked, tank, paths, all effects and their sigma."""
    s = study_slot(seed, index)
    for attempt in range(10):
        rng = np.random.default_rng([seed, index, attempt])
        tank = draw_tank(rng, s)
        fixed = [draw_fin(rng, tank.robot)] if s.fin else []
        drawn = candidate_effects(s, attempt, rng)
        if drawn:
            ok, tank, path, effs, sigma = solve_strengths(
                tank, drawn, fixed, TARGET_SIGMA_RANGES[s.group], rng
            )
        else:
            effs, (tank, path) = [], simulate_in_pool(tank, fixed, rng)
            sigma = detector.detectability(tank, path, fixed)[0]
            ok = min(tank.frames) >= 2 * tank.fps
        if ok and (not s.fin or sigma[-1] >= 15):
            return s, tank, path, [*effs, *fixed], sigma
    raise RuntimeError(
        f"study {index} of seed {seed}: no strength within {TARGET_SIGMA_RANGES[s.group]} sigma"
    )


def unit_of(key: str) -> str:
    """Unit at the end of a parameter's name; 1 where it has none."""
    units = {"_rad_s": "rad/s", "_m_s": "m/s", "_rad": "rad", "_m": "m", "_s": "s"}
    return next((unit for end, unit in units.items() if key.endswith(end)), "1")


def truth_json(
    name: str, s: StudySlot, tank: StudyTank, effs: list[HiddenEffect], sigma: Array
) -> dict[str, Any]:
    """The truth file's content."""
    causes, hidden = [], None
    for e, sg in sorted(zip(effs, sigma, strict=True), key=lambda p: -p[1]):
        p = {"strength": {"value": float(e.strength), "unit": e.unit}}
        p |= {k: {"value": v, "unit": unit_of(k)} for k, v in e.shape.items()}
        row = {
            "name": e.name,
            "kind": e.kind,
            "form": e.form,
            "sigma": round(float(sg), 2),
            "parameters": p,
        }
        if e.name == "unlisted":
            channels, variable = effects.UNLISTED[e.form]
            hidden = {"channels": channels, "variable": variable, **row}
        else:
            causes.append(row)
    kinds = {e.kind for e in effs}
    verdict = "physics" if kinds else "none"
    verdict = "measurement" if "measurement" in kinds else verdict
    verdict = "unexplained" if hidden else verdict
    robot = {k: v for k, v in vars(tank.robot).items() if k != "coefficients"}
    robot |= dict(zip(dynamics.COEFFICIENTS, map(float, tank.robot.coefficients), strict=True))
    where = {
        "fps": tank.fps, "camera": tank.layout, "motor_log": tank.has_log,
        "powers_pct": sorted(set(tank.power.tolist())),
        "head_angles_deg": sorted(set(np.round(np.degrees(tank.command), 1).tolist())),
        "head_lengths_m": sorted(set(tank.drive.head.tolist())),
    }  # fmt: skip
    return {
        "study": name,
        "generator": GENERATOR_NAME,
        "group": s.group,
        "fin": s.fin,
        "trials": s.trials,
        "verdict": verdict,
        "causes": causes,
        "unlisted": hidden,
        "noise": asdict(tank.noise),
        "robot": robot,
        "conditions": where,
    }


def generate(seed: int, index: int, directory: Folder) -> dict[str, Any]:
    """Write study and truth under `directory`; return the truth. A finished study is only read."""
    name = f"{GENERATOR_NAME}-{seed}-{index:03d}"
    answer, folder = directory / "truth" / f"{name}.json", directory / "studies" / name
    if answer.exists():
        return dict(json.loads(answer.read_text()))
    s, tank, path, effs, sigma = compose_study(seed, index)
    reported = truth_json(name, s, tank, effs, sigma) | {"seed": seed, "index": index}
    part = directory / "studies" / f".{name}.part"
    shutil.rmtree(part, ignore_errors=True)
    writing.write_study(part, tank, path, effs, np.random.default_rng([seed, index, 99]))
    shutil.rmtree(folder, ignore_errors=True)
    part.rename(folder)
    answer.parent.mkdir(parents=True, exist_ok=True)
    answer.with_suffix(".part").write_text(json.dumps(reported, indent=1))
    answer.with_suffix(".part").rename(answer)
    return reported
