"""Making a study: robot, session, hidden laws, films, files and truth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .detect import INTERVAL
from .files import draw_habits, study_text, text_of, write_keypoints, write_log, write_trials
from .filming import film_trial
from .here import Law
from .hiding import Hidden, hide
from .kalman import Noise
from .optics import draw_camera
from .plan import Plan, choices, draw_plan
from .registry import draw_law
from .robots import Robot, draw_fin, draw_robot
from .session import SERVO_ERROR, THRUST_ERROR, Session, draw_pool, draw_session
from .sight import Scene, true_scene, with_error
from .tracker import Tracker, draw_tracker
from .truth import truth_of
from .water import Unrest, draw_unrest

GENERATOR = "leading_plate"
STREAM = 57057
FRAME_RATES = (25.0, 30000 / 1001, 30.0, 40.0, 48.0, 50.0, 60000 / 1001)
ATTEMPTS = 60
"""Robots tried until one shows what the plan asks for; names change after every second one."""
NEEDS_LOG = {"time_offset", "clock_error", "motor_spin_up", "battery_sag"}


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    The truth is returned.
    """
    plan = draw_plan(seed, index)
    name = f"{GENERATOR}-{seed}-{index:03d}"
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([STREAM, seed, index, attempt])
        drawn = _draw(rng, plan, choices(plan, attempt // 2))
        if drawn:
            break
    else:
        raise ValueError(f"seed {seed}, study {index}: no robot shows {plan.group}")
    scene, session, tracker, unrest, fps, hidden = drawn
    study = Path(folder) / "studies" / name
    truth: dict[str, Any] = {"study": name, "generator": GENERATOR, "seed": seed, "index": index}
    truth |= truth_of(plan, hidden, scene, session, tracker, unrest=unrest, fps=fps)
    truth["conditions"]["motor_log"] = _write(rng, study, drawn)
    path = Path(folder) / "truth" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
    return truth


Drawn = tuple[Scene, Session, Tracker, Unrest, float, Hidden]


def _draw(rng: np.random.Generator, plan: Plan, names: tuple[str, ...]) -> Drawn | None:
    """A scene with hidden laws; None where they cannot be shown."""
    robot = draw_robot(rng)
    if plan.fin:
        robot = replace(robot, fin=draw_fin(rng, robot))
        if robot.fin is None:
            return None
    laws = tuple(draw_law(rng, name) for name in names)
    pool, unrest = draw_pool(rng, robot), draw_unrest(rng, robot)
    two_heads = "thrust_area" in names or bool(rng.random() < 0.35)
    count = 9 if plan.few_trials else 24
    session = draw_session(rng, robot, pool, unrest, count=count, two_heads=two_heads,
                           rounds="wake_reentry" in names)  # fmt: skip
    if session is None:
        return None
    scene = _scene(rng, robot, pool, laws)
    tracker = draw_tracker(rng, robot, scene.camera.size[0])
    fps = float(rng.choice(FRAME_RATES))
    noise = noise_of(scene, tracker, unrest, fps)
    hidden = hide(rng, scene, session, noise, laws, group=plan.group)
    if hidden is None:
        return None
    for law in hidden.laws:
        scene = with_error(scene, law)
    return scene, session, tracker, unrest, fps, hidden


def _scene(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], laws: tuple[Law, ...]
) -> Scene:
    names = {law.name for law in laws}
    depth = rng.uniform(0.08, 0.18) * robot.body_length
    if "uncorrected_refraction" in names:
        depth = rng.uniform(0.9, 1.3) * robot.body_length
    height = round(float(rng.choice([0.0, 0.0, 0.04, 0.1])), 3)
    fisheye = bool(rng.random() < 0.25) and "lens_error" not in names
    camera = draw_camera(rng, pool, fisheye=fisheye, height=height)
    return true_scene(robot, pool, camera, round(float(depth), 3), height)


def noise_of(scene: Scene, tracker: Tracker, unrest: Unrest, fps: float) -> Noise:
    """What the ideal detector knows of the noise of a study."""
    robot = scene.robot
    metre = (scene.camera.position[2] + scene.depth) / scene.camera.focal[0]
    base = robot.core_length + robot.hinge_to_com
    triple = np.array([1.0, 1.0, np.sqrt(2) / base]) * metre
    water = unrest.speed / np.sqrt(2)
    return Noise(
        white=triple * tracker.white / np.sqrt(fps * INTERVAL), slow=triple * tracker.slow,
        slow_keep=float(np.exp(-INTERVAL / tracker.memory)),
        push=np.array([water, water, unrest.torque]),
        water_keep=float(np.exp(-INTERVAL / unrest.memory)),
        start=np.array([0.05, 0.05, 0.1, 0.003, 0.003, 0.012]),
        servo=float(SERVO_ERROR), thrust=THRUST_ERROR * 1.5,
    )  # fmt: skip


def _write(rng: np.random.Generator, study: Path, drawn: Drawn) -> bool:
    """Write the folder; whether it has motor logs is returned."""
    scene, session, tracker, _, fps, hidden = drawn
    needed = bool(NEEDS_LOG & {law.name for law in hidden.laws})
    robot = scene.robot
    depth = round(max(0.3, scene.depth + 0.15), 2)
    depth = round(depth + 0.45 * robot.body_length * ("sinking" in _names(hidden)), 2)
    habits = draw_habits(rng, logged=needed or bool(rng.random() < 0.65), water_depth=depth)
    for part in ("keypoints", "motor") if habits.logged else ("keypoints",):
        (study / part).mkdir(parents=True, exist_ok=True)
    marks = scene.marks + rng.normal(0, 0.2, (4, 2))
    (study / "study.yaml").write_text(study_text(scene, habits, marks))
    rows = []
    for trial in range(session.count):
        take = film_trial(rng, hidden.laws, scene, hidden.run, tracker, trial=trial, fps=fps)
        trial_id = f"L{trial + 1:02d}"
        row = {
            "trial_id": trial_id, "source": f"keypoints/{trial_id}.csv",
            "power_pct": text_of(session.power[trial]),
            "head_angle_deg": text_of(session.angle[trial]),
            "head_length_m": text_of(session.head[trial]),
            "fps": text_of(take.stated_fps, 5),
        }  # fmt: skip
        write_keypoints(study / row["source"], take, habits.names)
        if habits.logged:
            row["motor_log"] = f"motor/{trial_id}.csv"
            write_log(study / row["motor_log"], rng, take, habits)
        else:
            row["flap_hz"] = text_of(session.setting.flap[trial] * (1 + rng.normal(0, 0.002)), 4)
        rows.append(row)
    write_trials(study / "trials.csv", rows)
    return habits.logged


def _names(hidden: Hidden) -> set[str]:
    return {law.name for law in hidden.laws}
