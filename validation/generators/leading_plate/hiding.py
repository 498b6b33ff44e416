"""Choosing sizes of hidden laws so that an ideal detector sees them as clearly as planned."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .detect import (
    Bench,
    Signal,
    bench_of,
    fin_signal,
    law_signal,
    linearise,
    nuisances,
    probe_signal,
    rows,
)
from .here import Law
from .kalman import Noise, significance
from .motion import Plant
from .registry import MEASUREMENT, NAMES, SIZED, probe_law
from .robots import Array, Fin, Robot
from .session import Run, Session, run_session
from .sight import Scene, with_delay

CLEAR, FAINT = (8.0, 45.0), (5.0, 8.0)
AIMS = {"faint": (5.6, 7.3)}
CLEAR_AIM = (11.0, 34.0)
LEAST_BESIDE = 4.0
LEAST_UNLISTED = 6.0
ROUNDS = 6


@dataclass(frozen=True)
class Hidden:
    """Laws with their significances: alone (nuisances projected out) and beside the best rival."""

    laws: tuple[Law, ...]
    sigma: tuple[float, ...]
    beside: tuple[float, ...]
    rivals: tuple[str, ...]
    fin_sigma: float
    fin_beside: float
    fin_rival: str
    run: Run


def plant_of(robot: Robot, pool: tuple[float, float], laws: tuple[Law, ...]) -> Plant:
    """The plant with those laws that act on the motion."""
    return Plant(robot, pool, tuple(one for one in laws if one.name not in MEASUREMENT))


def run_with(
    rng: np.random.Generator, scene: Scene, session: Session, laws: tuple[Law, ...]
) -> tuple[Run, Session] | None:
    """The motion under laws, and the session with the releases that it needed."""
    setting = session.setting
    for law in laws:
        if law.name == "time_offset":
            setting = with_delay(setting, law)
    return run_session(rng, plant_of(scene.robot, scene.pool, laws), session, setting)


def hide(
    rng: np.random.Generator, scene: Scene, session: Session, noise: Noise,
    laws: tuple[Law, ...], *, group: str,
) -> Hidden | None:  # fmt: skip
    """Laws with sizes; None where no likely size has the planned significance."""
    low, high = FAINT if group == "faint" else CLEAR
    aims = np.exp(rng.uniform(*np.log(AIMS.get(group, CLEAR_AIM)), len(laws)))
    tried: list[list[tuple[float, float]]] = [[] for _ in laws]
    for turn in range(ROUNDS):
        found = run_with(rng, scene, session, laws)
        if found is None:
            laws = tuple(
                replace(law, size=max(0.5 * law.size, SIZED[law.name].low)) for law in laws
            )
            continue
        run, session = found
        bench = bench_of(plant_of(scene.robot, scene.pool, laws), scene, laws, run)
        linear, effects = linearise(bench)
        white = rows(linear, noise, [*nuisances(bench, effects),
                                     *(law_signal(bench, law) for law in laws)])  # fmt: skip
        known = effects.shape[-1]
        sigma = [significance(white[:, known + k], np.delete(white, known + k, axis=1))
                 for k in range(len(laws))]  # fmt: skip
        if all(low <= s <= high for s in sigma) and (turn or not laws):
            return _checked(bench, noise, laws, sigma, group)
        if turn == 0 and any(
            1.5 * value * SIZED[law.name].high / law.size < low
            for law, value in zip(laws, sigma, strict=True)
        ):
            return None
        for pairs, law, value in zip(tried, laws, sigma, strict=True):
            pairs.append((float(np.log(law.size)), float(np.log(max(value, 0.01)))))
        sized = _resized(laws, tried, aims)
        if sized == laws:
            return None
        laws = sized
    return None


def _resized(
    laws: tuple[Law, ...], tried: list[list[tuple[float, float]]], aims: Array
) -> tuple[Law, ...]:
    """Laws with their next sizes. tried: of each law, pairs (log size, log significance)."""
    out = []
    for law, pairs, aim in zip(laws, tried, np.log(aims), strict=True):
        family = SIZED[law.name]
        size, found = pairs[-1]
        below = [pair for pair in pairs if pair[1] < aim]
        above = [pair for pair in pairs if pair[1] >= aim]
        if below and above and max(below)[0] < min(above)[0]:
            low, high = max(below), min(above)
            share = np.clip((aim - low[1]) / (high[1] - low[1]), 0.15, 0.85)
            size = low[0] + share * (high[0] - low[0])
        else:
            size += np.clip(aim - found, -1.6, 1.1)
        size = float(np.clip(np.exp(size), family.low, family.high))
        out.append(replace(law, size=size))
    return tuple(out)


def _checked(
    bench: Bench, noise: Noise, laws: tuple[Law, ...], sigma: list[float], group: str
) -> Hidden | None:
    """With the significances beside rivals; None where a rival explains a law."""
    linear, effects = linearise(bench)
    names = {law.name for law in laws}
    own = [law_signal(bench, law) for law in laws]
    fin = bench.plant.robot.fin
    rivals = rival_signals(bench, names)
    listed = [*nuisances(bench, effects), *own, *rivals.values()]
    white = rows(linear, noise, [*listed, fin_signal(bench)] if fin else listed)
    known, count = effects.shape[-1], len(laws)
    others = white[:, known + count : known + count + len(rivals)]
    found = [
        _beside(white[:, known + k], np.delete(white[:, : known + count], known + k, axis=1),
                others, [*rivals], pairs=group == "unlisted")
        for k in range(count)
    ]  # fmt: skip
    least = LEAST_UNLISTED if group == "unlisted" else LEAST_BESIDE
    if any(value < least for value, _ in found):
        return None
    fin_found = (0.0, 0.0, "")
    if fin:
        base = np.concatenate([white[:, :6], white[:, known : known + count]], axis=1)
        alone = significance(white[:, -1], base)
        fin_found = (alone, *_beside(white[:, -1], base, others, [*rivals], pairs=False))
        if fin_found[0] < CLEAR[0] or fin_found[1] < LEAST_BESIDE:
            return None
    return Hidden(laws, tuple(sigma), tuple(v for v, _ in found), tuple(n for _, n in found),
                  *fin_found, bench.run)  # fmt: skip


def rival_signals(bench: Bench, names: set[str]) -> dict[str, Signal]:
    """Of all causes of the list but some."""
    found = {n: probe_signal(bench, probe_law(n)) for n in NAMES if n not in names}
    if bench.plant.robot.fin is None:
        robot = bench.plant.robot
        area = 0.02 * robot.head_length * robot.head_span
        found["tail_fin_lift"] = fin_signal(bench, Fin("forward_speed", 1500 * area,
                                                       robot.core_length))  # fmt: skip
    return found


def _beside(
    signal: Array, base: Array, rivals: Array, names: list[str], *, pairs: bool
) -> tuple[float, str]:
    """Least significance of a signal beside one rival (or two), and that rival's name."""
    scale = np.maximum(np.linalg.norm(base, axis=0), 1e-12)
    basis = np.linalg.qr(base / scale)[0]
    every = np.concatenate([signal[:, None], rivals], axis=1)
    free = every - basis @ (basis.T @ every)
    size = np.linalg.norm(free, axis=0)
    use = [k for k in range(1, len(size)) if size[k] > 1e-6 * np.linalg.norm(every[:, k])]
    cosine = (free / np.maximum(size, 1e-12)).T @ (free / np.maximum(size, 1e-12))
    best = (float(size[0]), "")
    for k in use:
        left = size[0] * np.sqrt(max(1 - cosine[0, k] ** 2, 0))
        best = min(best, (float(left), names[k - 1]))
        for j in use if pairs else ():
            if j < k and abs(cosine[j, k]) < 0.999:
                both = cosine[0, [j, k]]
                inner = np.array([[1, cosine[j, k]], [cosine[j, k], 1]])
                left = size[0] * np.sqrt(max(1 - both @ np.linalg.solve(inner, both), 0))
                best = min(best, (float(left), f"{names[j - 1]}+{names[k - 1]}"))
    return best
