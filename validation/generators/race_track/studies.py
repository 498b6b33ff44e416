"""Making a study: robot, pool, trials, hidden causes, recording, files and truth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import writing
from .camera import draw_camera
from .faults import NEEDS_LOG, Place, draw_fault
from .filming import Campaign, takes
from .form import Law
from .labels import draw_tracker, point_noise
from .plan import CAUSES, UNLISTED, Plan, compatible, draw_plan
from .refit import Gauge, fin_that_matters, sized, with_floor
from .robots import FIN_FORMS, draw_fin, draw_robot
from .trials import draw_pool, draw_schedule
from .truth import truth_of
from .water import draw_unrest

GENERATOR = "race_track"
STREAM = 7331
FRAME_RATES = (25.0, 30000 / 1001, 30.0, 50.0, 60000 / 1001)


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    The truth is returned.
    """
    rng = np.random.default_rng([seed, index, STREAM])
    plan = draw_plan(seed, index)
    campaign, errors, floor = draw_campaign(rng, plan)
    name = f"{GENERATOR}-{seed}-{index:03d}"
    logged = _write(rng, Path(folder) / "studies" / name, campaign)
    truth: dict[str, Any] = {"study": name, "generator": GENERATOR, "seed": seed, "index": index}
    truth |= truth_of(plan, campaign, errors, floor)
    truth["conditions"]["motor_log"] = logged
    path = Path(folder) / "truth" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
    return truth


def draw_campaign(rng: np.random.Generator, plan: Plan) -> tuple[Campaign, dict[str, float], float]:
    """A campaign with its hidden causes, the path error of each (m), and the floor (m)."""
    robot = draw_robot(rng)
    if plan.fin:
        robot = replace(robot, fin=draw_fin(rng, robot, str(rng.choice(FIN_FORMS))))
    pool = draw_pool(rng, robot)
    schedule = draw_schedule(rng, robot, pool, two_heads=bool(rng.random() < 0.4))
    depth = round(max(0.3, 0.9 * robot.body_length), 2)
    camera = draw_camera(rng, pool)
    tracker = draw_tracker(rng, camera.size)
    unrest = draw_unrest(rng, robot, schedule.count, depth, level=rng.uniform(0.0015, 0.005))
    noise = point_noise(tracker, camera.focal[0] / float(camera.position[2]))
    gauge, errors = Gauge(robot, pool, schedule), dict[str, float]()
    if plan.fin:
        gauge, errors["tail_fin_lift"] = fin_that_matters(gauge, unrest, noise)
        robot = gauge.robot
    else:
        gauge = with_floor(gauge, unrest, noise)
    laws = _draw_laws(rng, plan, gauge, errors)
    fault = None
    if plan.fault:
        place = Place(0.3 * pool[0], float(camera.position[2]), gauge.floor)
        fault = draw_fault(rng, plan.fault, robot, schedule.count, place)
    robot = replace(robot, keypoint_depth=writing.true_depth(fault, robot.keypoint_depth))
    campaign = Campaign(
        robot, pool, max(depth, round(robot.keypoint_depth + 0.15, 2)), gauge.schedule, laws=laws,
        unrest=unrest, fault=fault, camera=camera, tracker=tracker,
        fps=float(rng.choice(FRAME_RATES)), first=rng.random(schedule.count),
    )  # fmt: skip
    return campaign, errors, gauge.floor


def _draw_laws(
    rng: np.random.Generator, plan: Plan, gauge: Gauge, errors: dict[str, float]
) -> list[Law]:
    """One law of each deck: the first that can matter and stands beside the others."""
    laws: list[Law] = []
    decks = [(deck, CAUSES) for deck in plan.decks]
    if plan.unlisted:
        decks.append((plan.unlisted, UNLISTED))
    for deck, families in decks:
        for name in deck:
            taken = [law.family.name for law in laws] + [plan.fault or ""]
            if not compatible(name, taken):
                continue
            found = sized(rng, families[name], gauge)
            if found:
                laws.append(found[0])
                errors[name] = found[1]
                break
    return laws


def _write(rng: np.random.Generator, study: Path, campaign: Campaign) -> bool:
    """Write the folder; whether it has motor logs is returned."""
    fault = campaign.fault
    logged = bool(rng.random() < 0.6) or (fault is not None and fault.name in NEEDS_LOG)
    renamed = bool(rng.random() < 0.2)
    sensor = writing.ShaftSensor(
        360 - rng.uniform(8, 30), str(rng.choice(["hold", "zero", "empty"])), rng.uniform(0.3, 1.0)
    )
    for part in ("keypoints", "motor") if logged else ("keypoints",):
        (study / part).mkdir(parents=True, exist_ok=True)
    height = float(rng.choice([0.0, 0.03, 0.06]))
    said = writing.stated(campaign, height, rng.normal(0, 0.2, (4, 2)), renamed=renamed)
    (study / "study.yaml").write_text(writing.study_text(campaign, said))
    rows = []
    for k, take in enumerate(takes(rng, campaign)):
        row = _row(campaign, k, f"R{k + 1:02d}")
        writing.write_keypoints(study / row["source"], take, renamed=renamed)
        if logged:
            row["motor_log"] = f"motor/{row['trial_id']}.csv"
            writing.write_log(study / row["motor_log"], rng, take, sensor)
        else:
            row["flap_hz"] = writing.number(take.flap, 4)
        rows.append(row)
    writing.write_trials(study / "trials.csv", rows)
    return logged


def _row(campaign: Campaign, trial: int, trial_id: str) -> dict[str, str]:
    """Row of trials.csv without the motor."""
    schedule = campaign.schedule
    return {
        "trial_id": trial_id,
        "source": f"keypoints/{trial_id}.csv",
        "power_pct": writing.number(schedule.power[trial]),
        "head_angle_deg": writing.number(np.degrees(schedule.phi[trial]), 3),
        "head_length_m": writing.number(schedule.head[trial]),
        "fps": writing.number(campaign.fps, 5),
    }
