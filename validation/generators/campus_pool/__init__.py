"""Concealed studies of simulated swimming robots from a made-up campus pool.

`generate(seed, index, folder)` writes one study in the layout of STUDY.md under `folder/studies`
and its truth under `folder/truth`.

How the laws were chosen.  Each named cause has at least four forms taken from ship hydrodynamics,
manoeuvring, fish swimming, servo and motor practice, or camera practice.  A form is drawn with its
shape parameters; its magnitude is set so that an ideal detector (a Kalman filter linearised about
the true paths, with the six coefficients, stated lengths, a tail fin, weak moving water, servo
error, thrust scatter and recoil marginalised) sees the effect at the wanted number of standard
deviations.  Rivals are all forms of all other causes, each with two draws of its shape.

What is left out.  Recoil is put on the labels and not on the forces.  Wakes are those of the
robot's own former passage in the same trial.  Pitch and roll are not simulated.  The change of
the head angle during a trial turns the core without reaction on the head.  The detector takes the
effect of a law as linear about the true paths and ignores what a motor log shows directly; its
view of autocorrelated tracking errors is an equivalent white error.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from . import (
    laws_camera,
    laws_drag,
    laws_head,
    laws_lift,
    laws_thrust,
    laws_time,
    laws_turn,
    laws_water,
    unlisted,
)
from .choose import Found, find
from .decks import orders
from .registry import UNLISTED_FACTS, Law
from .robot import straight_growth
from .write import write_study

__all__ = [
    "generate",
    "laws_camera",
    "laws_drag",
    "laws_head",
    "laws_lift",
    "laws_thrust",
    "laws_time",
    "laws_turn",
    "laws_water",
    "unlisted",
]


def _plain(value: Any) -> Any:
    """Numbers and containers as json knows them."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    return value


def _verdict(found: Found) -> str:
    """Kind of the strongest hidden cause; the fin decides only if it is alone."""
    if any(law.name == "unlisted" for law in found.laws):
        return "unexplained"
    ranked = sorted(zip(found.sigma, found.laws, strict=True), key=lambda pair: -pair[0])
    others = [law for _s, law in ranked if law.name != "tail_fin_lift"]
    if others:
        return others[0].kind
    return "physics" if found.laws else "none"


def _cause(found: Found, i: int) -> dict[str, Any]:
    """Truth entry of a listed cause."""
    law: Law = found.laws[i]
    return {
        "name": law.name,
        "kind": law.kind,
        "form": f"{law.form.label}: {law.form.text}",
        "parameters": law.params,
        "sigma": found.sigma[i],
        "sigma_beside_best_rival": found.beside[i],
        "best_rival": found.rival[i],
    }


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write one study and its truth; deterministic in (seed, index)."""
    order = orders(seed, index // 60)[index % 60]
    name = f"campus_pool-{seed}-{index:03d}"
    rng = np.random.default_rng([seed, index, 5801])
    found = find(rng, order)
    facts = write_study(Path(folder) / "studies" / name, found, rng)
    world = found.world
    listed = [i for i, law in enumerate(found.laws) if law.name != "unlisted"]
    hidden = None
    for i, law in enumerate(found.laws):
        if law.name == "unlisted":
            channels, variable = UNLISTED_FACTS[law.form.label]
            hidden = {
                "channels": channels,
                "variable": variable,
                "force": law.form.text,
                "form": law.form.label,
                "parameters": law.params,
                "sigma": found.sigma[i],
                "sigma_beside_best_rival": found.beside[i],
                "best_rival": found.rival[i],
            }
    base = [law for law in found.laws if law.name == "tail_fin_lift"]
    k, cam = world.trials, world.camera
    truth = {
        "study": name,
        "generator": "campus_pool",
        "seed": seed,
        "group": order.group,
        "fin": order.fin,
        "trials": k.count,
        "verdict": _verdict(found),
        "causes": sorted((_cause(found, i) for i in listed), key=lambda c: -c["sigma"]),
        "unlisted": hidden,
        "noise": world.noise,
        "robot": {
            **vars(world.robot),
            "coefficients": world.coef,
            "scales": vars(world.scales),
            "straight_growth_per_convective_time": straight_growth(world, base),
        },
        "conditions": {
            "pool": vars(world.pool),
            "refractive_index": world.index,
            "fps": world.fps,
            "camera": {
                "model": cam.model,
                "position_m": cam.position,
                "focal_px": cam.focal,
                "centre_px": cam.centre,
                "distortion": cam.distortion,
                "rotation": cam.turn,
            },
            "motor_log": world.log,
            "end_s": found.path.end,
            "redraws": found.redraws,
            "rest": k.rest[:, 0] > 0,
            "t_on_s": k.t_on[:, 0],
            "flap_hz": k.f_nom[:, 0],
            "servo_error_rad": k.phi_err[:, 0],
            "head_before_rad": k.phi_before[:, 0],
            "thrust_factor": k.thrust[:, 0],
            "start": k.start.T,
            **facts,
        },
    }
    truth = _plain(truth)
    file = Path(folder) / "truth" / f"{name}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    return truth
