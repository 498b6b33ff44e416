"""Making a study: robot, basin and trials, hidden causes of visible strength, files and truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .camera import draw_camera
from .filming import FilmedMotion, detections, draw_scene, pixels_of, with_measurement_errors
from .form import MEASUREMENT, UNLISTED, Array, Form, HiddenCause
from .ideal import Noise, detectability_sigmas
from .motion import simulate_motion
from .plan import TARGET_SIGMA_RANGE, hidden_forms, study_kind, with_drawn_shape
from .robots import Robot, draw_robot, growth_rate, with_fin
from .trials import TrialDesign, calibrate_unrest, draw_design, trial_ends, with_start_poses
from .writing import (
    motor_log,
    write_keypoints,
    write_log,
    write_study,
    write_trials,
    write_truth,
)

VISIBLE_SIGMA_RANGE = (10.0, 45.0)
LEAST_TRIAL_S = 4.0
MAX_LOG_SIGMA_ERROR = 0.3
"""Logarithm of sigma over the wanted one at which the strength is left as it is."""
MAX_ROUNDS = 8
MAX_ATTEMPTS = 6
GENERATOR = "towing_basin"


@dataclass(frozen=True)
class StudyContent:
    """A study before it is written. ends: s. sigma: cause -> sigma."""

    design: TrialDesign
    film: FilmedMotion
    ends: Array
    noise: Noise
    sigma: Mapping[str, float]

    @property
    def visible(self) -> bool:
        """Whether each hidden cause has its sigma in the range and no trial is too short."""
        low, high = VISIBLE_SIGMA_RANGE
        seen = all(low <= self.sigma[h.form.cause] <= high for h in self.film.hidden)
        return seen and bool(self.ends.min() >= LEAST_TRIAL_S)


def generate(
    seed: int, index: int, folder: Path, *, forms: Sequence[Form] | None = None
) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    forms: hidden in place of those of the plan. The truth is returned.
    Raises: RuntimeError where no strength makes the causes visible.
    """
    kind = study_kind(seed, index)
    for attempt in range(MAX_ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt])
        own = list(hidden_forms(rng, seed, kind, attempt) if forms is None else forms)
        made = make_study(rng, own, fin=kind.fin)
        if made.visible:
            name = f"{GENERATOR}-{seed}-{index:03d}"
            logged = _write_files(rng, folder / "studies" / name, made)
            group = kind.group if forms is None else _visibility_group(own)
            truth = {"study": name, "generator": GENERATOR, "seed": seed, "index": index,
                     "group": group, **_truth_json(made), "logged": logged}  # fmt: skip
            write_truth(folder, truth)
            return truth
    raise RuntimeError(f"study {index} of series {seed}: no cause became visible")


def _visibility_group(forms: Sequence[Form]) -> str:
    kinds = [f.kind for f in forms]
    if len(kinds) > 1:
        return "pair"
    names = {MEASUREMENT: "measurement", UNLISTED: "unlisted"}
    return names.get(kinds[0], "single") if kinds else "null"


def make_study(rng: np.random.Generator, forms: Sequence[Form], *, fin: bool) -> StudyContent:
    """A robot, a basin and trials, with the strengths of the forms set by the ideal detector."""
    robot = draw_robot(rng)
    if any(f.cause == "uncorrected_refraction" for f in forms):
        robot = replace(robot, keypoint_depth=round(float(rng.uniform(0.12, 0.3)), 3))
    robot = with_fin(rng, robot) if fin else robot
    length = float(np.round(rng.uniform(5.0, 7.0), 2))
    pool = (length, float(np.round(length * rng.uniform(0.48, 0.56), 2)))
    unrest = calibrate_unrest(rng, robot)
    causes = {f.cause for f in forms}
    design = draw_design(rng, robot, unrest, pool=pool, two_heads="thrust_area" in causes,
                         margin=0.16 if "wall_effect" in causes else 0.3)  # fmt: skip
    scene = draw_scene(rng, draw_camera(rng, pool), robot, pool)
    noise = Noise(unrest, scene, float(rng.choice([30.0, 60.0])))
    hidden = [with_drawn_shape(rng, form) for form in forms]
    targets = np.exp(rng.uniform(*np.log(TARGET_SIGMA_RANGE), len(forms)))
    return _with_visible_strengths(
        rng, with_start_poses(rng, design, robot, hidden), robot, hidden, targets, noise=noise
    )


def _with_visible_strengths(
    rng: np.random.Generator,
    design: TrialDesign,
    robot: Robot,
    hidden: Sequence[HiddenCause],
    targets: Array,
    *,
    noise: Noise,
) -> StudyContent:
    """The study whose causes have the wanted sigma, by repeated proportion."""
    for _ in range(MAX_ROUNDS):
        made = _simulate_design(design, robot, hidden, noise)
        if made.ends.min() < LEAST_TRIAL_S:
            design = with_start_poses(rng, design, robot, hidden)
            continue
        found = np.array([made.sigma[h.form.cause] for h in hidden])
        if made.visible and np.all(np.abs(np.log(found / targets)) < MAX_LOG_SIGMA_ERROR):
            break
        factors = np.clip(targets / np.maximum(found, 1e-3), 0.2, 4)
        larger = [_with_scaled_strength(h, float(f)) for h, f in zip(hidden, factors, strict=True)]
        if larger == list(hidden):
            break
        hidden = larger
    return made


