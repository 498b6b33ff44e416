"""The trials of a concealed study: where each starts, how it swims, what a tracker would see."""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from bluekoi.synthetic.body import body_point_positions
from bluekoi.synthetic.eddies import random_eddies
from bluekoi.synthetic.encode import GOPRO_FRAME_RATE_HZ
from bluekoi.synthetic.ground_truth_physics import GroundTruthPhysics, TrialSettings
from bluekoi.synthetic.motion_simulation import TrialMotion
from bluekoi.synthetic.optics import gopro_like_camera
from bluekoi.synthetic.picture_conditions import MIDDLE_PICTURE_CONDITIONS
from bluekoi.synthetic.synthetic_study_design import StudyDesign, TrialPlan
from bluekoi.synthetic.trial import (
    SolvedTrial,
    keypoint_pixels,
    start_pose_in_pool,
    time_until_wall,
    trial_rng,
)
from validation.generators.concealed.recipe import Recipe
from validation.generators.concealed.swimmer.inputs import NO_EDDIES, HiddenLaws, TrialCommand
from validation.generators.concealed.swimmer.motion import swim
from validation.generators.concealed.swimmer.water import eddies_as_rows

__all__ = [
    "MAX_DURATION_S",
    "SimulatedTrial",
    "design_while_filmed",
    "observed_pixels",
    "simulate_trial",
    "study_design",
]

MAX_DURATION_S = {50: 7.5, 75: 6.5, 100: 5.5}
NEEDS_LONG_TRIALS = ("wake_reentry",)
CHECK_STEP_S = 0.05
SINKING_DEPTH_M = 0.15
"""Depth (m) gained per unit of drag gained, while sinking."""
NUDGE_M_PER_DEG = 0.0234
FOOTAGE_PICTURE_CONDITIONS = replace(MIDDLE_PICTURE_CONDITIONS, mbit_s=20.0)


@dataclass(frozen=True)
class SimulatedTrial:
    """A trial that has been swum: what the film shows, its command, its motor (not delayed)."""

    trial: SolvedTrial
    command: TrialCommand
    eddies: np.ndarray
    motor: TrialMotion


