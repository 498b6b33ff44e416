"""Making a study: robot, pool, trials; hidden causes of a wanted sigma; files and truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .detector import Setting, largest_share, sigmas
from .footage import draw_recoil, draw_tracker, images, with_faults, with_tracking_errors
from .form import MEASUREMENT, UNLISTED, Array, Form, HiddenCause
from .motion import STEPS_PER_FRAME, frequency
from .optics import corners, draw_camera, image_of
from .plan import hidden_forms, study_kind, with_shape
from .robots import draw_robot
from .stability import growth_rate, with_fin
from .trials import (
    Plan,
    draw_gusts,
    draw_plan,
    draw_series,
    local_margin,
    run,
    trial_ends,
    with_starts,
)
from .view_faults import View
from .writing import (
    motor_log,
    write_keypoints,
    write_log,
    write_study,
    write_trials,
    write_truth,
)

GENERATOR = "flume_team"
SIGMA_RANGE = (8.0, 45.0)
MAX_SHARE = 0.6
LEAST_TRIAL_S = 8.0
MAX_ROUNDS = 7
TRIES_OF_CAUSES = 4
"""Robots and trials that are tried before other causes are drawn."""
MAX_ATTEMPTS = 60


@dataclass(frozen=True)
class SimulatedStudy:
    """A study before it is written. grid: s. states: (steps, 8, trials). ends: s."""

    setting: Setting
    plan: Plan
    grid: Array
    states: Array
    ends: Array
    fin_sigma: float
    sigma: Array


def generate(
    seed: int, index: int, folder: Path, *, forms: Sequence[Form] | None = None
) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    forms: hidden in place of those of the plan. The truth is returned.
    Raises: RuntimeError where no strength makes the causes visible.
    """
    kind, fin = study_kind(seed, index)
    for attempt in range(MAX_ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt, 7723])
        choice = np.random.default_rng([seed, index, attempt // TRIES_OF_CAUSES, 88])
        own = hidden_forms(choice, kind) if forms is None else list(forms)
        made = make_study(rng, own, fin=fin)
        if made is not None:
            name = f"{GENERATOR}-{seed}-{index:03d}"
            logged = _write_files(rng, folder / "studies" / name, made)
            group = kind if forms is None else _group(own)
            truth = {"study": name, "generator": GENERATOR, "seed": seed, "index": index,
                     "group": group, **_truth(made), "logged": logged}  # fmt: skip
            write_truth(folder, truth)
            return truth
    raise RuntimeError(f"study {index} of series {seed}: no cause became visible")


def _group(forms: Sequence[Form]) -> str:
    kinds = [f.kind for f in forms]
    if not kinds:
        return "null"
    if len(kinds) > 1:
        return "pair"
    return {MEASUREMENT: "measurement", UNLISTED: "unlisted"}.get(kinds[0], "single")


def _draw_view(rng: np.random.Generator, pool: tuple[float, float], depth: float) -> View:
    camera = draw_camera(rng, pool)
    height = float(rng.choice([0.0, 0.0, 0.05]))
    marks = image_of(corners(pool), height, camera)
    marks = np.round(marks + rng.normal(0, 0.15, 4) + 1j * rng.normal(0, 0.15, 4), 2)
    return View(
        camera, camera, pool, pool, 1.333, 1.333, depth, depth, marks, height,
        clock=lambda t, luck: t + 0 * luck,
        shift=lambda z, _, __: z,
        labels=lambda _, phi: 0j * phi,
    )  # fmt: skip


def make_study(
    rng: np.random.Generator, forms: Sequence[Form], *, fin: bool
) -> SimulatedStudy | None:
    """A study whose hidden causes have sigma in the range; None where that fails."""
    robot = draw_robot(rng)
    causes = {f.cause for f in forms}
    if "uncorrected_refraction" in causes:
        robot = replace(robot, keypoint_depth=round(float(rng.uniform(0.15, 0.35)), 3))
    robot = with_fin(rng, robot) if fin else robot
    length = round(float(rng.uniform(5.5, 8.0)), 2)
    pool = (length, round(length * float(rng.uniform(0.5, 0.6)), 2))
    two_heads = "thrust_area" in causes or bool(rng.random() < 0.35)
    plan = draw_plan(rng, robot, pool, two_heads=two_heads)
    fps = float(rng.choice([30.0, 60.0]))
    dt = 1 / fps / STEPS_PER_FRAME
    gusts = draw_gusts(rng, robot, plan)
    series = draw_series(rng, gusts, plan, dt)
    view = _draw_view(rng, pool, robot.keypoint_depth)
    hidden = tuple(with_shape(rng, form) for form in forms)
    setting = Setting(plan.lanes, robot, hidden, view, gusts, draw_tracker(rng), fps)
    targets = np.exp(rng.uniform(*np.log(SIGMA_RANGE), len(forms)))
    coarse = round(1 / 30 / dt)
    for _ in range(MAX_ROUNDS):
        made = _simulated(rng, setting, plan, series, dt=dt, every=coarse)
        if made is None:
            return None
        if robot.fin is not None and made.fin_sigma < 0.7 * SIGMA_RANGE[0]:
            return None
        plan, setting = made.plan, made.setting
        factors = _factors(made, targets)
        if factors is None:
            return None
        if np.all(np.abs(np.log(factors)) < 0.1):
            break
        pairs = zip(setting.hidden, factors, strict=True)
        setting = replace(setting, hidden=tuple(_rounded(h.scaled(f)) for h, f in pairs))
    if np.any((made.sigma < 0.9 * SIGMA_RANGE[0]) | (made.sigma > 1.2 * SIGMA_RANGE[1])):
        return None
    final = _simulated(rng, setting, plan, series, dt=dt, every=1)
    if final is None or not _in_range(final):
        return None
    return final


def _rounded(h: HiddenCause) -> HiddenCause:
    return replace(h, strength=float(f"{h.strength:.4g}"))


def _largest_factor(made: SimulatedStudy, k: int) -> float:
    """Factor on strength k up to its limit and to the largest share of the main force."""
    h = made.setting.hidden[k]
    room = h.form.limit / abs(h.strength)
    share = largest_share(made.setting, made.grid, made.states, made.ends, k)
    return min(room, MAX_SHARE / share) if share > 0 else room


def _factors(made: SimulatedStudy, targets: Array) -> Array | None:
    """Factors on the strengths towards the wanted sigma; None where a cause cannot reach 8, or
    where the information is too nearly singular to say.
    """
    if not np.isfinite(made.sigma).all():
        return None
    factors = np.clip(targets / np.maximum(made.sigma, 1e-6), 0.2, 4)
    most = np.array([_largest_factor(made, k) for k in range(len(targets))])
    reach = np.where(most < 1.05, 0.7, 0.4) * SIGMA_RANGE[0]
    if np.any(most * made.sigma < reach):
        return None
    return np.minimum(factors, most)


def _in_range(made: SimulatedStudy) -> bool:
    """Whether sigma, and the share of the main force, of every cause are in their ranges."""
    low, high = SIGMA_RANGE
    seen = bool(np.all((made.sigma >= low) & (made.sigma <= high)))
    modest = all(_largest_factor(made, k) > 0.95 for k in range(len(made.setting.hidden)))
    fin = made.setting.robot.fin is None or made.fin_sigma >= low
    return seen and modest and fin


def _simulated(
    rng: np.random.Generator,
    setting: Setting,
    plan: Plan,
    series: Array,
    *,
    dt: float,
    every: int,
) -> SimulatedStudy | None:
    """The study with its motion, with new first poses where a trial is too short."""
    robot, hidden = setting.robot, setting.hidden
    for attempt in range(4):
        if attempt or not np.any(plan.starts):
            plan = with_starts(rng, plan, robot, hidden, series, dt=dt, margin=local_margin(hidden))
        grid, states = run(plan, robot, hidden, series, dt=dt, every=every)
        ends = trial_ends(plan, grid, states)
        if ends.min() >= LEAST_TRIAL_S:
            break
    else:
        return None
    setting = replace(setting, lanes=plan.lanes)
    fin_sigma, sigma = sigmas(setting, grid, states, _video_ends(setting, ends))
    return SimulatedStudy(setting, plan, grid, states, ends, fin_sigma, sigma)


def _video_ends(setting: Setting, ends: Array) -> Array:
    """Last time of each recording, s; where a clock is wrong, within the simulated motion."""
    t = np.arange(0, ends.max() + 1, 0.05)[:, None]
    clock = with_faults(setting.view, setting.hidden).clock(t + 0 * ends, setting.lanes.luck)
    return np.max(np.where((clock <= ends) & (t <= ends + 1), t, 0), axis=0)


def _write_files(rng: np.random.Generator, folder: Path, made: SimulatedStudy) -> bool:
    """Files of a study; whether it has motor logs."""
    setting, plan, grid = made.setting, made.plan, made.grid
    view = with_faults(setting.view, setting.hidden)
    logged = bool(rng.random() < 0.6) or any(h.form.cause == "time_offset" for h in setting.hidden)
    write_study(folder, view, setting.robot)
    flap = frequency(grid[:, None], setting.lanes, setting.hidden)
    turns = np.cumsum(flap, axis=0) * (grid[1] - grid[0])
    last = _video_ends(setting, made.ends)
    t = np.arange(0, last.max() + 0.5 / setting.fps, 1 / setting.fps)
    seen = images(t, grid, made.states, setting.lanes, setting.robot, hidden=setting.hidden,
                  view=view, recoil=(draw_recoil(rng), 2 * np.pi * turns))  # fmt: skip
    rows = []
    for k, end in enumerate(made.ends):
        name, live = f"T{k + 1:02d}", t <= last[k]
        found = {part: with_tracking_errors(rng, z[live, k], setting.tracker, setting.fps)
                 for part, z in seen.items()}  # fmt: skip
        write_keypoints(folder / "keypoints" / f"{name}.csv", found)
        stated = plan.stated[k] / setting.lanes.flap[k]
        row = {
            "trial_id": name,
            "source": f"keypoints/{name}.csv",
            "power_pct": f"{plan.power[k]:g}",
            "head_angle_deg": f"{np.degrees(plan.commanded[k]):.6g}",
            "head_length_m": f"{setting.lanes.head[k]:.6g}",
            "fps": f"{setting.fps:g}",
        }
        if logged:
            log = motor_log(rng, grid, turns[:, k] * stated, float(end))
            write_log(folder / "motor" / f"{name}.csv", *log)
            row["motor_log"] = f"motor/{name}.csv"
        else:
            late = (grid > end / 2) & (grid <= end)
            row["flap_hz"] = f"{flap[late, k].mean() * stated:.3f}"
        rows.append(row)
    write_trials(folder, rows)
    return logged


def _cause(h: HiddenCause, sigma: float) -> dict[str, Any]:
    form = h.form
    return {
        "name": form.cause, "kind": form.kind, "form": form.name, "channels": list(form.channels),
        "variable": form.variable, "strength": h.strength, "unit": form.unit,
        "parameters": dict(h.parameters), "sigma": round(float(sigma), 1),
    }  # fmt: skip


def _truth(made: SimulatedStudy) -> dict[str, Any]:
    """Truth of a study, without its name."""
    setting = made.setting
    fin, gusts, tracker = setting.robot.fin, setting.gusts, setting.tracker
    pairs = list(zip(setting.hidden, made.sigma, strict=True))
    causes = [_cause(h, s) for h, s in pairs if h.form.kind != UNLISTED]
    unlisted = None
    for h, s in pairs:
        if h.form.kind == UNLISTED:
            unlisted = {k: v for k, v in _cause(h, s).items()
                        if k not in {"name", "kind", "channels"}}  # fmt: skip
            unlisted |= {"channel": h.form.channels[0]}
    if fin is not None:
        causes.insert(0, {
            "name": "tail_fin_lift", "kind": "physics", "form": fin.law,
            "channels": ["sway", "yaw"], "variable": "v - x r, u", "strength": fin.area,
            "unit": "m^2", "parameters": {"arm_m": fin.arm, "onset_rad": fin.onset},
            "sigma": round(made.fin_sigma, 1),
        })  # fmt: skip
    return {
        "fin": fin is not None,
        "trials": int(made.ends.size),
        "causes": causes,
        "unlisted": unlisted,
        "coefficients": asdict(setting.robot.coefficients),
        "stability_per_s": round(growth_rate(setting.robot), 3),
        "noise": {
            "linear_m_s2": gusts.linear,
            "turning_rad_s2": gusts.turning,
            "pole_rad_s": gusts.pole,
            "white_px": tracker.white,
            "slow_px": tracker.slow,
        },
    }