def _with_scaled_strength(hidden: HiddenCause, factor: float) -> HiddenCause:
    limit = hidden.form.limit
    return hidden.sized(float(f"{np.clip(hidden.strength * factor, -limit, limit):.4g}"))


def _simulate_design(
    design: TrialDesign, robot: Robot, hidden: Sequence[HiddenCause], noise: Noise
) -> StudyContent:
    states = simulate_motion(design.lanes, robot, hidden, first=design.first, pushes=design.pushes)
    film = FilmedMotion(states, design.lanes, robot, tuple(hidden))
    ends = trial_ends(states, design)
    return StudyContent(design, film, ends, noise, detectability_sigmas(film, noise, ends))


def _truth_json(made: StudyContent) -> dict[str, Any]:
    film = made.film
    listed = [h for h in film.hidden if h.form.kind != UNLISTED]
    other = [h for h in film.hidden if h.form.kind == UNLISTED]
    fin = film.robot.fin
    causes = [_cause_json(h, made.sigma[h.form.cause]) for h in listed]
    if fin is not None:
        sizes = {"arm_m": fin.arm, "cross": fin.cross, "onset_rad": fin.onset}
        causes.insert(0, {
            "name": "tail_fin_lift", "kind": "physics", "form": fin.law.__name__,
            "channels": ["sway", "yaw"], "strength": fin.area, "unit": "m^2", "parameters": sizes,
            "sigma": round(made.sigma["tail_fin_lift"], 1),
        })  # fmt: skip
    unlisted = None
    if other:
        unlisted = {k: v for k, v in _cause_json(other[0], made.sigma["unexplained"]).items()
                    if k not in {"name", "kind", "channels"}}  # fmt: skip
        unlisted |= {"channel": other[0].form.channels[0], "variable": other[0].form.variable}
    unrest, tracker = made.noise.unrest, made.noise.scene.tracker
    return {
        "fin": fin is not None,
        "trials": int(film.lanes.angle.size),
        "causes": causes,
        "unlisted": unlisted,
        "coefficients": asdict(film.robot.coefficients),
        "stability_per_s": round(growth_rate(film.robot), 3),
        "noise": {
            "linear_m_s2": unrest.linear, "turning_rad_s2": unrest.turning,
            "memory_s": unrest.memory, "white_px": tracker.white, "slow_px": tracker.slow,
        },
    }  # fmt: skip


def _cause_json(hidden: HiddenCause, sigma: float) -> dict[str, Any]:
    form = hidden.form
    return {
        "name": form.cause, "kind": form.kind, "form": form.name, "channels": list(form.channels),
        "variable": form.variable, "strength": hidden.strength, "unit": form.unit,
        "parameters": dict(hidden.parameters), "sigma": round(sigma, 1),
    }  # fmt: skip


def _write_files(rng: np.random.Generator, folder: Path, made: StudyContent) -> bool:
    """Files of a study; whether it has motor logs."""
    film, design, scene, fps = made.film, made.design, made.noise.scene, made.noise.fps
    view = with_measurement_errors(scene, film.hidden)
    logged = bool(rng.random() < 0.7) or any(h.form.cause == "time_offset" for h in film.hidden)
    write_study(folder, scene, view, film.robot)
    rows = []
    for k, end in enumerate(made.ends):
        name = f"T{k + 1:02d}"
        t = np.arange(0, end + 2, 1 / fps)
        t = t[(view.clock(k, t) <= end) & (t <= end + 1)]
        images = pixels_of(film, scene, view, k, t, recoil=True)
        found = detections(rng, images, scene.tracker, fps)
        write_keypoints(folder / "keypoints" / f"{name}.csv", found)
        row = {
            "trial_id": name,
            "power_pct": f"{design.power[k]:g}",
            "head_angle_deg": f"{np.degrees(design.commanded[k]):.4g}",
            "head_length_m": f"{film.lanes.head[k]:.6g}",
            "source": f"keypoints/{name}.csv",
            "fps": f"{fps:g}",
        }
        grid = film.times()
        if logged:
            write_log(folder / "motor" / f"{name}.csv",
                      *motor_log(rng, grid, film.cycles()[:, k], float(end)))  # fmt: skip
            row["motor_log"] = f"motor/{name}.csv"
        else:
            late = (grid > end / 2) & (grid <= end)
            row["flap_hz"] = f"{film.frequencies()[late, k].mean():.3f}"
        rows.append(row)
    write_trials(folder, rows)
    return logged
