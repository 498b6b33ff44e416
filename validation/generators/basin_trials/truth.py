"""The truth of a study: verdict, causes with forms and sizes, noise, robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from .design import StudySetup
from .faults import Fault
from .form import HiddenLaw
from .plan import Plan
from .robots import Fin

COEFFICIENT_UNITS = {
    "C_T": "m2", "C_La": "1", "C_Da": "1", "C_D0": "1", "C_Ma": "m", "C_Md": "kg m2"
}  # fmt: skip


def _parameters(law: HiddenLaw) -> dict[str, Any]:
    """Size with its unit, and the shape numbers between 0 and 1."""
    shape = {f"shape_{i}": {"value": s, "unit": "1"} for i, s in enumerate(law.shape)}
    return {law.family.parameter: {"value": law.size, "unit": law.family.unit}} | shape


def _strength(error: float, setup: StudySetup) -> dict[str, float]:
    """Path error after the refit (m), over the floor, and sigma.

    Sigma counts a segment as one measurement; the true significance is larger.
    """
    ratio = error / setup.floor
    return {
        "sigma": float(ratio * np.sqrt(setup.bench.segments)),
        "path_error_m": float(error),
        "path_error_over_floor": float(ratio),
    }


def _fin_cause(fin: Fin, setup: StudySetup) -> dict[str, Any]:
    values = {
        "area": {"value": fin.area, "unit": "m2"},
        "arm": {"value": fin.arm, "unit": "m"},
        "shape": {"value": fin.shape, "unit": ""},
    }
    entry = {"name": "tail_fin_lift", "kind": "physics", "form": fin.form, "parameters": values}
    return entry | _strength(setup.fin_error, setup)


def typical_displacement(fault: Fault, height: float) -> float:
    """Apparent displacement (m) before any refit, with the camera at this height (m).

    0.8 m from the axis of the camera, or in 3 s at 0.3 m/s.
    """
    size = abs(fault.size)
    return {
        "scale_error": 0.8 * size,
        "clock_error": 0.9 * size,
        "camera_shift": size,
        "uncorrected_refraction": 0.8 * size * 0.25 / height,
        "lens_error": 0.8 * size * (0.8 / height) ** 2,
        "time_offset": 0.3 * size,
        "keypoint_bias": size,
    }[fault.name]


def _fault_cause(fault: Fault, setup: StudySetup) -> dict[str, Any]:
    """Entry of a measurement error; sigma follows from the displacement before a refit."""
    moved = typical_displacement(fault, setup.camera.position[2])
    return {
        "name": fault.name,
        "kind": "measurement",
        "form": fault.form,
        "sigma": float(moved / setup.floor * np.sqrt(setup.bench.segments)),
        "displacement_m": float(moved),
        "parameters": {"size": {"value": fault.size, "unit": fault.unit}},
        "trials": [int(k) for k in np.flatnonzero(fault.where)],
    }


def truth_of(
    plan: Plan, setup: StudySetup, laws: Sequence[HiddenLaw], fault: Fault | None
) -> dict[str, Any]:
    """Everything that is hidden, as plain values for JSON."""
    robot = setup.robot
    causes = [_fin_cause(robot.fin, setup)] if robot.fin else []
    unlisted = None
    for law in laws:
        entry: dict[str, Any] = {"form": law.form, "parameters": _parameters(law)}
        entry |= _strength(law.path_error, setup)
        if law.family.where:
            channel, variable = law.family.where
            unlisted = {"channels": [channel], "variable": variable, "force": law.name} | entry
        else:
            causes.append({"name": law.name, "kind": "physics"} | entry)
    if fault:
        causes.append(_fault_cause(fault, setup))
    verdict = "unexplained" if unlisted else "measurement" if fault else "physics"
    noise = {"point_m": float(setup.bench.noise), "floor_m": setup.floor}
    truth = {
        "group": plan.group, "fin": bool(robot.fin), "trials": setup.trials,
        "verdict": verdict if causes or unlisted else "none", "causes": causes,
        "noise": asdict(setup.noise) | noise,
        "robot": {
            name: {"value": v, "unit": COEFFICIENT_UNITS[name]}
            for name, v in robot.coefficients.items()
        },
    }  # fmt: skip
    return truth | ({"unlisted": unlisted} if unlisted else {})
