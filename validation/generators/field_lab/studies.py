"""Writing a study: keypoints, motor logs, tables and the truth."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from . import effects as eff
from . import noise as ns
from . import plan, solve
from . import world as wd

GENERATOR_NAME = "field_lab"
ALTERNATIVE_PART_NAMES = dict(
    zip(wd.KEYPOINT_NAMES, ("snout", "neck", "com", "peduncle", "fin_tip"), strict=True)
)


def frame_times(world: wd.StudyWorld, n_trial: int, until: float) -> np.ndarray:
    """True times (s) of the recorded frames, evenly spaced or with frames lost without a trace."""
    rate, fps = wd.stated_clock_rate(world, n_trial), world.noise["fps"]
    e = world.by_name().get("clock_error")
    k = np.arange(int(until * fps) + 2)
    t = np.round(k * rate) / fps if e is not None and e.form.code == 3 else k * rate / fps
    return t[t <= until + 1e-9]


def with_recoil(
    world: wd.StudyWorld, states: np.ndarray, phase: np.ndarray, on: np.ndarray, phi: np.ndarray
) -> np.ndarray:
    """``states`` (n, 8) with tail-beat recoil of heading and sideways position."""
    out, n = states.copy(), world.noise
    psi = states[:, 2] + phi
    sway = n["recoil_m"] * np.sin(phase + 0.7) * on
    out[:, 2] += n["recoil_rad"] * np.sin(phase) * on
    out[:, 0] -= sway * np.sin(psi)
    out[:, 1] += sway * np.cos(psi)
    return out


def keypoint_images(
    world: wd.StudyWorld, n_trial: int, t: np.ndarray, states: np.ndarray
) -> np.ndarray:
    """Exact pixels (n, 5, 2) at ``t`` (s): rest before 0, drift after the end."""
    trial = world.trials[n_trial]
    f, phi = wd.trial_inputs(world, trial)
    grid, end = eff.step_times(len(states) - 1), 1e-3 * (len(states) - 1)
    s = np.stack([np.interp(t, grid, states[:, i]) for i in range(8)], 1)
    s[:, :3] += s[:, 3:6] * np.clip(t - end, 0, None)[:, None]
    steps = np.clip(np.round(1000 * t).astype(int), 0, len(phi) - 1)
    beat = 2 * math.pi * np.cumsum(f) * 1e-3
    on = np.minimum(f[steps] / 1.0, 1.0) * np.clip(t / 0.3, 0, 1)
    moved = with_recoil(world, s, beat[steps], on, phi[steps])
    xy = wd.keypoint_positions(world, trial, moved, phi[steps])
    swing = world.noise["tail_flap_rad"] * np.sin(beat[steps] - 1.2) * on
    z = (xy[:, 4] - xy[:, 3]) @ np.array([1, 1j]) * np.exp(1j * swing)
    xy[:, 4] = xy[:, 3] + np.stack([z.real, z.imag], 1)
    return wd.keypoint_pixels(world, n_trial, xy, t)


def write_keypoint_file(px: np.ndarray, lk: np.ndarray, layout: dict, path: Path) -> None:
    """Write DeepLabCut's csv layout, single or multi-animal."""
    names = [ALTERNATIVE_PART_NAMES[p] if layout["renamed"] else p for p in wd.KEYPOINT_NAMES]
    head = [[part, c] for part in names for c in ("x", "y", "likelihood")]
    one = ["fish"] if layout["individuals"] else []
    levels = ["scorer", *(["individuals"] if one else []), "bodyparts", "coords"]
    cols = pd.MultiIndex.from_tuples([("DLC_field", *one, *h) for h in head], names=levels)
    data = np.concatenate([px, lk[..., None]], 2).reshape(len(px), -1)
    pd.DataFrame(data, columns=cols).round(4).to_csv(path)


def write_motor_log(  # noqa: PLR0917
    rng: np.random.Generator, world: wd.StudyWorld, trial: wd.Trial, layout: dict, ahead: float,
    until: float, path: Path,
) -> None:  # fmt: skip
    """Write the shaft angle every 5 ms; the motor starts ``ahead`` (s) after the log."""
    e = world.by_name().get("time_offset")
    shift = -ahead
    if e is not None:
        shift = e.strength if e.form.code == 1 else -e.strength
    f = wd.trial_inputs(world, trial)[0] / (1 + trial.flap_error)
    t = 0.005 * np.arange(int(until / 0.005) + 1)
    turned = np.concatenate([[0.0], np.cumsum(f)]) * 1e-3
    at = t + shift
    turns = np.interp(at, 1e-3 * np.arange(len(turned)), turned)
    turns += f[-1] * np.maximum(at - 1e-3 * (len(turned) - 1), 0)
    angle = ns.logged_shaft_angle(rng, 360 * turns + rng.uniform(0, 360), layout["dead_zone"])
    pd.DataFrame({"time_s": t.round(4), "angle_deg": angle}).to_csv(path, index=False)


