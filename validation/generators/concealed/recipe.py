"""What one concealed study is made of: robot, laws, faults, campaign, noise; drawn from a seed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bluekoi.synthetic.ground_truth_physics import Recoil, Robot
from validation.generators.concealed.effects import PHYSICS, UNLISTED, Effect, Form
from validation.generators.concealed.faults import FAULTS
from validation.generators.concealed.robots import draw_body, draw_fin, draw_recoil, draw_robot
from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws

__all__ = [
    "CLEAR",
    "FAINT",
    "ChosenEffect",
    "Recipe",
    "draw_recipe",
    "effect_by_name",
    "with_effect",
]

CLEAR, FAINT = 10.0, 2.0
"""Path error that the rest of the model leaves, in units of the measuring noise."""


@dataclass(frozen=True)
class ChosenEffect:
    """An effect that is put in: the form of its law, its drawn numbers, what error it must make."""

    name: str
    form: Form
    numbers: Mapping[str, float]
    ratio: float


@dataclass(frozen=True)
class Recipe:
    """A whole study but for the strengths of its effects.

    kind: null, single, double, outside or measurement. trials: 24 or 9. fault: name, size.
    noise: factor on the tracker's noise. water_rms_m_s: speed of the eddies.
    """

    name: str
    kind: str
    level: str
    trials: int
    seed: int
    robot: Robot
    body: BodyParameters
    laws: HiddenLaws
    recoil: Recoil
    flap_hz: Mapping[int, float]
    chosen: tuple[ChosenEffect, ...] = ()
    fault: tuple[str, float] | None = None
    noise: float = 1.5
    water_rms_m_s: float = 0.0005
    footage: bool = False
    wide_lens: bool = False
    angles_deg: tuple[float, float] = field(default=(30.0, 45.0))

    @property
    def has_fin(self) -> bool:
        """Whether core and tail act as a fin."""
        return self.laws.fin_m2 > 0


def effect_by_name(name: str) -> Effect:
    """The effect of a name, listed or outside the list."""
    return PHYSICS[name] if name in PHYSICS else UNLISTED[name]


def draw_form(rng: np.random.Generator, name: str, ratio: float) -> ChosenEffect:
    """A form of an effect with its drawn numbers; weights carry sign and direction."""
    effect = effect_by_name(name)
    form = effect.forms[int(rng.integers(len(effect.forms)))]
    sign = float(rng.choice((-1.0, 1.0))) if effect.signed else 1.0
    weights = {k: sign * w for k, w in form.weights.items()}
    if effect.direction is not None:
        turn = rng.uniform(0, 2 * np.pi)
        weights = dict(zip(effect.direction, (np.cos(turn), np.sin(turn)), strict=True))
    drawn = {k: float(rng.uniform(*span)) for k, span in form.shape.items()}
    if name == "tail_fin_lift":
        drawn["fin_arm_m"] = float(rng.uniform(0.1, 0.15))
    reported = Form(form.law, weights, form.fixed, form.shape, form.reported_as)
    return ChosenEffect(name, reported, drawn, ratio)


def with_effect(laws: HiddenLaws, chosen: ChosenEffect, strength: float) -> HiddenLaws:
    """Laws with a chosen effect put in at a strength."""
    fixed: dict[str, Any] = {
        k: int(v) if k.endswith("_law") else v for k, v in chosen.form.fixed.items()
    }
    scaled = {k: w * strength for k, w in chosen.form.weights.items()}
    return laws._replace(**{**fixed, **chosen.numbers, **scaled})


def draw_recipe(
    seed: Sequence[int], name: str, *, kind: str, trials: int, effects: tuple[str, ...], level: str
) -> Recipe:
    """The recipe of one study: `effects` are what is concealed (a fault's name for measurement)."""
    rng = np.random.default_rng(list(seed))
    robot = draw_robot(rng)
    body = draw_body(rng, robot)
    wants_bare = "tail_fin_lift" in effects
    fin = rng.random() < 0.5 and not wants_bare
    laws = draw_fin(rng, robot) if fin else HiddenLaws()
    flap = float(rng.uniform(0.88, 1.12))
    ratio = CLEAR if level == "clear" else FAINT
    measured = kind == "measurement"
    return Recipe(
        name=name,
        kind=kind,
        level=level,
        trials=trials,
        seed=int(rng.integers(2**31)),
        robot=robot,
        body=body,
        laws=laws,
        recoil=draw_recoil(rng),
        flap_hz={50: 2.37 * flap, 75: 4.02 * flap, 100: 5.82 * flap},
        chosen=() if measured else tuple(draw_form(rng, e, ratio) for e in effects),
        fault=(effects[0], _draw_fault_size(rng, effects[0], level)) if measured else None,
        noise=float(rng.uniform(1.2, 2.0)),
        water_rms_m_s=float(rng.uniform(0.0003, 0.001) if fin else rng.uniform(0.0001, 0.0003)),
        wide_lens=bool(rng.random() < 0.2),
        angles_deg=(float(rng.choice((20.0, 25.0, 30.0))), float(rng.choice((40.0, 45.0)))),
    )


def _draw_fault_size(rng: np.random.Generator, fault: str, level: str) -> float:
    reported = FAULTS[fault]
    size = float(rng.uniform(*(reported.clear if level == "clear" else reported.faint)))
    return size * float(rng.choice((-1.0, 1.0))) if reported.signed else size
