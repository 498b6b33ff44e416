"""Making a study: robot, session, hidden causes, recording, files and truth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import writing
from .camera import draw_camera
from .eddies import draw_eddies
from .experiment import Experiment
from .faults import Scene, stated_of
from .filming import Campaign, metres_per_px, takes
from .fins import draw_fin
from .hiding import Bench, HiddenFault, fin_found, hide_fault, hide_laws
from .plan import Plan, draw_plan
from .robots import Robot, draw_robot
from .scatter import measure_scatter
from .sizing import LEAST_RATIO, LEAST_SIGMA
from .tracker import draw_tracker
from .trials import draw_pool, draw_session
from .truth import fault_entry, fin_entry, law_entry, strength, truth_of

GENERATOR = "pond_fleet"
STREAM = 52009
FRAME_RATES = (24.0, 25.0, 30000 / 1001, 30.0, 48.0, 50.0, 60000 / 1001, 60.0)
ATTEMPTS = 80
"""Robots tried until one shows what the plan asks for."""

Drawn = tuple[Campaign, list[dict[str, Any]], dict[str, Any] | None, float]
"""A campaign with its causes, its unlisted force, and the floor of the path error (m)."""


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    The truth is returned.
    """
    plan = draw_plan(seed, index)
    rng, (campaign, causes, unlisted, floor) = _first_possible(seed, index, plan)
    name = f"{GENERATOR}-{seed}-{index:03d}"
    logged = _write(rng, Path(folder) / "studies" / name, campaign)
    truth: dict[str, Any] = {"study": name, "generator": GENERATOR, "seed": seed, "index": index}
    truth |= truth_of(plan, campaign, causes, unlisted, floor)
    truth["conditions"]["motor_log"] = logged
    path = Path(folder) / "truth" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
    return truth


def _first_possible(seed: int, index: int, plan: Plan) -> tuple[np.random.Generator, Drawn]:
    """The first robot that shows what the plan asks for."""
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt, STREAM])
        drawn = draw_campaign(rng, plan)
        if drawn:
            return rng, drawn
    raise ValueError(f"seed {seed}, study {index}: no robot shows {plan}")


def draw_campaign(rng: np.random.Generator, plan: Plan) -> Drawn | None:
    """A campaign with its hidden causes; None where the robot cannot show them."""
    robot = draw_robot(rng)
    if plan.fin:
        robot = replace(robot, fin=draw_fin(rng, robot))
        if robot.fin is None:
            return None
    scene = _draw_scene(rng, robot)
    pixel = metres_per_px(scene.camera)
    tracker = draw_tracker(rng, robot, pixel)
    water = rng.uniform(0.0015, 0.005) * robot.speed
    experiment = Experiment(robot, scene.pool, scene.session)
    tracking = tracker.sample_error(pixel, robot.head_length)
    scatter = measure_scatter(rng, experiment, (), (), water=water, tracking=tracking)
    bench = Bench(scene, experiment, scatter)
    hidden = _draw_hidden(rng, plan, bench)
    if hidden is None:
        return None
    causes, unlisted, laws, fault = hidden
    count = scene.session.count
    campaign = Campaign(
        fault.scene if fault else scene, laws, fault.fault if fault else None,
        draw_eddies(rng, count, robot.body_length, water), tracker,
        float(rng.choice(FRAME_RATES)), rng.random(count),
    )  # fmt: skip
    return campaign, causes, unlisted, scatter.floor


def _draw_scene(rng: np.random.Generator, robot: Robot) -> Scene:
    pool = draw_pool(rng, robot)
    session = draw_session(rng, robot, pool, two_heads=bool(rng.random() < 0.4))
    mark_height = round(float(rng.choice([0.0, 0.05, 0.12]) * robot.body_length), 3)
    camera = draw_camera(rng, pool, mark_height)
    return Scene(robot, session, pool, camera, robot.keypoint_depth, mark_height)


def _draw_hidden(rng: np.random.Generator, plan: Plan, bench: Bench) -> Any:
    """Entries of causes and of an unlisted force, the laws, the error of measurement; or None."""
    causes: list[dict[str, Any]] = []
    fin, fault = bench.scene.robot.fin, None
    if fin:
        found = fin_found(bench)
        if not (found.sigma >= LEAST_SIGMA and found.ratio >= LEAST_RATIO):
            return None
        causes.append(fin_entry(fin) | strength(found))
    if plan.fault:
        fault = hide_fault(rng, plan.fault, bench)
        if fault is None:
            return None
    laws = hide_laws(rng, plan, bench, fault)
    if laws is None:
        return None
    unlisted = None
    for law, found in laws:
        entry, family = law_entry(law) | strength(found), law.family
        if family.where:
            channel, variable = family.where
            unlisted = {"channels": [channel], "variable": variable, "force": family.name} | entry
        else:
            causes.append({"name": family.name, "kind": "physics"} | entry)
    if fault:
        causes.append(_fault_cause(fault, bench.scatter.floor))
    return causes, unlisted, [law for law, _ in laws], fault


def _fault_cause(hidden: HiddenFault, floor: float) -> dict[str, Any]:
    return fault_entry(hidden.fault, hidden.displacement, floor) | strength(hidden.found)


def _write(rng: np.random.Generator, study: Path, campaign: Campaign) -> bool:
    """Write the folder; whether it has motor logs is returned."""
    fault, scene = campaign.fault, campaign.scene
    needs_log = fault is not None and fault.name in {"clock_error", "time_offset"}
    logged = needs_log or bool(rng.random() < 0.7)
    water_depth = round(max(0.25, 1.1 * scene.robot.body_length, scene.depth + 0.15), 2)
    habits = writing.draw_habits(rng, logged=logged, water_depth=water_depth)
    for part in ("keypoints", "motor") if logged else ("keypoints",):
        (study / part).mkdir(parents=True, exist_ok=True)
    text = writing.study_text(campaign, stated_of(fault, scene), habits)
    (study / "study.yaml").write_text(text)
    rows = []
    for trial, take in enumerate(takes(rng, campaign)):
        row = _row(campaign, trial)
        writing.write_keypoints(study / row["source"], take, habits)
        if logged:
            row["motor_log"] = f"motor/{row['trial_id']}.csv"
            writing.write_log(study / row["motor_log"], rng, take, habits.sensor)
        else:
            row["flap_hz"] = writing.number(take.flap * scene.session.logged[trial], 4)
        rows.append(row)
    writing.write_trials(study / "trials.csv", rows)
    return logged


def _row(campaign: Campaign, trial: int) -> dict[str, str]:
    """Row of trials.csv without the motor."""
    session, trial_id = campaign.scene.session, f"P{trial + 1:02d}"
    return {
        "trial_id": trial_id,
        "source": f"keypoints/{trial_id}.csv",
        "power_pct": writing.number(session.power[trial]),
        "head_angle_deg": writing.number(np.degrees(session.phi[trial]), 3),
        "head_length_m": writing.number(session.head[trial]),
        "fps": writing.number(campaign.fps, 5),
    }
