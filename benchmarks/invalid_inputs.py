"""Invalid inputs and plausible mistakes, with the message that each one causes.

    python benchmarks/invalid_inputs.py inputs            # 115 broken or hostile files, about two minutes
    python benchmarks/invalid_inputs.py mistakes [NAME]   # 26 mistakes of a user, a search each

Every case changes one thing of a small keypoint study. Inputs go through `bluekoi check` and, where
that finds nothing, through detection and tracks. Mistakes go through the search as well. The outcome
is `refused` (check lists it), `trial lost` (a trial ends with a message), `warned`, `named` (a cause
of the verdict), `harmless` (speeds and coefficients within their stated intervals of the right
study's) or `SILENT`; `CRASH` and `HANG` speak for themselves.
"""

# ruff: noqa: E501  a case is a row of a table
from __future__ import annotations

import csv
import json
import re
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import yaml
from click.testing import CliRunner

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bluekoi.camera.rigid_length_warnings import rigid_length_warnings
from bluekoi.cli import main as bluekoi
from bluekoi.errors import InputError
from bluekoi.motor.swimming_plausibility import clock_and_length_warnings
from bluekoi.stages.geometry import geometry
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.mismatch import mismatch
from bluekoi.stages.steady import steady
from bluekoi.stages.tracks import tracks
from bluekoi.stages.tuning import tuning
from bluekoi.study import load_study
from small_studies import edit_trials_csv, small_study

MAX_SECONDS = 30
Change = Callable[[Path], object]
TRIAL_IDS = ("T09", "T10", "T11")


class HangError(Exception):
    """A case that did not end."""


@contextmanager
def time_limit(seconds: int) -> Iterator[None]:
    def end(*_: object) -> None:
        raise HangError

    signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)


# --- ways to change a study ---


def replace_file_text(name: str, content: str | bytes) -> Change:
    data = content.encode() if isinstance(content, str) else content
    return lambda s: (s / name).write_bytes(data)


def set_yaml_key(path: str, value: object) -> Change:
    def change(study: Path) -> None:
        content = yaml.safe_load((study / "study.yaml").read_text())
        *sections, last = path.split(".")
        place = content
        for section in sections:
            place = place[section]
        place[last] = value
        (study / "study.yaml").write_text(yaml.safe_dump(content, sort_keys=False))

    return change


def append_text(name: str, content: str) -> Change:
    return lambda s: (s / name).open("a").write(content)


def set_cell(column: str, value: str, trial: str = "T10") -> Change:
    return lambda s: edit_trials_csv(s, **{trial: {column: value}})


def set_column(column: str, value: Callable[[dict[str, str]], str]) -> Change:
    def change(study: Path) -> None:
        with (study / "trials.csv").open(newline="") as lines:
            rows = list(csv.DictReader(lines))
        edit_trials_csv(study, **{row["trial_id"]: {column: value(row)} for row in rows})

    return change


def change_lines(name: str, function: Callable[[list[str]], list[str]]) -> Change:
    def change(study: Path) -> None:
        path = study / name
        path.write_text("\n".join(function(path.read_text().splitlines())) + "\n")

    return change


def change_keypoints(
    function: Callable[[np.ndarray], np.ndarray], trials: tuple[str, ...] = ("T10",)
) -> Change:
    """Change x, y, likelihood (frames, parts, 3) of trials."""

    def change(study: Path) -> None:
        for trial in trials:
            path = study / f"keypoints/{trial}.csv"
            found = path.read_text().splitlines()
            table = np.array([[float(v or "nan") for v in row.split(",")[1:]] for row in found[3:]])
            new = function(table.reshape(len(table), -1, 3)).reshape(-1, table.shape[1])
            rows = [",".join([str(i), *(f"{v:.4f}" for v in row)]) for i, row in enumerate(new)]
            path.write_text("\n".join([*found[:3], *rows]) + "\n")

    return change


