"""Studies: solve for the strengths, then write the study folder and its truth."""
# ruff: noqa: PLR0917  (plan, effects and errors go together)

import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import detector as det
from . import dynamics as dy
from .catalogue import CAUSE_ROW, CAUSES, MEASUREMENT, PHYSICS, UNLISTED
from .effects import BODY, HEAD1, HINGE, TAIL
from .files import write_study
from .noise import KEYPOINT_NOISE_FACTORS
from .observation import apparent_pose, keypoint_pixels, stated_setup
from .plan import (
    INTEGRATION_RATE_HZ,
    StudyPlan,
    draw_plan,
    effect_names_of_study,
    effect_rows,
    study_slot,
)

Array = NDArray[np.float64]
Errors = dict[str, tuple[int, float]]
TARGET_SIGMAS = {"clear": (20, 45), "faint": (8, 14), "pair": (14, 35), "measurement": (12, 40),
          "unlisted": (14, 40)}  # fmt: skip
BLOCK_S = 0.1
POOL_EDGE_MARGIN_M = 0.02


def start_delay(errors: Errors, order: Array) -> Array:
    """Delay (s) of the robot's start against the log: constant, drifting, alternating."""
    form, size = errors.get("time_offset", (0, 0.0))
    count = len(order)
    if form == 2:
        return 2 * size * order
    if form == 3:
        return size * (np.arange(count) % 2)
    return np.full(count, size if form == 1 else 0.0)


def with_start_delays(plan: StudyPlan, errors: Errors) -> Array:
    """Trial rows with the start delays."""
    trials = plan.trials.copy()
    trials[:, dy.START] = start_delay(errors, trials[:, dy.ORDER])
    return trials


def simulate_trials(plan: StudyPlan, E: Array, errors: Errors) -> list[tuple[Array, Array]]:
    """Path (frames, 18) and wake (frames, 2) of every trial, cut where it would leave the pool."""
    runs, substeps = [], max(round(INTEGRATION_RATE_HZ / plan.fps), 4)
    for trial, start, gust in zip(
        with_start_delays(plan, errors), plan.starts, plan.gust, strict=True
    ):
        path, wake = dy.simulate_trial(trial, plan.R, E, start, gust, plan.fps, substeps)
        reach = wall_clearance(path, trial, plan.R)
        inside = np.all(np.isfinite(path), axis=1) & (reach > POOL_EDGE_MARGIN_M)
        frames = len(path) if inside.all() else int(np.argmin(inside))
        runs.append((path[:frames], wake[:frames]))
    return runs


def wall_clearance(path: Array, trial: Array, R: Array) -> Array:
    """Distance (m) of the nose or the tail tip, whichever is nearer, from the pool's walls."""
    z, head = path[:, 0] + 1j * path[:, 1], np.exp(1j * path[:, 2])
    nose = z + (R[HINGE] + trial[dy.HEAD]) * head
    tail = z - (R[BODY] - R[HEAD1] - R[HINGE] + R[TAIL]) * head * np.exp(1j * trial[dy.PHI])
    ends = np.stack([nose, tail])
    sides = [ends.real, 2.6 - ends.real, ends.imag, 1.6 - ends.imag]
    return np.min(sides, axis=(0, 1))


def steady_frequency(trial: Array, E: Array, times: Array) -> float:
    """Frequency (Hz) that stands in trials.csv: the mean under sag, else the steady one."""
    if E[dy.SAG, 0] == 0:
        return float(trial[dy.F])
    plain = E.copy()
    plain[dy.SPIN] = 0.0
    return float(np.mean([dy.flapping_frequency(t, trial, plain) for t in times[times > trial[3]]]))


def without_effect(E: Array, errors: Errors, name: str) -> tuple[Array, Errors]:
    """Effects and errors with one of them off."""
    rest, others = E.copy(), {k: v for k, v in errors.items() if k != name}
    if CAUSE_ROW[name] < len(rest):
        rest[CAUSE_ROW[name]] = 0.0
    return rest, others


def error_model(plan: StudyPlan, frames: int) -> det.ErrorModel:
    """Block-mean errors of x, y, heading from the rigid fit of four keypoints."""
    metre = plan.optics.camera.pose[5] / plan.optics.camera.focal[0]
    level = KEYPOINT_NOISE_FACTORS[:4]
    lever = np.array([plan.R[5] + plan.R[3], plan.R[5], 0.0, -(plan.R[2] - plan.R[3] - plan.R[5])])
    weight = 1 / level**2
    info = np.array([[weight.sum(), weight @ lever], [weight @ lever, weight @ lever**2]])
    spread = np.sqrt(np.diag(np.linalg.inv(info)))[[0, 0, 1]] * metre
    n, noise = plan.noise, plan.noise
    gust = np.array([n.gust_m_s, n.gust_m_s, n.gust_nm])
    return det.ErrorModel(spread * n.white_px / np.sqrt(frames), spread * n.tracking_px,
                          n.tracking_s, gust, noise.gust_s, n.servo_rad, n.flap_ratio)  # fmt: skip


