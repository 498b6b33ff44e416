"""A study folder, read and checked at the door: the only reader of study.yaml and trials.csv."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from .data import PARTS
from .faults import Fault, Finding, fault, nearest

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Pixel = tuple[Number, Number]
Row3 = tuple[Number, Number, Number]
VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".m4v", ".360", ".mts")


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Pool(_Section):
    """Inner size of the pool along x and y and the water's depth, m."""

    length_m: Positive = 2.6
    width_m: Positive = 1.6
    depth_m: Positive = 0.3


class Water(_Section):
    """Density in kg/m3 and refractive index against air."""

    density_kg_m3: Positive = 1000.0
    refractive_index: Annotated[float, Field(ge=1.0, le=2.0)] = 1.333


class Robot(_Section):
    """Geometry and inertia; lengths in m, mass in kg, yaw inertia in kg m2."""

    mass_kg: Positive
    yaw_inertia_kg_m2: Positive
    body_length_m: Positive
    head_length_m: Positive
    head_span_m: Positive
    hinge_to_com_m: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    tail_length_m: Positive
    keypoint_depth_m: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.04

    @model_validator(mode="after")
    def _lengths_fit(self) -> Robot:
        if self.head_length_m + self.hinge_to_com_m >= self.body_length_m:
            raise ValueError(
                "head_length_m + hinge_to_com_m must be smaller than body_length_m, "
                f"found {self.head_length_m} + {self.hinge_to_com_m} and {self.body_length_m}"
            )
        return self

    def aerodynamic_arm_m(self, head_length_m: float) -> float:
        """Aerodynamic arm l = h + hinge_to_com - (body_length + h - head_length) / 4, m, for head h."""
        body = self.body_length_m + head_length_m - self.head_length_m
        return head_length_m + self.hinge_to_com_m - body / 4

    def head_area_m2(self, head_length_m: float) -> float:
        """A = head length x span, m2."""
        return head_length_m * self.head_span_m

    @property
    def com_to_tail_base_m(self) -> float:
        """Distance from the centre of mass back to the caudal base on the core axis, m."""
        return self.body_length_m - self.head_length_m - self.hinge_to_com_m


class Camera(_Section):
    """One fixed overhead camera; without `matrix` the pool corners give a homography alone."""

    model: Literal["pinhole", "fisheye"] = "pinhole"
    image_size_px: tuple[Annotated[int, Field(gt=0)], Annotated[int, Field(gt=0)]] | None = None
    matrix: tuple[Row3, Row3, Row3] | None = None
    distortion: tuple[Number, ...] | None = None
    pool_corners_px: tuple[Pixel, Pixel, Pixel, Pixel]
    pool_corners_height_m: Number = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> Camera:
        problems = [*self._lens_problems(), *_corner_problems(self.pool_corners_px)]
        if problems:
            raise ValueError("; ".join(problems))
        return self

    def _lens_problems(self) -> list[str]:
        if self.matrix is None:
            return ["distortion is given without a matrix"] if self.distortion else []
        problems = []
        fx, fy = self.matrix[0][0], self.matrix[1][1]
        if fx <= 0 or fy <= 0:
            problems.append(f"matrix: focal lengths must be positive, found {fx} and {fy}")
        if self.image_size_px is None:
            problems.append("image_size_px is needed with a matrix")
        allowed = (4,) if self.model == "fisheye" else (4, 5, 8, 12, 14)
        if self.distortion is not None and len(self.distortion) not in allowed:
            problems.append(
                f"distortion: a {self.model} lens has {' or '.join(map(str, allowed[:2]))} "
                f"coefficients, found {len(self.distortion)}"
            )
        return problems


class Detection(_Section):
    """How keypoints are found in footage."""

    source: str = "silhouette"
    marker_hues_deg: dict[str, Annotated[float, Field(ge=0, lt=360)]] = Field(default_factory=dict)


class Setup(_Section):
    """The whole of study.yaml."""

    pool: Pool = Pool()
    water: Water = Water()
    robot: Robot
    camera: Camera
    bodyparts: dict[str, str] = Field(default_factory=dict)
    detection: Detection = Detection()

    @model_validator(mode="after")
    def _known_parts(self) -> Setup:
        unknown = [part for part in self.bodyparts if part not in PARTS]
        if unknown:
            hints = "; ".join(f"'{part}': {nearest(part, PARTS)}" for part in unknown)
            raise ValueError(f"bodyparts maps our part to the file's name; unknown {hints}")
        return self


