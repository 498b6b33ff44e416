"""Compiled functions of the detector, loaded before they are needed; see `compiling`."""

from __future__ import annotations

from dataclasses import replace

import cv2

from ..data import Frame
from ..keypoints import silhouette
from ..study import StudySettings, Trial
from ..study.setup import DetectionSettings
from ..synthetic.footage import render_frames
from ..synthetic.picture_conditions import PictureConditions
from ..synthetic.study_rendering import study_yaml_content
from ..synthetic.synthetic_study_design import demo_design
from ..synthetic.trial import solve_trial

WARM_UP_FRAME_SIZE_PX = (480, 270)
WARM_UP_FRAME_STEP = 16


def preload() -> None:
    """Detect the robot in a few small rendered frames, so that the detector is compiled."""
    cv2.setNumThreads(1)  # a process with threads of OpenCV cannot be forked
    design = replace(demo_design(), conditions=PictureConditions(size_px=WARM_UP_FRAME_SIZE_PX))
    plan = design.plans[0]
    trial = solve_trial(design, plan.trial_id)
    few = replace(trial, time_s=trial.time_s[::WARM_UP_FRAME_STEP])
    pictures = zip(few.time_s, render_frames(design, few), strict=True)
    film = [Frame(i, float(t), picture.luma) for i, (t, picture) in enumerate(pictures)]
    setup = StudySettings(**study_yaml_content(design), detection=DetectionSettings(body="rigid"))
    silhouette.detect_keypoints(lambda: film, setup, Trial(
        trial_id=plan.trial_id, source=f"{plan.trial_id}.mp4", power_pct=plan.power_pct,
        head_angle_deg=plan.head_angle_deg, head_length_m=plan.head_length_m,
    ))  # fmt: skip
