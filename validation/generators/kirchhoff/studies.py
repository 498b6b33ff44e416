"""Composition, calibration and writing of studies."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import yaml
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline

from . import observe
from .camera import draw_camera
from .detector import BLOCK_S, cut_into_blocks, path_detectability_sigmas
from .dynamics import HiddenEffect, Robot, StudyWorld, Trials, simulate, straight_growth_rate
from .effects import Form, cause_names, draw_unlisted, forms_of
from .noise import draw_noise, motor_log, tracked_keypoints, water_accelerations
from .observe import KEYPOINT_NAMES, StudyTruth

GENERATOR_NAME = "kirchhoff"
GROUPS_BY_SLOT = (
    ["null"] * 8
    + ["clear"] * 8
    + ["faint"] * 6
    + ["pair"] * 6
    + ["measurement"] * 6
    + ["unlisted"] * 6
)
SLOT_PERMUTATION = np.random.default_rng(91735).permutation(40)
NINE_TRIAL_SLOTS = {1, 4, 9, 14, 17, 20, 25, 28, 33, 38}  # places in GROUPS with nine trials
TARGET_SIGMAS = {
    "clear": (20, 45), "faint": (8, 14), "pair": (14, 35),
    "measurement": (12, 40), "unlisted": (14, 40),
}  # fmt: skip
COARSE, FINE = 40, 120  # integration steps a second while calibrating and in the end
REPORTED = ("report", "observe", "mass_centre")


def study_slot(index: int) -> tuple[str, bool, int]:
    """Group, fin and number of trials of a study index."""
    k = int(SLOT_PERMUTATION[index % 40])
    return GROUPS_BY_SLOT[k], k % 2 == 1, 9 if k in NINE_TRIAL_SLOTS else 24


def cause_from_deck(seed: int, kind: str, number: int) -> str:
    """Card ``number`` of endless shuffled decks of cause names, so that all come equally often."""
    cards = cause_names(kind)
    deck = np.random.default_rng([seed, number // len(cards), len(cards)]).permutation(len(cards))
    return cards[deck[number % len(cards)]]


def causes_of(seed: int, index: int) -> list[str]:
    """Names of the calibrated causes of a study, fin excluded."""
    group, k, lap = study_slot(index)[0], int(SLOT_PERMUTATION[index % 40]), index // 40
    if group == "measurement":
        return [cause_from_deck(seed, "measurement", lap * 6 + k - 28)]
    if group in ("clear", "faint"):
        return [cause_from_deck(seed, "physics", lap * 26 + k - 8)]
    if group != "pair":
        return []
    number = lap * 26 + 14 + 2 * (k - 22)
    first, second = (
        cause_from_deck(seed, "physics", number),
        cause_from_deck(seed, "physics", number + 1),
    )
    return [first, second if second != first else cause_from_deck(seed, "physics", number + 2)]


def draw_robot(rng: np.random.Generator) -> Robot:
    """Robot within 20 per cent of the paper's calibration (MODEL.md, audit 2 and Table I)."""

    def about(value: float, part: float = 0.2) -> float:
        return float(value * rng.uniform(1 - part, 1 + part))

    return Robot(
        mass=about(0.68), inertia=about(0.0095), body_length=about(0.331, 0.1),
        head_length=about(0.12, 0.1), head_span=about(0.069, 0.15), hinge_to_com=about(0.04),
        tail_length=about(0.066), depth=about(0.04, 0.5), C_T=about(4.5e-3), C_La=about(3.14),
        C_D0=about(0.5), C_Da=about(2.5), C_Ma=about(0.1), C_Md=about(0.125),
    )  # fmt: skip


