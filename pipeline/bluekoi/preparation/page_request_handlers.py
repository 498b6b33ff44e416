"""Answers to the requests of the set-up page: functions of plain values that return json."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import BaseModel, ValidationError

from ..camera.lens_calibration import calibrate_files, calibration_from_lens_profile, camera_yaml
from ..camera.pool_corner_check import compare_corners, edge_points_px, projected_pool_grid_px
from ..errors import InputError, InputIssue, input_error, unreadable_reason
from ..files import read_text, to_json_types
from ..footage import open_recording
from ..motor import flapping_from_log
from ..study import Camera, Pool, Robot, StudySettings, Trial, Water
from ..study.image_files import expand_source
from ..study.key_reference import setting_keys
from ..study.validation_messages import issues_of_refused_values, shortened_repr
from .draft import Draft, read_draft
from .draft_check import draft_findings
from .frame_images import Luma, frame_at_recording_share, points_as_json
from .prefill import prefilled_trial_rows, usable_study_files
from .robot_outline import robot_outline

SETTINGS_CLASS_BY_SECTION: dict[str, type[BaseModel]] = {
    "pool": Pool,
    "water": Water,
    "robot": Robot,
    "camera": Camera,
}
BOARD_FILE_SUFFIXES = (
    ".png",
    ".jpg",
    ".jpeg",
    ".tif",
    ".tiff",
    ".bmp",
    ".mp4",
    ".mov",
    ".avi",
    ".mkv",
)
MAX_CAMERA_YAML_BYTES = 1_000_000


def page_state(folder: Path) -> dict[str, Any]:
    """Files of the folder, the draft, and every key with its meaning."""
    (files, notes), draft = usable_study_files(folder), read_draft(folder)
    return {
        "folder": str(folder),
        "files": {**asdict(files), "cameras": _camera_files(folder)},
        "notes": notes,
        "keys": [asdict(key) for key in setting_keys()],
        "draft": draft_as_json(draft),
        "new_rows": _rows_of_unlisted_files(draft, folder),
        "findings": [asdict(finding) for finding in draft_findings(draft, folder)],
    }


def draft_as_json(draft: Draft) -> dict[str, Any]:
    """A draft as the page gets it."""
    return {"values": dict(draft.values), "rows": [dict(row) for row in draft.rows],
            "revision": draft.revision}  # fmt: skip


def recording_properties(folder: Path, rows: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Of each row: duration of the recording [s], frames/s, size, and flapping frequency of its log
    [Hz]; what cannot be read is left out.
    """
    return [_recording_properties(folder, row) for row in rows]


def source_frame(
    folder: Path, source: str, share: float, fps: str, first_s: float | None = None
) -> tuple[float, Luma]:
    """A frame of a source as trials.csv names it, `frame_at_recording_share`.

    Raises: InputError where it cannot be read.
    """
    paths = _source_paths(folder, source)
    if not paths or any(".." in Path(part).parts for part in source.split(";")):
        raise input_error(folder / "trials.csv", "source", shortened_repr(source), "a video")
    return frame_at_recording_share(paths, share, _parse_number(fps), first_s)


def corners_compared_with_pool_edges(values: Mapping[str, str], grey: Luma) -> dict[str, Any]:
    """The corners given, compared with the edges of the pool in a frame, in the frame's pixels.

    Raises: InputError where pool or camera are not yet complete.
    """
    found = compare_corners(grey, _setup_without_robot(values))
    check = found.check
    return to_json_types({
        "edges_px": [points_as_json(points[::2]) for points in edge_points_px(found.fit)],
        "grid_px": [points_as_json(line[::9])
                    for line in (projected_pool_grid_px(found.camera) if found.camera else [])],
        "fitted_px": points_as_json(found.fit.corners_px),
        "suggested_px": points_as_json(check.suggested_px),
        "inner_rim_px": points_as_json(found.fit.inner_rim_px),
        "std_px": points_as_json(check.std_px),
        "off_px": points_as_json(check.off_px),
        "doubts": found.fit.doubts,
        "sentences": check.sentences,
        "confirmed": check.confirmed,
    })  # fmt: skip


