"""One study: robot, trials, hidden content, files and truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import files
from .filming import (
    GAP_LIKELIHOOD,
    draw_film,
    frame_times,
    keypoint_pixels,
    labelled_points,
    shaft_turns,
    stated_setup,
    tracked_keypoints,
)
from .form import Form
from .ideal import COEFFICIENTS, SimulatedMotion
from .motion import HiddenLaw, straight_growth_rate
from .optics import draw_camera
from .plan import (
    MEASUREMENT,
    UNLISTED_NAME,
    StudyKind,
    draw_fin,
    draw_forms,
    draw_hidden_law,
    study_kind,
)
from .robots import draw_robot, draw_trials
from .strength import (
    SIMULATED_S,
    StudySetup,
    TooFaintError,
    draw_target_sigma,
    set_fault,
    set_forces,
    visibility_group,
)

OBSERVATION_STAGES = ("time", "picture", "depth", "stated", "label", "sink")
"""Stages that change the film and not the motion."""
MAX_ATTEMPTS = 40


@dataclass(frozen=True)
class StudyContent:
    """Motion and hidden content of one study, with the sigma of each law."""

    setup: StudySetup
    motion: SimulatedMotion
    laws: Sequence[tuple[HiddenLaw, float]]
    fault: HiddenLaw | None
    fin_sigma: float | None


def generate(
    seed: int, index: int, folder: Path, *, forms: Sequence[Form] | None = None
) -> dict[str, Any]:
    """Write study `index` of a series below `folder` and return its truth.

    folder/studies/NAME holds the study, folder/truth/NAME.json the truth. forms: hide these.
    """
    what = study_kind(seed, index)
    name = f"tow_tank-{seed}-{index:03d}"
    for attempt in range(MAX_ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt, 40961])
        try:
            content = _draw_content(
                rng, what, draw_forms(rng, what.name) if forms is None else forms
            )
            break
        except TooFaintError:
            continue
    else:
        raise TooFaintError(f"{name}: no content in {MAX_ATTEMPTS} attempts")
    _write_files(rng, content, folder / "studies" / name)
    truth = {"study": name, "generator": "tow_tank", "seed": seed, "index": index}
    truth |= _truth_json(content, what, forms is not None)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "truth" / f"{name}.json").write_text(json.dumps(truth, indent=1) + "\n")
    return truth


def _draw_content(rng: np.random.Generator, what: StudyKind, forms: Sequence[Form]) -> StudyContent:
    setup = _draw_setup(rng, what)
    laws = [draw_hidden_law(rng, form, setup.pool) for form in forms]
    wanted = [draw_target_sigma(rng) for _ in laws]
    seen_only = [law for law in laws if law.form.stage in OBSERVATION_STAGES]
    forces = [law for law in laws if law not in seen_only]
    motion, forces, values, fin_sigma = set_forces(
        setup, forces, [w for w, law in zip(wanted, laws, strict=True) if law in forces], rng
    )
    setup = replace(setup, lanes=motion.lanes)
    fault = None
    if seen_only:
        deepest = setup.pool[2] - 0.07
        if seen_only[0].form.stage == "sink":
            deepest -= setup.robot.depth
        fault, value, fin_sigma = set_fault(setup, motion, seen_only[0], wanted[-1], deepest)
        forces, values = [*forces, fault], [*values, value]
        if fault.form.stage == "time":
            motion = _cut_at_wall(motion, fault)
    return StudyContent(setup, motion, list(zip(forces, values, strict=True)), fault, fin_sigma)


def _draw_setup(rng: np.random.Generator, what: StudyKind) -> StudySetup:
    pool = (rng.uniform(2.6, 4.6), rng.uniform(1.6, 2.3), rng.uniform(0.3, 0.6))
    pool = (round(pool[0], 2), round(pool[1], 2), round(pool[2], 2))
    robot = draw_robot(rng, what.fin)
    lanes = draw_trials(rng, robot, what.few)
    fps = float(rng.choice([30.0, 29.97003, 60.0, 59.94006]))
    fin = (draw_fin(rng, robot, lanes),) if what.fin else ()
    film = draw_film(rng, draw_camera(rng, pool))
    lengths = rng.uniform(6.0, 10.0, len(lanes.flap))
    return StudySetup(robot, lanes, pool, film, fps, lengths, fin)


def _cut_at_wall(motion: SimulatedMotion, fault: HiddenLaw) -> SimulatedMotion:
    """Only frames that are exposed before the robot is too near to a wall."""
    frames = motion.frames.copy()
    for k, n in enumerate(frames):
        at = fault.form.law(frame_times(motion, k), fault.strength, fault.shape)
        frames[k] = int(np.count_nonzero(at <= motion.times[n - 1]))
    return replace(motion, frames=frames)


def _write_files(rng: np.random.Generator, content: StudyContent, folder: Path) -> None:
    setup, motion, fault = content.setup, content.motion, content.fault
    for part in ("keypoints", "motor"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    said = stated_setup(setup.film, setup.robot, fault)
    corners = said.corners + 0.15 * rng.normal(size=(4, 2))
    files.write_study(folder / "study.yaml", setup.robot, setup.film, said, corners)
    files.write_trials(folder / "trials.csv", motion.lanes, setup.fps)
    sensor = files.draw_potentiometer(rng)
    count = len(motion.frames)
    turns = shaft_turns(motion, rng.random(count), 0.005, SIMULATED_S)
    for k, n in enumerate(motion.frames):
        seen = labelled_points(motion, k, turns, fault, setup.film)
        px = keypoint_pixels(setup.film.camera, seen, motion, k, fault)
        found = tracked_keypoints(rng, setup.film, px, setup.fps)
        found[np.any((px < 0) | (px > setup.film.camera.size), -1)] = GAP_LIKELIHOOD
        files.write_keypoints(folder / f"keypoints/T{k + 1:02d}.csv", setup.film.scorer, found)
        logged = turns[0] <= motion.times[n - 1] + 0.3
        files.write_motor_log(rng, folder / f"motor/T{k + 1:02d}.csv", sensor,
                          turns[0][logged], turns[1][logged, k])  # fmt: skip


def _truth_json(content: StudyContent, what: StudyKind, chosen: bool) -> dict[str, Any]:
    robot = content.setup.robot
    listed = [(h, s) for h, s in content.laws if h.form.cause != UNLISTED_NAME]
    others = [(h, s) for h, s in content.laws if h.form.cause == UNLISTED_NAME]
    causes = [_cause_json(h, content.fin_sigma) for h in content.setup.fin]
    causes += [_cause_json(h, s) for h, s in listed]
    group = "chosen" if chosen else what.name
    if group == "single":
        group = visibility_group([s for _, s in listed])
    return {
        "group": group, "fin": what.fin, "trials": len(content.motion.frames),
        "causes": causes,
        "unlisted": _unlisted_json(*others[0]) if others else None,
        "coefficients": {name: float(getattr(robot, name)) for name in COEFFICIENTS},
        "stability_per_s": straight_growth_rate(robot, content.setup.fin, content.setup.lanes),
    }  # fmt: skip


def _cause_json(law: HiddenLaw, sigma: float | None) -> dict[str, Any]:
    form = law.form
    kind_of = "measurement" if form.cause in MEASUREMENT else "physics"
    return {"name": form.cause, "kind": kind_of, "form": form.name, "channels": form.channels,
            "strength": law.strength, "unit": form.unit, "parameters": law.shape,
            "sigma": None if sigma is None else round(sigma, 1)}  # fmt: skip


def _unlisted_json(law: HiddenLaw, sigma: float) -> dict[str, Any]:
    entry = _cause_json(law, sigma)
    return {"form": entry["form"], "channel": law.form.channels[0], "variable": law.form.variable,
            "strength": entry["strength"], "unit": entry["unit"], "parameters": entry["parameters"],
            "sigma": entry["sigma"]}  # fmt: skip