def draw_trials(rng: np.random.Generator, robot: Robot, count: int, wishes: set[str]) -> Trials:
    """Conditions: a random sample of a grid of powers, head angles and head lengths."""
    powers = np.array([[50, 75, 100], [60, 80, 100], [50, 70, 90], [55, 75, 95]][rng.integers(4)])
    positive = rng.choice([15, 20, 25, 30, 35, 40, 45], 2 if count == 24 else 1, replace=False)
    negative = -rng.choice([15, 20, 25, 30, 35, 40, 45], int(rng.integers(1, 3)), replace=False)
    angles = np.concatenate([[0], positive, negative[: 1 if count == 9 else 2]])
    heads = [1.0]
    if "thrust_area" in wishes or (count == 24 and rng.random() < 0.85):
        heads.append(float(rng.choice([1.25, 1.458, 1.5])))
    grid = np.array([(p, a, h) for p in powers for a in angles for h in heads])
    if count == 9:  # each power with each angle
        grid = np.array([(p, a, rng.choice(heads)) for p in powers for a in angles])
    laps = np.concatenate([rng.permutation(grid) for _ in range(count // len(grid) + 1)])[:count]
    power, angle, head = laps[np.argsort(rng.random(count))].T
    f = 5.82 * rng.uniform(0.92, 1.08) * (power / 100) ** rng.uniform(1.15, 1.4)
    zero = np.zeros(count)
    long = rng.random(count) < 0.08
    if "wake_reentry" in wishes:
        long = (np.abs(angle) >= 20) & (power >= 70)
    return Trials(
        power=power, phi=np.radians(angle), servo=zero, head=head * robot.head_length,
        f=f * (1 + 0.01 * rng.normal(size=count)),
        duration=np.where(long, rng.uniform(9, 12, count), rng.uniform(3.5, 8, count)),
        x0=zero, y0=zero, theta0=zero,
    )  # fmt: skip


def draw_start_poses(  # noqa: PLR0917
    rng: np.random.Generator,
    trials: Trials,
    path: np.ndarray,
    per_second: int,
    pool: tuple,
    margin: float,
) -> Trials:
    """Start poses (and shorter durations where needed) that keep each path inside the pool."""
    x0, y0, theta0, duration = (
        getattr(trials, k).copy() for k in ("x0", "y0", "theta0", "duration")
    )
    room = np.array(pool) - 2 * margin
    for b in range(len(x0)):
        z = (path[:, 0, b] + 1j * path[:, 1, b] - trials.x0[b] - 1j * trials.y0[b]) * np.exp(
            -1j * trials.theta0[b]
        )
        for _ in range(400):
            heading = rng.uniform(-np.pi, np.pi)
            w = z[: int(duration[b] * per_second) + 1] * np.exp(1j * heading)
            low = np.array([w.real.min(), w.imag.min()])
            spare = room - np.array([w.real.max(), w.imag.max()]) + low
            if (spare > 0).all():
                break
            duration[b] = max(duration[b] * 0.99, 3.0)
        start = margin - low + rng.random(2) * np.maximum(spare, 0)
        x0[b], y0[b], theta0[b] = *start, heading
    return replace(trials, x0=x0, y0=y0, theta0=theta0, duration=duration)


def wall_times(
    path: np.ndarray, trials: Trials, per_second: int, pool: tuple, margin: float
) -> np.ndarray:
    """Time (s) at which each trial comes within ``margin`` of a wall, inf if it does not."""
    x, y = path[:, 0], path[:, 1]
    out = (x < margin) | (x > pool[0] - margin) | (y < margin) | (y > pool[1] - margin)
    out &= np.arange(len(path))[:, None] / per_second <= trials.duration
    return np.where(out.any(0), out.argmax(0) / per_second, np.inf)


def detectability_sigmas(
    study: StudyTruth, path: np.ndarray, per_second: int
) -> tuple[list[float], list[float]]:
    """Total and path sigma of each hidden effect of a study."""
    cut = cut_into_blocks(path, study.trials, per_second)
    t = np.arange(len(cut.seen)) * BLOCK_S
    pixel_m = study.camera.centre[2] / study.camera.matrix[0]
    seen, sizes = [], []
    for h in study.world.hidden:
        change = (None, None)
        if h.form.channel in REPORTED:
            alone = replace(study, world=replace(study.world, hidden=(h,)))
            change = observe.observed_change(alone, path, per_second, t)
        seen.append(change[0])
        sizes.append(change[1])
    on_path = path_detectability_sigmas(
        study.world, cut, study.noise, seen, pixel_m=pixel_m, fps=study.fps
    )
    total = [
        np.hypot(s, observe.length_and_label_sigma(study, i, sizes[i], cut.seen, pixel_m))
        if study.world.hidden[i].form.channel in ("report", "observe")
        and study.world.hidden[i].form.name not in ("time_offset", "camera_shift")
        else s
        for i, s in enumerate(on_path)
    ]
    return [float(s) for s in total], on_path


def solve_strengths(study: StudyTruth, targets: dict[int, float]) -> StudyTruth | None:
    """Solve for the strengths that give ``targets`` (sigma by index), or None."""
    log_s, log_sigma = [], []
    for _ in range(9):
        path = simulate(study.world, study.trials, study.gusts, COARSE)
        if not np.isfinite(path).all():
            return None
        total, _ = detectability_sigmas(study, path, COARSE)
        now = np.array([total[i] for i in targets]).clip(1e-3)
        goal = np.array(list(targets.values()))
        if (np.abs(np.log(now / goal)) < 0.06).all():
            return study
        log_s.append(np.log([study.world.hidden[i].strength for i in targets]))
        log_sigma.append(np.log(now))
        slope = np.ones(len(goal))
        if len(log_s) > 1:
            moved = log_s[-1] - log_s[-2]
            steep = (log_sigma[-1] - log_sigma[-2]) / np.where(np.abs(moved) > 1e-6, moved, np.inf)
            slope = np.where(np.abs(moved) > 1e-6, np.clip(steep, 0.35, 2.5), 1)
        step = np.clip((np.log(goal) - log_sigma[-1]) / slope, -3, 2.3)
        if len(log_s) > 1 and is_at_bound(study, targets, step):
            return None
        for j, i in enumerate(targets):
            form = study.world.hidden[i].form
            s = float(np.clip(np.exp(log_s[-1][j] + step[j]), form.low, form.high))
            study = replace(study, world=study.world.with_strength(i, s))
    return None


def is_at_bound(study: StudyTruth, targets: dict[int, float], step: np.ndarray) -> bool:
    """Whether a strength at one of its bounds would have to go beyond."""
    for j, i in enumerate(targets):
        h = study.world.hidden[i]
        at_bound = int(h.strength >= h.form.high) - int(h.strength <= h.form.low)
        if at_bound and np.sign(step[j]) == at_bound:
            return True
    return False


def draw_fin(rng: np.random.Generator, world: StudyWorld, f: float) -> HiddenEffect:
    """A fin whose area gives straight swimming a growth rate between -2 and -0.1 per second."""
    form = forms_of("tail_fin_lift")[rng.integers(4)]
    constants, goal = form.draw(rng), rng.uniform(-2.0, -0.1)
    low, high = form.low, form.high
    for _ in range(30):
        area = np.sqrt(low * high)
        stable = (
            straight_growth_rate(replace(world, hidden=(HiddenEffect(form, area, constants),)), f)
            < goal
        )
        low, high = (low, area) if stable else (area, high)
    return HiddenEffect(form, float(high), constants)


def candidate_form_sets(rng: np.random.Generator, seed: int, index: int) -> list[tuple[Form, ...]]:
    """Sets of forms to try in turn: the dealt causes in all their forms, then other causes."""
    wanted = causes_of(seed, index)
    kind = "measurement" if study_slot(index)[0] == "measurement" else "physics"
    sets = []
    for attempt in range(12):
        chosen = wanted
        if attempt >= 6:
            chosen = list(rng.choice(cause_names(kind), len(wanted), replace=False))
        forms = [forms_of(str(name)) for name in chosen]
        first = [np.random.default_rng([seed, index, j]).integers(99) for j in range(len(forms))]
        sets.append(tuple(f[(first[j] + attempt) % len(f)] for j, f in enumerate(forms)))
    return sets


def draw_study(rng: np.random.Generator, index: int, forms: tuple[Form, ...]) -> StudyTruth:
    """A study with effects at trial strengths, not yet placed or calibrated."""
    group, fin, count = study_slot(index)
    wishes = {form.name for form in forms}
    robot, noise, pool = draw_robot(rng), draw_noise(rng), (2.6, 1.6)
    plain = group in ("null", "clear", "pair") and rng.random() < 0.15 and not wishes & {"sinking"}
    if plain:
        robot = replace(robot, depth=0.004)
    trials = draw_trials(rng, robot, count, wishes)
    trials = replace(trials, servo=noise.servo_rad * rng.normal(size=count))
    world = StudyWorld(robot, pool)
    hidden = [draw_fin(rng, world, float(trials.f.max()))] if fin else []
    for form in forms:
        hidden.append(HiddenEffect(form, float(np.sqrt(form.low * form.high)), form.draw(rng)))
    if group == "unlisted":
        form, constants = draw_unlisted(rng)
        hidden.append(HiddenEffect(form, float(np.sqrt(form.low * form.high)), constants))
    fps = float(rng.choice([30000 / 1001, 30000 / 1001, 60000 / 1001, 25.0, 50.0]))
    return StudyTruth(
        replace(world, hidden=tuple(hidden)),
        trials,
        noise,
        water_accelerations(rng, noise, count, 13.0),
        draw_camera(rng, pool, plain),
        fps,
        float(rng.choice([0, 0, 0.03, 0.06])),
        plain,
    )


def try_calibrated_study(
    rng: np.random.Generator, index: int, forms: tuple[Form, ...], reach: float = 1.0
) -> tuple | None:
    """Placed and calibrated study with its fine path and sigmas, or None.

    ``reach`` (0 to 1) lowers the upper end of the drawn sigma towards the lower one.
    """
    study, group = draw_study(rng, index, forms), study_slot(index)[0]
    fins = sum(h.form.name == "tail_fin_lift" for h in study.world.hidden)
    low, high = TARGET_SIGMAS.get(group, (0, np.inf))
    targets = {
        i: float(rng.uniform(low * 1.1, low * 1.1 + reach * (0.9 * high - 1.1 * low)))
        for i in range(fins, len(study.world.hidden))
    }
    margin = 0.21 if "wall_effect" in {form.name for form in forms} else 0.27
    bare = replace(study.world, hidden=study.world.hidden[:fins])
    path = simulate(bare, study.trials, 0 * study.gusts, COARSE)
    pool = study.world.pool
    trials = draw_start_poses(rng, study.trials, path, COARSE, pool, margin)
    for _ in range(4):
        study = replace(study, trials=trials)
        calibrated = solve_strengths(study, targets) if targets else study
        if calibrated is None:
            return None
        study = calibrated
        path = simulate(study.world, trials, study.gusts, FINE)
        left = wall_times(path, trials, FINE, pool, 0.18)
        total, on_path = detectability_sigmas(study, path, FINE)
        fine = all(low <= total[i] <= high for i in targets) and all(s >= 15 for s in total[:fins])
        if np.isinf(left).all() and fine:
            return study, path, total, on_path
        if all(s < 15 for s in total[:fins]) and fins:
            study = replace(
                study, world=study.world.with_strength(0, study.world.hidden[0].strength * 1.5)
            )
        again = draw_start_poses(rng, trials, path, FINE, pool, margin)
        early = left < 3.3
        trials = Trials(
            **{
                k: np.where(early, getattr(again, k), getattr(trials, k))
                for k in Trials.__dataclass_fields__
            }
        )
        shorter = np.minimum(trials.duration, left - 0.15)
        trials = replace(trials, duration=np.where(early, again.duration, shorter))
    return None


# ------------------------------------------------------------------------------------------- files


def record_trial(
    rng: np.random.Generator, study: StudyTruth, path: np.ndarray, labels: np.ndarray, b: int
) -> tuple:
    """Detections (frames, 5, 2), likelihoods and shaft turns (5 ms grid of robot time) of trial
    ``b``.
    """
    noise, world, trial = study.noise, study.world, study.trials.take(np.array([b]))
    t = np.arange(int(trial.duration[0] * study.fps)) / study.fps
    when = observe.robot_time(study, t, np.full(len(t), b))
    grid = np.arange(0, trial.duration[0] + 1.0, 0.005)
    f = world.frequency(grid, trial.take(np.zeros(len(grid), int)))
    turns = cumulative_trapezoid(f, grid, initial=0)
    beat = 2 * np.pi * np.interp(when, grid, turns) + 0.7
    started = np.clip(when / 0.2, 0, 1)
    state = CubicSpline(np.arange(len(path)) / FINE, path[:, :3, b])(when).T
    state[2] += noise.recoil_rad * started * np.sin(beat)
    side = 1j * np.exp(1j * state[2]) * noise.recoil_m * started * np.cos(beat)
    state[0] += side.real
    state[1] += side.imag
    rows = trial.take(np.zeros(len(t), int))
    phi = world.head_angle(when, rows)
    pose = observe.labelled_pose(study, state, phi)
    swing = np.radians(22) * started * np.sin(beat)
    points = observe.body_points(world.robot, pose, phi, rows.head, labels, swing)
    pixels = observe.keypoint_pixels(study, points, t, np.full(len(t), b))
    log = turns[grid <= trial.duration[0]]
    return *tracked_keypoints(rng, noise, pixels, study.fps), log


def write_keypoints(
    file: Path, found: np.ndarray, likelihood: np.ndarray, parts: list[str], many: bool
) -> None:
    """DeepLabCut CSV; parts named "" are left out; ``many`` adds the row of individuals."""
    kept = [i for i, part in enumerate(parts) if part]
    values = np.concatenate([found, likelihood[..., None]], -1)[:, kept].reshape(len(found), -1)
    head = {"scorer": "DLC_resnet50", "individuals": "fish1" if many else None}
    lines = [",".join([k, *[v] * values.shape[1]]) for k, v in head.items() if v]
    lines.append(",".join(["bodyparts", *(parts[i] for i in kept for _ in range(3))]))
    lines.append(",".join(["coords", *["x", "y", "likelihood"] * len(kept)]))
    for k, row in enumerate(values):
        lines.append(",".join([str(k), *("" if np.isnan(v) else f"{v:.3f}" for v in row)]))
    file.write_text("\n".join(lines) + "\n")


def study_yaml(rng: np.random.Generator, study: StudyTruth, parts: list[str]) -> dict:
    """What a competent lab states, with the study's error of reporting if it has one."""
    robot, camera = study.world.robot, study.camera
    L, W = observe.stated_pool(study)
    depth, index = observe.stated_optics(study)
    stated = observe.stated_camera(study, observe.corner_pixels(study))
    pixels = observe.corner_pixels(study) + rng.normal(0, 0.25, (4, 2))
    fx, fy, cx, cy = (round(float(v), 3) for v in stated.matrix)
    lens = {
        "model": camera.model, "matrix": [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
        "distortion": [round(float(k), 6) for k in stated.distortion],
    }  # fmt: skip
    document = {
        "pool": {"length_m": round(L, 4), "width_m": round(W, 4), "depth_m": 0.3},
        "water": {"density_kg_m3": 1000.0, "refractive_index": index},
        "robot": {
            "mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia,
            "body_length_m": robot.body_length,
            "head_length_m": robot.head_length, "head_span_m": robot.head_span,
            "hinge_to_com_m": robot.hinge_to_com, "tail_length_m": robot.tail_length,
            "keypoint_depth_m": depth,
        },
        "camera": ({} if study.homography else lens) | {
            "image_size_px": list(camera.size), "pool_corners_px": pixels.round(2).tolist(),
            "pool_corners_height_m": study.corner_height,
        },
    }  # fmt: skip
    document["robot"] = {k: round(float(v), 5) for k, v in document["robot"].items()}
    renamed = {p: n for p, n in zip(KEYPOINT_NAMES, parts, strict=True) if n and n != p}
    return document | ({"bodyparts": renamed} if renamed else {})


def write_study(
    rng: np.random.Generator, study: StudyTruth, path: np.ndarray, folder: Path
) -> None:
    """study.yaml, trials.csv, keypoints/ and motor/ in ``folder``."""
    (folder / "keypoints").mkdir(parents=True)
    count, trials, noise = len(study.trials.phi), study.trials, study.noise
    parts, many = list(KEYPOINT_NAMES), bool(rng.random() < 0.15)
    if rng.random() < 0.25:
        parts = ["snout", "neck", "com", "peduncle", "fluke"]
    if rng.random() < 0.12:
        parts[4] = ""
    logs = rng.random() < 0.8 or study.report("time_offset") != 0
    dead = (float(rng.uniform(335, 345)), 355.0, str(rng.choice(["hold", "zero", "empty"])))
    labels = observe.label_bias(study) + noise.label_m * (rng.normal(size=(5, 2)) @ [1, 1j])
    if logs:
        (folder / "motor").mkdir()
    lines = [
        "trial_id,source,power_pct,head_angle_deg,head_length_m,fps,"
        + ("motor_log" if logs else "flap_hz")
    ]
    for b in range(count):
        found, likelihood, turns = record_trial(rng, study, path, labels, b)
        name, error = f"T{b + 1:02d}", 1 + noise.frequency * rng.normal()
        write_keypoints(folder / "keypoints" / f"{name}.csv", found, likelihood, parts, many)
        if logs:
            angle = motor_log(rng, turns * error, dead)
            rows = ("" if np.isnan(a) else f"{a:.2f}" for a in angle)
            text = "\n".join(f"{0.005 * k:.3f},{a}" for k, a in enumerate(rows))
            (folder / "motor" / f"{name}.csv").write_text(f"time_s,angle_deg\n{text}\n")
            drive = f"motor/{name}.csv"
        else:
            spin = any(h.form.name == "motor_spin_up" for h in study.world.hidden)
            mean = turns[-1] / (0.005 * (len(turns) - 1))
            drive = f"{(trials.f[b] if spin else mean) * error:.4f}"
        condition = f"{trials.power[b]:g},{np.degrees(trials.phi[b]):.4g},{trials.head[b]:.5f}"
        lines.append(f"{name},keypoints/{name}.csv,{condition},{study.fps:.6g},{drive}")
    (folder / "trials.csv").write_text("\n".join(lines) + "\n")
    document = study_yaml(rng, study, parts)
    (folder / "study.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def cause_json(hidden: HiddenEffect, sigma: float, on_path: float) -> dict:
    """A cause as in the truth file."""
    form, constants = hidden.form, hidden.constants
    others = {
        k: {"value": v, "unit": "SI"} for k, v in constants.items() if k not in ("side", "shape")
    }
    strength = {"value": hidden.strength * constants["side"], "unit": form.unit}
    kind = "measurement" if form.channel == "report" else "physics"
    return {
        "name": form.name, "kind": kind, "form": form.form, "sigma": round(sigma, 2),
        "sigma_path": round(on_path, 2), "source": form.source,
        "parameters": {form.parameter: strength} | others,
    }  # fmt: skip


def truth_json(
    seed: int, index: int, study: StudyTruth, total: list[float], on_path: list[float]
) -> dict:
    """The truth file's content."""
    group, fin, count = study_slot(index)
    hidden = study.world.hidden
    causes = [
        cause_json(h, total[i], on_path[i])
        for i, h in enumerate(hidden)
        if h.form.name != "unlisted"
    ]
    unlisted = None
    if group == "unlisted":
        c = hidden[-1].constants
        terms = {
            "amplitudes": c["a"].tolist(),
            "wavenumbers": c["w"].tolist(),
            "phases": c["b"].tolist(),
        }
        unlisted = {
            "channels": [c["axis"]], "variable": c["variable"], "form": hidden[-1].form.form,
            "sigma": round(total[-1], 2), "strength": hidden[-1].strength,
            "unit": hidden[-1].form.unit, **terms,
        }  # fmt: skip
    verdict = {
        "null": "physics" if fin else "none",
        "measurement": "measurement",
        "unlisted": "unexplained",
    }
    t = study.trials
    angles = sorted({round(float(a), 2) for a in np.degrees(t.phi)})
    return {
        "study": f"{GENERATOR_NAME}-{seed}-{index:03d}",
        "generator": GENERATOR_NAME,
        "seed": seed,
        "index": index,
        "group": group,
        "fin": fin,
        "trials": count,
        "verdict": verdict.get(group, "physics"),
        "causes": sorted(causes, key=lambda cause: -cause["sigma"]),
        "unlisted": unlisted,
        "noise": study.noise.as_dict(),
        "robot": asdict(study.world.robot),
        "conditions": {
            "power_pct": sorted(set(t.power.tolist())),
            "head_angle_deg": angles,
            "head_length_m": sorted({round(float(h), 5) for h in t.head}),
            "fps": study.fps,
            "duration_s": t.duration.round(2).tolist(),
            "camera": study.camera.model,
            "homography": study.homography,
            "flap_hz": t.f.round(3).tolist(),
            "straight_growth_per_s": straight_growth_rate(study.world, float(t.f.max())),
        },
    }


def build_study(seed: int, index: int) -> tuple[np.random.Generator, tuple]:
    """Generator and the first candidate study that can be calibrated."""
    for k, forms in enumerate(
        candidate_form_sets(np.random.default_rng([seed, index, 1]), seed, index)
    ):
        rng = np.random.default_rng([seed, index, 2, k])
        if (
            result := try_calibrated_study(rng, index, forms, 0.1 if 3 <= k < 6 else 1.0)
        ) is not None:
            return rng, result
    raise RuntimeError(f"study {index} of seed {seed}: no candidate reaches its sigma")


def generate(seed: int, index: int, directory: Path) -> dict:
    """Write study ``index`` of ``seed`` below ``directory`` and return its truth; skip if it
    exists.
    """
    name = f"{GENERATOR_NAME}-{seed}-{index:03d}"
    truth_file = Path(directory) / "truth" / f"{name}.json"
    if truth_file.exists():
        return json.loads(truth_file.read_text())
    rng, (study, path, total, on_path) = build_study(seed, index)
    folder, draft = Path(directory) / "studies" / name, Path(directory) / "studies" / f".{name}"
    for old in (folder, draft):
        shutil.rmtree(old, ignore_errors=True)
    write_study(rng, study, path, draft)
    draft.rename(folder)
    truth = truth_json(seed, index, study, total, on_path)
    truth_file.parent.mkdir(parents=True, exist_ok=True)
    part = truth_file.with_suffix(".part")
    part.write_text(json.dumps(truth, indent=1))
    part.rename(truth_file)
    return truth