def robot_outline_on_frame(values: Mapping[str, str], place: Mapping[str, float]) -> dict[str, Any]:
    """The robot to scale with its centre of mass at a pixel of study.yaml.

    place: x_px, y_px; toward_x_px, toward_y_px, where the core points; head_angle_deg;
    head_length_m (0: the 1x head).
    Raises: InputError where pool, camera or robot are not yet complete.
    """
    camera, pool = _validated_section("camera", values), _validated_section("pool", values)
    found = robot_outline(
        camera, pool, _validated_section("robot", values),
        com_px=(float(place["x_px"]), float(place["y_px"])),
        toward_px=(float(place["toward_x_px"]), float(place["toward_y_px"])),
        head_angle_rad=math.radians(float(place["head_angle_deg"])),
        head_length_m=float(place.get("head_length_m") or 0) or None,
        refractive_index=_validated_section("water", values).refractive_index,
    )  # fmt: skip
    return to_json_types(
        {name: points_as_json(np.array(value)) for name, value in asdict(found).items()}
    )


def lens_calibration(folder: Path, files: str, pattern: str, square_mm: float) -> dict[str, Any]:
    """Camera keys from a camera.yaml, a lens profile, or pictures of a board; with remarks.

    files: a path or a pattern such as `board/*.jpg`, relative to the study folder. What is computed
    from pictures is also written to camera.yaml, or camera-2.yaml and so on, in the folder.

    Raises: InputError where there is no such file or no lens can be had from it.
    """
    paths = _matching_files(folder, files)
    if len(paths) == 1 and paths[0].suffix.lower() in (".yaml", ".yml"):
        return {"values": _lens_keys(_camera_section(paths[0])), "remarks": [f"from {files}"]}
    if len(paths) == 1 and paths[0].suffix.lower() == ".json":
        found, out = calibration_from_lens_profile(paths[0]), None
    else:
        names = ("camera.yaml", *(f"camera-{k}.yaml" for k in range(2, 1000)))
        out = next(folder / name for name in names if not (folder / name).exists())
        found = calibrate_files(paths, pattern=pattern, square_mm=square_mm, out=out)
    content = yaml.safe_load(camera_yaml(found))["camera"]
    written = [f"written: {out.name} and {out.stem}.png"] if out else []
    return {
        "values": _lens_keys(content),
        "remarks": [found.quality_text, *found.remarks, *written],
    }


def _setup_without_robot(values: Mapping[str, str]) -> StudySettings:
    """A setup without the robot, of which the corners need nothing but the depth of its points."""
    depth = _parse_number(values.get("robot.keypoint_depth_m", ""))
    return StudySettings.model_construct(
        pool=_validated_section("pool", values),
        water=_validated_section("water", values),
        camera=_validated_section("camera", values),
        robot=Robot.model_construct(keypoint_depth_m=depth) if depth else Robot.model_construct(),
    )


def _validated_section(name: str, values: Mapping[str, str]) -> Any:
    """A section of study.yaml from the values typed. Raises: InputError."""
    given = {key.partition(".")[2]: _parse_yaml_value(text) for key, text in values.items()
             if key.startswith(f"{name}.") and text.strip()}  # fmt: skip
    missing = [
        InputIssue("study.yaml", f"{name}.{key}", "nothing", "a number")
        for key in ("length_m", "width_m")
        if name == "pool" and key not in given
    ]
    if missing:
        raise InputError(missing)
    model = SETTINGS_CLASS_BY_SECTION[name]
    try:
        return model.model_validate(given)
    except ValidationError as error:
        raise InputError(
            issues_of_refused_values("study.yaml", error, model, prefix=name)
        ) from error


def _parse_yaml_value(text: str) -> Any:
    try:
        return yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError):
        return text


def _parse_number(text: str) -> float | None:
    try:
        found = float(text)
    except ValueError:
        return None
    return found if math.isfinite(found) and found > 0 else None


