"""Write a study folder: study.yaml, trials.csv, keypoint files, motor logs."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any

import numpy as np
import yaml

from .choose import Found
from .observe import NAMES, delays, keypoints, project
from .optics import Stated
from .simulate import Path
from .world import World


def frame_times(world: World, found: Found) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Believed and true times of the frames (K, N), and the count of frames of each trial."""
    longest = int(np.ceil(world.duration * 1.3 * world.fps))
    believed = np.broadcast_to(np.arange(longest) / world.fps, (world.trials.count, longest))
    blank = np.zeros(believed.shape)
    dummy = Path(believed[0], np.zeros((8, *believed.shape)), blank, blank, found.path.end)
    true = believed + delays(world, dummy, found.laws)
    counts = np.sum(true < found.path.end[:, None], axis=1)
    return believed, np.clip(true, 0, world.duration), counts


def phases(world: World, path: Path, times: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Flapping phase at the frames, with a random start for each trial."""
    step = path.t[1] - path.t[0]
    turns = np.cumsum(0.5 * (path.f + np.roll(path.f, 1, axis=1)), axis=1) * step
    turns -= turns[:, :1]
    start = rng.uniform(0, 1, world.trials.count)
    world.extra["shaft_start"] = start
    return np.stack(
        [
            2 * np.pi * (np.interp(times[i], path.t, turns[i]) + start[i])
            for i in range(world.trials.count)
        ]
    )


def noisy(
    rng: np.random.Generator, world: World, pixels: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Tracking errors on pixels (5, N, 2): labels and likelihoods of one trial."""
    nz = world.noise
    points, n = pixels.shape[0], pixels.shape[1]
    rho = np.exp(-1 / (world.fps * nz["correlation_s"]))
    drive = rng.normal(0, nz["correlated_px"] * np.sqrt(1 - rho**2), (points, n, 2))
    slow = np.empty_like(drive)
    slow[:, 0] = rng.normal(0, nz["correlated_px"], (points, 2))
    for i in range(1, n):
        slow[:, i] = rho * slow[:, i - 1] + drive[:, i]
    out = pixels + slow + rng.normal(0, nz["white_px"], (points, n, 2))
    like = np.clip(1 - rng.gamma(1.2, 0.012, (points, n)), 0.6, 1.0)
    wild = rng.uniform(size=(points, n)) < nz["outlier_share"]
    far = rng.uniform(15, 90, (points, n, 1)) * world.camera.size[0] / 1920
    way = rng.uniform(0, 2 * np.pi, (points, n))
    out = np.where(wild[..., None], out + far * np.stack([np.cos(way), np.sin(way)], -1), out)
    like = np.where(wild, rng.uniform(0.15, 0.99, (points, n)), like)
    for j in range(points):
        for _ in range(rng.poisson(nz["gap_rate_hz"] * n / world.fps)):
            begin, size = int(rng.integers(n)), int(1 + rng.geometric(min(0.9, 4 / world.fps)))
            stop = min(begin + size, n)
            like[j, begin:stop] = rng.uniform(0.001, 0.09, stop - begin)
            out[j, begin:stop] += rng.normal(0, 25, (stop - begin, 2))
            if rng.uniform() < 0.3:
                out[j, begin:stop] = np.nan
    return out, like


def write_keypoints(file: FilePath, xy: np.ndarray, like: np.ndarray) -> None:
    """One DeepLabCut table: three header rows, then x, y, likelihood of each label."""
    head = [
        "scorer" + ",campus_tracker" * 15,
        "bodyparts" + "".join(f",{name}" * 3 for name in NAMES),
        "coords" + ",x,y,likelihood" * 5,
    ]
    lines = []
    for i in range(xy.shape[1]):
        cells = [str(i)]
        for j in range(5):
            x, y = xy[j, i]
            cells += [
                "" if np.isnan(x) else f"{x:.3f}",
                "" if np.isnan(y) else f"{y:.3f}",
                f"{like[j, i]:.4f}",
            ]
        lines.append(",".join(cells))
    file.write_text("\n".join(head + lines) + "\n", encoding="utf-8")


def write_log(
    file: FilePath,
    rng: np.random.Generator,
    world: World,
    path: Path,
    *,
    trial: int,
    delay: float,
    dead: tuple[str, float],
) -> None:
    """Shaft angle every 5 ms on the log's clock; the dead zone holds, reads 0, or is empty."""
    t = np.arange(0.0, path.end[trial], 0.005)
    step = path.t[1] - path.t[0]
    mean = 0.5 * (path.f[trial, 1:] + path.f[trial, :-1])
    turns = np.concatenate([[0.0], np.cumsum(mean)]) * step
    real = t + delay
    shaft = np.interp(real, path.t, turns) + world.extra["shaft_start"][trial]
    shaft += np.minimum(real, 0) * path.f[trial, 0]
    shaft += np.maximum(real - path.t[-1], 0) * path.f[trial, -1]
    angle = (360 * shaft + rng.normal(0, 0.4, t.size)) % 360
    held, lines = 0.0, ["time_s,angle_deg"]
    kind, width = dead
    for one, a in zip(t, angle, strict=True):
        if a > 360 - width:
            text = {"hold": f"{held:.2f}", "zero": "0.00", "empty": ""}[kind]
        else:
            held, text = a, f"{min(a, 359.99):.2f}"
        lines.append(f"{one:.3f},{text}")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def log_delays(world: World, found: Found) -> np.ndarray:
    """True time minus log time of each trial, from the time offset laws."""

    class Probe:
        """Receives the shift of the motor time."""

    out = np.zeros((world.trials.count, 1))
    for law in found.laws:
        if law.name == "time_offset":
            probe: Any = Probe()
            probe.sc, probe.k, probe.motor_time = world.scales, world.trials, 0.0 * out
            law.apply(probe)
            out = out - probe.motor_time
    return out[:, 0]


def write_yaml(file: FilePath, world: World, stated: Stated) -> None:
    """The statement of pool, water, robot and camera."""
    rb, cam = world.stated_robot, stated.camera

    def r(value: float, digits: int = 5) -> float:
        """A value to a number of significant digits."""
        return float(f"{value:.{digits}g}")

    text = {
        "pool": {
            "length_m": r(stated.length),
            "width_m": r(stated.width),
            "depth_m": r(world.pool.depth),
        },
        "water": {"density_kg_m3": rb.density, "refractive_index": r(stated.index)},
        "robot": {
            "mass_kg": r(rb.mass),
            "yaw_inertia_kg_m2": r(rb.inertia),
            "body_length_m": r(rb.body),
            "head_length_m": r(rb.head),
            "head_span_m": r(rb.span),
            "hinge_to_com_m": r(rb.hinge_to_com),
            "tail_length_m": r(rb.tail),
            "keypoint_depth_m": r(stated.depth),
        },
        "camera": {
            "model": cam.model,
            "image_size_px": [int(v) for v in cam.size],
            "matrix": [
                [r(cam.focal[0], 7), 0.0, r(cam.centre[0], 7)],
                [0.0, r(cam.focal[1], 7), r(cam.centre[1], 7)],
                [0.0, 0.0, 1.0],
            ],
            "distortion": [r(v, 6) for v in cam.distortion],
            "pool_corners_px": [
                [round(float(a), 2), round(float(b), 2)] for a, b in stated.corners
            ],
            "pool_corners_height_m": r(stated.mark_height),
        },
    }
    file.write_text(
        yaml.safe_dump(text, sort_keys=False, default_flow_style=None), encoding="utf-8"
    )


def write_study(folder: FilePath, found: Found, rng: np.random.Generator) -> dict[str, Any]:
    """All files of a study; returns facts for the truth file."""
    world, k = found.world, found.world.trials
    (folder / "keypoints").mkdir(parents=True, exist_ok=True)
    _believed, true, counts = frame_times(world, found)
    path = found.path.at(true)
    phase = phases(world, found.path, true, rng)
    nz = world.noise
    strength = np.clip(path.f / world.scales.frequency, 0, 1.2)
    recoil = nz["recoil_rad"] * strength * np.sin(phase)
    points = keypoints(
        world,
        path,
        found.laws,
        recoil=recoil,
        sway=nz["recoil_sway_m"] * strength * np.sin(phase + 1.1),
        tail=nz["tail_rad"] * (0.5 + 0.5 * strength) * np.sin(phase + 2.0),
    )
    pixels, stated = project(world, path, points, found.laws)
    write_yaml(folder / "study.yaml", world, stated)
    offset = log_delays(world, found)
    dead = (str(rng.choice(["hold", "zero", "empty"])), float(rng.uniform(10, 30)))
    drive = "motor_log" if world.log else "flap_hz"
    rows = [f"trial_id,source,power_pct,head_angle_deg,head_length_m,fps,{drive}"]
    scale = world.stated_robot.head / world.robot.head
    for i in range(k.count):
        name, n = f"T{i + 1:02d}", int(counts[i])
        stack = np.stack([p[i, :n] for p in pixels])
        xy, like = noisy(rng, world, stack)
        write_keypoints(folder / "keypoints" / f"{name}.csv", xy, like)
        if world.log:
            (folder / "motor").mkdir(exist_ok=True)
            log = folder / "motor" / f"{name}.csv"
            write_log(log, rng, world, found.path, trial=i, delay=offset[i], dead=dead)
            last = f"motor/{name}.csv"
        else:
            last = f"{k.f_nom[i, 0]:.4f}"
        rows.append(
            f"{name},keypoints/{name}.csv,{k.power[i, 0]:g},"
            f"{np.degrees(k.phi_cmd[i, 0]):.6g},{k.head[i, 0] * scale:.5f},"
            f"{world.fps:.5f},{last}"
        )
    (folder / "trials.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return {
        "frames": int(counts.sum()),
        "dead_zone": dead[0],
        "dead_zone_deg": dead[1],
        "log_delay_s": [round(float(v), 5) for v in offset],
    }
