"""The truth of a study as plain values."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .labels import Footage
from .law import Law
from .optics import Camera
from .plan import Trials
from .robots import UNITS, Robot


@dataclass(frozen=True)
class Hidden:
    """Fin (none or one) and causes; sigmas in the order of causes, then fin."""

    group: str
    fin: list[Law]
    causes: list[Law]
    sigmas: list[float]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _robot(robot: Robot) -> dict[str, Any]:
    fin = robot.fin_strength / robot.fin_critical if robot.fin_strength else 0.0
    return robot.study() | {
        "coefficients": {
            name: {"value": value, "unit": UNITS[name]}
            for name, value in robot.coefficients.items()
        },
        "fin_over_critical": fin,
    }


def _conditions(trials: Trials, camera: Camera) -> dict[str, Any]:
    return {
        "power_pct": trials.power,
        "head_angle_deg": np.rad2deg(trials.phi).round(3),
        "head": trials.head,
        "duration_s": trials.duration,
        "fps": trials.fps,
        "pool_m": trials.pool,
        "start": trials.start,
        "servo_error_deg": np.rad2deg(trials.servo_error),
        "thrust_error_rel": trials.thrust_error,
        "camera": {
            "size": camera.size,
            "lens": asdict(camera.lens),
            "rotvec": camera.rotation_vector,
            "cam": camera.position,
            "height": camera.marks_height,
            "n": camera.index,
        },
    }


def describe(hidden: Hidden, footage: Footage) -> dict[str, Any]:
    """The truth without the names of files; units in the names or beside the values."""
    robot, trials, camera = footage.view.robot, footage.view.trials, footage.view.camera
    strengths = list(zip(hidden.causes, hidden.sigmas, strict=False))
    causes = [law.truth(sigma) for law, sigma in strengths if law.name != "unlisted"]
    truth: dict[str, Any] = {
        "group": hidden.group,
        "fin": bool(hidden.fin),
        "trials": len(trials.phi),
        "causes": causes + [fin.truth(hidden.sigmas[-1]) for fin in hidden.fin],
    }
    for law, sigma in strengths:
        if law.name == "unlisted":
            entry = law.truth(sigma)
            truth["unlisted"] = {
                "channels": list(law.channels),
                "variable": law.variable,
                "sigma": entry["sigma"],
                "form": law.form,
                "parameters": entry["parameters"],
            }
    errors = {"metres_per_px": camera.metres_per_px}
    return truth | {
        "noise": footage.noise | trials.noise | errors,
        "robot": _robot(robot),
        "conditions": _conditions(trials, camera),
    }


def as_json(truth: dict[str, Any]) -> str:
    """With arrays as lists."""
    return json.dumps(truth, indent=1, default=_plain)
