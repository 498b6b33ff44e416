"""Rendered frames of a trial, as the camera records them."""

import math
from collections.abc import Iterator
from functools import lru_cache

import cv2
import numpy as np

from bluekoi.synthetic import distractors
from bluekoi.synthetic.body import DrawnShape
from bluekoi.synthetic.frame_drawing import (
    FilmSetup,
    ImagePlanes,
    add_light,
    add_noise,
    draw_body,
    draw_robot,
    noise_tiles,
)
from bluekoi.synthetic.glare import add_glare, random_lamp_reflections
from bluekoi.synthetic.optics import Camera, pool_points_to_pixels
from bluekoi.synthetic.picture_conditions import PictureConditions
from bluekoi.synthetic.scene import PoolImagery, build_scene
from bluekoi.synthetic.synthetic_study_design import StudyDesign
from bluekoi.synthetic.trial import SolvedTrial, camera_of_design_at_time, trial_rng


@lru_cache(maxsize=3)
def _cached_scene(
    camera: Camera, caustics: float, pool: tuple[float, float, float], seed: int
) -> PoolImagery:
    return build_scene(camera, caustics, pool_m=pool[:2], depth_m=pool[2], seed=seed)


def film_setup_at(design: StudyDesign, time_s: float) -> FilmSetup:
    """Pool, camera, light, lamps and noise of a design at a time (changed by a camera shift)."""
    camera, state = camera_of_design_at_time(design, time_s), design.conditions
    pool = (*design.tank.pool_m, design.pool_depth_m)
    rng = np.random.default_rng([design.seed, 7])
    return FilmSetup(
        _cached_scene(camera, state.caustics, pool, design.seed),
        camera,
        state,
        noise_tiles(rng, camera.size_px),
        random_lamp_reflections(rng, camera, state.glare_spots, pool_m=design.tank.pool_m),
    )


def _hand_release_position(trial: SolvedTrial) -> complex:
    x, y, psi = trial.run.start
    return complex(x, y) - 0.10 * complex(math.cos(psi), math.sin(psi))


def distractors_at(
    state: PictureConditions, trial: SolvedTrial, time_s: float
) -> list[tuple[list[DrawnShape], float]]:
    """Bodies over the water at a time, each with its height (m)."""
    pool = trial.tank.pool_m
    bodies = []
    if state.occluder:
        bodies.append((distractors.crossbar(pool), distractors.BAR_HEIGHT_ABOVE_WATER_M))
    if state.hand:
        bodies.append(
            (
                distractors.hand_parts_at_time(time_s, _hand_release_position(trial), pool),
                distractors.HAND_HEIGHT_ABOVE_WATER_M,
            )
        )
    return [(parts, height) for parts, height in bodies if parts]


def render_frame(
    design: StudyDesign, trial: SolvedTrial, stage: FilmSetup, *, number: int, offset: int
) -> ImagePlanes:
    """One frame without noise: pool, bodies in the water, the robot, bodies above, glare."""
    state, now = design.conditions, float(trial.time_s[number])
    planes = add_light(stage, offset + number)
    if state.second_body:
        other = distractors.toy_fish_shapes(now, trial.tank.pool_m)
        draw_body(planes, stage, [other], height_m=distractors.SECOND_BODY_HEIGHT_ABOVE_WATER_M)
    within = (np.arange(state.sub_frames) + 0.5) / state.sub_frames - 0.5
    draw_robot(
        planes,
        stage,
        trial.motion.pose_with_recoil(now + state.exposure_s * within),
        robot=trial.tank.robot,
        head_length_m=trial.plan.head_length_m,
        floor_m=design.pool_depth_m,
    )
    for parts, height in distractors_at(state, trial, now):
        draw_body(planes, stage, [parts], height_m=height)
    for lamp in stage.lamps:
        add_glare(planes.luma, planes.chroma, lamp, time_s=now, level=state.glare)
    return planes


def render_frames(design: StudyDesign, trial: SolvedTrial) -> Iterator[ImagePlanes]:
    """The frames of a trial, in order, with sensor noise."""
    moved_at_s = design.conditions.nudge_at_s
    before = film_setup_at(design, -math.inf)
    after = before if moved_at_s is None else film_setup_at(design, math.inf)
    rng = trial_rng(design, trial.plan.trial_id, "noise")
    offset = int(rng.integers(0, 100))
    for number, now in enumerate(trial.time_s):
        stage = before if moved_at_s is None or now < moved_at_s else after
        clean = render_frame(design, trial, stage, number=number, offset=offset)
        yield add_noise(clean, stage, rng)


def _occlusion_mask(
    camera: Camera, pixels: np.ndarray, parts: list[DrawnShape], height_m: float
) -> np.ndarray:
    """Which of pixels `(5, 2)` lie behind a body."""
    hidden = np.zeros(len(pixels), bool)
    for part in parts:
        place = np.column_stack(
            [part.outline.real, part.outline.imag, np.full(len(part.outline), height_m)]
        )
        outline = pool_points_to_pixels(camera, place).astype(np.float32)
        hidden |= [
            cv2.pointPolygonTest(outline, (float(u), float(v)), measureDist=False) >= 0
            for u, v in pixels
        ]
    return hidden


def visible_keypoints(
    design: StudyDesign, trial: SolvedTrial, keypoints_px: np.ndarray
) -> np.ndarray:
    """Which keypoints `(frames, 5)` are in the picture and behind nothing."""
    width, height = design.conditions.size_px
    inside = (keypoints_px > -0.5) & (keypoints_px < np.array([width, height]) - 0.5)
    shown: np.ndarray = np.all(inside, axis=-1)
    for number, now in enumerate(trial.time_s):
        camera = camera_of_design_at_time(design, float(now))
        for parts, height_m in distractors_at(design.conditions, trial, float(now)):
            shown[number] &= ~_occlusion_mask(camera, keypoints_px[number], parts, height_m)
    return shown
