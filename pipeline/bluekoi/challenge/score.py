"""What the finder said of each study against its opened seal, one study at a time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import input_error
from ..files import read_json
from ..synthetic.concealed.truth import true_law_error
from .find import results_of, studies_of
from .make import sealed_folder

Tree = Mapping[str, Any]
WHOLE_S = 60.0
KINDS: Mapping[str, str] = {
    "speed_m_s": "speed", "flap_hz": "speed",
    "yaw_rate_rad_s": "turn", "sway_speed_m_s": "turn", "angle_of_attack_rad": "turn",
    "head_angle_rad": "turn", "side": "turn",
    "x_m": "place", "y_m": "place",
    "time_s": "time", "heading_turned_rad": "time",
    "head_length_m": "head", "tail_beat_phase_rad": "beat",
}  # fmt: skip
TOGETHER = 0.2
"""A rival of this weight or more counts as named together with the cause whose place it takes."""


@dataclass(frozen=True)
class Judged:
    """One study: truth and findings side by side.

    true, said: names. together: names said at least as rivals. weights: name -> weight, for
    `causes` alone. pulls: parameter -> (value - truth)/std; errors: parameter -> relative error.
    channels, places: counts, see `_channels`, `_places`. held_out: mm by name.
    """

    name: str
    kind: str
    level: str
    trials: int
    fin: bool
    footage: bool
    verdict: str
    true: tuple[str, ...]
    said: tuple[str, ...]
    together: tuple[str, ...]
    laws: tuple[str, ...]
    ratio: float
    weights: Mapping[str, float] = field(default_factory=dict)
    pulls: Mapping[str, float] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    channels: tuple[int, int, int] = (0, 0, 0)
    places: tuple[int, int, int, int] = (0, 0, 0, 0)
    held_out: Mapping[str, float] = field(default_factory=dict)
    cpu_s: Mapping[str, float] = field(default_factory=dict)
    failure: str = ""

    @property
    def concealed(self) -> tuple[str, ...]:
        """What was concealed: all that is true but the fin of a robot that swims straight."""
        return tuple(n for n in self.true if not (self.fin and n == "tail_fin_lift"))

    @property
    def found(self) -> bool:
        """Every true cause named, be it with rivals."""
        return set(self.true) <= set(self.together)

    @property
    def false(self) -> tuple[str, ...]:
        """Named causes that are not true, unless a true one is named as their rival."""
        return tuple(n for n in self.said if n not in self.true and n not in self.excused)

    @property
    def excused(self) -> tuple[str, ...]:
        """Wrong names that stand for a true one, named as their rival."""
        missing = [n for n in self.true if n not in self.said and n in self.together]
        return tuple(n for n in self.said if n not in self.true)[: len(missing)]

    @property
    def right(self) -> bool:
        """All true causes named and none beside them."""
        return not self.failure and self.found and not self.false


def judge_all(folder: Path) -> list[Judged]:
    """Every study of a challenge judged; opens the seals.

    Raises: InputError where a seal does not have the published hash, or a study was never analysed.
    """
    return [judge(folder, name) for name in studies_of(folder)]


def opened(folder: Path, name: str) -> Tree:
    """The truth of a study, its bytes checked against the hash published before the analysis."""
    sealed = sealed_folder(folder) / f"{name}.json"
    published = read_json(folder / "challenge.json")["studies"][name]["truth_sha256"]
    content = sealed.read_bytes() if sealed.is_file() else b""
    digest = hashlib.sha256(content).hexdigest()
    if digest != published:
        raise input_error(sealed, "", f"SHA-256 {digest}", f"{published}, as published",
                    "This is not the truth that was sealed before the analysis.")  # fmt: skip
    truth: Tree = json.loads(content)
    return truth


def judge(folder: Path, name: str) -> Judged:
    """One study judged."""
    truth, results = opened(folder, name), results_of(folder, name)
    if not (results / "times.json").is_file():
        raise input_error(results, "", "no results", "results of `challenge find`")
    times = read_json(results / "times.json")
    told: Tree = read_json(results / "mismatch.json") if not times["failure"] else {}
    causes, rivals = told.get("causes", ()), told.get("rivals", ())
    said = tuple(c["name"] for c in causes)
    near = tuple(r["name"] for r in rivals if r["weight"] >= TOGETHER)
    true = truth["causes"]
    asked = [c for c in true if "wanted_ratio" in c]
    return Judged(
        name=name,
        kind=truth["kind"],
        level=_level(truth),
        trials=truth["trials"],
        fin=truth["body_swims_straight"],
        footage=truth["footage"],
        verdict=told.get("verdict", "failed"),
        true=tuple(c["name"] for c in true),
        said=said,
        together=(*said, *near),
        laws=tuple(c["law"] for c in true),
        ratio=float(min((c["ratio"] for c in asked), default=0.0)),
        weights={c["name"]: float(c["weight"]) for c in causes},
        pulls=_compared(true, causes, pulls=True),
        errors=_compared(true, causes, pulls=False),
        channels=_channels(true, told),
        places=_places(true, told),
        held_out=_held_out(truth, told),
        cpu_s=times["cpu_s"],
        failure=times["failure"],
    )


def _level(truth: Tree) -> str:
    return str(truth["level"]) if truth["kind"] != "null" else ""


def _compared(true: Sequence[Tree], causes: Sequence[Tree], *, pulls: bool) -> dict[str, float]:
    """Errors of parameters whose law is the candidate's: in standard deviations, or relative."""
    said = {c["name"]: c["parameters"] for c in causes}
    out = {}
    for cause in true:
        for name, value in cause["parameters"].items():
            given = said.get(cause["name"], {}).get(name)
            if given is None or given["value"] is None:
                continue
            off = given["value"] - value
            by = (given["std"] or 0.0) if pulls else abs(value)
            out[f"{cause['name']}.{name}"] = off / by if by > 0 else float("inf")
    return out


