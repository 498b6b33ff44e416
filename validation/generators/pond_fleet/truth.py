"""The truth of a study: verdict, causes with forms, sizes and strengths, robot, noise."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from .detector import Measured
from .faults import RANGES, Fault
from .filming import Campaign
from .fins import straight_growth
from .law import Law
from .plan import Plan
from .robots import COEFFICIENT_UNITS, COEFFICIENTS, Fin


def strength(found: Measured) -> dict[str, float]:
    """How visible a cause is (see `detector`)."""
    return {"sigma": found.sigma, "path_error_m": found.path_error,
            "path_error_over_floor": found.ratio}  # fmt: skip


def law_entry(law: Law) -> dict[str, Any]:
    """Form and parameters of a law."""
    size = {"value": float(law.size), "unit": law.family.unit, "meaning": law.family.meaning}
    return {
        "form": law.form,
        "parameters": {"size": size, "shape": {"value": law.shape, "unit": "1"}},
    }


def fin_entry(fin: Fin) -> dict[str, Any]:
    """The fin as a cause."""
    values = {"area": (fin.area, "m2"), "arm": (fin.arm, "m"), "slope": (fin.slope, "1/rad")}
    parameters = {name: {"value": float(v), "unit": unit} for name, (v, unit) in values.items()}
    return {"name": "tail_fin_lift", "kind": "physics", "form": fin.form, "parameters": parameters}


def fault_entry(fault: Fault, displacement: float, floor: float) -> dict[str, Any]:
    """An error of measurement. displacement: root mean square, before any refit (m)."""
    parameters = {"size": {"value": fault.size, "unit": RANGES[fault.name][2]}}
    return {
        "name": fault.name, "kind": "measurement", "form": fault.form, "parameters": parameters,
        "strength_by_trial": fault.strength.tolist(), "displacement_m": displacement,
        "displacement_over_floor": displacement / floor,
    }  # fmt: skip


def verdict(causes: list[dict[str, Any]], *, unlisted: bool) -> str:
    """As in mismatch.json: an error of measurement goes before physics."""
    kinds = {cause["kind"] for cause in causes}
    if unlisted:
        return "unexplained"
    return "measurement" if "measurement" in kinds else "physics" if kinds else "none"


def truth_of(
    plan: Plan, campaign: Campaign, causes: list[dict[str, Any]], unlisted: dict[str, Any] | None,
    floor: float,
) -> dict[str, Any]:  # fmt: skip
    """Everything hidden, as plain values. floor: path error of the true model (m)."""
    robot = campaign.scene.robot
    coefficients = zip(COEFFICIENTS, robot.coefficients, COEFFICIENT_UNITS, strict=True)
    truth = {
        "group": plan.group, "fin": robot.fin is not None,
        "trials": campaign.scene.session.count,
        "verdict": verdict(causes, unlisted=unlisted is not None), "causes": causes,
        "noise": asdict(campaign.tracker) | {"floor_m": floor},
        "robot": {n: {"value": float(v), "unit": u} for n, v, u in coefficients},
        "conditions": _conditions(campaign),
    }  # fmt: skip
    return truth | ({"unlisted": unlisted} if unlisted else {})


def _conditions(campaign: Campaign) -> dict[str, Any]:
    scene = campaign.scene
    robot, session, camera = scene.robot, scene.session, scene.camera
    eddy_speed = np.sqrt((campaign.eddies.speed**2).sum(axis=0) / 2)
    return {
        "fps": campaign.fps,
        "straight_growth_per_s": straight_growth(robot, robot.fin),
        "body_length_m": robot.body_length, "cruise_speed_m_s": robot.speed,
        "flap_hz": robot.flap, "recoil_rad": robot.recoil,
        "pool_m": list(scene.pool), "label_depth_m": scene.depth,
        "eddy_speed_m_s": float(eddy_speed.mean()),
        "servo_error_deg": np.degrees(session.servo_error).tolist(),
        "logged_over_true_flap": session.logged.tolist(),
        "thrust_factor": session.quality.tolist(),
        "camera": {
            "model": camera.model, "position_m": camera.position.tolist(),
            "rotation_vector": camera.turn.tolist(), "focal_px": list(camera.focal),
            "distortion": list(camera.distortion),
        },
    }  # fmt: skip
