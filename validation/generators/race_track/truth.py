"""The truth of a study: verdict, causes with forms and sizes, floor, robot, trials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from .faults import UNITS, Fault
from .filming import Campaign
from .form import Law
from .plan import Plan
from .robots import COEFFICIENTS, Fin, straight_growth

COEFFICIENT_UNITS = ("m2", "1", "1", "1", "m", "kg m2")


def _strength(error: float, floor: float, trials: int) -> dict[str, float]:
    """Path error after the refit (m), and over the floor; sigma counts a trial once."""
    return {
        "sigma": float(error / floor * np.sqrt(trials)),
        "path_error_m": float(error),
        "path_error_over_floor": float(error / floor),
    }


def _law_entry(law: Law) -> dict[str, Any]:
    values = {law.family.parameter: {"value": law.size, "unit": law.family.unit}}
    return {"form": law.form, "parameters": values | {"shape": {"value": law.shape, "unit": "1"}}}


def _fin_entry(fin: Fin) -> dict[str, Any]:
    values = {"area": (fin.area, "m2"), "arm": (fin.arm, "m"), "slope": (fin.slope, "1/rad")}
    parameters = {k: {"value": float(v), "unit": u} for k, (v, u) in values.items()}
    return {"name": "tail_fin_lift", "kind": "physics", "form": fin.form, "parameters": parameters}


def _fault_entry(fault: Fault, floor: float, trials: int) -> dict[str, Any]:
    """Sigma and ratio of the apparent displacement before a refit."""
    return {
        "name": fault.name, "kind": "measurement", "form": fault.form,
        "parameters": {"size": {"value": fault.size, "unit": UNITS[fault.name]}},
        "sigma": float(fault.displacement / floor * np.sqrt(trials)),
        "displacement_m": float(fault.displacement),
        "displacement_over_floor": float(fault.displacement / floor),
        "trials": [int(k) for k in np.flatnonzero(fault.where)],
    }  # fmt: skip


def truth_of(
    plan: Plan, campaign: Campaign, errors: Mapping[str, float], floor: float
) -> dict[str, Any]:
    """Everything hidden, as plain values. errors: cause -> path error after the refit (m)."""
    count, robot = campaign.schedule.count, campaign.robot
    causes, unlisted = [], None
    if robot.fin:
        strength = _strength(errors["tail_fin_lift"], floor, count)
        causes.append(_fin_entry(robot.fin) | strength)
    for law in campaign.laws:
        name = law.family.name
        entry = _law_entry(law) | _strength(errors[name], floor, count)
        if law.family.where:
            channel, variable = law.family.where
            unlisted = {"channels": [channel], "variable": variable, "force": name} | entry
        else:
            causes.append({"name": name, "kind": "physics"} | entry)
    if campaign.fault:
        causes.append(_fault_entry(campaign.fault, floor, count))
    truth = {
        "group": plan.group, "fin": bool(robot.fin), "trials": count,
        "verdict": _verdict(causes, unlisted), "causes": causes,
        "noise": asdict(campaign.tracker) | {"floor_m": floor},
        "robot": {
            name: {"value": value, "unit": unit}
            for name, value, unit in zip(
                COEFFICIENTS, robot.coefficients, COEFFICIENT_UNITS, strict=True
            )
        },
        "conditions": _conditions(campaign),
    }  # fmt: skip
    return truth | ({"unlisted": unlisted} if unlisted else {})


def _verdict(causes: list[dict[str, Any]], unlisted: dict[str, Any] | None) -> str:
    """As in mismatch.json: an error of measurement goes before physics."""
    if unlisted:
        return "unexplained"
    kinds = {cause["kind"] for cause in causes}
    return "measurement" if "measurement" in kinds else "physics" if kinds else "none"


def _conditions(campaign: Campaign) -> dict[str, Any]:
    robot, schedule, camera = campaign.robot, campaign.schedule, campaign.camera
    return {
        "fps": campaign.fps,
        "straight_growth_per_s": straight_growth(robot, robot.fin),
        "body_length_m": robot.body_length,
        "keypoint_depth_m": robot.keypoint_depth,
        "pool_m": list(campaign.pool),
        "servo_error_deg": [float(v) for v in np.degrees(schedule.servo)],
        "flap_error": [float(v) for v in schedule.logged],
        "thrust_factor": [float(v) for v in schedule.quality],
        "camera": {
            "model": camera.model, "position": camera.position.tolist(),
            "rotation": camera.rotation.tolist(), "distortion": list(camera.distortion),
        },
    }  # fmt: skip