def trial_row(
    rng: np.random.Generator, world: wd.StudyWorld, n_trial: int, layout: dict, folder: Path
) -> dict:
    """Write one trial's files; its row of trials.csv."""
    trial = world.trials[n_trial]
    states = wd.trial_path(world, trial)
    end = 1e-3 * (len(states) - 1)
    rolled = layout["pre_roll"] and rng.random() < 0.7
    ahead, after = (rng.uniform(0.3, 1.2), rng.uniform(0.3, 0.8)) if rolled else (0.0, 0.0)
    t = frame_times(world, n_trial, end + ahead + after) - ahead
    px, lk = ns.tracked_keypoints(
        rng, keypoint_images(world, n_trial, t, states), world.noise, trial.light
    )
    px[t > end + 0.05] += rng.normal(0, 15, px[t > end + 0.05].shape)
    write_keypoint_file(px, lk, layout, folder / "keypoints" / f"{trial.name}.csv")
    row = {
        "trial_id": trial.name,
        "source": f"keypoints/{trial.name}.csv",
        "power_pct": trial.power_pct,
        "head_angle_deg": round(math.degrees(trial.head_angle), 4),
        "head_length_m": trial.head_length,
        "fps": round(world.noise["fps"], 5),
    }
    if layout["motor_log"]:
        row["motor_log"] = f"motor/{trial.name}.csv"
        write_motor_log(
            rng, world, trial, layout, ahead, end + ahead + after, folder / row["motor_log"]
        )
    else:
        f = wd.trial_inputs(world, trial)[0][: len(states)] / (1 + trial.flap_error)
        row["flap_hz"] = round(float(f[len(f) // 2 :].mean()), 4)
    if layout["pre_roll"]:
        row |= {"start_s": round(ahead, 3) if rolled else 0.0, "end_s": round(end + ahead, 3)}
    return row


def study_yaml(rng: np.random.Generator, world: wd.StudyWorld, layout: dict) -> dict:
    """The content of study.yaml as the laboratory states it."""
    c, depth, index, (length, width, px) = wd.stated_optics(world, wd.corner_pixels(world))
    measured = (px + rng.normal(0, 0.2, (4, 2))).round(2).tolist()
    lens = {
        "model": c.model,
        "matrix": [[c.fx, 0.0, c.cx], [0.0, c.fy, c.cy], [0.0, 0.0, 1.0]],
        "distortion": list(c.dist),
    }
    out = {
        "pool": {"length_m": float(length), "width_m": float(width), "depth_m": 0.3},
        "water": {"density_kg_m3": 1000.0, "refractive_index": float(index)},
        "robot": world.robot | {"keypoint_depth_m": float(depth)},
        "camera": ({} if layout["homography"] else lens)
        | {"image_size_px": [1920, 1080], "pool_corners_px": measured,
           "pool_corners_height_m": world.corner_height},
    }  # fmt: skip
    if layout["renamed"]:
        out["bodyparts"] = ALTERNATIVE_PART_NAMES
    return json.loads(json.dumps(out, default=float))


def truth_json(
    world: wd.StudyWorld, s: plan.StudySlot, sigma: dict[str, float], layout: dict, identity: dict
) -> dict:
    """The truth file: causes ordered by sigma, unlisted load, noise, robot and conditions."""
    causes, unlisted = [], None
    for e in sorted(world.effects, key=lambda e: -sigma[e.name]):
        row = {"form": e.form.name, "sigma": round(sigma[e.name], 2), "parameters": e.parameters()}
        if e.name == "unlisted":
            _, channels, variable = next(u for u in eff.UNLISTED if u[0] == e.form)
            unlisted = {"channels": list(channels), "variable": variable} | row
        else:
            kind = "measurement" if e.name in eff.MEASUREMENT else "physics"
            causes.append({"name": e.name, "kind": kind} | row)
    kinds = {c["kind"] for c in causes}
    verdict = "physics" if kinds else "none"
    verdict = "measurement" if "measurement" in kinds else verdict
    last = [len(wd.trial_path(world, t)) / 1000 for t in world.trials]
    return identity | {
        "group": s.group, "fin": s.fin, "trials": len(world.trials),
        "verdict": "unexplained" if unlisted else verdict,
        "causes": causes, "unlisted": unlisted, "noise": world.noise,
        "robot": world.robot | world.coefficients._asdict(),
        "conditions": {
            "count": len({(t.power_pct, t.head_angle, t.head_length) for t in world.trials}),
            "powers_pct": sorted({int(t.power_pct) for t in world.trials}),
            "head_angles_deg": sorted({round(math.degrees(t.head_angle)) for t in world.trials}),
            "head_lengths_m": sorted({t.head_length for t in world.trials}),
            "durations_s": last, "camera": world.camera.model, **layout,
        },
    }  # fmt: skip


def generate(seed: int, index: int, directory: Path) -> dict:
    """Write study ``index`` of ``seed`` under ``directory``; its truth.

    The study is written whole: under a temporary name first, the truth file last.
    """
    name = f"{GENERATOR_NAME}-{seed}-{index:03d}"
    path = Path(directory) / "truth" / f"{name}.json"
    if path.exists():
        return json.loads(path.read_text())
    rng = np.random.default_rng([seed, index, 4711])
    s = plan.study_slot(index)
    world, layout, sigma = solve.concealed_study(rng, s, plan.causes_from_deck(seed, index))
    final = Path(directory) / "studies" / name
    folder = final.with_name(f".{name}.part")
    for old in (folder, final):
        shutil.rmtree(old, ignore_errors=True)
    for sub in ("keypoints", *(["motor"] if layout["motor_log"] else [])):
        (folder / sub).mkdir(parents=True)
    rows = [trial_row(rng, world, i, layout, folder) for i in range(len(world.trials))]
    pd.DataFrame(rows).to_csv(folder / "trials.csv", index=False)
    stated = study_yaml(rng, world, layout)
    (folder / "study.yaml").write_text(yaml.safe_dump(stated, sort_keys=False))
    identity = {"study": name, "generator": GENERATOR_NAME, "seed": seed, "index": index}
    reported = json.loads(json.dumps(truth_json(world, s, sigma, layout, identity), default=float))
    folder.rename(final)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps(reported, indent=1))
    part.rename(path)
    return reported