def trial_signals(
    plan: StudyPlan,
    E: Array,
    errors: Errors,
    number: int,
    run: tuple[Array, Array],
    names: list[str],
) -> tuple[Array, Array]:
    """Whitened signals (rows, 6 + names) of one trial, and layout changes (blocks, names, 2)."""
    step = max(round(BLOCK_S * plan.fps), 1)
    path, wake = run[0][::step], run[1][::step]
    times, trial = np.arange(len(path)) * step / plan.fps, with_start_delays(plan, errors)[number]
    J, G = det.block_jacobians(times, path, wake, trial, plan.R, without_memory(E))
    full = block_means(run, step, plan, trial, E)
    d, e = np.zeros((len(path), 3, 6 + len(names))), np.zeros((len(path), 3, 6 + len(names)))
    layout = np.zeros((len(path), len(names), 2))
    d[:, :, :6] = G
    for j, name in enumerate(names):
        rest, others = without_effect(E, errors, name)
        plain = trial.copy()
        plain[dy.START] = trial[dy.START] if name != "time_offset" else 0.0
        if name == "battery_sag":
            plain[dy.F] = steady_frequency(trial, E, times)
        still = (run[0], run[1] * (name != "wake_reentry"))
        d[:, :, 6 + j] = full - block_means(still, step, plan, plain, rest)
        if name in {*MEASUREMENT, "sinking", "centre_of_mass_shift"} - {"time_offset"}:
            change = pose_change(plan, (E, errors), (rest, others), path, times, trial)
            e[:, :, 6 + j], layout[:, j] = change[:, :3], change[:, 3:]
    m = error_model(plan, step)
    return det.whitened_innovations(J, d, e, step / plan.fps, *m), layout


def without_memory(E: Array) -> Array:
    """Effects without memory, for Jacobians: with frozen lags the lift would not follow alpha."""
    E = E.copy()
    E[dy.LAG] = 0.0
    if E[dy.FIN, 0] == 4:
        E[dy.FIN, 0] = 1.0
    if E[dy.STALL, 0] in {2.0, 3.0}:
        E[dy.STALL, 0] = 1.0
    return E


def block_means(
    run: tuple[Array, Array], step: int, plan: StudyPlan, trial: Array, E: Array
) -> Array:
    """Accelerations (blocks, 3): means over the frames of a block, at the frames' half-times."""
    times = (np.arange(len(run[0])) + 0.5) / plan.fps
    a = det.accelerations(times, *run, trial, plan.R, E)
    first = np.arange(0, len(a), step)
    counts = np.diff(np.append(first, len(a)))
    return np.add.reduceat(a, first, axis=0) / counts[:, None]


def pose_change(
    plan: StudyPlan, all_on: tuple, one_off: tuple, path: Array, times: Array, trial: Array
) -> Array:
    """Change (blocks, 5) of the apparent pose that one effect's optics or labels make."""
    poses = []
    for E, errors in (all_on, one_off):
        pixels = keypoint_pixels(path, times, trial, plan.R, E, optics=plan.optics, errors=errors)
        poses.append(apparent_pose(pixels, stated_setup(plan.optics, errors)))
    change = poses[0] - poses[1]
    change[:, 2:4] = (change[:, 2:4] + np.pi) % (2 * np.pi) - np.pi
    return change


def detectability(
    plan: StudyPlan, E: Array, errors: Errors, runs: list[tuple[Array, Array]]
) -> dict[str, float]:
    """Sigma of every effect and error that is on."""
    names = [c.name for c in CAUSES[:25] if E[CAUSE_ROW[c.name], 0] > 0] + list(errors)
    parts = [trial_signals(plan, E, errors, i, run, names) for i, run in enumerate(runs)]
    signals, sigma = np.concatenate([p[0] for p in parts]), {}
    for j, name in enumerate(names):
        rest = np.delete(signals, 6 + j, axis=1)
        sigma[name] = det.projected_norm(signals[:, 6 + j], rest)
        if name in MEASUREMENT:
            extra = head_angle_and_length_sigmas(plan, [p[1][:, j] for p in parts])
            sigma[name] = float(np.hypot(sigma[name], extra))
        if name == "clock_error":
            form, size = errors[name]
            sigma[name] = float(np.linalg.norm(clock_factors(form, size, len(runs)))) / 0.003
    return sigma


