"""One study: robot, trials, hidden content, files and truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import plan, writing
from .articulated import laws_of_stage
from .camera import draw_camera
from .form import Form, HiddenLaw, draw_law
from .ideal import MOTION_STAGES, StudySetup
from .placing import LONGEST, PlacedMotion
from .robots import COEFFICIENTS, FLAP_STD, ParallelTrials, draw_robot, draw_trials
from .scene import (
    body_points,
    draw_scene,
    exposure_times,
    keypoint_depth,
    pixels_after_camera_shift,
    shaft_motion,
    stated_setup,
    with_label_bias,
    with_recoil,
)
from .strength import StrengthNotReachableError, draw_fin, set_strengths, straight_growth_rate
from .tracking import correlated_errors, detections, draw_tracker
from .water import draw_water_motion, with_water

Array = NDArray[np.float64]
MAX_ATTEMPTS = 60


@dataclass(frozen=True)
class StudyContent:
    """Motion and laws of one study, with the sigma of each; a fin is the first."""

    setup: StudySetup
    motion: PlacedMotion
    laws: Sequence[HiddenLaw]
    sigmas: Array


def generate(
    seed: int, index: int, folder: Path, *, forms: Sequence[Form] | None = None
) -> dict[str, Any]:
    """Write study `index` of a series below `folder` and return its truth.

    folder/studies/NAME holds the study, folder/truth/NAME.json the truth. forms: hide these.
    """
    what, name = plan.study_kind(seed, index), f"coupled_bodies-{seed}-{index:03d}"
    for attempt in range(MAX_ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt, 52711])
        chosen = _forms_in_turn(rng, seed, index, attempt) if forms is None else forms
        try:
            content = draw_content(rng, what, chosen)
            break
        except StrengthNotReachableError:
            continue
    else:
        raise StrengthNotReachableError(f"{name}: no content in {MAX_ATTEMPTS} attempts")
    write_files(rng, content, folder / "studies" / name)
    truth = {"study": name, "generator": "coupled_bodies", "seed": seed, "index": index}
    truth |= _truth_json(content, what, "chosen" if forms is not None else what.name)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "truth" / f"{name}.json").write_text(json.dumps(truth, indent=1) + "\n")
    return truth


def _forms_in_turn(rng: np.random.Generator, seed: int, index: int, attempt: int) -> list[Form]:
    """Forms of the causes whose turn it is; of others of their kind after 15 attempts."""
    names = plan.hidden_causes(seed, index)
    if attempt >= 15 and names and names[0] != plan.UNLISTED_NAME:
        pool = plan.MEASUREMENT if names[0] in plan.MEASUREMENT else plan.PHYSICS
        names = [str(n) for n in rng.choice(pool, len(names), replace=False)]
    return plan.draw_forms(rng, names)


def draw_setup(rng: np.random.Generator, what: plan.StudyKind, forms: Sequence[Form]) -> StudySetup:
    """Everything of a study but what is hidden in it."""
    causes = {f.cause for f in forms}
    deep = "uncorrected_refraction" in causes
    pool = (round(rng.uniform(3.2, 4.4), 2), round(rng.uniform(1.9, 2.5), 2),
            round(rng.uniform(0.55, 0.7) if deep else rng.uniform(0.3, 0.5), 2))  # fmt: skip
    robot = draw_robot(rng)
    if deep:
        robot = replace(robot, depth=round(rng.uniform(0.12, 0.24), 3))
    sea = draw_water_motion(rng)
    lanes = with_water(rng, sea, draw_trials(rng, robot, what.few))
    direct = causes & {"motor_spin_up", "battery_sag", "clock_error", "time_offset"}
    return StudySetup(
        robot, lanes, pool, draw_scene(rng, draw_camera(rng, pool), pool, lanes.count),
        draw_tracker(rng), sea, float(rng.choice([29.97003, 30.0, 59.94006, 60.0])),
        rng.uniform(4.8, LONGEST, lanes.count), bool(rng.random() < (0.35 if direct else 0.85)),
    )  # fmt: skip


def draw_content(
    rng: np.random.Generator, what: plan.StudyKind, forms: Sequence[Form]
) -> StudyContent:
    """A study's motion with hidden laws of the wanted strength.

    Raises: UnsuitableError where they cannot be had.
    """
    setup = draw_setup(rng, what, forms)
    fins = []
    if what.fin:
        kinds = [f for f in plan.CATALOGUE if f.cause == plan.FIN_CAUSE]
        form = kinds[rng.integers(len(kinds))]
        fins = [draw_fin(rng, setup.lanes, setup.robot, form, setup.pool)]
    hidden = [draw_law(rng, form, setup.pool) for form in forms]
    hidden.sort(key=lambda law: law.form.stage not in MOTION_STAGES)
    motion, laws, sigmas = set_strengths(rng, setup, fins, hidden)
    deepest = keypoint_depth(setup.robot, motion.lanes, laws, np.array([0.0, LONGEST])).max()
    if deepest > setup.pool[2] - 0.06:
        raise StrengthNotReachableError("on the floor")
    return StudyContent(setup, motion, laws, sigmas)


def write_files(rng: np.random.Generator, content: StudyContent, folder: Path) -> None:
    """All files of the study."""
    setup, lanes, laws = content.setup, content.motion.lanes, content.laws
    for part in ("keypoints", "motor") if setup.logged else ("keypoints",):
        (folder / part).mkdir(parents=True, exist_ok=True)
    said = stated_setup(setup.scene, setup.robot, laws)
    marks = said.marks + 0.15 * rng.normal(size=(4, 2))
    writing.write_study_yaml(folder / "study.yaml", setup.robot, setup.scene.camera, said, marks,
                        height=setup.scene.height)  # fmt: skip
    times, turns = shaft_motion(lanes, laws, LONGEST + 2)
    flap = None
    if not setup.logged:
        error = 1 + FLAP_STD * rng.normal(size=lanes.count)
        flap = _steady_flap_hz(times, turns, content.motion.ends) * error
    writing.write_trials(folder / "trials.csv", lanes, setup.fps, flap)
    sensor = writing.draw_potentiometer(rng)
    for k, end in enumerate(content.motion.ends):
        found = film_detections(rng, content, k, times, turns[:, k])
        writing.write_keypoints(folder / f"keypoints/T{k + 1:02d}.csv", found)
        if setup.logged:
            logged = times <= end + 0.2
            angles = writing.logged_angles(rng, sensor, turns[logged, k])
            writing.write_motor(folder / f"motor/T{k + 1:02d}.csv", times[logged], angles)


def _steady_flap_hz(times: Array, turns: Array, ends: Array) -> Array:
    """Mean flapping frequency of the second half of each trial, Hz."""
    halves = [(times > end / 2) & (times < end) for end in ends]
    return np.array([np.polyfit(times[h], turns[h, k], 1)[0] for k, h in enumerate(halves)])


def film_detections(
    rng: np.random.Generator, content: StudyContent, k: int, shaft_times: Array, turns: Array
) -> Array:
    """Detections (frames, 5, 3) of trial k; turns: revolutions of the shaft at shaft_times, s."""
    setup, motion, laws = content.setup, content.motion, content.laws
    lane, robot = motion.lanes.take(np.array([k])), setup.robot
    frames = np.arange(int(LONGEST * setup.fps) + 1) / setup.fps
    at = exposure_times(laws, frames, k, motion.lanes.count)
    frames, at = frames[at <= motion.ends[k]], at[at <= motion.ends[k]]
    film = replace(motion.film, states=motion.film.states[:, :, k : k + 1],
                   rates=motion.film.rates[:, :, k : k + 1])  # fmt: skip
    still = np.clip(at, 0, None)
    points = body_points(film.at(at), lane, robot, laws, still, labels=setup.scene.labels)[..., 0]
    beat = np.interp(still, shaft_times, turns)
    points = with_recoil(points, beat, setup.scene, k, at, tail=robot.tail_length)
    phi = np.angle((points[:, 1] - points[:, 3]) / (points[:, 0] - points[:, 1]))
    points = with_label_bias(points, phi, laws)
    px = setup.scene.camera.see(points, keypoint_depth(robot, lane, laws, still))
    px = pixels_after_camera_shift(px, frames, k, laws, setup.scene.camera)
    noise = correlated_errors(rng, setup.tracker, frames, 10).reshape(-1, 5, 2)
    return detections(rng, setup.tracker, px, noise)


def _truth_json(content: StudyContent, what: plan.StudyKind, group: str) -> dict[str, Any]:
    pairs = list(zip(content.laws, content.sigmas, strict=True))
    listed = [_cause_json(law, s) for law, s in pairs if law.form.cause != plan.UNLISTED_NAME]
    others = [(law, s) for law, s in pairs if law.form.cause == plan.UNLISTED_NAME]
    setup = content.setup
    fin = [
        law for _, law in laws_of_stage(content.laws, "force") if law.form.cause == plan.FIN_CAUSE
    ]
    return {
        "group": group,
        "fin": what.fin,
        "trials": setup.lanes.count,
        "causes": listed,
        "unlisted": _unlisted_json(*others[0]) if others else None,
        "coefficients": {name: float(getattr(setup.robot, name)) for name in COEFFICIENTS},
        "stability_per_s": straight_growth_rate(setup.lanes, setup.robot, fin),
        "logged": setup.logged,
    }


def _cause_json(law: HiddenLaw, sigma: float) -> dict[str, Any]:
    form = law.form
    return {"name": form.cause, "kind": "physics" if form.stage in MOTION_STAGES else "measurement",
            "form": form.name, "channels": list(form.channels),
            "strength": law.sign * law.strength, "unit": form.unit,
            "parameters": dict(law.shape), "sigma": round(float(sigma), 1)}  # fmt: skip


def _unlisted_json(law: HiddenLaw, sigma: float) -> dict[str, Any]:
    entry = _cause_json(law, sigma)
    return {"form": entry["form"], "channel": law.form.channels[0], "variable": law.form.variable,
            **{key: entry[key] for key in ("strength", "unit", "parameters", "sigma")}}  # fmt: skip


__all__ = [
    "ParallelTrials",
    "StudyContent",
    "draw_content",
    "draw_setup",
    "film_detections",
    "generate",
    "write_files",
]
