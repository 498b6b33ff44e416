"""Composition of the studies: group and causes by index, conditions, strengths, truth."""

import json
import math
import os
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.camera import draw_camera
from validation.generators.strip_theory.detector import (
    FLAP_STD,
    SERVO_STD,
    ObservationScene,
    detectability,
)
from validation.generators.strip_theory.effects import (
    FINS,
    MEASUREMENT_CAUSES,
    PHYSICS_CAUSES,
    UNLISTED,
    Form,
    forms_of,
)
from validation.generators.strip_theory.files import write_study
from validation.generators.strip_theory.noise import draw_noise
from validation.generators.strip_theory.parameters import COEFFICIENTS, INDEX, KEYS, NAMES, UNITS
from validation.generators.strip_theory.tank import (
    SimulatedTrial,
    Trial,
    fin_area_for,
    run_trials,
    straight_growth_rate,
)
from validation.generators.strip_theory.water import random_modes

Floats = NDArray[np.float64]
GENERATOR_NAME = "strip_theory"
SLOT_CYCLE = 40
SLOT_PERMUTATION = np.random.default_rng(1805).permutation(SLOT_CYCLE)  # index modulo 40 -> slot
GROUPS = (("null", 8), ("clear", 8), ("faint", 6), ("pair", 6), ("measurement", 6), ("unlisted", 6))
TARGET_SIGMA_RANGES = {"clear": (20.0, 45.0), "faint": (8.0, 14.0), "pair": (14.0, 35.0),
          "measurement": (12.0, 40.0), "unlisted": (14.0, 40.0)}  # fmt: skip
POOL = (2.6, 1.6, 0.3)
FIN_SIGMA = 15.0
HiddenEffect = tuple[Form, dict[str, float]]


@dataclass(frozen=True)
class StudySlot:
    """Group of a study and its rank within the group."""

    group: str
    rank: int
    fin: bool
    trials: int


@dataclass(frozen=True)
class SolvedStudy:
    """Study with strengths found: parameters, runs, strength and sigma by hidden effect."""

    P: Floats
    runs: list[SimulatedTrial]
    hidden: list[HiddenEffect]
    strengths: list[float]
    sigmas: list[float]