def head_angle_and_length_sigmas(plan: StudyPlan, change: list[Array]) -> float:
    """Sigma of head angle and body length changes, with tracking errors per independent block."""
    step = max(round(BLOCK_S * plan.fps), 1)
    m, R, n = error_model(plan, step), plan.R, plan.noise
    metre = plan.optics.camera.pose[5] / plan.optics.camera.focal[0]
    runs = 1 + 2 * n.tracking_s / BLOCK_S
    px = np.sqrt(n.white_px**2 / step + (n.tracking_px**2 + n.bias_px**2 / 2) * runs)
    std = (px * metre / R[3] * 1.6, px * metre * 1.5 / (R[2] - 0.0))
    return det.head_angle_and_length_sigma(change, std, m.servo)


def clock_factors(form: int, size: float, count: int) -> Array:
    """Relative error of the stated frame rate in every trial: constant, or drifting from zero."""
    return np.full(count, size) if form == 1 else size * 1.7 * np.arange(count) / count


def strength_of(E: Array, errors: Errors, name: str) -> float:
    """Strength of an effect or error."""
    return float(E[CAUSE_ROW[name], 1]) if CAUSE_ROW[name] < len(E) else errors[name][1]


def with_scaled_strength(
    E: Array, errors: Errors, name: str, factor: float
) -> tuple[Array, Errors]:
    """Effects and errors with one strength multiplied, kept within its bound."""
    value, bound = strength_of(E, errors, name) * factor, CAUSES[CAUSE_ROW[name]].bound
    least = 0.05 if name == "lift_lag" else 0.0  # a faster lag is too stiff for Adams-Bashforth
    value = max(float(np.clip(value, -bound, bound)), least or -bound)
    if CAUSE_ROW[name] < len(E):
        changed = E.copy()
        changed[CAUSE_ROW[name], 1] = value
        return changed, errors
    return E, {**errors, name: (errors[name][0], value)}


def secant_step(here: tuple[float, float], last: tuple[float, float] | None, aim: float) -> float:
    """Step of the log strength towards the log sigma `aim`; slope 1 where no secant is known."""
    slope = 1.0
    if last is not None and abs(here[0] - last[0]) > 1e-3:
        slope = (here[1] - last[1]) / (here[0] - last[0])
    return float(np.clip((aim - here[1]) / np.clip(slope, 0.5, 4.0), -1.4, 1.4))


def solve_strengths(
    plan: StudyPlan, E: Array, errors: Errors, rng: np.random.Generator
) -> tuple[Array, Errors, list, dict[str, float]]:
    """Strengths that reach drawn sigmas, by secants in the logarithm (ten at most)."""
    low, high = TARGET_SIGMAS.get(plan.group, (0, 0))
    aim = {
        n: float(np.exp(rng.uniform(np.log(low * 1.1), np.log(high * 0.92)))) for n in plan.names
    }
    last: dict[str, tuple[float, float]] = {}
    for _ in range(10):
        runs = simulate_trials(plan, E, errors)
        sigma = dict.fromkeys(plan.names, 0.0)
        if min(len(r[0]) for r in runs) < 1.5 * plan.fps:
            for n in plan.names:
                E, errors = with_scaled_strength(E, errors, n, 0.4)
            continue
        sigma = detectability(plan, E, errors, runs)
        if all(low <= sigma[n] <= high for n in plan.names):
            break
        for n in plan.names:
            here = (np.log(abs(strength_of(E, errors, n))), np.log(max(sigma[n], 1e-6)))
            step = secant_step(here, last.get(n), np.log(aim[n]))
            last[n] = here
            E, errors = with_scaled_strength(E, errors, n, float(np.exp(step)))
    return E, errors, runs, sigma


def try_plan(seed: int, index: int, names: tuple[str, ...], trial_number: int) -> tuple | None:
    """A plan with effects that reach their sigma, or None."""
    rng = np.random.default_rng([seed, index, trial_number, 2026])
    plan = draw_plan(seed, index, names, rng)
    E = effect_rows(rng, names)
    errors: Errors = {}
    for name in set(names) & set(MEASUREMENT):
        cause = CAUSES[CAUSE_ROW[name]]
        sign = -1.0 if cause.signed and rng.random() < 0.5 else 1.0
        form = int(rng.integers(1, len(cause.forms) + 1))
        errors[name] = (form, sign * cause.start * float(np.exp(rng.uniform(-0.5, 0.4))))
    E[dy.FIN] = plan.fin_row
    E, errors, runs, sigma = solve_strengths(plan, E, errors, rng)
    low, high = TARGET_SIGMAS.get(plan.group, (0, np.inf))
    good = all(low <= sigma[n] <= high for n in names) and sigma.get("tail_fin_lift", 99) >= 15
    whole = min(len(r[0]) for r in runs) >= 2.95 * plan.fps
    return (plan, E, errors, runs, sigma, rng) if good and whole else None


