"""A campaign whose every number is known: circles and straight starts, no noise."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bluekoi.campaign import Campaign
from bluekoi.data import Float, SteadyState, Track
from bluekoi.model import HYDRODYNAMIC_COEFFICIENTS, PUBLISHED_FLAP_HZ, TABLE_1
from bluekoi.study import Camera, Robot, Study, StudySettings, Trial
from paper_robot import PAPER_ROBOT

POOL_CORNERS_PX = ((360.0, 930.0), (1660.0, 930.0), (1660.0, 130.0), (360.0, 130.0))
"""500 px a metre, straight from above, no lens: pool (x, y) is at (360 + 500 x, 930 - 500 y)."""
ROBOT = Robot(**PAPER_ROBOT)
SPEED_M_S = {50: 0.225, 75: 0.381, 100: 0.552}
INF, NAN = float("inf"), float("nan")


def exact_setup() -> StudySettings:
    camera = Camera(image_size_px=(1920, 1080), pool_corners_px=POOL_CORNERS_PX)
    return StudySettings(robot=ROBOT, camera=camera)


def make_trial(number: int, power: float, angle: float, head: float = 0.12, **more: Any) -> Trial:
    name = f"T{number:02d}"
    return Trial(trial_id=name, source=f"keypoints/{name}.csv", power_pct=power, fps=30.0,
                 head_angle_deg=angle, head_length_m=head, **more)  # fmt: skip


def exact_track(
    t: Float, xy: Float, velocity: Float, heading: Float, rate: float, phi: float
) -> Track:
    n = len(t)
    small = {f"{k}_std": np.full(n, 1e-3) for k in (
        "x_m", "y_m", "heading_rad", "head_angle_rad", "speed_m_s", "vx_m_s", "vy_m_s",
        "yaw_rate_rad_s")}  # fmt: skip
    return Track(
        time_s=t, x_m=xy[:, 0], y_m=xy[:, 1], heading_rad=heading, head_angle_rad=np.full(n, phi),
        speed_m_s=np.hypot(*velocity.T), vx_m_s=velocity[:, 0], vy_m_s=velocity[:, 1],
        yaw_rate_rad_s=np.full(n, rate), **small,
    )  # fmt: skip


def straight_trial(one: Trial, speed: float, seconds: float = 4.0) -> tuple[Track, SteadyState]:
    """From rest along x: v = speed tanh t."""
    t = np.arange(round(seconds * 30)) / 30
    v = np.column_stack([speed * np.tanh(t), np.zeros(len(t))])
    xy = np.column_stack([0.3 + speed * np.log(np.cosh(t)), np.full(len(t), 0.8)])
    found = exact_track(t, xy, v, np.zeros(len(t)), 0.0, 0.0)
    row = SteadyState(
        PUBLISHED_FLAP_HZ[round(one.power_pct)],
        speed,
        0.001,
        INF,
        INF,
        0.0,
        2.0,
        float(t[-1]),
        "straight",
        "",
    )
    return found, row


def circle_trial(
    one: Trial, speed: float, radius: float, *, quality: str = "good"
) -> tuple[Track, SteadyState]:
    """A circle about (1.3, 0.8); positive head angle turns clockwise."""
    side = -1 if one.head_angle_deg > 0 else 1
    t = np.arange(90) / 30
    around = 0.4 + side * speed / radius * t
    xy = np.array([1.3, 0.8]) + radius * np.column_stack([np.cos(around), np.sin(around)])
    v = side * speed * np.column_stack([-np.sin(around), np.cos(around)])
    heading = around + side * np.pi / 2
    found = exact_track(t, xy, v, heading, side * speed / radius, np.radians(one.head_angle_deg))
    row = SteadyState(PUBLISHED_FLAP_HZ[round(one.power_pct)], speed, 0.001, radius, 0.004,
                      float(np.degrees(speed / radius * 2.0)), 1.0, float(t[-1]), quality,
                      "" if quality == "good" else "film for longer", side, (1.3, 0.8))  # fmt: skip
    return found, row


def exact_radius(power: float, angle: float, head: float) -> float:
    """Radius given to the circles, m."""
    return round(0.9 - 0.006 * abs(angle) - 1.5 * (head - 0.12) - 0.001 * power, 4)


def coefficients_json(powers: Sequence[int] = (50, 75, 100)) -> dict[str, Any]:
    """coefficients.json with the paper's Table I as its fits."""
    units = {p.name: p.unit for p in HYDRODYNAMIC_COEFFICIENTS}

    def cells(values: dict[str, float]) -> dict[str, Any]:
        return {k: {"value": v, "std": 0.02 * v, "unit": units[k], "determined": k != "C_Da",
                    "why": "hardly any turn <b>" if k == "C_Da" else ""}
                for k, v in values.items()}  # fmt: skip

    step = {"head_angle_deg": 45.0, "head_length_m": 0.175, "step": 3, "trials": [],
            "radius_m": 0.5, "model_radius_m": 0.45, "radius_difference_pct": -10.0}  # fmt: skip
    return {
        "paper_steps": {
            str(p): {
                "flap_hz": PUBLISHED_FLAP_HZ[p],
                "coefficients": cells(TABLE_1[p]),
                "steps": {"a": step},
            }
            for p in powers
        },
        "joint": {
            "coefficients": cells(TABLE_1[75]),
            "undetermined": [],
            "straight_swimming": {"sentence": "It does not swim straight."},
        },
    }


