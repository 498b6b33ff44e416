"""Overlay video of a trial: keypoints, measured path and model paths on its footage."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path

import cv2
import numpy as np

from ..camera.pool_projection import PoolCamera, pool_to_pixels
from ..camera.study_camera import pool_camera
from ..campaign import Campaign
from ..data import Float, Frame, Track
from ..footage import encode_h264, frames, open_recording
from ..keypoints.deeplabcut import read_detections
from ..study import Study, Trial
from .overlay_frame import (
    AFTER_BGR,
    BEFORE_BGR,
    LEGEND_STRIP_HEIGHT_PX,
    MEASURED_BGR,
    BgrImage,
    OverlayContent,
    OverlayPath,
    annotated_frame,
    empty_pool_image,
)

VIDEO_WIDTH_PX = 640
MAX_FPS = 30.0
VIDEO_CRF = 29
"""Constant rate factor of the encoder: larger is smaller and coarser."""


def write_trial_overlay(
    campaign: Campaign, trial_id: str, results: str | Path, path: str | Path
) -> tuple[int, float]:
    """Write the overlay of one analysed trial; return its number of frames and the time of the
    first one, s.

    Background: the trial's footage, or for keypoint files a drawing of the empty pool.

    Raises: InputError where footage or keypoints cannot be read.
    """
    study, trial = campaign.study, campaign.study.trial(trial_id)
    footage, size = _footage_frames(study, trial)
    camera = pool_camera(study.setup, size)
    seen = Path(results) / "keypoints" / f"{trial_id}.csv"
    found = read_detections(seen, trial) if seen.is_file() else None
    track = campaign.tracks[trial_id]
    columns = campaign.model_columns(trial_id)
    scene = OverlayContent(
        label=_trial_label(trial),
        size_px=camera.size_px,
        lines=projected_overlay_paths(camera, track, columns, study.setup.robot.keypoint_depth_m),
        keypoints=found,
        background=empty_pool_image(camera, VIDEO_WIDTH_PX),
    )
    times = found.time_s if found is not None else track.time_s
    source: Iterator[Frame | float] = footage if footage is not None else map(float, times)
    first = next(source, None)
    source = source if first is None else chain([first], source)
    count = write_overlay(path, scene, source, fps=overlay_frame_rate(times))
    return count, first.time_s if isinstance(first, Frame) else first or 0.0


def write_overlay(
    path: str | Path,
    scene: OverlayContent,
    source: Iterable[Frame | float],
    *,
    fps: float = MAX_FPS,
) -> int:
    """Write an H.264 mp4, 640 px wide, with a constant frame rate; return its number of frames.

    source: frames with colour, or times [s] for the empty pool. Each frame is repeated until the
    time of the next one; of frames within one frame period, the first is used.
    """
    width, height = overlay_size(scene.size_px)
    pictures = _frames_at_steady_rate(scene, source, (width, height), fps)
    return encode_h264(
        path, pictures, fps=fps, size=(width, height + LEGEND_STRIP_HEIGHT_PX), crf=VIDEO_CRF
    )


def overlay_size(size_px: tuple[int, int]) -> tuple[int, int]:
    """Width and height of the picture in the film of footage of a size, even."""
    return VIDEO_WIDTH_PX, 2 * round(VIDEO_WIDTH_PX / size_px[0] * size_px[1] / 2)


def _frames_at_steady_rate(
    scene: OverlayContent, source: Iterable[Frame | float], size: tuple[int, int], fps: float
) -> Iterator[BgrImage]:
    """Pictures at a steady rate; one that is missing is that before it."""
    count, first = 0, np.nan
    picture: BgrImage | None = None
    for one in source:
        time_s = one.time_s if isinstance(one, Frame) else float(one)
        first = time_s if count == 0 else first
        place = round((time_s - first) * fps)
        while picture is not None and count < place:
            yield picture
            count += 1
        if place < count:
            continue
        picture = annotated_frame(
            _scene_background(one, scene, size), scene, time_s, size[0] / scene.size_px[0]
        )
        yield picture
        count += 1


def overlay_frame_rate(time_s: Float) -> float:
    """Frame rate from frame times, 1/s, at most 30."""
    return float(min(MAX_FPS, 1 / np.median(np.diff(time_s)))) if len(time_s) > 1 else MAX_FPS


def projected_overlay_paths(
    camera: PoolCamera, track: Track, columns: Mapping[str, Float], depth_m: float
) -> tuple[OverlayPath, ...]:
    """Measured path and model paths in pixels.

    Order and width keep all of them visible where they coincide: measured wide, after narrow,
    before dashed on top.
    """

    def projected(x: Float, y: Float) -> Float:
        return pool_to_pixels(camera, np.column_stack([x, y, np.full(len(x), -depth_m)]))

    measured = projected(track.x_m, track.y_m)
    lines = [OverlayPath("measured path", track.time_s, measured, MEASURED_BGR, width_px=6)]
    before = "model before" if "extended_x_m" in columns else "model"
    names = {
        "extended": ("model after", AFTER_BGR, False),
        "joint": (before, BEFORE_BGR, True),
    }
    for prefix, (name, colour, dashed) in names.items():
        if f"{prefix}_x_m" in columns:
            path_px = projected(columns[f"{prefix}_x_m"], columns[f"{prefix}_y_m"])
            lines.append(OverlayPath(name, columns["time_s"], path_px, colour, dashed))
    return tuple(lines)


def _footage_frames(
    study: Study, trial: Trial
) -> tuple[Iterator[Frame | float] | None, tuple[int, int] | None]:
    if trial.reads_keypoints:
        return None, None
    recording = open_recording(
        study.paths(trial), fps=trial.fps, start_s=trial.start_s, end_s=trial.end_s
    )
    film = frames(recording, colour=True, bgr_size=overlay_size(recording.size_px))
    return iter(film), recording.size_px


def _trial_label(trial: Trial) -> str:
    return (
        f"{trial.trial_id}   {trial.power_pct:g} % power   head {trial.head_angle_deg:g} deg, "
        f"{100 * trial.head_length_m:g} cm"
    )


def _scene_background(one: Frame | float, scene: OverlayContent, size: tuple[int, int]) -> BgrImage:
    if not isinstance(one, Frame):
        return scene.background.copy()
    whole = one.bgr if one.bgr is not None else cv2.cvtColor(one.luma, cv2.COLOR_GRAY2BGR)
    if whole.shape[1::-1] == size:
        return whole
    return np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_AREA), np.uint8)
