"""Build one study: draw until everything is usable, scale the causes, write files and truth."""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from . import unlisted
from .choose import CAUSES, LAWS, NEEDS_LOG, draw_names, group_and_fin
from .detector import Whitener, sigmas
from .engine import Motion, simulate, variant_set
from .files import write
from .fins import make_fin
from .labels import Footage, draw_noise
from .law import Law
from .optics import draw_camera
from .plan import SHORTEST, Trials, draw_trials, place
from .robots import Robot, draw_robot
from .truth import Hidden, as_json, describe
from .typical import Typical, typical
from .view import Track, View, make_view, skeleton, with_laws

TRANSIENT = ("motor_spin_up", "servo_lag", "time_offset")
"""Wanted with a larger sigma, as they would else be shorter than real ones."""
LOWEST_SIGMA, HIGHEST_SIGMA, LOWEST_FIN_SIGMA = 8.2, 39.5, 15.0
CLEARANCE = 0.03
"""Of the labels from the walls, m."""
ATTEMPTS = 200

log = logging.getLogger(__name__)


class Reject(Exception):
    """Raised when a draw cannot become a study."""


@dataclass(frozen=True)
class Session:
    """Robot and trials without hidden causes, and what they are typical of."""

    robot: Robot
    trials: Trials
    fin: list[Law]
    motion: Motion
    typical: Typical


def _motion(robot: Robot, trials: Trials, laws: list[Law]) -> Motion:
    return simulate(robot, trials, laws, variant_set(robot, trials, laws, 1))


def usable(robot: Robot, trials: Trials, motion: Motion) -> bool:
    """Whether the robot swims and does not spin."""
    sizes = typical(robot, trials, motion)
    swims = np.isfinite(sizes.speeds).all() and (sizes.speeds > 0.1 * robot.length).all()
    calm = (sizes.rates < 2.5).all() and (sizes.speeds < 1.2).all()
    return bool(swims and calm and np.median(sizes.rates / sizes.speeds) * robot.length < 3.0)


def inside(view: View, track: Track) -> bool:
    """Whether all labels stay in the basin; durations are cut where that saves the trial."""
    trials = view.trials
    length, width, _ = trials.pool
    low, high_x, high_y = CLEARANCE, length - CLEARANCE, width - CLEARANCE
    for trial in range(len(trials.phi)):
        label_time = np.arange(0, trials.duration[trial] + 0.02, 0.04)
        time = view.true_time(label_time, trial)
        points, _ = skeleton(view, track, time, trial)
        free = np.ones(len(time), bool)
        for z in points.values():
            free &= (z.real > low) & (z.real < high_x) & (z.imag > low) & (z.imag < high_y)
        last = label_time[-1] if free.all() else label_time[np.argmin(free)] - 0.1
        if last < SHORTEST or time.max() > track.time[-1]:
            return False
        trials.duration[trial] = np.round(min(trials.duration[trial], last), 2)
    return True