class Trial(_Section):
    """One row of trials.csv; `head_angle_rad` is core minus head, counter-clockwise positive."""

    trial_id: str
    source: str
    power_pct: Annotated[float, Field(ge=0, le=300, allow_inf_nan=False)]
    head_angle_deg: Annotated[float, Field(ge=-120, le=120, allow_inf_nan=False)]
    head_length_m: Annotated[float, Field(gt=0, le=10, allow_inf_nan=False)]
    fps: Annotated[float, Field(gt=0, le=10000, allow_inf_nan=False)] | None = None
    motor_log: str | None = None
    flap_hz: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] | None = None
    start_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    end_s: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    role: Literal["fit", "held_out"] | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Trial:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,100}", self.trial_id):
            raise ValueError(f"trial_id: letters, digits, _ and - only, found '{self.trial_id}'")
        if self.reads_keypoints and self.fps is None:
            raise ValueError("fps is required where the source is a keypoint file")
        if self.start_s is not None and self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s must come after start_s, found {self.start_s}, {self.end_s}")
        return self

    @property
    def sources(self) -> tuple[str, ...]:
        """Files of this trial: one, or the chapters of one recording."""
        return tuple(part.strip() for part in self.source.split(";") if part.strip())

    @property
    def reads_keypoints(self) -> bool:
        """Whether the source is a keypoint file rather than footage."""
        return any(Path(name).suffix.lower() in (".csv", ".h5", ".hdf5") for name in self.sources)

    @property
    def head_angle_rad(self) -> float:
        """Commanded head angle phi, rad."""
        return math.radians(self.head_angle_deg)

    @property
    def condition(self) -> tuple[float, float, float]:
        """What repeats share: power, head angle, head length."""
        return (self.power_pct, self.head_angle_deg, self.head_length_m)


class Study(_Section):
    """A checked study folder."""

    root: Path
    setup: Setup
    trials: tuple[Trial, ...]

    def trial(self, trial_id: str) -> Trial:
        """The trial of that id; Fault with the nearest id where there is none."""
        for trial in self.trials:
            if trial.trial_id == trial_id:
                return trial
        ids = [trial.trial_id for trial in self.trials]
        raise fault(
            self.root / "trials.csv",
            "",
            f"no trial '{trial_id}'",
            "a known trial",
            nearest(trial_id, ids),
        )

    def paths(self, trial: Trial) -> tuple[Path, ...]:
        """Absolute paths of a trial's source files."""
        return tuple(self.root / name for name in trial.sources)

    def motor_path(self, trial: Trial) -> Path | None:
        """Absolute path of a trial's motor log, where it has one."""
        return self.root / trial.motor_log if trial.motor_log else None


def load_study(folder: str | Path) -> Study:
    """Study of a folder with study.yaml and trials.csv.

    Raises: Fault with all that is wrong in both files at once. Files that the trials point to are
    not opened here: a broken recording stops only its own trial.
    """
    root = Path(folder)
    findings: list[Finding] = []
    setup = _setup(root / "study.yaml", findings)
    trials = _trials(root / "trials.csv", findings)
    if findings or setup is None:
        raise Fault(findings)
    return Study(root=root.resolve(), setup=setup, trials=tuple(trials))


def missing_files(study: Study) -> list[Finding]:
    """A finding for each file that trials.csv points to and that is not there."""
    found = []
    for row, trial in enumerate(study.trials, start=2):
        paths = [*study.paths(trial), *([study.motor_path(trial)] if trial.motor_log else [])]
        for path in paths:
            if path is not None and not path.is_file():
                found.append(
                    Finding(
                        "trials.csv",
                        f"row {row} ({trial.trial_id})",
                        f"no file '{path.relative_to(study.root)}'",
                        "a file at that path, relative to the study folder",
                    )
                )
    return found


def _setup(path: Path, findings: list[Finding]) -> Setup | None:
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        findings.append(Finding(str(path), "", "no such file", "a study.yaml in the study folder"))
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        findings.append(Finding(str(path), "", f"no readable yaml ({reason})", "plain yaml"))
        return None
    if not isinstance(content, dict):
        findings.append(Finding(str(path), "", _show(content), "keys pool, robot, camera, ..."))
        return None
    try:
        return Setup.model_validate(content)
    except ValidationError as error:
        findings.extend(_explain(str(path), error, Setup))
        return None


def _trials(path: Path, findings: list[Finding]) -> list[Trial]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except FileNotFoundError:
        findings.append(Finding(str(path), "", "no such file", "a trials.csv, one row a trial"))
        return []
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        findings.append(Finding(str(path), "", f"no readable csv ({error})", "a csv file"))
        return []
    if len(rows) < 2:
        findings.append(Finding(str(path), "", f"{len(rows)} rows", "a header and a row a trial"))
        return []
    names = [cell.strip() for cell in rows[0]]
    header = _header_findings(str(path), names)
    findings.extend(header)
    if header:
        return []
    trials = [_trial(str(path), i, names, row, findings) for i, row in enumerate(rows[1:], start=2)]
    known = [trial for trial in trials if trial is not None]
    findings.extend(_duplicates(str(path), known))
    return known


