"""What was measured and what the model does, drawn on the footage itself."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import cv2
import numpy as np

from ..camera.corners import pool_camera
from ..camera.pool import PoolCamera, project
from ..campaign import Campaign
from ..data import Float, Frame, Keypoints, Track
from ..footage import frames, open_recording
from ..footage.writing import encoder
from ..keypoints.deeplabcut import read
from ..study import Study, Trial
from .drawing import (
    AFTER,
    BEFORE,
    MEASURED,
    STRIP_PX,
    Line,
    Picture,
    Scene,
    annotated,
    empty_pool,
)

WIDTH_PX = 640
MOST_FPS = 30.0
CRF = 29


def trial_overlay(campaign: Campaign, trial_id: str, results: str | Path, path: str | Path) -> int:
    """Number of frames of the overlay written for one analysed trial.

    The trial's footage where it has some, else the empty pool as its camera would see it.

    Raises: Fault where footage or keypoints cannot be read.
    """
    study, trial = campaign.study, campaign.study.trial(trial_id)
    film, size = _footage(study, trial)
    camera = pool_camera(study.setup, size)
    found = _keypoints(Path(results) / "keypoints" / f"{trial_id}.csv", trial)
    track = campaign.tracks[trial_id]
    columns = campaign.model_columns(trial_id)
    scene = Scene(
        label=_label(trial),
        size_px=camera.size_px,
        lines=paths(camera, track, columns, _depth_m(campaign)),
        keypoints=found,
        floor=empty_pool(camera, WIDTH_PX),
    )
    moments = found.time_s if found is not None else track.time_s
    shown = film if film is not None else _blank(moments)
    return write_overlay(path, scene, shown, fps=frame_rate(moments))


def _depth_m(campaign: Campaign) -> float:
    """Depth of the keypoints that the tracks were made with."""
    given = campaign.study.setup.robot.keypoint_depth_m
    return float((campaign.geometry or {}).get("depth_m", given))


def write_overlay(
    path: str | Path, scene: Scene, film: Iterable[Frame | float], *, fps: float = MOST_FPS
) -> int:
    """Number of pictures written to an H.264 mp4, 640 px wide, at a constant rate of `fps`.

    film: frames with colour, or bare times [s] for the empty pool. A frame stands until the next
    one's time; of frames that share a place the first is shown.
    """
    scale = WIDTH_PX / scene.size_px[0]
    height = 2 * round(scale * scene.size_px[1] / 2)
    count, first = 0, np.nan
    picture: Picture | None = None
    with encoder(path, fps=fps, size=(WIDTH_PX, height + STRIP_PX), crf=CRF) as out:
        for one in film:
            time_s = one.time_s if isinstance(one, Frame) else float(one)
            first = time_s if count == 0 else first
            place = round((time_s - first) * fps)
            while picture is not None and count < place:
                out.write(picture)
                count += 1
            if place < count:
                continue
            picture = annotated(_ground(one, scene, (WIDTH_PX, height)), scene, time_s, scale)
            out.write(picture)
            count += 1
    return count


def frame_rate(time_s: Float) -> float:
    """Rate of a recording from its times, 1/s, 30 at most."""
    return float(min(MOST_FPS, 1 / np.median(np.diff(time_s)))) if len(time_s) > 1 else MOST_FPS


def paths(
    camera: PoolCamera, track: Track, columns: Mapping[str, Float], depth_m: float
) -> tuple[Line, ...]:
    """Measured path, and model paths after and before where they are known, in pixels.

    Measured wide, after narrow on it, before dashed on top: all can be seen where they agree.
    """

    def seen(x: Float, y: Float) -> Float:
        return project(camera, np.column_stack([x, y, np.full(len(x), -depth_m)]))

    measured = seen(track.x_m, track.y_m)
    lines = [Line("measured path", track.time_s, measured, MEASURED, width_px=6)]
    before = "model before" if "extended_x_m" in columns else "model"
    names = {"extended": ("model after", AFTER, False), "joint": (before, BEFORE, True)}
    for prefix, (name, colour, dashed) in names.items():
        if f"{prefix}_x_m" in columns:
            way = seen(columns[f"{prefix}_x_m"], columns[f"{prefix}_y_m"])
            lines.append(Line(name, columns["time_s"], way, colour, dashed))
    return tuple(lines)


def _footage(study: Study, trial: Trial) -> tuple[Iterator[Frame] | None, tuple[int, int] | None]:
    if trial.reads_keypoints:
        return None, None
    recording = open_recording(
        study.paths(trial), fps=trial.fps, start_s=trial.start_s, end_s=trial.end_s
    )
    return iter(frames(recording, colour=True)), recording.size_px


def _keypoints(path: Path, trial: Trial) -> Keypoints | None:
    if not path.is_file():
        return None
    whole = trial.model_copy(update={"start_s": None, "end_s": None, "fps": trial.fps or 30.0})
    return read(path, whole, {})


def _blank(times: Float) -> Iterator[float]:
    return (float(t) for t in times)


def _label(trial: Trial) -> str:
    return (
        f"{trial.trial_id}   {trial.power_pct:g} % power   head {trial.head_angle_deg:g} deg, "
        f"{100 * trial.head_length_m:g} cm"
    )


def _ground(one: Frame | float, scene: Scene, size: tuple[int, int]) -> Picture:
    if not isinstance(one, Frame):
        return scene.floor.copy()
    whole = one.bgr if one.bgr is not None else cv2.cvtColor(one.luma, cv2.COLOR_GRAY2BGR)
    return np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_AREA), np.uint8)