def _recording_properties(folder: Path, row: Mapping[str, str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    try:
        trial = Trial.model_construct(source=row.get("source", ""), trial_id="")
        if trial.source and not trial.reads_keypoints:
            film = open_recording(
                _source_paths(folder, trial.source), fps=_parse_number(row.get("fps", ""))
            )
            fps = film.fps or film.nominal_fps
            found |= {"duration_s": round(film.frames_present / fps, 2), "fps": round(fps, 3),
                      "size_px": list(film.size_px)}  # fmt: skip
    except InputError as error:
        found["error"] = str(error)
    try:
        if (log := row.get("motor_log", "").strip()) and os.path.isfile(folder / log):
            found["flap_hz"] = round(flapping_from_log(folder / log).flap_hz, 3)
    except InputError as error:
        found["log_error"] = str(error)
    return found


def _source_paths(folder: Path, source: str) -> tuple[Path, ...]:
    """Files that a source names. Raises: InputError where it can be no path."""
    names = [part.strip() for part in source.split(";") if part.strip()]
    try:
        return tuple(path for name in names for path in expand_source(folder, name))
    except (OSError, ValueError) as error:
        found = shortened_repr(source)
        raise input_error(folder / "trials.csv", "source", found, "a video") from error


def _rows_of_unlisted_files(draft: Draft, folder: Path) -> list[dict[str, str]]:
    """Pre-filled rows of trials.csv for files of the folder that no row of the draft names."""
    named = {part.strip() for row in draft.rows for part in row.get("source", "").split(";")}
    return [row for row in prefilled_trial_rows(usable_study_files(folder)[0])
            if not set(row["source"].split(";")) & named]  # fmt: skip


def _camera_files(folder: Path) -> list[str]:
    """Files in the folder that hold a camera section, or may be a lens profile."""
    some = sorted(p for p in folder.glob("*") if p.suffix.lower() in (".yaml", ".yml", ".json"))
    found = []
    for path in some:
        if path.name == "study.yaml" or not path.is_file():
            continue
        if path.suffix.lower() == ".json":
            try:
                calibration_from_lens_profile(path)
            except InputError:
                continue
        elif "camera:" not in path.read_text("utf-8", "replace"):
            continue
        found.append(path.name)
    return found


def _camera_section(path: Path) -> dict[str, Any]:
    """The camera section of a yaml file. Raises: InputError where there is none."""
    try:
        content = yaml.safe_load(read_text(path, MAX_CAMERA_YAML_BYTES))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise input_error(
            path, "", f"no readable yaml ({unreadable_reason(error)})", "a camera section"
        ) from error
    camera = content.get("camera") if isinstance(content, dict) else None
    if not isinstance(camera, dict) or "matrix" not in camera:
        raise input_error(path, "camera", "no matrix", "a file that `bluekoi calibrate` wrote")
    return camera


def _lens_keys(content: Mapping[str, Any]) -> dict[str, str]:
    """Lens keys of a camera section as text; the corners stay as they are."""
    names = ("model", "image_size_px", "matrix", "distortion")
    return {
        f"camera.{name}": str(to_json_types(content[name]))
        for name in names
        if content.get(name) is not None
    }


def _matching_files(folder: Path, files: str) -> list[Path]:
    """Files that a path or a pattern names. Raises: InputError where there are none."""
    given = Path(files.strip())
    if not files.strip() or ".." in given.parts:
        raise input_error(folder, "calibration", repr(files), "a file, or a pattern as board/*.jpg")
    base = Path(given.anchor) if given.is_absolute() else folder
    pattern = str(given.relative_to(given.anchor)) if given.is_absolute() else str(given)
    found = sorted(base.glob(pattern)) if any(c in pattern for c in "*?[") else [base / pattern]
    if len(found) == 1 and found[0].is_dir():
        found = sorted(p for p in found[0].iterdir() if p.suffix.lower() in BOARD_FILE_SUFFIXES)
    if not found or not all(path.is_file() for path in found):
        raise input_error(folder / files, "", "no such file", "a file, or a pattern as board/*.jpg")
    return found
