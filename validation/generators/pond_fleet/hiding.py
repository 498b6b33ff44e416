"""Choice and size of what a study hides: fin, laws, error of measurement."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .detector import Fault as Observer
from .detector import Measured, Model, measured
from .experiment import Experiment, Variant
from .faults import Fault, Scene, apparent, draw_fault, true_depth
from .law import Law
from .plan import FAMILIES, UNLISTED, Plan, compatible
from .scatter import Scatter
from .sizing import LEAST_RATIO, LEAST_SIGMA, Hidden, lacking, sized_law

LEAST_DISPLACEMENT = 2.5
"""Displacement by an error of measurement over the floor, at least."""
FAULT_DRAWS = 6
MOST_TRIED = 6
"""Candidates for a hidden law that are tried on one robot."""


@dataclass(frozen=True)
class Bench:
    """A scene with its experiment and scatter."""

    scene: Scene
    experiment: Experiment
    scatter: Scatter

    @property
    def two_heads(self) -> bool:
        """Whether trials differ in head length."""
        return bool(np.ptp(self.scene.session.head) > 0)

    @property
    def both_sides(self) -> bool:
        """Whether the robot turns to both sides."""
        phi = self.scene.session.phi
        return bool((phi > 0).any() and (phi < 0).any())


@dataclass(frozen=True)
class HiddenFault:
    """An error of measurement with its displacement (m) and what the detector makes of it."""

    fault: Fault
    scene: Scene
    displacement: float
    found: Measured


def observer(fault: Fault | None, scene: Scene) -> Observer | None:
    """The error as a function of an observation; None without one."""
    if fault is None:
        return None
    return lambda seen: apparent(fault, scene, seen)


def fin_found(bench: Bench) -> Measured:
    """What a model without the fin leaves over."""
    experiment = bench.experiment
    starts = Hidden().starts(experiment)
    shown = Hidden().shown(experiment, starts)
    bare = replace(experiment, robot=replace(experiment.robot, fin=None))
    return measured(Model(bare, starts, (), ()), shown, bench.scatter, "tail_fin_lift")


def hide_fault(rng: np.random.Generator, name: str, bench: Bench) -> HiddenFault | None:
    """An error of measurement that displaces the tracks clearly and that the detector sees.

    Of a wrong scale it sees only what is left of the motion; the robot's own lengths show more.
    """
    for _ in range(FAULT_DRAWS):
        fault = draw_fault(rng, name, bench.scene.session)
        scene = replace(bench.scene, depth=true_depth(fault, bench.scene.robot))
        starts = Hidden().starts(bench.experiment)
        true = bench.experiment.observe([Variant()], (), starts)
        moved = (apparent(fault, scene, true) - true)[..., :2]
        displacement = float(np.sqrt((moved**2).sum(axis=-1).mean()))
        shown = Hidden(fault=observer(fault, scene)).shown(bench.experiment, starts)
        found = measured(Hidden().model(bench.experiment, starts), shown, bench.scatter, name)
        clear = displacement > LEAST_DISPLACEMENT * bench.scatter.floor
        if clear and (found.sigma > LEAST_SIGMA or name == "scale_error"):
            return HiddenFault(fault, scene, displacement, found)
    return None


def hide_laws(
    rng: np.random.Generator, plan: Plan, bench: Bench, fault: HiddenFault | None
) -> list[tuple[Law, Measured]] | None:
    """A law for each list of candidates with what the detector measures of it; None where no
    candidate of a list is usable.
    """
    laws: list[tuple[Law, Measured]] = []
    seen = observer(fault.fault, fault.scene) if fault else None
    for candidates in plan.candidate_lists:
        found = _first_of(
            rng, candidates, bench, laws, seen=seen, fault_name=fault.fault.name if fault else ""
        )
        if found is None:
            return None
        laws = found
    return laws


def _first_of(
    rng: np.random.Generator, candidates: tuple[str, ...], bench: Bench,
    laws: list[tuple[Law, Measured]], *, seen: Observer | None, fault_name: str,
) -> list[tuple[Law, Measured]] | None:  # fmt: skip
    """The laws and the first candidate that can be distinguished from them."""
    taken = [law.family.name for law, _ in laws] + [fault_name]
    usable = [name for name in candidates if compatible(name, taken) and _possible(name, bench)]
    known = Hidden(tuple(law for law, _ in laws), seen)
    for name in usable[:MOST_TRIED]:
        family = (FAMILIES | UNLISTED)[name]
        found = sized_law(rng, family, bench.experiment, known, bench.scatter)
        if found is None:
            continue
        every = [*laws, found]
        again = [_beside_the_others(bench, every, place, seen) for place in range(len(laws))]
        if all(m.sigma >= LEAST_SIGMA and m.ratio >= LEAST_RATIO for m in again):
            return [*((law, m) for (law, _), m in zip(laws, again, strict=True)), found]
    return None


def _beside_the_others(
    bench: Bench, laws: list[tuple[Law, Measured]], place: int, seen: Observer | None
) -> Measured:  # fmt: skip
    """A law measured again beside those that came later."""
    every = tuple(law for law, _ in laws)
    known = Hidden((*every[:place], *every[place + 1 :]), seen)
    name = every[place].family.name
    return lacking(bench.experiment, Hidden(every, seen), known, bench.scatter, name)


def _possible(name: str, bench: Bench) -> bool:
    """Whether the session can show a cause at all."""
    if name == "thrust_area":
        return bench.two_heads
    return name != "port_starboard_asymmetry" or bench.both_sides