def _suits(name: str, sizes: Typical) -> bool:
    """Whether the conditions can show a cause."""
    if name == "wake_reentry":
        return int((sizes.turned > 5.0).sum()) >= max(3, len(sizes.trials.phi) // 4)
    if name == "stall":
        return sizes.high_attack > np.deg2rad(8.0)
    return True


def _draw_session(rng: Generator, has_fin: bool, names: list[str]) -> Session:
    """Robot, plan and basin."""
    two_heads = "thrust_area" in names or rng.random() < 0.4
    robot = draw_robot(rng, has_fin)
    trials = draw_trials(rng, robot, two_heads)
    fin = [make_fin(rng, robot.fin_strength, robot.fin_behind)] if has_fin else []
    motion = _motion(robot, trials, fin)
    if not usable(robot, trials, motion):
        raise Reject("robot swims badly")
    paths = motion.x[:, 0] + 1j * motion.y[:, 0]
    if not place(rng, robot, trials, paths, "wall_effect" in names):
        raise Reject("no room")
    trials.simulated = float(np.ceil((trials.duration.max() + 1.7) * 10) / 10)
    depth = np.ceil(10 * max(0.4, 1.6 * robot.length)) / 10
    trials.pool = (trials.pool[0], trials.pool[1], float(depth))
    motion = _motion(robot, trials, fin)
    sizes = typical(robot, trials, motion)
    if not all(_suits(name, sizes) for name in names):
        raise Reject("conditions do not show the cause")
    return Session(robot, trials, fin, motion, sizes)


@dataclass(frozen=True)
class Sight:
    """Camera with what is written about it, tracking noise, and whether there is a motor log."""

    view: View
    noise: dict[str, float]
    has_log: bool


def _draw_sight(rng: Generator, session: Session, names: list[str]) -> Sight:
    """Camera and tracking noise."""
    camera = draw_camera(rng, session.trials.pool)
    session.typical.lens_model = camera.lens.model
    noise = draw_noise(rng)
    has_log = bool(rng.random() < 0.6) or any(name in NEEDS_LOG for name in names)
    view = make_view(rng, session.robot, session.trials, camera)
    if not inside(view, Track(session.motion)):
        raise Reject("leaves the basin")
    return Sight(view, noise, has_log)


def _wanted(rng: Generator, causes: list[Law]) -> np.ndarray:
    """Sigmas to be reached."""
    wanted = np.exp(rng.uniform(np.log(10.5), np.log(35.0), len(causes)))
    for k, law in enumerate(causes):
        if law.name in TRANSIENT:
            wanted[k] = np.exp(rng.uniform(np.log(20.0), np.log(36.0)))
    return wanted


def scale(
    rng: Generator, view: View, fin: list[Law], causes: list[Law], whitener: Whitener
) -> list[Law]:
    """The causes with sizes for the wanted sigmas, within the plausible."""
    if not causes:
        return causes
    wanted = _wanted(rng, causes)
    times_too_low = [0] * len(causes)
    for step in range(7):
        got = np.array(sigmas(view, fin, causes, whitener)[: len(causes)])
        if (np.abs(np.log(got / wanted)) < 0.12).all():
            return causes
        power = 1.0 if step < 3 else 0.7
        scaled = []
        for k, law in enumerate(causes):
            factor = float(np.clip((wanted[k] / max(got[k], 0.05)) ** power, 0.15, 6.0))
            if law.size == law.largest and factor > 1:
                times_too_low[k] += 1
                if got[k] > LOWEST_SIGMA + 0.5:
                    wanted[k] = got[k]
                elif times_too_low[k] > 1 or len(causes) == 1:
                    raise Reject(f"{law.name}/{law.form} too small: {got[k]:.1f}")
            scaled.append(replace(law, size=float(min(law.size * factor, law.largest))))
        causes = scaled
    return causes


def _strengths(view: View, whitener: Whitener, fin: list[Law], causes: list[Law]) -> list[float]:
    """Sigmas of causes and fin, all of them within limits."""
    found = sigmas(view, fin, causes, whitener)
    if any(not LOWEST_SIGMA <= sigma <= HIGHEST_SIGMA for sigma in found[: len(causes)]):
        raise Reject(f"sigma {found}")
    if fin and found[-1] < LOWEST_FIN_SIGMA:
        raise Reject("fin hidden by the cause")
    return found


def _draw_causes(
    rng: Generator, session: Session, sight: Sight, names: list[str], group: str
) -> list[Law]:
    """The hidden causes at their final sizes."""
    whitener = Whitener(sight.view, session.fin, sight.noise)
    spread, length = whitener.spread, session.robot.length
    if np.median(spread) > 0.25 * length + 0.02 or spread.max() > 0.8:
        raise Reject("paths not repeatable")
    causes = [LAWS[name](rng, session.typical) for name in names]
    if group == "unlisted":
        force = unlisted.ALL[int(rng.integers(len(unlisted.ALL)))]
        causes = [force(rng, session.typical)]
    return scale(rng, sight.view, session.fin, causes, whitener)


def attempt(seed: int, index: int, number: int, folder: Path) -> dict[str, Any]:
    """One try at a study and its truth; raises Reject."""
    rng = np.random.default_rng([seed, index, number])
    group, has_fin, used = group_and_fin(seed, index)
    names = draw_names(rng, seed, CAUSES[group], used, number)
    session = _draw_session(rng, has_fin, names)
    robot, trials, fin = session.robot, session.trials, session.fin
    sight = _draw_sight(rng, session, names)
    causes = _draw_causes(rng, session, sight, names, group)
    laws = fin + causes
    view = with_laws(sight.view, laws, [law.size for law in laws])
    motion = _motion(robot, trials, laws)
    track = Track(motion)
    if not usable(robot, trials, motion) or not inside(view, track):
        raise Reject("the cause spoils the trials")
    whitener = Whitener(sight.view, laws, sight.noise)
    hidden = Hidden(group, fin, causes, _strengths(sight.view, whitener, fin, causes))
    name = f"harbour_dock-{seed}-{index:03d}"
    footage = Footage(view, track, sight.noise)
    flap = write(rng, folder / "studies" / name, footage, sight.has_log)
    truth = describe(hidden, footage)
    truth |= {
        "study": name,
        "generator": "harbour_dock",
        "seed": seed,
        "index": index,
        "attempt": number,
    }
    truth["conditions"] |= {"motor_log": sight.has_log, "flap_hz": flap}
    return truth


def build(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Draw until a study succeeds; write it and its truth below `folder`, return the truth."""
    for number in range(ATTEMPTS):
        try:
            truth = json.loads(as_json(attempt(seed, index, number, folder)))
        except Reject as why:
            log.debug("%d attempt %d: %s", index, number, why)
            continue
        (folder / "truth").mkdir(parents=True, exist_ok=True)
        (folder / "truth" / f"{truth['study']}.json").write_text(as_json(truth) + "\n")
        return truth
    raise RuntimeError(f"no usable study for seed {seed}, index {index}")
