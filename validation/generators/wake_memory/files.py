"""Files of a study: study.yaml, trials.csv, DeepLabCut keypoints (csv, h5) and motor logs."""

import pickle
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray

from . import dynamics as dy
from .noise import shaft_log, tracked_keypoints
from .observation import keypoint_pixels, stated_setup

Array = NDArray[np.float64]
KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
ALTERNATIVE_PART_NAMES = (
    {"head_tip": "snout", "core_center": "body"},
    {"head_tip": "nose", "hinge": "neck", "core_center": "com", "tail_base": "peduncle",
     "tail_tip": "fluke"},
)  # fmt: skip
LAYOUTS = ("csv", "csv", "multi_csv", "csv", "h5", "csv", "csv", "multi_h5", "csv")


def keypoint_table(
    seen: Array, likelihood: Array, names: list[str], *, multi: bool
) -> pd.DataFrame:
    """DeepLabCut's table: columns scorer, (individuals,) bodyparts, coords."""
    scorer = "DLC_resnet50_tankJun8shuffle1_200000"
    values = np.concatenate([seen, likelihood[..., None]], axis=-1).reshape(len(seen), -1)
    heads = [(scorer, *(("robot",) if multi else ()), n, c) for n in names
             for c in ("x", "y", "likelihood")]  # fmt: skip
    levels = ["scorer", *(["individuals"] if multi else []), "bodyparts", "coords"]
    return pd.DataFrame(values, columns=pd.MultiIndex.from_tuples(heads, names=levels))


def write_h5(path: Path, data: pd.DataFrame) -> None:
    """DeepLabCut's h5: the pandas table `df_with_missing` in the layout of PyTables."""
    kind = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (data.shape[1],))])
    rows = np.zeros(len(data), dtype=kind)
    rows["index"], rows["values_block_0"] = np.arange(len(data)), data.to_numpy()
    columns = [tuple(c) for c in data.columns]

    def packed(value: object) -> np.bytes_:
        return np.bytes_(pickle.dumps(value, protocol=0))

    with h5py.File(path, "w") as file:
        file.attrs.update({"CLASS": np.bytes_("GROUP"), "PYTABLES_FORMAT_VERSION": np.bytes_("2.1"),
                           "TITLE": np.bytes_(""), "VERSION": np.bytes_("1.0")})  # fmt: skip
        group = file.create_group("df_with_missing")
        names = {"names": list(data.columns.names), "type": "MultiIndex"}
        group.attrs.update({
            "CLASS": np.bytes_("GROUP"), "TITLE": np.bytes_(""), "VERSION": np.bytes_("1.0"),
            "pandas_type": np.bytes_("frame_table"), "pandas_version": np.bytes_("0.15.2"),
            "table_type": np.bytes_("appendable_frame"), "encoding": np.bytes_("UTF-8"),
            "errors": np.bytes_("strict"), "nan_rep": np.bytes_("nan"), "levels": 1,
            "index_cols": packed([(0, "index")]), "data_columns": packed([]),
            "values_cols": packed(["values_block_0"]), "metadata": packed([]),
            "non_index_axes": packed([(1, columns)]), "info": packed({1: names, "index": {}}),
        })  # fmt: skip
        stored = group.create_dataset("table", data=rows, chunks=True, maxshape=(None,))
        stored.attrs.update({
            "CLASS": np.bytes_("TABLE"), "VERSION": np.bytes_("2.7"), "TITLE": np.bytes_(""),
            "FIELD_0_NAME": np.bytes_("index"), "FIELD_1_NAME": np.bytes_("values_block_0"),
            "FIELD_0_FILL": 0, "FIELD_1_FILL": 0.0, "NROWS": len(rows),
            "index_kind": np.bytes_("integer"), "values_block_0_dtype": np.bytes_("float64"),
            "values_block_0_kind": packed(columns),
        })  # fmt: skip


