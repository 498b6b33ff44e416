"""The truth of a study as plain values."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from .here import Law
from .hiding import Hidden
from .plan import Plan
from .registry import MEASUREMENT, SIZED
from .robots import COEFFICIENT_UNITS, COEFFICIENTS, Fin, straight_growth
from .session import Session
from .sight import Scene
from .tracker import Tracker
from .unlisted_laws import WHERE
from .water import Unrest


def _entry(law: Law, sigma: float, beside: float, rival: str) -> dict[str, Any]:
    family = SIZED[law.name]
    return {
        "form": law.form,
        "parameters": {
            "size": {"value": law.size, "unit": family.unit, "meaning": family.meaning},
            "shape": {"value": list(law.shape), "unit": "1"},
            "side": {"value": law.side, "unit": "1"},
        },
        "sigma": sigma, "sigma_beside_best_rival": beside, "best_rival": rival,
    }  # fmt: skip


def _fin_entry(fin: Fin, hidden: Hidden) -> dict[str, Any]:
    return {
        "name": "tail_fin_lift", "kind": "physics", "form": fin.form,
        "parameters": {"strength": {"value": fin.strength, "unit": "kg/m"},
                       "arm": {"value": fin.arm, "unit": "m"}},
        "sigma": hidden.fin_sigma, "sigma_beside_best_rival": hidden.fin_beside,
        "best_rival": hidden.fin_rival,
    }  # fmt: skip


def truth_of(
    plan: Plan, hidden: Hidden, scene: Scene, session: Session, tracker: Tracker, *,
    unrest: Unrest, fps: float,
) -> dict[str, Any]:  # fmt: skip
    """Everything that is hidden. An unlisted force is under `unlisted`, not among the causes."""
    robot = scene.robot
    causes = [_fin_entry(robot.fin, hidden)] if robot.fin else []
    unlisted = None
    for law, *strength in zip(hidden.laws, hidden.sigma, hidden.beside, hidden.rivals, strict=True):
        entry = _entry(law, *strength)
        if law.name in WHERE:
            where = WHERE[law.name]
            unlisted = {"channels": [where.channel], "variable": where.variable,
                        "force": law.name} | entry  # fmt: skip
        else:
            kind = "measurement" if law.name in MEASUREMENT else "physics"
            causes.append({"name": law.name, "kind": kind} | entry)
    coefficients = zip(COEFFICIENTS, robot.coefficients, COEFFICIENT_UNITS, strict=True)
    errors = {k: v for k, v in asdict(tracker).items() if k != "label_error"}
    truth = {
        "group": plan.group, "fin": robot.fin is not None, "trials": session.count,
        "verdict": _verdict(causes, unlisted), "causes": causes,
        "noise": errors | {f"water_{k}": v for k, v in asdict(unrest).items()},
        "robot": {n: {"value": float(v), "unit": u} for n, v, u in coefficients},
        "conditions": {
            "fps": fps, "cruise_speed_m_s": robot.speed, "full_flap_hz": robot.flap,
            "straight_growth_per_s": straight_growth(robot, robot.fin),
            "servo_error_deg":
                (np.degrees(hidden.run.setting.phi) - session.angle).tolist(),
            "thrust_factor": hidden.run.setting.thrust.tolist(),
            "pool_m": list(scene.pool), "label_depth_m": scene.depth,
        },
    }  # fmt: skip
    return truth | ({"unlisted": unlisted} if unlisted else {})


def _verdict(causes: list[dict[str, Any]], unlisted: dict[str, Any] | None) -> str:
    kinds = {cause["kind"] for cause in causes}
    if unlisted:
        return "unexplained"
    return "measurement" if "measurement" in kinds else "physics" if kinds else "none"
