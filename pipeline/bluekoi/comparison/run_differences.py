"""What differs between two runs, read from their results alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..data import SteadyState
from ..errors import input_error
from ..files import flatten_mapping, read_json, read_manifest
from ..steady import read_steady

MIN_LISTED_CAUSE_PROBABILITY = 0.02
"""A cause less probable than this in both runs is not listed."""
MISSING_TEXT = "–"
"""Text that stands for a value that one of two runs does not have."""


@dataclass(frozen=True)
class RunResults:
    """Files of one results folder; empty mappings where a file is not there."""

    folder: Path
    coefficients: Mapping[str, Any] = field(default_factory=dict)
    mismatch: Mapping[str, Any] = field(default_factory=dict)
    manifest: Mapping[str, Any] = field(default_factory=dict)
    steady: Mapping[str, SteadyState] = field(default_factory=dict)

    @property
    def missing_result_files(self) -> tuple[str, ...]:
        """Results, without the manifest, that the run has not written."""
        found = {"coefficients.json": self.coefficients, "mismatch.json": self.mismatch,
                 "steady.csv": self.steady}  # fmt: skip
        return tuple(name for name, content in found.items() if not content)

    @property
    def joint_coefficients(self) -> Mapping[str, Any]:
        """Cells of the joint fit by coefficient."""
        return dict((self.coefficients.get("joint") or {}).get("coefficients") or {})


@dataclass(frozen=True)
class Difference:
    """One entry: section, name, value in both runs as text, their difference where it has one.

    sigmas: difference in standard deviations of both together, NaN where they are not known.
    """

    section: str
    name: str
    first: str
    second: str
    difference: float = math.nan
    sigmas: float = math.nan

    @property
    def same(self) -> bool:
        """Whether both runs say the same."""
        return self.first == self.second


def read_run(folder: Path) -> RunResults:
    """The results in a folder.

    Raises: InputError where there are none, or where a file cannot be read.
    """
    readers = {"coefficients": read_json, "mismatch": read_json, "manifest": read_manifest}
    found = {n: read(p) for n, read in readers.items() if (p := folder / f"{n}.json").is_file()}
    if "coefficients" not in found and "mismatch" not in found:
        raise input_error(folder, "", "neither coefficients.json nor mismatch.json",
                          "a folder with the results of a run", "Run the study first.")  # fmt: skip
    table = folder / "steady.csv"
    return RunResults(folder, **found, steady=read_steady(table) if table.is_file() else {})


def list_run_differences(first: RunResults, second: RunResults) -> list[Difference]:
    """All entries in which two runs can be compared, section by section; settings, inputs and
    versions only where both have a manifest.
    """
    both = bool(first.manifest and second.manifest)
    return [
        Difference("verdict", "verdict", _verdict_differences(first), _verdict_differences(second)),
        *_cause_differences(first, second),
        *_coefficient_differences(first, second),
        *_error_differences(first, second),
        *_steady_speed_differences(first, second),
        *(_setting_differences(first, second) if both else ()),
        *(_input_differences(first, second) if both else ()),
    ]


def _verdict_differences(run: RunResults) -> str:
    return str(run.mismatch.get("verdict", MISSING_TEXT))


def _cause_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    """Probabilities of the causes, and the numbers of those that are named in both."""
    chances = [dict(run.mismatch.get("probabilities") or {}) for run in (first, second)]
    for name in sorted(chances[0].keys() | chances[1].keys()):
        a, b = (float(c.get(name) or 0.0) for c in chances)
        if max(a, b) >= MIN_LISTED_CAUSE_PROBABILITY:
            yield Difference("probability of cause", name, f"{a:.2f}", f"{b:.2f}", b - a)
    named = [{c["name"]: c["parameters"] for c in run.mismatch.get("causes") or []}
             for run in (first, second)]  # fmt: skip
    for name in sorted(named[0].keys() | named[1].keys()):
        cells = [causes.get(name, {}) for causes in named]
        for key in sorted(cells[0].keys() | cells[1].keys()):
            yield number_difference(
                "parameter of cause", f"{name}.{key}", *(c.get(key) for c in cells)
            )


def _coefficient_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    for name in dict.fromkeys([*first.joint_coefficients, *second.joint_coefficients]):
        yield number_difference(
            "coefficient",
            name,
            first.joint_coefficients.get(name),
            second.joint_coefficients.get(name),
        )


def number_difference(
    section: str, name: str, a: Mapping[str, Any] | None, b: Mapping[str, Any] | None
) -> Difference:
    """Difference of two cells with `value`, `std` and `unit`; either may be missing."""
    values = [math.nan if c is None or c.get("value") is None else float(c["value"])
              for c in (a, b)]  # fmt: skip
    stds = [math.nan if c is None or c.get("std") is None else float(c["std"]) for c in (a, b)]
    apart, both = values[1] - values[0], math.hypot(*stds)
    sigmas = apart / both if both > 0 else math.nan
    return Difference(section, name, _cell_text(a), _cell_text(b), apart, sigmas)


def _cell_text(cell: Mapping[str, Any] | None) -> str:
    if cell is None or cell.get("value") is None:
        return MISSING_TEXT
    unit = "" if cell.get("unit") in (None, "", "1") else f" {cell['unit']}"
    std = "" if cell.get("std") is None else f" +- {cell['std']:.2g}"
    return f"{cell['value']:.4g}{std}{unit}"


def _error_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    held = [run.mismatch.get("held_out") or {} for run in (first, second)]
    for model in ("baseline", "extended"):
        for key, unit, factor in (("path_rmse_m", "mm", 1e3), ("radius_error_pct", "%", 1.0),
                                  ("speed_error_pct", "%", 1.0)):  # fmt: skip
            cells = [_as_cell((h.get(model) or {}).get(key), factor, unit) for h in held]
            yield number_difference(
                "error on held-out trials", f"{model} {key.rpartition('_')[0]}", *cells
            )
    floor = [_as_cell(h.get("noise_floor_path_rmse_m"), 1e3, "mm") for h in held]
    yield number_difference("error on held-out trials", "noise floor path_rmse", *floor)


def _as_cell(value: float | None, factor: float, unit: str) -> dict[str, Any]:
    return {"value": None if value is None else factor * value, "unit": unit}


def _steady_speed_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    for name in dict.fromkeys([*first.steady, *second.steady]):
        rows = [run.steady.get(name) for run in (first, second)]
        cells = [
            None
            if r is None
            else {
                "value": _finite_or_none(r.speed_m_s),
                "std": _finite_or_none(r.speed_std_m_s),
                "unit": "m/s",
            }
            for r in rows
        ]
        yield number_difference("steady speed", name, *cells)


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _setting_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    for section, key in (("study.yaml", "study"), ("trials.csv", "trials"),
                         ("setting", "settings"), ("version", "versions")):  # fmt: skip
        a, b = ({name: MISSING_TEXT if value in (None, {}, []) else str(value)
                 for name, value in flatten_mapping(run.manifest.get(key) or {})}
                for run in (first, second))  # fmt: skip
        for name in dict.fromkeys([*a, *b]):
            if a.get(name, MISSING_TEXT) != b.get(name, MISSING_TEXT):
                yield Difference(
                    section, name, a.get(name, MISSING_TEXT), b.get(name, MISSING_TEXT)
                )
    if (a_code := first.manifest.get("code")) != (b_code := second.manifest.get("code")):
        yield Difference(
            "version", "code", str(a_code or MISSING_TEXT), str(b_code or MISSING_TEXT)
        )


def _input_differences(first: RunResults, second: RunResults) -> Iterator[Difference]:
    """Input files that differ, by the start of their hash."""
    files = [dict(run.manifest.get("inputs") or {}) for run in (first, second)]
    for name in sorted(files[0].keys() | files[1].keys()):
        a, b = (str((f.get(name) or {}).get("sha256", MISSING_TEXT))[:12] for f in files)
        if a != b:
            yield Difference("input file", name, a, b)
