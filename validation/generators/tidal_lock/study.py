"""One synthetic study: draws it, writes its folder and the truth about it."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from .calibration import SIGMA_LOW, Tank, calibrated_forms, draw_stable_fin, run, straight_growth
from .campaign import draw_campaign, ends, placed
from .catalogue import draw_fin, draw_form, draw_unlisted, needs_two_heads
from .dynamics import TIME_STEP, drive_factor
from .files import study_table, write_keypoints, write_rows, write_yaml
from .form import Active, Form
from .motor import draw_potentiometer, write_log
from .optics import draw_camera
from .robot import draw_robot, in_pool
from .tracking import draw_disturbances, draw_noise, perfect_pixels, tracked
from .water import draw_ambient

BLOCK = 20
TANKS = 4
GROUPS = {"null": 4, "one": 8, "two": 5, "unlisted": 3}
CORNER_STD = 0.4  # px


def plan(seed: int, index: int) -> tuple[str, bool]:
    """Group and tail fin of a study; each block of 20 holds every group in a random order."""
    rng = np.random.default_rng([seed, index // BLOCK, 20])
    slots, odd = [], bool(rng.integers(2))
    for group, count in GROUPS.items():
        fins = count // 2 + (count % 2 if odd else 0)
        odd = odd != bool(count % 2)
        slots += [(group, k < fins) for k in range(count)]
    return slots[rng.permutation(BLOCK)[index % BLOCK]]


def _tank(
    rng: np.random.Generator, with_fin: bool, two_heads: bool
) -> tuple[Tank, tuple[Active, ...]]:
    robot = in_pool(rng, draw_robot(rng))
    camera, campaign = draw_camera(rng, robot), draw_campaign(rng, robot, two_heads)
    fin: tuple[Active, ...] = ()
    if with_fin:
        fin = (draw_stable_fin(rng, robot, draw_fin(rng), campaign.trials),)
    campaign = placed(rng, robot, campaign, fin)
    ambient = draw_ambient(rng, robot, campaign.trials)
    return Tank(robot, campaign, camera, draw_noise(rng), ambient), fin


def _forms(rng: np.random.Generator, group: str) -> list[Form]:
    """Hidden forms of a study of this group."""
    if group == "unlisted":
        return [draw_unlisted(rng)]
    forms: list[Form] = []
    for _ in range({"null": 0, "one": 1, "two": 2}[group]):
        forms.append(draw_form(rng, forms))
    return forms


def _long_enough(tank: Tank, active: tuple[Active, ...]) -> bool:
    _, times, _, valid = run(tank, active)
    spans = ends(times, valid)
    return bool(np.median(spans) > 5.5 and spans.min() > 2.5)


def _drawn(rng: np.random.Generator, group: str, with_fin: bool):
    """A tank with its causes (fin first) and their sigmas.

    The causes stay for four tanks; if none of these shows them well enough, others are drawn.
    """
    while True:
        forms = _forms(rng, group)
        for _ in range(TANKS):
            tank, fin = _tank(rng, with_fin, any(needs_two_heads(form) for form in forms))
            found = calibrated_forms(rng, tank, fin, forms) if _long_enough(tank, fin) else None
            if found is None or min(found[1], default=SIGMA_LOW) < SIGMA_LOW:
                continue
            if _long_enough(tank, found[0]):
                return tank, *found


def _stated_camera(tank: Tank, active: tuple[Active, ...]):
    stated = tank.camera
    for form in active:
        if form.form.stage == "camera":
            stated = form.form.law(stated, form.p)
    return stated


def _write_trials(rng, tank: Tank, active, folder: Path, with_logs: bool):
    """Keypoint files, motor logs and trials.csv; returns keypoint disturbances and durations."""
    case, times, states, valid = run(tank, active)
    campaign, noise = tank.campaign, tank.noise
    disturbances, pot = draw_disturbances(rng), draw_potentiometer(rng)
    beats = campaign.logged * drive_factor(times[:, None], case)
    phase = np.cumsum(2 * np.pi * beats * TIME_STEP, axis=0)
    phase -= phase[0]
    spans, rows = ends(times, valid), []
    frames = np.arange(int(spans.max() * noise.fps) + 1) / noise.fps
    origin = rng.uniform(0, 2 * np.pi, campaign.trials)
    pixels = perfect_pixels(
        times,
        states,
        case,
        instruments=(tank.camera, disturbances),
        frames=frames,
        beat=(phase, origin),
    )
    (folder / "keypoints").mkdir(parents=True, exist_ok=True)
    if with_logs:
        (folder / "motor").mkdir(exist_ok=True)
    for i in range(campaign.trials):
        name = f"T{i + 1:02d}"
        shown = frames <= spans[i] - 0.05
        write_keypoints(
            folder / f"keypoints/{name}.csv", *tracked(rng, pixels[shown, i], noise, disturbances)
        )
        row = {
            "trial_id": name,
            "source": f"keypoints/{name}.csv",
            "power_pct": f"{campaign.power_pct[i]:g}",
            "head_angle_deg": f"{np.degrees(campaign.commanded[i]):.1f}",
            "head_length_m": f"{campaign.head[i]:.4f}",
            "fps": f"{noise.fps:.7g}",
        }
        if with_logs:
            row["motor_log"] = f"motor/{name}.csv"
            span = times <= spans[i]
            turned = phase[span, i] + origin[i]
            write_log(rng, folder / row["motor_log"], times[span], turned, pot)
        else:
            row["flap_hz"] = f"{campaign.logged[i] * case.logged_ratio[i]:.4f}"
        rows.append(row)
    write_rows(folder / "trials.csv", rows)
    return disturbances, spans


def _records(active: tuple[Active, ...], seen: np.ndarray) -> list[dict]:
    return [
        {
            "name": a.form.cause,
            "kind": a.form.kind,
            "form": a.form.form,
            "parameters": a.parameters(),
            "sigma": round(float(s), 2),
        }
        for a, s in zip(active, seen, strict=True)
    ]


def _unlisted_record(active: Active, sigma: float) -> dict:
    return {
        "channels": list(active.form.channels),
        "variable": active.form.variable,
        "form": active.form.form,
        "sigma": round(float(sigma), 2),
        "parameters": active.parameters(),
    }


def _conditions(tank: Tank, spans: np.ndarray, with_logs: bool, fin: tuple[Active, ...]) -> dict:
    campaign = tank.campaign
    return {
        "power_pct": sorted({float(p) for p in campaign.power_pct}),
        "head_angle_deg": sorted({float(a) for a in np.round(np.degrees(campaign.commanded), 1)}),
        "head_length_m": sorted({float(h) for h in campaign.head}),
        "duration_s": [round(float(t), 2) for t in spans],
        "pool_m": [round(float(n), 3) for n in tank.robot.pool],
        "camera_model": tank.camera.model,
        "fps": tank.noise.fps,
        "motor_logs": with_logs,
        "straight_growth_per_s": round(straight_growth(tank.robot, fin[0] if fin else None), 4),
    }


def _noise_record(tank: Tank, disturbances) -> dict:
    return {
        **{f"tracking_{k}": round(float(v), 4) for k, v in asdict(tank.noise).items()},
        **{k: round(float(v), 5) for k, v in asdict(disturbances).items()},
        "water_kind": tank.ambient.kind,
        "water_speed_m_s": round(float(tank.ambient.speed), 6),
        "water_correlation_s": round(float(tank.ambient.correlation), 3),
        "corner_std_px": CORNER_STD,
    }


def generate(seed: int, index: int, folder: Path) -> dict:
    """Write `folder`/studies/NAME and `folder`/truth/NAME.json; the truth.

    Deterministic in (seed, index).
    """
    name = f"tidal_lock-{seed}-{index:03d}"
    group, with_fin = plan(seed, index)
    rng = np.random.default_rng([seed, index, 1])
    tank, active, seen = _drawn(rng, group, with_fin)
    study = Path(folder) / "studies" / name
    study.mkdir(parents=True, exist_ok=True)
    has_drive = any(a.form.stage == "drive" for a in active)
    with_logs = bool(rng.random() < (0.25 if has_drive else 0.6))
    stated = _stated_camera(tank, active)
    corners = stated.corners + rng.normal(0, CORNER_STD, (4, 2))
    write_yaml(study / "study.yaml", study_table(tank.robot, stated, corners))
    disturbances, spans = _write_trials(rng, tank, active, study, with_logs)
    fin = active[: int(with_fin)]
    unlisted = active[-1] if group == "unlisted" else None
    listed = active[:-1] if unlisted else active
    truth = {
        "study": name,
        "generator": "tidal_lock",
        "group": group,
        "fin": with_fin,
        "trials": tank.campaign.trials,
        "causes": _records(listed, seen[: len(listed)]),
        "noise": _noise_record(tank, disturbances),
        "robot": {k: v for k, v in asdict(tank.robot).items() if k != "pool"},
        "conditions": _conditions(tank, spans, with_logs, fin),
    }
    if unlisted:
        truth["unlisted"] = _unlisted_record(unlisted, seen[-1])
    truth = json.loads(json.dumps(truth, default=float))
    path = Path(folder) / "truth" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
    return truth