def compose_study(seed: int, index: int) -> tuple:
    """The first attempt that succeeds: three with the dealt names, then with other names."""
    group, slot, _ = study_slot(seed, index)
    names = effect_names_of_study(seed, group, slot)
    spare = np.random.default_rng([seed, index, 99])
    for number in range(40):
        if number >= 4 and number % 2 == 0 and names and group != "unlisted":
            deck = MEASUREMENT if group == "measurement" else PHYSICS
            names = tuple(str(n) for n in spare.choice(deck, len(names), replace=False))
        found = try_plan(seed, index, names, number)
        if found:
            return found
    raise RuntimeError(f"study {index} of seed {seed}: no effect reached its sigma")


def cause_entry(name: str, form: int, value: float, shape: float, sigma: float) -> dict:
    """One entry of the truth's `causes`."""
    cause = CAUSES[CAUSE_ROW[name]]
    parameters = {cause.parameter: {"value": value, "unit": cause.unit}}
    if shape:
        parameters["shape"] = {"value": shape, "unit": "see effects.py"}
    return {"name": name, "kind": cause.kind, "form": cause.forms[form - 1],
            "sigma": round(sigma, 2), "parameters": parameters}  # fmt: skip


def truth_json(study: str, seed: int, index: int, found: tuple) -> dict:
    """The truth file's content."""
    plan, E, errors, runs, sigma, _ = found
    causes = [cause_entry(n, int(E[CAUSE_ROW[n], 0]), E[CAUSE_ROW[n], 1], E[CAUSE_ROW[n], 2], s)
              for n, s in sigma.items() if CAUSE_ROW[n] < len(E) and n != "unlisted"]  # fmt: skip
    causes += [cause_entry(n, f, v, 0.0, sigma[n]) for n, (f, v) in errors.items()]
    free, row = None, E[dy.UNLISTED]
    if row[0] > 0:
        channels, variable = UNLISTED[int(row[0])]
        free = {"channels": channels, "variable": variable, "sigma": round(sigma["unlisted"], 2),
                "form": CAUSES[CAUSE_ROW["unlisted"]].forms[int(row[0]) - 1],
                "amplitude": row[1]}  # fmt: skip
    kinds = {c["kind"] for c in causes}
    verdict = "unexplained" if free else "measurement" if "measurement" in kinds else (
        "physics" if kinds else "none")  # fmt: skip
    keys = ("mass", "inertia", "body", "head", "span", "hinge", "tail",
            "C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")  # fmt: skip
    speed = [float(np.hypot(*p[-1, 3:5])) for p, _ in runs]
    return {"study": study, "generator": "wake_memory", "seed": seed, "index": index,
            "group": plan.group, "fin": plan.fin, "trials": len(runs), "verdict": verdict,
            "causes": causes, "unlisted": free, "noise": asdict(plan.noise),
            "robot": dict(zip(keys, plan.R.tolist(), strict=True)),
            "conditions": {"fps": plan.fps, "power_pct": sorted(set(plan.power.tolist())),
                           "head_angle_deg": np.degrees(plan.commanded).round(2).tolist(),
                           "seconds": [round(len(p) / plan.fps, 2) for p, _ in runs],
                           "final_speed_m_s": np.round(speed, 3).tolist(),
                           "camera": asdict(plan.optics.camera),
                           "depth_m": plan.optics.depth}}  # fmt: skip


def generate(seed: int, index: int, directory: Path) -> dict:
    """Write study `index` below `directory` unless its truth exists; returns the truth."""
    study = f"wake_memory-{seed}-{index:03d}"
    answer, folder = (
        Path(directory) / "truth" / f"{study}.json",
        Path(directory) / "studies" / study,
    )
    if answer.exists():
        return json.loads(answer.read_text(encoding="utf-8"))
    found = compose_study(seed, index)
    plan, E, errors, runs, _, rng = found
    unfinished = folder.with_name(f".{study}.unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    placed = replace(plan, trials=with_start_delays(plan, errors))
    write_study(unfinished, placed, E, errors, runs, rng=rng)
    shutil.rmtree(folder, ignore_errors=True)
    unfinished.rename(folder)
    answer.parent.mkdir(parents=True, exist_ok=True)
    truth = truth_json(study, seed, index, found)
    draft = answer.with_suffix(".part")
    draft.write_text(json.dumps(truth, indent=1), encoding="utf-8")
    draft.rename(answer)
    return truth