def study_slot(index: int) -> StudySlot:
    """Return the group of study `index`; any 40 consecutive indices hold the whole composition."""
    slot = int(SLOT_PERMUTATION[index % SLOT_CYCLE])
    group, rank = [(name, k) for name, size in GROUPS for k in range(size)][slot]
    short = slot % 4 == (slot // 4) % 2
    return StudySlot(group, rank, slot % 2 == 0, 9 if short else 24)


def cause_in_turn(causes: tuple[str, ...], seed: int, position: int) -> str:
    """Return the cause at `position` of a sequence in which every cause comes once a round."""
    n = len(causes)
    order = np.random.default_rng([seed, 77, n, position // n]).permutation(n)
    return causes[order[position % n]]


def hidden_causes(seed: int, index: int) -> list[str]:
    """Return the names of the hidden effects that study `index` is to have, besides a fin."""
    place, block = study_slot(index), index // SLOT_CYCLE
    if place.group in ("clear", "faint", "pair"):
        start = {"clear": 0, "faint": 8, "pair": 14}[place.group] + block * 26
        at = [place.rank] if place.group != "pair" else [place.rank, place.rank + 6]
        return [cause_in_turn(PHYSICS_CAUSES, seed, start + k) for k in at]
    if place.group == "measurement":
        return [cause_in_turn(MEASUREMENT_CAUSES, seed, block * 6 + place.rank)]
    if place.group == "unlisted":
        names = tuple(row.form for row in UNLISTED)
        return [cause_in_turn(names, seed, block * 6 + place.rank)]
    return []


def draw_robot(rng: np.random.Generator) -> Floats:
    """Return P with geometry and the six coefficients of one robot, +-20 % (MODEL.md, audit 2)."""
    P = np.zeros(len(NAMES))
    middle = {"C_T": 4.5e-3, "C_LA": 3.14, "C_DA": 2.0, "C_D0": 0.5, "C_MA": 0.1, "C_MD": 0.12}
    for name, value in middle.items():
        P[INDEX[name]] = value * rng.uniform(0.8, 1.2)
    head, body, hinge, tail = (
        round(v * rng.uniform(0.9, 1.1), 4) for v in (0.12, 0.331, 0.04, 0.066)
    )
    P[[KEYS.HEAD, KEYS.HEAD_1X, KEYS.BODY, KEYS.HINGE, KEYS.TAIL]] = head, head, body, hinge, tail
    P[KEYS.AFT] = body - head - hinge
    P[KEYS.SPAN] = round(0.069 * rng.uniform(0.9, 1.1), 4)
    P[KEYS.MASS] = round(0.68 * rng.uniform(0.85, 1.15), 3)
    P[KEYS.INERTIA] = round(0.0095 * P[KEYS.MASS] / 0.68 * rng.uniform(0.9, 1.1), 5)
    P[[KEYS.RHO, KEYS.POOL_L, KEYS.POOL_W, KEYS.LOSS_V, KEYS.CUR_NOW]] = (
        1000.0,
        POOL[0],
        POOL[1],
        1.0,
        1.0,
    )
    P[KEYS.AREA] = P[KEYS.AREA_1X] = head * P[KEYS.SPAN]
    return P


def draw_conditions(rng: np.random.Generator, count: int, head_1x: float, two_heads: bool
                    ) -> list[tuple[float, float, float]]:  # fmt: skip
    """Return (power %, head angle deg, head length m) of every trial, in random order."""
    powers = [(50, 75, 100), (45, 70, 100), (60, 80, 100)][int(rng.integers(3))]
    long = round(head_1x * float(rng.uniform(1.35, 1.55)), 4)
    a, b, c = rng.choice([10, 15, 20, 25], 1)[0], rng.choice([28, 30, 35]), rng.choice([40, 45])
    sign = float(rng.choice([-1.0, 1.0]))
    if count == 9:
        cells = [(0.0, head_1x), (sign * b, head_1x), (-sign * c, long if two_heads else head_1x)]
    else:
        angles = [0.0, sign * a, -sign * b, sign * c, -sign * a, sign * b]
        extra = (
            [(0.0, long), (sign * b, long)] if two_heads else [(-sign * c, head_1x), (0.0, head_1x)]
        )
        cells = [(angle, head_1x) for angle in angles] + extra
    rows = [(float(p), float(angle), h) for p in powers for angle, h in cells]
    return [rows[k] for k in rng.permutation(len(rows))]


def draw_trials(rng: np.random.Generator, place: StudySlot, P: Floats, names: list[str], rms: float
                ) -> list[Trial]:  # fmt: skip
    """Return the trials without start poses."""
    two = rng.random() < 0.75 or "thrust_area" in names
    rows = draw_conditions(rng, place.trials, P[KEYS.HEAD_1X], two)
    fps = float(rng.choice([30000 / 1001, 60000 / 1001, 25.0, 50.0], p=[0.5, 0.3, 0.1, 0.1]))
    slope, base = rng.uniform(0.062, 0.074), 2.37 * rng.uniform(0.9, 1.1)
    lead = rng.random() < 0.25 and "time_offset" not in names
    trials = []
    for order, (power, angle, head) in enumerate(rows):
        long = "wake_reentry" in names and angle != 0.0
        duration = rng.uniform(8.0, 12.0) if long or rng.random() < 0.06 else rng.uniform(3.2, 8.0)
        lead_in = rng.uniform(0.2, 0.6) if lead else 0.0
        trials.append(Trial(
            f"T{order + 1:02d}", order, power, math.radians(angle), head, fps, float(duration),
            float(base + slope * (power - 50.0)), rng.normal(0, SERVO_STD), rng.normal(0, FLAP_STD),
            float(lead_in), random_modes(rng, POOL, rms), len(rows)))  # fmt: skip
    return trials


def with_lead_in(trials: list[Trial], hidden: list[HiddenEffect]) -> list[Trial]:
    """Give every trial a lead-in of 0.5 s where the hidden offset shifts a log that shows one."""
    if any(form.form == "lead_in_shifted" for form, _ in hidden):
        return [Trial(**(vars(trial) | {"lead_in": 0.5})) for trial in trials]
    return trials


def add_fin(P: Floats, rng: np.random.Generator) -> HiddenEffect:
    """Write a fin into P, from marginally to strongly stable at full power; return its row."""
    form = FINS[int(rng.integers(len(FINS)))]
    sides = form.draw(rng)
    form.put(P, form.low, sides)
    rate = -float(np.exp(rng.uniform(math.log(0.1), math.log(2.5))))
    area = fin_area_for(P, 5.8, rate, (form.low, form.high))
    form.put(P, area, sides)
    return form, sides


def choose_forms(names: list[str], rng: np.random.Generator) -> list[HiddenEffect]:
    """Draw a functional form and its side parameters for every named effect."""
    out = []
    for name in names:
        rows = forms_of(name) or [row for row in UNLISTED if row.form == name]
        form = rows[int(rng.integers(len(rows)))]
        out.append((form, form.draw(rng)))
    return out


def with_strengths(P: Floats, hidden: list[HiddenEffect], strengths: list[float]) -> Floats:
    """Return P with the hidden effects at the given strengths."""
    out = P.copy()
    for (form, sides), s in zip(hidden, strengths, strict=True):
        form.put(out, s, sides)
    return out


def secant_step(history: list[tuple[float, float]], target: float, form: Form) -> float:
    """Next strength: secant in log strength and log sigma, within the form's bounds."""
    (s1, g1) = history[-1]
    slope = 1.0
    if len(history) > 1 and abs(math.log(s1 / history[-2][0])) > 0.02:
        slope = math.log(g1 / history[-2][1]) / math.log(s1 / history[-2][0])
    step = math.log(target / max(g1, 0.05)) / min(max(slope, 0.5), 2.0)
    return min(max(s1 * math.exp(min(max(step, -3.0), 3.0)), form.low), form.high)


def solve_strengths(
    P: Floats,
    trials: list[Trial],
    hidden: list[HiddenEffect],
    scene: ObservationScene,
    *,
    group: str,
    seed: list[int],
) -> SolvedStudy | None:
    """Find strengths that give a sigma within the group's range; None if bounds forbid it."""
    rng = np.random.default_rng([*seed, 5])
    low, high = TARGET_SIGMA_RANGES.get(group, (0.0, np.inf))
    targets = [float(rng.uniform(low * 1.12, high * 0.9)) for _ in hidden]
    fins = [FINS[int(P[KEYS.FIN_FORM]) - 1]] if P[KEYS.FIN_AREA] > 0 else []
    strengths = [math.sqrt(form.low * form.high) for form, _ in hidden]
    history: list[list[tuple[float, float]]] = [[] for _ in hidden]
    for _ in range(9):
        full = with_strengths(P, hidden, strengths)
        runs = run_trials(trials, full, seed)
        short = any(len(run.Y) < 3.0 * run.trial.fps for run in runs)
        finite = all(np.isfinite(run.Y).all() for run in runs)
        if not finite or short:
            return None
        sigmas = detectability(runs, full, [*fins, *(form for form, _ in hidden)], scene)
        own = sigmas[len(fins) :]
        if all(low <= g <= high for g in own):
            return SolvedStudy(full, runs, hidden, strengths, sigmas)
        stuck = True
        for k, (form, _) in enumerate(hidden):
            history[k].append((strengths[k], max(own[k], 1e-3)))
            new = secant_step(history[k], targets[k], form)
            stuck &= abs(math.log(new / strengths[k])) < 1e-3
            strengths[k] = new
        if stuck:
            return None
    return None


def try_study(
    seed: int, index: int, number: int
) -> tuple[SolvedStudy, ObservationScene, bool] | None:
    """Draw the study with the `number`-th choice of causes; None where it is not reachable."""
    place = study_slot(index)
    rng = np.random.default_rng([seed, index, number])
    names = hidden_causes(seed, index)
    if number >= 3:  # the intended cause is out of reach of this robot and these trials
        pool = {"measurement": MEASUREMENT_CAUSES, "unlisted": tuple(r.form for r in UNLISTED)}
        names = list(rng.choice(pool.get(place.group, PHYSICS_CAUSES), len(names), replace=False))
    P, noise = draw_robot(rng), draw_noise(rng)
    plain = place.group != "measurement" and rng.random() < 0.1
    refracted = "uncorrected_refraction" in names  # seen well only deep and under a wide lens
    deep = rng.uniform(0.2, 0.24) if refracted else rng.uniform(0.02, 0.06)
    depth = 0.008 if plain else round(float(deep), 3)
    scene = ObservationScene(draw_camera(rng, POOL[:2], plain, 1.333, low=refracted), depth, noise)
    if place.fin:
        add_fin(P, rng)
    hidden = choose_forms(names, rng)
    trials = with_lead_in(draw_trials(rng, place, P, names, noise.water_rms_m_s), hidden)
    for _ in range(4):
        solved = solve_strengths(
            P, trials, hidden, scene, group=place.group, seed=[seed, index, number]
        )
        if solved is None or not place.fin or solved.sigmas[0] >= FIN_SIGMA:
            break
        P[KEYS.FIN_AREA] = min(1.5 * P[KEYS.FIN_AREA], FINS[0].high)
    if solved is None or (place.fin and solved.sigmas[0] < FIN_SIGMA):
        return None
    return solved, scene, plain


def truth_json(
    seed: int, index: int, solved: SolvedStudy, scene: ObservationScene, name: str
) -> dict:
    """Return the truth file's content."""
    place, P = study_slot(index), solved.P
    fin = FINS[int(P[KEYS.FIN_FORM]) - 1] if place.fin else None
    rows = list(zip(solved.hidden, solved.strengths, solved.sigmas[int(place.fin) :], strict=True))
    causes, other = [], None
    if fin is not None:
        sides = {key: float(P[INDEX[key]]) for key in fin.sides} | {"sign": 1.0}
        causes.append({"name": fin.cause, "kind": "physics", "form": fin.form,
                       "sigma": round(solved.sigmas[0], 2),
                       "parameters": fin.stated(float(P[KEYS.FIN_AREA]), sides)})  # fmt: skip
    for (form, sides), s, sigma in rows:
        row = {"form": form.form, "sigma": round(sigma, 2), "parameters": form.stated(s, sides)}
        if form.kind == "unlisted":
            other = {"channels": list(form.channels), "variable": form.variable} | row
        else:
            causes.append({"name": form.cause, "kind": form.kind} | row)
    verdict = {"measurement": "measurement", "unlisted": "unexplained"}.get(
        place.group, "physics" if causes else "none")  # fmt: skip
    robot = {n: {"value": float(P[INDEX[n]]), "unit": UNITS[n]} for n in COEFFICIENTS}
    growth = {
        "straight_growth_per_s": round(straight_growth_rate(P, solved.runs[0].trial.flap_hz), 3)
    }
    return {"study": name, "generator": GENERATOR_NAME, "seed": seed, "index": index,
            "group": place.group, "fin": place.fin, "trials": len(solved.runs), "verdict": verdict,
            "causes": causes, "unlisted": other, "noise": asdict(scene.noise),
            "robot": robot | growth, "conditions": conditions_json(solved, scene)}  # fmt: skip


def conditions_json(solved: SolvedStudy, scene: ObservationScene) -> dict:
    """Return the true camera and the trials' true conditions for the truth file."""
    trials = [
        {"trial_id": r.trial.name, "servo_error_deg": math.degrees(r.trial.servo_error),
         "flap_error": r.trial.flap_error, "duration_s": float(r.times[-1]),
         "start": list(map(float, r.trial.start))}
        for r in solved.runs
    ]  # fmt: skip
    return {"camera": asdict(scene.camera), "keypoint_depth_m": scene.depth, "trials": trials}


def generate(seed: int, index: int, directory: Path) -> dict:
    """Write study `index` of `seed` under `directory` and return its truth; see GENERATOR.md."""
    name = f"{GENERATOR_NAME}-{seed}-{index:03d}"
    target = Path(directory) / "truth" / f"{name}.json"
    if target.exists():
        return json.loads(target.read_text())
    found, number = None, 0
    while found is None:
        if number > 25:
            raise RuntimeError(f"study {name}: no strength within range after {number} attempts")
        found, number = try_study(seed, index, number), number + 1
    solved, scene, plain = found
    rng = np.random.default_rng([seed, index, 999])
    written = write_study(Path(directory) / "studies" / name, solved.runs, solved.P, scene,
                          plain=plain, rng=rng)  # fmt: skip
    truth = truth_json(seed, index, solved, scene, name)
    truth["conditions"] |= written
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_suffix(".part")
    text = json.dumps(truth, indent=1)
    part.write_text(text)
    os.replace(part, target)
    return json.loads(text)
