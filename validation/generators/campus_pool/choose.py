"""Draw hidden laws and set their magnitudes until an ideal detector sees them as wanted."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .decks import Order
from .detector import DIMS, PRIOR_DIM, Detector, remaining, rivals
from .plan import build
from .registry import FORMS, UNLISTED, Law
from .simulate import Path, simulate
from .world import World

LEAST_FIN = 7.0
LEAST_BESIDE = 3.0
Goal = tuple[float, float, float]
"""Wanted sigma and the allowed range."""


class OutOfReach(ArithmeticError):
    """The drawn laws cannot be brought into range."""


@dataclass
class Found:
    """A finished study before it is written."""

    world: World
    laws: list[Law]
    path: Path
    sigma: list[float] = field(default_factory=list)
    beside: list[float] = field(default_factory=list)
    rival: list[str] = field(default_factory=list)
    redraws: int = 0


def _nuisance_fin(laws: list[Law]) -> list[Law]:
    """Fin laws marginalised as nuisances: other arms of the true fin, or a nominal fin."""
    own = [law for law in laws if law.name == "tail_fin_lift"]
    if own:
        other = {
            **own[0].params,
            "amp": 0.1 * own[0].params["amp"],
            "aft": own[0].params["aft"] + 0.5,
        }
        return [Law(own[0].form, other)]
    rng = np.random.default_rng(0)
    one = FORMS["tail_fin_lift"][0].draw(rng)
    return [one, Law(one.form, {**one.params, "aft": one.params["aft"] - 0.4})]


def weigh(
    world: World,
    laws: list[Law],
    path: Path,
    trial_laws: list[Law] | None = None,
    against: list[tuple[str, list[Law]]] | None = None,
) -> tuple[list[float], list[float], list[str]]:
    """Sigma of each law, sigma beside its best rival, and the name of that rival.

    With `trial_laws` these are laws not yet in the truth, weighed along its path.
    """
    det = Detector(world, laws, path)
    hidden = laws if trial_laws is None else [*laws, *trial_laws]
    columns = list(det.nuisance)
    n_base = len(columns)
    columns += [det.column(law, law in laws) for law in hidden]
    first_fin = len(columns)
    columns += [det.column(law, False) for law in _nuisance_fin(laws)]
    nuisance_end = len(columns)
    spans: list[tuple[str, list[int]]] = []
    for name, pair in against or []:
        begin = len(columns)
        columns += [det.column(law, False) for law in pair]
        spans.append((name, list(range(begin, len(columns)))))
    info = det.information(columns)
    if not np.all(np.isfinite(info)):
        raise ArithmeticError("the information is not finite")
    prior = np.zeros(len(columns))
    prior[n_base - DIMS : n_base] = 1 / PRIOR_DIM**2
    sigma, beside, names = [], [], []
    for i, law in enumerate(hidden):
        me = n_base + i
        fin = law.name == "tail_fin_lift"
        last = first_fin if fin else nuisance_end
        free = [j for j in range(last) if j != me]
        sigma.append(remaining(info, me, free, prior))
        best, who = sigma[-1], ""
        for name, span in spans:
            if name == law.name:
                continue
            left = remaining(info, me, free + span, prior)
            if left < best:
                best, who = left, name
        beside.append(best)
        names.append(who)
    return sigma, beside, names


def _draw(rng: np.random.Generator, order: Order) -> list[Law]:
    """One law for each hidden thing of the order, with random forms."""
    if order.group == "unlisted":
        return [UNLISTED[order.unlisted].draw(rng)]
    return [FORMS[name][int(rng.integers(len(FORMS[name])))].draw(rng) for name in order.names]


def _target(rng: np.random.Generator, group: str) -> Goal:
    """Wanted sigma and the allowed range."""
    if group == "faint":
        return float(rng.uniform(4.3, 5.7)), 4.0, 6.0
    return float(np.exp(rng.uniform(np.log(7.5), np.log(34.0)))), 6.0, 40.0


def _rivalled(rng: np.random.Generator, world: World, laws: list[Law], path: Path) -> Found:
    """The study as it would be written, its laws weighed beside all rivals."""
    against = rivals(rng, {law.name for law in laws})
    return Found(world, laws, path, *weigh(world, laws, path, None, against))


def _first_sizes(hidden: list[Law], sigma: list[float], goals: list[Goal]) -> list[Law]:
    """The laws with magnitudes from the sigma that they have along a path without them."""
    scaled = []
    for law, s, (goal, low, _high) in zip(hidden, sigma, goals, strict=True):
        amp = law.params["amp"] * min(goal / max(s, 1e-3), 4.0 * law.form.cap / law.form.start)
        if amp > law.form.cap:
            amp = law.form.cap
            if s * amp / law.params["amp"] < 0.5 * low:
                raise OutOfReach("the greatest magnitude is far too small")
        scaled.append(law.with_amp(amp))
    return scaled


def _long_enough(world: World, laws: list[Law]) -> Path:
    """The paths under the laws, if the robot stays in the pool long enough."""
    path = simulate(world, laws)
    if np.min(path.end) < 1.2 or np.median(path.end) < 0.5 * world.duration:
        raise OutOfReach("the robot leaves the pool too soon")
    return path


def _hidden_sigma(world: World, base: list[Law], laws: list[Law], path: Path) -> list[float]:
    """Sigma of the laws other than the fin, if the fin is still seen."""
    sigma, _beside, _names = weigh(world, laws, path)
    if base and sigma[0] < LEAST_FIN - 1.0:
        raise OutOfReach("the fin is too faint")
    return sigma[len(base) :]


def _raised(goals: list[Goal], found: Found, place: int) -> list[Goal]:
    """Greater goals for the laws from `place` on that a rival nearly explains."""
    out = list(goals)
    for i, (s, b) in enumerate(zip(found.sigma[place:], found.beside[place:], strict=True)):
        if b >= LEAST_BESIDE:
            continue
        if b * 37.0 / s < 3.1:
            raise OutOfReach("a rival explains the law at any magnitude")
        out[i] = (min(37.0, 3.6 * s / b), 6.0, 40.0)
    return out


def _next_sizes(
    hidden: list[Law], sigma: list[float], fits: list[bool], goals: list[Goal]
) -> list[Law]:
    """The laws with those that do not fit a step nearer to their goals."""
    fresh = []
    for law, s, good, (goal, _low, _high) in zip(hidden, sigma, fits, goals, strict=True):
        if good:
            fresh.append(law)
            continue
        step = (goal / max(s, 1e-3)) ** 0.75
        amp = law.params["amp"] * float(np.clip(step, 0.2, 4.0))
        if amp > law.form.cap and law.params["amp"] > 0.98 * law.form.cap:
            raise OutOfReach("the greatest magnitude is too small")
        fresh.append(law.with_amp(min(amp, law.form.cap)))
    return fresh


def _attempt(
    rng: np.random.Generator, order: Order, world: World, base: list[Law], path: Path
) -> Found:
    """Bring one draw of laws in a world into range; `OutOfReach` if this cannot be done."""
    n_base = len(base)
    hidden = _draw(rng, order)
    goals = [_target(rng, order.group) for _ in hidden]
    hidden = _first_sizes(hidden, weigh(world, base, path, hidden)[0][n_base:], goals)
    raised = False
    for _round in range(6):
        laws = [*base, *hidden]
        now = _long_enough(world, laws)
        sigma = _hidden_sigma(world, base, laws, now)
        fits = [low <= s <= high for s, (_g, low, high) in zip(sigma, goals, strict=True)]
        if all(fits):
            found = _rivalled(rng, world, laws, now)
            fits = [b >= LEAST_BESIDE for b in found.beside[n_base:]]
            if order.group == "faint" or all(fits):
                return found
            if raised:
                break
            raised, goals = True, _raised(goals, found, n_base)
        hidden = _next_sizes(hidden, sigma, fits, goals)
    raise OutOfReach("no magnitudes bring all laws into range")


def find(rng: np.random.Generator, order: Order) -> Found:
    """Worlds and laws are drawn until one meets the demands."""
    count = 0
    for _world in range(25):
        world, base = build(rng, order.trials, order.fin, order.names)
        path = simulate(world, base)
        if order.group == "null":
            found = _rivalled(rng, world, base, path) if base else Found(world, base, path)
            if base and found.sigma[0] < LEAST_FIN:
                continue
            return found
        if base and weigh(world, base, path)[0][0] < LEAST_FIN:
            continue
        for _ in range(4):
            try:
                found = _attempt(rng, order, world, base, path)
            except (ArithmeticError, np.linalg.LinAlgError, ValueError):
                count += 1
                continue
            found.redraws = count
            return found
    raise RuntimeError("no hidden laws of the wanted strength were found")