def head_settings(recipe: Recipe) -> tuple[tuple[float, float], ...]:
    """Head angles (deg) and lengths (m) of each power: three in a small campaign, else eight,
    repeated in a large one.
    """
    head = recipe.robot.head_length_m
    long = round(1.4583 * head, 4)
    small, large = recipe.angles_deg
    if recipe.trials == 9:
        return (0.0, head), (small, head), (-large, long)
    one = ((0.0, head), (0.0, head), (0.0, long), (small, head), (-small, head))
    eight = (*one, (large, head), (-large, head), (large, long))
    return tuple(itertools.islice(itertools.cycle(eight), recipe.trials // len(recipe.flap_hz)))


def study_design(recipe: Recipe) -> StudyDesign:
    """The recipe's trials, camera and noise as a design; its tank gives robot and pool alone."""
    longer = 1.5 if any(c.name in NEEDS_LONG_TRIALS for c in recipe.chosen) else 1.0
    rows = [(power, *setting) for power in recipe.flap_hz for setting in head_settings(recipe)]
    plans = tuple(
        TrialPlan(f"T{n:02d}", power, angle, round(head, 4), longer * MAX_DURATION_S[power])
        for n, (power, angle, head) in enumerate(rows, start=1)
    )
    robot = recipe.robot
    if recipe.fault is not None and recipe.fault[0] == "uncorrected_refraction":
        robot = replace(robot, keypoint_depth_m=round(recipe.fault[1], 4))
    return StudyDesign(
        recipe.name,
        plans,
        GroundTruthPhysics(robot=robot, fin=None, recoil=recipe.recoil),
        recipe.seed,
        camera=gopro_like_camera("fisheye" if recipe.wide_lens else "pinhole"),
        flap_hz=recipe.flap_hz,
        water_rms_m_s=recipe.water_rms_m_s,
    )


def _open_water_path(
    recipe: Recipe, laws: HiddenLaws, design: StudyDesign, plan: TrialPlan, run: TrialSettings
) -> np.ndarray:
    """Keypoints `(times, 5)` of the path in still open water, from the origin along x."""
    still = laws._replace(current_x=0.0, current_y=0.0, gyre=0.0, wall=0.0, tether_n_m=0.0)
    command = TrialCommand(run.flap_hz, run.head_angle_rad, run.head_length_m)
    motion = swim(
        recipe.body, still, command, plan.longest_s, eddies=NO_EDDIES, recoil=recipe.recoil
    )
    time_s = np.arange(0, plan.longest_s + 1e-9, CHECK_STEP_S)
    return body_point_positions(
        design.tank.robot, plan.head_length_m, motion.pose_with_recoil(time_s)
    )


def simulate_trial(
    recipe: Recipe, design: StudyDesign, laws: HiddenLaws, plan: TrialPlan
) -> SimulatedTrial:
    """One trial of the recipe under the given laws, from its seed."""
    rng = trial_rng(design, plan.trial_id, "motion")
    eddies = random_eddies(rng, design.water_rms_m_s)
    spread = 1 + design.flap_spread * rng.standard_normal()
    run = TrialSettings(
        flap_hz=design.flap_hz[plan.power_pct] * spread,
        head_angle_rad=math.radians(plan.head_angle_deg),
        head_length_m=plan.head_length_m,
        start_beat_rad=float(rng.uniform(0, 2 * math.pi)),
    )
    path = _open_water_path(recipe, laws, design, plan, run)
    start = start_pose_in_pool(
        design, design.tank.pool_m, path, trial_rng(design, plan.trial_id, "start")
    )
    run = replace(run, start=start)
    command = TrialCommand(run.flap_hz, run.head_angle_rad, run.head_length_m, *start,
                      beat=run.start_beat_rad)  # fmt: skip
    rows = eddies_as_rows(eddies)
    motion = swim(recipe.body, laws, command, plan.longest_s, eddies=rows, recoil=recipe.recoil)
    late = recipe.fault[1] if recipe.fault and recipe.fault[0] == "time_offset" else 0.0
    frames = (
        int((time_until_wall(design, design.tank, plan, motion) + late) * GOPRO_FRAME_RATE_HZ) + 1
    )
    time_s = np.arange(frames) / float(GOPRO_FRAME_RATE_HZ) - late
    return SimulatedTrial(
        SolvedTrial(plan, design.tank, run, motion, time_s), command, rows, motion
    )


def design_while_filmed(recipe: Recipe, design: StudyDesign, trial: SolvedTrial) -> StudyDesign:
    """The design as it stands while a trial is filmed: the camera may have been displaced."""
    if recipe.fault is None or recipe.fault[0] != "camera_shift":
        return replace(design, conditions=FOOTAGE_PICTURE_CONDITIONS)
    numbers = [plan.trial_id for plan in design.plans]
    displaced_trial, now = len(numbers) // 2, numbers.index(trial.plan.trial_id)
    at = 0.55 * float(trial.time_s[-1]) if now == displaced_trial else -100.0
    degrees = recipe.fault[1] / NUDGE_M_PER_DEG
    state = replace(
        FOOTAGE_PICTURE_CONDITIONS,
        nudge_at_s=None if now < displaced_trial else at,
        nudge_deg=degrees,
    )
    return replace(design, conditions=state)


def observed_pixels(
    recipe: Recipe, design: StudyDesign, one: SimulatedTrial, laws: HiddenLaws
) -> np.ndarray:
    """Pixels `(frames, 5, 2)` where the keypoints truly appear, faults of seeing included."""
    trial = one.trial
    pose = trial.motion.pose_with_recoil(trial.time_s)
    points = body_point_positions(trial.tank.robot, trial.plan.head_length_m, pose)
    if recipe.fault is not None and recipe.fault[0] == "keypoint_bias":
        points[:, 2] += 1j * np.exp(1j * pose[:, 2]) * recipe.fault[1]
    sinking = SINKING_DEPTH_M * laws.sink_per_s
    return keypoint_pixels(
        design_while_filmed(recipe, design, trial), trial, points, sinking_m_s=sinking
    )
