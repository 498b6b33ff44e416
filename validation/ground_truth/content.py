"""Content of a ground truth, in each of the supported formats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bluekoi.data import Float
from bluekoi.model import HYDRODYNAMIC_COEFFICIENTS

Tree = Mapping[str, Any]
KNOWN_KEYS = ("hidden", "causes", "coefficients", "body", "trials")
"""Keys interpreted here; all others are listed unchanged."""


def injected_causes(truth: Tree) -> dict[str, Any] | None:
    """Cause -> parameters, from `hidden` or from `causes` (format of mismatch.json).

    None if the truth does not state its causes.
    """
    if isinstance(truth.get("hidden"), Mapping):
        return dict(truth["hidden"])
    causes = truth.get("causes")
    if isinstance(causes, list):
        known = [c for c in causes if isinstance(c, Mapping) and "name" in c]
        return {str(c["name"]): c.get("parameters") for c in known}
    return None


def true_coefficients(truth: Tree) -> dict[str, Any]:
    """Name -> value, or power -> name -> value, from `coefficients` or `body`."""
    found = truth.get("coefficients")
    if isinstance(found, Mapping):
        return dict(found)
    body = truth.get("body")
    names = [p.name for p in HYDRODYNAMIC_COEFFICIENTS]
    return {n: body[n] for n in names if n in body} if isinstance(body, Mapping) else {}


def true_trials(truth: Tree) -> dict[str, Tree]:
    """Trial id -> true values, from the list `trials`."""
    entries = truth.get("trials")
    known = [e for e in entries if isinstance(e, Mapping)] if isinstance(entries, list) else []
    return {str(entry.get("trial_id")): entry for entry in known}


def true_steady(entry: Tree, from_s: float, to_s: float) -> tuple[Any, Any]:
    """True speed (m/s) and radius (m) over an interval, from the sealed mean path.

    Speed: mean of |v|. Radius: path length over change of course. Without a readable mean path,
    the values stated in the truth.
    """
    stated = entry.get("speed_m_s"), entry.get("radius_m")
    path = entry.get("mean_path")
    if not isinstance(path, Mapping) or not {"time_s", "vx_m_s", "vy_m_s"} <= path.keys():
        return stated
    try:
        t, vx, vy = np.array([path[k] for k in ("time_s", "vx_m_s", "vy_m_s")], dtype=float)
    except (TypeError, ValueError):
        return stated
    return _mean_motion(t, vx, vy, np.linspace(from_s, to_s, 200))


def _mean_motion(t: Float, vx: Float, vy: Float, at: Float) -> tuple[float, float | None]:
    x, y = np.interp(at, t, vx), np.interp(at, t, vy)
    speed = float(np.hypot(x, y).mean())
    course = np.unwrap(np.arctan2(y, x))
    turned = abs(float(course[-1] - course[0]))
    return speed, speed * float(at[-1] - at[0]) / turned if turned > 0 else None