def _channels(true: Sequence[Tree], told: Tree) -> tuple[int, int, int]:
    """Channels hit, said, true: those of the named causes against those of the true effects."""
    want = {c for cause in true for c in cause["channels"]}
    said = {c for cause in told.get("causes", ()) if cause["kind"] == "physics"
            for c in cause["channels"]}  # fmt: skip
    if told.get("verdict") in ("none", None):
        said = set()
    return len(want & said), len(said), len(want)


def _places(true: Sequence[Tree], told: Tree) -> tuple[int, int, int, int]:
    """Told places that are true, told places, true effects with a told place, true effects.

    A place is a channel and the kind of thing (`KINDS`) that its force depends on.
    """
    want = [{(c, KINDS.get(v, v)) for c in cause["channels"] for v in cause["variables"]}
            for cause in true if cause["channels"]]  # fmt: skip
    said = {(w["channel"], KINDS.get(w["variable"], w["variable"])) for w in told.get("where", ())}
    said = said if told.get("verdict") not in ("none", None) else set()
    hit = sum(any(place in effect for effect in want) for place in said)
    return hit, len(said), sum(bool(said & effect) for effect in want), len(want)


def _held_out(truth: Tree, told: Tree) -> dict[str, float]:
    """Path errors on the held-out trials, mm: before, after, with the true law, noise floor."""
    held = told.get("held_out")
    if not held:
        return {}
    floor = held["noise_floor_path_rmse_m"]
    law = true_law_error(truth, held["trials"], held.get("stretch_s") or WHOLE_S)
    known = {
        "before": held["baseline"]["path_rmse_m"],
        "after": held["extended"]["path_rmse_m"],
        "true_law": float(np.hypot(law, floor or 0.0)),
        "floor": floor,
    }
    return {k: float("nan") if v is None else 1000 * float(v) for k, v in known.items()}