def study_yaml(plan: object, errors: dict, names: dict[str, str]) -> dict:
    """What the lab states about pool, water, robot and camera."""
    R, view = plan.R, stated_setup(plan.optics, errors)
    camera, (u, v) = view.camera, view.camera.centre
    keys = ("mass_kg", "yaw_inertia_kg_m2", "body_length_m", "head_length_m", "head_span_m",
            "hinge_to_com_m", "tail_length_m")  # fmt: skip
    content = {
        "pool": {"length_m": view.pool[0], "width_m": view.pool[1], "depth_m": 0.3},
        "water": {"density_kg_m3": 1000.0, "refractive_index": camera.index},
        "robot": {**{k: float(x) for k, x in zip(keys, R[:7], strict=True)},
                  "keypoint_depth_m": float(view.depth)},
        "camera": {
            "model": camera.model, "image_size_px": list(camera.size),
            "matrix": [[camera.focal[0], 0.0, u], [0.0, camera.focal[1], v], [0.0, 0.0, 1.0]],
            "distortion": [float(k) for k in camera.distortion],
            "pool_corners_px": np.round(view.corners_px, 3).tolist(),
            "pool_corners_height_m": float(plan.optics.corner_height),
        },
    }  # fmt: skip
    return {**content, "bodyparts": names} if names else content


def write_keypoints(folder: Path, trial_id: str, layout: str, data: pd.DataFrame) -> str:
    """Write one keypoint file; returns its path relative to the study folder."""
    name = f"keypoints/{trial_id}.{'h5' if layout.endswith('h5') else 'csv'}"
    if layout.endswith("h5"):
        write_h5(folder / name, data)
    else:
        data.to_csv(folder / name, float_format="%.3f")
    return name


def shaft_cycles(trial: Array, path: Array, fps: float, ratio: float) -> tuple:
    """Times (s) and cycles of the logger, whose frequency is the true one over `ratio`."""
    times, cycles = np.arange(len(path)) / fps, path[:, 6] / ratio
    delay = trial[dy.START]
    if delay > 0:
        tail = times[-1] + np.arange(1, int(delay * fps) + 2) / fps
        grown = cycles[-1] + trial[dy.F] / ratio * (tail - times[-1])
        times, cycles = np.append(times, tail) - delay, np.append(cycles, grown)
        return times[times >= 0], cycles[times >= 0]
    return times, cycles


def write_study(
    folder: Path, plan: object, E: Array, errors: dict, runs: list, *, rng: np.random.Generator
) -> None:
    """Write a whole study folder."""
    from .studies import clock_factors, steady_frequency  # noqa: PLC0415

    for part in ("keypoints", "motor"):
        (folder / part).mkdir(parents=True)
    layout, rows = LAYOUTS[rng.integers(len(LAYOUTS))], []
    names = ALTERNATIVE_PART_NAMES[rng.integers(2)] if rng.random() < 0.3 else {}
    with_log = rng.random() < 0.8 or bool({"time_offset", "clock_error"} & set(errors))
    fill, dead = str(rng.choice(["hold", "zero", "empty"])), float(rng.uniform(4, 20))
    form, size = errors.get("clock_error", (1, 0.0))
    wrong = clock_factors(form, size, len(runs))
    for i, (path, _) in enumerate(runs):
        trial, trial_id = plan.trials[i], f"T{i + 1:02d}"
        times = np.arange(len(path)) / plan.fps
        pixels = keypoint_pixels(path, times, trial, plan.R, E, optics=plan.optics, errors=errors)
        seen, sure = tracked_keypoints(rng, plan.noise, pixels, path[:, 2], plan.fps)
        data = keypoint_table(
            seen, sure, [names.get(p, p) for p in KEYPOINT_NAMES], multi=layout.startswith("multi")
        )
        ratio = 1 + rng.normal(0, plan.noise.flap_ratio)
        row = {"trial_id": trial_id, "source": write_keypoints(folder, trial_id, layout, data),
               "power_pct": int(plan.power[i]),
               "head_angle_deg": round(float(np.degrees(plan.commanded[i])), 3),
               "head_length_m": trial[dy.HEAD],
               "fps": round(plan.fps * (1 + wrong[i]), 5)}  # fmt: skip
        if with_log:
            row["motor_log"] = f"motor/{trial_id}.csv"
            log = shaft_log(rng, *shaft_cycles(trial, path, plan.fps, ratio), fill, dead)
            frame = pd.DataFrame(log, columns=["time_s", "angle_deg"])
            frame.to_csv(folder / row["motor_log"], index=False, float_format="%.3f")
        else:
            row["flap_hz"] = round(steady_frequency(trial, E, times) / ratio, 4)
        rows.append(row)
    pd.DataFrame(rows).to_csv(folder / "trials.csv", index=False)
    content = study_yaml(plan, errors, names)
    (folder / "study.yaml").write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
