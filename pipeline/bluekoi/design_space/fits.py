"""The fitted robot of a results folder, with the reasons to doubt it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..data import Float
from ..errors import did_you_mean, input_error
from ..files import read_json
from ..integrate import LANES, System
from ..model import HYDRODYNAMIC_COEFFICIENTS, robot_system, two_plate_system
from ..study import Study

T = TypeVar("T")
COEFFICIENT_DRAWS = LANES - 1
"""Draws of the coefficients beside their best values: together they fill the lanes."""
RERUN_ADVICE = "Run the analysis again: bluekoi run STUDY."
DOUBTFUL_VERDICTS = ("measurement", "unexplained")
"""Verdicts with which a design carries a warning."""


@dataclass(frozen=True)
class FittedRobot:
    """values (draws, parameters), the best ones first; flap_hz by power; which model it is.

    warnings: sentences on why its answers may be wrong.
    """

    values: Float
    flap_hz: Mapping[float, float]
    model: str
    warnings: tuple[str, ...] = ()

    def flap_hz_at_power(self, power_pct: float) -> float:
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


def load_fitted_robot(
    results: Path, *, model: str | None = None, study: Study | None = None, seed: int = 0
) -> FittedRobot:
    """The fitted model of a results folder with draws of its coefficients.

    model: `joint`, or `extended` by the causes that were found (with mismatch_detail.json; draws
    from the deviations alone); None: extended where the verdict is physics. With `study`, results
    of trials that it does not have are warned of.

    Raises: InputError where the folder has no fit, an incomplete one, or no extended one.
    """
    path, detail = results / "coefficients.json", results / "mismatch_detail.json"
    if not path.is_file():
        remedy = "Run the study first (bluekoi run STUDY), or name its results with --results."
        raise input_error(results, "", "no coefficients.json", "the results of a run", remedy)
    found = read_json(path)
    verdict = _read_verdict(results / "mismatch.json") if detail.is_file() else "none"
    chosen = model or ("extended" if verdict == "physics" else "joint")
    rng = np.random.default_rng(seed)
    system = robot_system(study.setup.robot) if study else two_plate_system()
    if chosen == "extended":
        if not detail.is_file():
            raise input_error(detail, "", "no such file",
                              "results of the search for what was left out",
                        "Run the whole analysis first, or ask for the joint model.")  # fmt: skip
        cells = read_json(detail)
        values = _read_or_incomplete_error(
            detail,
            lambda: _extended_model_draws(cells["coefficients"]["after"], detail, rng, system),
        )
    else:
        values = _read_or_incomplete_error(path, lambda: _joint_fit_draws(found["joint"], rng))
    flap_hz = _read_or_incomplete_error(path, lambda: _flap_hz_by_power(found["paper_steps"]))
    doubts = _read_or_incomplete_error(path, lambda: _warning_sentences(found, verdict, chosen))
    strangers = (
        _read_or_incomplete_error(path, lambda: _results_of_other_study_warnings(found, study))
        if study
        else []
    )
    return FittedRobot(values, flap_hz, chosen, (*doubts, *strangers))


def _read_or_incomplete_error(path: Path, read: Callable[[], T]) -> T:
    try:
        return read()
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        found = f"incomplete content ({type(error).__name__}: {error})"
        raise input_error(
            path, "", found, "what a finished analysis writes", RERUN_ADVICE
        ) from error


def _read_verdict(path: Path) -> str:
    content = read_json(path)
    return _read_or_incomplete_error(path, lambda: str(content["verdict"]))


def _flap_hz_by_power(steps: Mapping[str, Any]) -> dict[float, float]:
    found = {float(power): float(step["flap_hz"]) for power, step in steps.items()}
    if not found:
        raise ValueError("paper_steps without a power")
    return found


def _joint_fit_draws(joint: Mapping[str, Any], rng: np.random.Generator) -> Float:
    best = {
        p.name: float(joint["coefficients"][p.name]["value"]) for p in HYDRODYNAMIC_COEFFICIENTS
    }
    names = joint["ensemble"]["names"]
    every = np.array(joint["ensemble"]["values"], dtype=float)
    chosen = every[
        rng.choice(len(every), size=COEFFICIENT_DRAWS, replace=len(every) < COEFFICIENT_DRAWS)
    ]
    rows = [best, *(dict(zip(names, row.tolist(), strict=True)) for row in chosen)]
    return np.array([two_plate_system().parameter_vector(row) for row in rows])


def _extended_model_draws(
    cells: Mapping[str, Any], path: Path, rng: np.random.Generator, system: System
) -> Float:
    best = system.parameter_vector({})
    std = np.zeros(len(best))
    for name, cell in cells.items():
        slot = system.parameter_index.get(name)
        if slot is None:
            raise input_error(path, name, "an unknown parameter", "a known one",
                        did_you_mean(name, system.parameter_index))  # fmt: skip
        best[slot], std[slot] = float(cell["value"]), float(cell.get("std") or 0.0)
    lower = np.array([p.lower for p in system.parameters])
    upper = np.array([p.upper for p in system.parameters])
    drawn = best + std * rng.standard_normal((COEFFICIENT_DRAWS, len(best)))
    return np.vstack([best, np.where(std > 0, np.clip(drawn, lower, upper), best)])


def _warning_sentences(found: Mapping[str, Any], verdict: str, chosen: str) -> list[str]:
    """Coefficients that are guesses, and a verdict that speaks against the joint fit."""
    cells = found["joint"]["coefficients"] if chosen == "joint" else {}
    guesses = [name for name, cell in cells.items() if cell.get("determined") is False]
    out = []
    if guesses:
        out.append(f"these trials do not determine {', '.join(guesses)}: numbers that hang on "
                   "them are guesses (coefficients.json says why)")  # fmt: skip
    if verdict in DOUBTFUL_VERDICTS or (verdict == "physics" and chosen == "joint"):
        out.append(f"the search ended with '{verdict}': this fit may be off by more than its "
                   "bands (mismatch.json says where)")  # fmt: skip
    return out


def _results_of_other_study_warnings(found: Mapping[str, Any], study: Study) -> list[str]:
    """A sentence where results are of trials or powers that the study does not have."""
    known = {t.trial_id for t in study.trials}
    powers = {t.power_pct for t in study.trials}
    trials = [name for name in found["joint"].get("trials", ()) if name not in known]
    others = [f"{p} %" for p in found["paper_steps"] if float(p) not in powers]
    if not trials and not others:
        return []
    return [f"the results are of another study or an earlier state of it: {study.root} has no "
            f"{', '.join([*trials[:5], *others[:5]])}"]  # fmt: skip
