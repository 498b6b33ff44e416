"""The fitted robot as the design space takes it, and the designs made from it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..data import Float
from ..faults import fault, nearest
from ..files import read_json
from ..integrate import LANES
from ..model import plates
from ..study import Setup, Study
from .front import Design
from .steady_states import Condition, steady_states

DRAWS = LANES - 1
"""Draws of the coefficients beside their best values: together they fill the lanes."""


@dataclass(frozen=True)
class Fitted:
    """values (draws, parameters), the best ones first; flap_hz by power; which model it is."""

    values: Float
    flap_hz: Mapping[float, float]
    model: str

    def at_power(self, power_pct: float) -> float:
        """Flapping frequency, Hz, between tested powers; beyond them along the line through all."""
        powers, hz = np.array(list(self.flap_hz)), np.array(list(self.flap_hz.values()))
        if len(powers) == 1:
            return float(hz[0] * power_pct / powers[0])
        inside = powers.min() <= power_pct <= powers.max()
        order = np.argsort(powers)
        if inside:
            return float(np.interp(power_pct, powers[order], hz[order]))
        slope, offset = np.polyfit(powers, hz, 1)
        return float(np.maximum(slope * power_pct + offset, 0.0))


@dataclass(frozen=True)
class Range:
    """What was tested: lowest and highest power, head angle (its size) and head length."""

    power_pct: tuple[float, float]
    head_angle_deg: tuple[float, float]
    head_length_m: tuple[float, float]

    def beyond(self, power_pct: float, head_angle_deg: float, head_length_m: float) -> list[str]:
        """Names of what lies outside."""
        given = (
            ("power", power_pct, self.power_pct),
            ("head angle", abs(head_angle_deg), self.head_angle_deg),
            ("head length", head_length_m, self.head_length_m),
        )
        return [n for n, v, (low, high) in given if not low - 1e-9 <= v <= high + 1e-9]


def tested_range(study: Study) -> Range:
    """Range of a study's trials; head angles of its turns."""
    trials = study.trials
    angles = [abs(t.head_angle_deg) for t in trials if abs(t.head_angle_deg) >= 3]
    return Range(
        _span([t.power_pct for t in trials]),
        _span(angles or [0.0]),
        _span([t.head_length_m for t in trials]),
    )


def _span(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)


def fitted(results: Path, *, model: str | None = None, seed: int = 0) -> Fitted:
    """The fitted model of a results folder with draws of its coefficients.

    model: `joint`, or `extended` by the causes that were found (with mismatch_detail.json; draws
    from the deviations alone); None: extended where the verdict is physics.

    Raises: Fault where the folder has no fit, or no extended one.
    """
    found = read_json(results / "coefficients.json")
    detail = results / "mismatch_detail.json"
    verdict = read_json(results / "mismatch.json")["verdict"] if detail.is_file() else "none"
    chosen = model or ("extended" if verdict == "physics" else "joint")
    rng = np.random.default_rng(seed)
    if chosen == "extended":
        if not detail.is_file():
            raise fault(detail, "", "no such file", "results of the search for what was left out",
                        "Run the whole analysis first, or ask for the joint model.")  # fmt: skip
        values = _extended(read_json(detail)["coefficients"]["after"], rng)
    else:
        values = _joint(found["joint"], rng)
    steps = found["paper_steps"]
    return Fitted(values, {float(p): float(s["flap_hz"]) for p, s in steps.items()}, chosen)


def _joint(joint: Mapping[str, Any], rng: np.random.Generator) -> Float:
    best = {n: float(c["value"]) for n, c in joint["coefficients"].items()}
    names = joint["ensemble"]["names"]
    every = np.array(joint["ensemble"]["values"], dtype=float)
    chosen = every[rng.choice(len(every), size=DRAWS, replace=len(every) < DRAWS)]
    rows = [best, *(dict(zip(names, row.tolist(), strict=True)) for row in chosen)]
    return np.array([plates().values(row) for row in rows])


def _extended(cells: Mapping[str, Any], rng: np.random.Generator) -> Float:
    best = plates().values({})
    std = np.zeros(len(best))
    for name, cell in cells.items():
        slot = plates().slot.get(name)
        if slot is None:
            raise fault("mismatch_detail.json", name, "an unknown parameter", "a known one",
                        nearest(name, plates().slot))  # fmt: skip
        best[slot], std[slot] = float(cell["value"]), float(cell.get("std") or 0.0)
    lower = np.array([p.lower for p in plates().parameters])
    upper = np.array([p.upper for p in plates().parameters])
    drawn = best + std * rng.standard_normal((DRAWS, len(best)))
    return np.vstack([best, np.where(std > 0, np.clip(drawn, lower, upper), best)])


def designs(
    fit: Fitted,
    setup: Setup,
    tested: Range,
    *,
    powers: Sequence[float],
    angles_deg: Sequence[float],
    lengths_m: Sequence[float],
    other: Mapping[str, Sequence[float]] | None = None,
) -> list[Design]:
    """Every combination with its steady speed and radius and their 95 % bands.

    other: values of further keys of `robot` in study.yaml, such as `mass_kg`; nothing else about
    the robot changes with them.

    Raises: Fault for a key that the robot does not have.
    """
    keys = list(other or {})
    known = set(type(setup.robot).model_fields)
    for key in keys:
        if key not in known:
            raise fault("robot", key, "an unknown key", "a key of robot in study.yaml",
                        nearest(key, known))  # fmt: skip
    grid = list(itertools.product(powers, angles_deg, lengths_m, *(other or {}).values()))
    robots = [_with(setup, dict(zip(keys, rest, strict=True))) for _, _, _, *rest in grid]
    conditions = [
        Condition(fit.at_power(p), float(np.radians(a)), h, robot)
        for (p, a, h, *_), robot in zip(grid, robots, strict=True)
    ]
    states = steady_states(conditions, fit.values)
    return [
        Design(
            power_pct=p,
            flap_hz=c.flap_hz,
            head_angle_deg=a,
            head_length_m=h,
            other=dict(zip(keys, rest, strict=True)),
            speed_m_s=_band(states.speed_m_s[i]),
            radius_m=_band(states.radius_m[i]),
            beyond=tuple(tested.beyond(p, a, h)) + tuple(
                k for k, v in zip(keys, rest, strict=True) if v != getattr(setup.robot, k)
            ),
        )
        for i, ((p, a, h, *rest), c) in enumerate(zip(grid, conditions, strict=True))
    ]  # fmt: skip


def _with(setup: Setup, changes: Mapping[str, float]) -> Setup:
    if not changes:
        return setup
    robot = type(setup.robot).model_validate(setup.robot.model_dump() | dict(changes))
    return setup.model_copy(update={"robot": robot})


def _band(draws: Float) -> tuple[float, float, float]:
    """Best value, and 95 % bounds from the spread of the draws (in logarithms)."""
    best, rest = draws[0], draws[1:]
    rest = rest[np.isfinite(rest) & (rest > 0)]
    if not np.isfinite(best) or best <= 0 or len(rest) < DRAWS // 2:
        return float(best), float("nan"), float("nan")
    spread = 1.96 * float(np.std(np.log(rest), ddof=1))
    return float(best), float(best * np.exp(-spread)), float(best * np.exp(spread))