def exact_campaign(
    powers: Sequence[int] = (50, 75, 100),
    angles: Sequence[float] = (0, 30, -30, 45, -45),
    heads: Sequence[float] = (0.12, 0.175),
    **more: Any,
) -> Campaign:
    """One trial a condition; the longer head turns at 45 and goes straight only."""
    trials, tracks, steady = [], {}, {}
    for power in powers:
        for head in heads:
            for angle in angles:
                if head > 0.12 and abs(angle) not in (0, 45):
                    continue
                one = make_trial(len(trials) + 1, power, angle, head)
                trials.append(one)
                made = (
                    straight_trial(one, SPEED_M_S[power])
                    if angle == 0
                    else circle_trial(one, 0.9 * SPEED_M_S[power], exact_radius(power, angle, head))
                )
                tracks[one.trial_id], steady[one.trial_id] = made
    study = Study(root=Path("exact"), setup=exact_setup(), trials=tuple(trials))
    given: dict[str, Any] = {
        "tracks": tracks,
        "steady": steady,
        "coefficients": coefficients_json(powers),
    }
    return Campaign(study=study, **(given | more))


GEOMETRY_JSON = {
    "scale": 0.985, "scale_std": 0.002, "likely": "scale_error", "rivals": [], "depth_m": 0.04,
    "sentence": "rigid lengths come out -1.50 +- 0.20 % over the pool",
    "estimates": [{"name": "scale_error", "parameters": ["scale"], "units": ["-"],
                   "values": [0.015], "stds": [0.002], "gain": 210.0, "p_value": 1e-6,
                   "share": 0.015, "detectable": True,
                   "text": "the pool is larger than stated by: scale +0.015 +- 0.002"}],
    "map": {"x_edges_m": [0.0, 1.3, 2.6], "y_edges_m": [0.0, 1.6], "excess": [[-0.014, -0.016]],
            "std": [[0.001, 0.001]], "count": [[400.0, 300.0]], "model": [[-0.015, -0.015]]},
}  # fmt: skip

DAMPING_LAW = {
    "variable": "yaw_rate_rad_s", "unit": "rad/s", "x": [-1.0, 0.0, 1.0],
    "y": [0.02, 0.0, -0.02], "low": [0.018, 0.0, -0.022], "high": [0.022, 0.0, -0.018],
    "channel": "yaw", "y_unit": "N m",
}  # fmt: skip
"""Law of the damping that `searched` finds."""


def campaign_with_damping_found(base: Campaign) -> Campaign:
    """The campaign with a search that found a linear yaw damping of 0.02 N m s in it."""
    forces = {}
    for name, one in base.tracks.items():
        zero = [0.0] * len(one.time_s)
        forces[name] = {
            "time_s": one.time_s.tolist(), "x_m": one.x_m.tolist(), "y_m": one.y_m.tolist(),
            "surge_N": zero, "sway_N": zero, "yaw_Nm": (-0.02 * one.yaw_rate_rad_s).tolist(),
            "surge_std": zero, "sway_std": zero, "yaw_std": [1e-3] * len(zero),
        }  # fmt: skip
    reported = {k: {"value": v, "std": 0.01 * v} for k, v in TABLE_1[75].items()}
    damping = {"linear_yaw_damping.N_r": {"value": 0.02, "std": 0.001}}
    cause = {"name": "linear_yaw_damping", "kind": "physics", "channels": ["yaw"], "weight": 0.98,
             "regime": "turns", "sentence": "Turning is resisted in proportion to the yaw rate.",
             "parameters": {"N_r": {"value": 0.02, "std": 0.001, "unit": "N m s"}},
             "law": DAMPING_LAW}  # fmt: skip
    errors = {"path_rmse_m": 0.031, "radius_error_pct": 9.8, "speed_error_pct": 3.1}
    return Campaign(**{
        **base.__dict__,
        "geometry": GEOMETRY_JSON,
        "mismatch": {
            "verdict": "physics", "sentence": "Missing physics: linear_yaw_damping.",
            "causes": [cause], "rivals": [],
            "probabilities": {"linear_yaw_damping": 0.98, "servo_lag": 0.04},
            "where": [{"channel": "yaw", "variable": "yaw_rate_rad_s", "share": 0.7,
                       "trials": ["T02"]}],
            "held_out": {"trials": ["T02"], "baseline": errors, "noise_floor_path_rmse_m": 0.002,
                         "extended": {k: v / 10 for k, v in errors.items()}},
            "next_trial": {"power_pct": 50, "head_angle_deg": 20, "why": "it separates them"},
        },
        "mismatch_detail": {
            "forces": forces,
            "partial_residuals": {"linear_yaw_damping": {
                name: {"x": one.yaw_rate_rad_s[::10].tolist(),
                       "y": (-0.02 * one.yaw_rate_rad_s[::10]).tolist(),
                       "cause_force": (-0.02 * one.yaw_rate_rad_s[::10]).tolist()}
                for name, one in base.tracks.items()
            }},
            "coefficients": {"before": reported, "after": {**reported, **damping}},
        },
    })  # fmt: skip