def shift_keypoints(dx: float, dy: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda p: p + np.array([dx, dy, 0.0])


def change_motor_log(
    function: Callable[[np.ndarray], np.ndarray], trials: tuple[str, ...] = TRIAL_IDS
) -> Change:
    """Change time_s, angle_deg (samples, 2) of motor logs."""

    def change(study: Path) -> None:
        for trial in trials:
            path = study / f"motor/{trial}.csv"
            rows = np.array([[float(v or "nan") for v in line.split(",")]
                             for line in path.read_text().splitlines()[1:]])  # fmt: skip
            out = [f"{t:.6g},{a:.6g}" for t, a in function(rows)]
            path.write_text("\n".join(["time_s,angle_deg", *out]) + "\n")

    return change


def swap_files(folder: str, a: str, b: str) -> Change:
    def change(study: Path) -> None:
        one, two = study / folder / f"{a}.csv", study / folder / f"{b}.csv"
        first, second = one.read_bytes(), two.read_bytes()
        one.write_bytes(second)
        two.write_bytes(first)

    return change


def combine_changes(*changes: Change) -> Change:
    return lambda s: [change(s) for change in changes]


K, M, T = "keypoints/T10.csv", "motor/T10.csv", "trials.csv"
CORNERS_KEY = "camera.pool_corners_px"
RIGHT_CORNERS_PX = [[255.3, 939.7], [1607.7, 946.4], [1623.7, 115.9], [256.2, 93.7]]

YAML_CASES: dict[str, Change] = {
    "empty": replace_file_text("study.yaml", ""),
    "comment only": replace_file_text("study.yaml", "# nothing\n"),
    "list at the top": replace_file_text("study.yaml", "- 1\n- 2\n"),
    "scalar at the top": replace_file_text("study.yaml", "7\n"),
    "tab as indent": replace_file_text("study.yaml", "pool:\n\tlength_m: 2\n"),
    "duplicate key": append_text("study.yaml", "pool: {length_m: 9, width_m: 9, depth_m: 9}\n"),
    "unknown section": append_text("study.yaml", "robots: {}\n"),
    "python object": append_text("study.yaml", "x: !!python/object/apply:os.system [id]\n"),
    "alias bomb": replace_file_text("study.yaml", "a: &a [1,1,1,1,1,1,1,1,1]\n" + "".join(
        f"{c}: &{c} [{','.join(9 * [f'*{p}'])}]\n"
        for p, c in zip("abcdefgh", "bcdefghi", strict=True))),
    "100,000 brackets": replace_file_text("study.yaml", "[" * 100_000),
    "UTF-16": replace_file_text("study.yaml", "pool: {}\n".encode("utf-16")),
    "binary": replace_file_text("study.yaml", bytes(range(256)) * 40),
    "mass nan": set_yaml_key("robot.mass_kg", float("nan")),
    "mass inf": set_yaml_key("robot.mass_kg", float("inf")),
    "mass negative": set_yaml_key("robot.mass_kg", -0.68),
    "mass with comma": set_yaml_key("robot.mass_kg", "0,68"),
    "mass true": set_yaml_key("robot.mass_kg", True),
    "mass a list": set_yaml_key("robot.mass_kg", [0.68]),
    "mass in g": set_yaml_key("robot.mass_kg", 680.0),
    "inertia in g cm2": set_yaml_key("robot.yaw_inertia_kg_m2", 95000.0),
    "lengths in mm": set_yaml_key("robot.body_length_m", 331.0),
    "pool in mm": set_yaml_key("pool.length_m", 2600.0),
    "head longer than body": set_yaml_key("robot.head_length_m", 0.4),
    "hinge behind the tail": set_yaml_key("robot.hinge_to_com_m", 0.5),
    "depth below the floor": set_yaml_key("robot.keypoint_depth_m", 0.5),
    "three corners": set_yaml_key(CORNERS_KEY, RIGHT_CORNERS_PX[:3]),
    "equal corners": set_yaml_key(CORNERS_KEY, [RIGHT_CORNERS_PX[0]] * 4),
    "corners on a line": set_yaml_key(CORNERS_KEY, [[100, 100], [200, 200], [300, 300], [400, 400]]),
    "corners crossed": set_yaml_key(CORNERS_KEY, [RIGHT_CORNERS_PX[0], RIGHT_CORNERS_PX[2], RIGHT_CORNERS_PX[1], RIGHT_CORNERS_PX[3]]),
    "corners mirrored": set_yaml_key(CORNERS_KEY, [RIGHT_CORNERS_PX[1], RIGHT_CORNERS_PX[0], RIGHT_CORNERS_PX[3], RIGHT_CORNERS_PX[2]]),
    "corners far outside": set_yaml_key(CORNERS_KEY, [[-9000, 9000], *RIGHT_CORNERS_PX[1:]]),
    "corners 1e300": set_yaml_key(CORNERS_KEY, [[1e300, 1e300], *RIGHT_CORNERS_PX[1:]]),
    "focal length 0": set_yaml_key("camera.matrix", [[0, 0, 958], [0, 0, 543], [0, 0, 1]]),
    "focal length negative": set_yaml_key("camera.matrix", [[-915, 0, 958], [0, 917, 543], [0, 0, 1]]),
    "matrix 2 x 2": set_yaml_key("camera.matrix", [[915, 0], [0, 917]]),
    "distortion of 10": set_yaml_key("camera.distortion", [10.0, 10.0, 0, 0, 0]),
    "distortion of 3 numbers": set_yaml_key("camera.distortion", [0.1, 0.1, 0.1]),
    "image size 0": set_yaml_key("camera.image_size_px", [0, 1080]),
    "image size swapped": set_yaml_key("camera.image_size_px", [1080, 1920]),
    "index of 3": set_yaml_key("water.refractive_index", 3.0),
    "density in g/cm3": set_yaml_key("water.density_kg_m3", 1.0),
    "unknown body part": set_yaml_key("bodyparts", {"nose": "head_tip"}),
    "a folder": lambda s: ((s / "study.yaml").unlink(), (s / "study.yaml").mkdir()),
    "a link to itself": lambda s: ((s / "study.yaml").unlink(),
                                   (s / "study.yaml").symlink_to("study.yaml")),
}  # fmt: skip

TRIALS_CSV_CASES: dict[str, Change] = {
    "empty": replace_file_text(T, ""),
    "header alone": replace_file_text(
        T, "trial_id,source,power_pct,head_angle_deg,head_length_m\n"
    ),
    "binary": replace_file_text(T, bytes(range(256)) * 20),
    "NUL bytes": append_text(T, "T\0X,keypoints/T09.csv,100,0,0.12,,30\n"),
    "unclosed quote": append_text(T, '"TX,keypoints/T09.csv,100,0,0.12,,30\n'),
    "missing column": change_lines(T, lambda r: [",".join(line.split(",")[:2]) for line in r]),
    "unknown column": change_lines(T, lambda r: [r[0] + ",pwr", *(line + ",1" for line in r[1:])]),
    "column twice": change_lines(T, lambda r: [r[0] + ",fps", *(line + ",30" for line in r[1:])]),
    "short row": append_text(T, "TX,keypoints/T09.csv\n"),
    "long row": append_text(T, "TX,keypoints/T09.csv,100,0,0.12,,30,1,2,3,4\n"),
    "id twice": append_text(T, "T09,keypoints/T09.csv,100,0,0.12,,30\n"),
    "id with other case": append_text(T, "t09,keypoints/T09.csv,100,0,0.12,motor/T09.csv,30\n"),
    "id ../x": append_text(T, "../x,keypoints/T09.csv,100,0,0.12,motor/T09.csv,30\n"),
    "id of 300 letters": append_text(T, "x" * 300 + ",keypoints/T09.csv,100,0,0.12,,30\n"),
    "id empty": append_text(T, ",keypoints/T09.csv,100,0,0.12,motor/T09.csv,30\n"),
    "id a formula": append_text(T, "=1+1,keypoints/T09.csv,100,0,0.12,motor/T09.csv,30\n"),
    "source missing": set_cell("source", "keypoints/T99.csv"),
    "source outside": set_cell("source", "../../../../etc/passwd"),
    "source a folder": set_cell("source", "keypoints"),
    "source study.yaml": set_cell("source", "study.yaml"),
    "source /dev/zero": set_cell("source", "/dev/zero"),
    "source twice": set_cell("source", "keypoints/T09.csv"),
    "power text": set_cell("power_pct", "full"),
    "power 1e9": set_cell("power_pct", "1e9"),
    "power nan": set_cell("power_pct", "nan"),
    "angle 300": set_cell("head_angle_deg", "300"),
    "angle of another trial": set_cell("head_angle_deg", "75"),
    "head in mm": set_cell("head_length_m", "120"),
    "fps 0": set_cell("fps", "0"),
    "fps negative": set_cell("fps", "-30"),
    "fps 1e-3": set_cell("fps", "0.001"),
    "fps 9999": set_cell("fps", "9999"),
    "fps with comma": set_cell("fps", "29,97"),
    "fps empty": set_cell("fps", ""),
    "start after end": combine_changes(set_cell("start_s", "3"), set_cell("end_s", "1")),
    "start after the end": set_cell("start_s", "1000"),
    "role typed wrong": set_cell("role", "heldout"),
    "flap_hz 1e6": set_cell("flap_hz", "1e6"),
}

KEYPOINT_CASES: dict[str, Change] = {
    "empty": replace_file_text(K, ""),
    "header alone": change_lines(K, lambda r: r[:3]),
    "one frame": change_lines(K, lambda r: r[:4]),
    "three frames": change_lines(K, lambda r: r[:6]),
    "text in a cell": change_lines(K, lambda r: [*r[:9], r[9].replace(",", ",x", 1), *r[10:]]),
    "inf": change_keypoints(lambda p: np.where(np.arange(len(p))[:, None, None] == 20, np.inf, p)),
    "1e300": change_lines(K, lambda r: [*r[:9], "6" + 15 * ",1e300", *r[10:]]),
    "all not seen": change_keypoints(lambda p: p * np.nan),
    "likelihood 0": change_keypoints(lambda p: p * [1, 1, 0]),
    "likelihood percent": change_keypoints(lambda p: p * [1, 1, 100]),
    "likelihood negative": change_keypoints(lambda p: p * [1, 1, -1]),
    "standing still": change_keypoints(lambda p: np.repeat(p[:1], len(p), axis=0)),
    "all parts in one place": change_keypoints(lambda p: np.repeat(p[:, :1], p.shape[1], axis=1)),
    "frames reversed": change_keypoints(lambda p: p[::-1]),
    "frames shuffled": change_keypoints(lambda p: np.random.default_rng(0).permutation(p)),
    "every second frame": change_keypoints(lambda p: p[::2]),
    "every frame twice": change_keypoints(lambda p: np.repeat(p, 2, axis=0)),
    "head and tail exchanged": change_keypoints(lambda p: p[:, ::-1]),
    "x and y exchanged": change_keypoints(lambda p: p[:, :, [1, 0, 2]]),
    "1000 px off": change_keypoints(shift_keypoints(1000, 0)),
    "noise of 300 px": change_keypoints(lambda p: p + np.random.default_rng(0).normal(0, 300, p.shape) * [1, 1, 0]),
    "a cut": change_keypoints(lambda p: np.concatenate([p[:40], shift_keypoints(250, 90)(p[40:])])),
    "binary": replace_file_text(K, bytes(range(256)) * 99),
    "cut within a line": lambda s: (s / K).write_bytes((s / K).read_bytes()[:2000]),
    "body parts missing": change_lines(K, lambda r: [",".join(line.split(",")[:7]) for line in r]),
    "parts renamed": change_lines(K, lambda r: [r[0], r[1].replace("hinge", "neck"), *r[2:]]),
}  # fmt: skip

MOTOR_LOG_CASES: dict[str, Change] = {
    "empty": replace_file_text(M, ""),
    "header alone": replace_file_text(M, "time_s,angle_deg\n"),
    "one sample": replace_file_text(M, "time_s,angle_deg\n0,0\n"),
    "text": replace_file_text(M, "hello\n"),
    "time backwards": change_motor_log(lambda r: np.column_stack([r[::-1, 0], r[:, 1]]), ("T10",)),
    "time constant": change_motor_log(lambda r: r * [0, 1], ("T10",)),
    "angle constant": change_motor_log(lambda r: r * [1, 0], ("T10",)),
    "nan": change_motor_log(lambda r: r * np.nan, ("T10",)),
    "time in ms": change_motor_log(lambda r: r * [1000, 1], ("T10",)),
    "angle in radians": change_motor_log(lambda r: r * [1, np.pi / 180], ("T10",)),
    "noise": change_motor_log(lambda r: np.column_stack([r[:, 0], np.random.default_rng(0).uniform(0, 360, len(r))]), ("T10",)),
    "missing": lambda s: (s / M).unlink(),
    "columns exchanged": change_motor_log(lambda r: r[:, ::-1], ("T10",)),
    "of another trial's length": change_motor_log(lambda r: r[: len(r) // 8], ("T10",)),
    "binary": replace_file_text(M, bytes(range(256)) * 9),
}  # fmt: skip

PLAUSIBLE_MISTAKES: dict[str, Change] = {
    "fps 119.88 for 29.97": set_column("fps", lambda _: "119.88"),
    "fps 60 for 29.97": set_column("fps", lambda _: "59.94"),
    "fps 30 for 29.97": set_column("fps", lambda _: "30"),
    "fps 25 for 29.97": set_column("fps", lambda _: "25"),
    "fps 240 without a log": combine_changes(set_column("fps", lambda _: "240"), set_column("motor_log", lambda _: "")),
    "fps 240, flap_hz stated": combine_changes(set_column("fps", lambda _: "240"), set_column("motor_log", lambda _: ""),
                                      set_column("flap_hz", lambda _: "5.82")),
    "one fps of three doubled": set_cell("fps", "59.94"),
    "motor log of 75 % power": change_motor_log(lambda r: r / [1.0, 1.0] * [1.45, 1.0], ("T10",)),
    "motor logs 1 s late": change_motor_log(lambda r: r[200:] - [r[200, 0], 0]),
    "motor logs in ms": change_motor_log(lambda r: r * [1000, 1]),
    "keypoint files exchanged": swap_files("keypoints", "T10", "T11"),
    "all head angles negated": set_column("head_angle_deg", lambda r: str(-float(r["head_angle_deg"]))),
    "one head angle negated": set_cell("head_angle_deg", "-30"),
    "head angles in radians": set_column("head_angle_deg", lambda r: f"{np.radians(float(r['head_angle_deg'])):.3f}"),
    "head of the 1.5x robot": set_column("head_length_m", lambda _: "0.18"),
    "pool in feet": combine_changes(set_yaml_key("pool.length_m", 8.53), set_yaml_key("pool.width_m", 5.25)),
    "pool length and width exchanged": combine_changes(set_yaml_key("pool.length_m", 1.6), set_yaml_key("pool.width_m", 2.6)),
    "pool 5 % too long": combine_changes(set_yaml_key("pool.length_m", 2.73), set_yaml_key("pool.width_m", 1.68)),
    "corners from another one on": set_yaml_key(CORNERS_KEY, RIGHT_CORNERS_PX[2:] + RIGHT_CORNERS_PX[:2]),
    "corners mirrored": set_yaml_key(CORNERS_KEY, [RIGHT_CORNERS_PX[3], RIGHT_CORNERS_PX[2], RIGHT_CORNERS_PX[1], RIGHT_CORNERS_PX[0]]),
    "x and y of keypoints exchanged": change_keypoints(lambda p: p[:, :, [1, 0, 2]], TRIAL_IDS),
    "keypoints of half-size pictures": change_keypoints(lambda p: p * [0.5, 0.5, 1], TRIAL_IDS),
    "camera 7 cm further from a trial on": change_keypoints(shift_keypoints(36, 0)),
    "one picture turned by 180 degrees": change_keypoints(lambda p: np.array([1920, 1080, 0]) - p * [1, 1, -1]),
    "mass in pounds": set_yaml_key("robot.mass_kg", 1.5),
    "inertia ten times too large": set_yaml_key("robot.yaw_inertia_kg_m2", 0.07),
    "no refraction": set_yaml_key("water.refractive_index", 1.0),
}  # fmt: skip


# --- what is said of a study ---


def check_outcome(study: Path) -> tuple[str, str]:
    """Outcome of `bluekoi check`, and its first line."""
    done = CliRunner().invoke(bluekoi, ["check", str(study)])
    said = (done.output.strip().splitlines() or [""])[0]
    said = re.sub(re.escape(str(study)) + "/?", "", said)
    if done.exception and not isinstance(done.exception, SystemExit):
        return "CRASH", repr(done.exception)
    return ("" if done.exit_code == 0 else "refused"), said


def measure_outcome(study: Path, results: Path) -> tuple[str, str, dict[str, dict[str, object]]]:
    """Outcome of detection and tracks: a lost trial, a warning, or nothing; with all statuses."""
    loaded = load_study(study)
    for trial in loaded.trials:
        keypoints(study, results, trial.trial_id)
        tracks(study, results, trial.trial_id)
    found = {t.trial_id: json.loads((results / f"status/{t.trial_id}.json").read_text())
             for t in loaded.trials}  # fmt: skip
    lost = [f"{name}: {s['message']}" for name, s in found.items() if not s["ok"]]
    lost += [f"{name}: {s['cut_short']}" for name, s in found.items() if s.get("cut_short")]
    if any("a defect of this program" in text for text in lost):
        return "CRASH", lost[0], found
    warned = clock_and_length_warnings(found)
    warned += [r for s in found.values() for r in s.get("remarks", []) if "clocks disagree" in r]
    said = (lost or warned or [""])[0]
    return (
        ("trial lost" if lost else "warned" if warned else ""),
        said.replace(str(study), ""),
        found,
    )


def steady_speeds(results: Path) -> dict[str, tuple[float, float, str]]:
    out = {}
    for path in sorted((results / "steady").glob("*.csv")):
        (row,) = csv.DictReader(path.open())
        numbers = (float(row[name] or "nan") for name in ("speed_m_s", "speed_std_m_s"))
        out[path.stem] = (*numbers, row["quality"])
    return out


def speeds_agree(results: Path, right: Path) -> bool:
    """Whether speeds agree with the right study's within three of their deviations."""
    a, b = steady_speeds(results), steady_speeds(right)
    near = [not np.isfinite(v) or abs(a[name][0] - v) < 3 * np.hypot(std, a[name][1])
            for name, (v, std, _) in b.items() if name in a]  # fmt: skip
    return len(near) == len(b) and all(near)


def search_outcome(study: Path, results: Path, right: Path) -> tuple[str, str]:
    """Outcome of fits and search."""
    try:
        geometry(study, results)
        steady(study, results)
        tuning(study, results)
        mismatch(study, results)
    except InputError as error:
        return "refused", str(error).replace(str(study), "")
    found = json.loads((results / "mismatch.json").read_text())
    if found["verdict"] in ("measurement", "unexplained"):
        return "named", found["sentence"]
    cells = [json.loads((r / "coefficients.json").read_text())["joint"]["coefficients"]
             for r in (results, right)]  # fmt: skip
    off = [name for name, c in cells[0].items()
           if c["std"] is not None and abs(c["value"] - cells[1][name]["value"])
           > 3 * np.hypot(c["std"], cells[1][name]["std"] or 0.0)]  # fmt: skip
    content = json.loads((results / "geometry.json").read_text())
    if warned := rigid_length_warnings(content, found):
        return "warned", warned[0]
    if found["verdict"] == "none" and not off and speeds_agree(results, right):
        return "harmless", found["sentence"]
    return "SILENT", f"{found['verdict']}; off: {', '.join(off) or 'speeds'}; {found['sentence']}"


def case_outcome(change: Change, base: Path, right: Path, *, search: bool) -> tuple[str, str]:
    with tempfile.TemporaryDirectory() as folder:
        study, results = Path(folder) / "study", Path(folder) / "results"
        shutil.copytree(base, study)
        change(study)
        try:
            with time_limit(MAX_SECONDS * (10 if search else 1)):
                found, said = check_outcome(study)
                if found:
                    return found, said
                found, said, _ = measure_outcome(study, results)
                if not search:
                    same = "harmless" if speeds_agree(results, right) else "SILENT"
                    return found or same, said
                if found in {"trial lost", "CRASH"}:
                    return found, said
                last, reported = search_outcome(study, results, right)
                return (
                    (last, reported) if last in ("named", "refused") or not found else (found, said)
                )
        except HangError:
            return "HANG", ""
        except Exception as error:
            traceback.print_exc()
            return "CRASH", repr(error)


def run_cases(
    cases: dict[str, Change], base: Path, right: Path, *, search: bool
) -> list[tuple[str, str, str]]:
    rows = []
    for name, change in cases.items():
        rows.append((name, *case_outcome(change, base, right, search=search)))
        print(
            "| " + " | ".join(" ".join(w.replace("|", "/").split())[:230] for w in rows[-1]) + " |",
            flush=True,
        )
    return rows


def main() -> None:
    what, *names = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        base, right = small_study(Path(folder) / "base"), Path(folder) / "right"
        measure_outcome(base, right)
        rows = []
        print("| case | outcome | message |\n|---|---|---|")
        if what == "inputs":
            for kind, cases in (("study.yaml", YAML_CASES), ("trials.csv", TRIALS_CSV_CASES), ("keypoints", KEYPOINT_CASES),
                                ("motor log", MOTOR_LOG_CASES)):  # fmt: skip
                named = {f"{kind}: {name}": change for name, change in cases.items()
                         if not names or f"{kind}: {name}" in names}  # fmt: skip
                rows += run_cases(named, base, right, search=False)
        else:
            geometry(base, right)
            steady(base, right)
            tuning(base, right)
            rows = run_cases({n: c for n, c in PLAUSIBLE_MISTAKES.items() if not names or n in names}, base, right,
                       search=True)  # fmt: skip
        count: dict[str, int] = {}
        for _, found, _ in rows:
            count[found] = count.get(found, 0) + 1
        print(f"\n{len(rows)} cases: " + ", ".join(f"{n} {k}" for k, n in sorted(count.items())))


if __name__ == "__main__":
    main()