def _header_findings(path: str, names: list[str]) -> list[Finding]:
    known = list(Trial.model_fields)
    required = [name for name, info in Trial.model_fields.items() if info.is_required()]
    unknown = [
        Finding(path, "row 1", f"unknown column '{name}'", "a known column", nearest(name, known))
        for name in names
        if name not in known
    ]
    missing = [
        Finding(path, "row 1", f"no column '{name}'", f"the columns {', '.join(required)}")
        for name in required
        if name not in names
    ]
    repeated = [
        Finding(path, "row 1", f"column '{name}' twice", "each column once")
        for name in sorted({name for name in names if names.count(name) > 1})
    ]
    return unknown + missing + repeated


def _trial(
    path: str, number: int, names: list[str], row: list[str], findings: list[Finding]
) -> Trial | None:
    if len(row) != len(names):
        found = f"{len(row)} cells"
        findings.append(Finding(path, f"row {number}", found, f"{len(names)} cells, as the header"))
        return None
    cells = {n: cell.strip() for n, cell in zip(names, row, strict=True) if cell.strip()}
    try:
        trial = Trial.model_validate(cells)
    except ValidationError as error:
        found = f"row {number} ({cells.get('trial_id', '?')})"
        findings.extend(_explain(path, error, Trial, prefix=found))
        return None
    findings.extend(_path_findings(path, number, trial))
    return trial


def _path_findings(path: str, number: int, trial: Trial) -> list[Finding]:
    named = [*(("source", s) for s in trial.sources), ("motor_log", trial.motor_log or "")]
    found = [
        Finding(
            path,
            f"row {number} ({trial.trial_id}), {column}",
            f"'{name}'",
            "a path inside the study folder, without '..'",
        )
        for column, name in named
        if ".." in Path(name).parts or Path(name).is_absolute() or "\0" in name
    ]
    suffixes = {Path(name).suffix.lower() for name in trial.sources}
    known = {*VIDEO_SUFFIXES, ".csv", ".h5", ".hdf5"}
    if not trial.sources or not suffixes <= known:
        found.append(
            Finding(
                path,
                f"row {number} ({trial.trial_id}), source",
                f"'{trial.source}'",
                f"a video or keypoint file ({', '.join(sorted(known))})",
            )
        )
    return found


def _duplicates(path: str, trials: list[Trial]) -> list[Finding]:
    ids = [trial.trial_id for trial in trials]
    folded = [name.casefold() for name in ids]
    return [
        Finding(
            path,
            "trial_id",
            f"'{name}' {folded.count(name.casefold())} times",
            "each trial_id once (upper and lower case count as the same)",
        )
        for name in sorted({n for n in ids if folded.count(n.casefold()) > 1})
    ]


def _explain(
    path: str, error: ValidationError, model: type[BaseModel], prefix: str = ""
) -> list[Finding]:
    findings = []
    for item in error.errors(include_url=False):
        where = ", ".join(filter(None, [prefix, ".".join(map(str, item["loc"]))]))
        if item["type"] == "extra_forbidden":
            cure = nearest(str(item["loc"][-1]), _siblings(model, item["loc"][:-1]))
            findings.append(Finding(path, where, "an unknown key", "a known key", cure))
        elif item["type"] == "missing":
            findings.append(Finding(path, where, "nothing", "this key, which is required"))
        else:
            message = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
            findings.append(Finding(path, where, _show(item["input"]), message))
    return findings


def _siblings(model: type[BaseModel], location: tuple[Any, ...]) -> list[str]:
    for key in location:
        section = model.model_fields.get(str(key))
        annotation = section.annotation if section else None
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            break
        model = annotation
    return list(model.model_fields)


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 120 else text[:117] + "..."


def _corner_problems(corners: tuple[Pixel, ...]) -> list[str]:
    """Corners must go round the pool once: (0,0), (L,0), (L,W), (0,W), seen from above."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners
    turns = [
        (bx - ax) * (cy - by) - (by - ay) * (cx - bx),
        (cx - bx) * (dy - cy) - (cy - by) * (dx - cx),
        (dx - cx) * (ay - dy) - (dy - cy) * (ax - dx),
        (ax - dx) * (by - ay) - (ay - dy) * (bx - ax),
    ]
    if all(turn < 0 for turn in turns):
        return []
    expected = (
        "pool_corners_px must be the images of pool (0,0), (length,0), (length,width), (0,width) "
        "in this order, seen from above (counter-clockwise in the pool, image v downwards)"
    )
    if all(turn > 0 for turn in turns):
        return [expected + "; these go round the other way: swap the second and the fourth"]
    return [expected + "; these cross over or lie on a line"]
